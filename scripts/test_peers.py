"""Tests of what scripts/peers measures with, and of what scripts/bench records: python3 -m unittest discover -s scripts"""

import contextlib
import csv
import dataclasses
import io
import json
import math
import os
import pathlib
import random
import struct
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
from typing import Any, Iterator, Sequence

from for_tests import HERE, module_of, need_packages

need_packages()
import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402
import PIL.Image  # noqa: E402

import images  # noqa: E402
import peers_color  # noqa: E402
import peers_crops  # noqa: E402
import peers_frames as pf  # noqa: E402
import peers_table  # noqa: E402
from peers_codecs import CODERS, Dial, Ffv1, PerStream, Rvl, Xz, Zstd, key_frames, rotated, x265  # noqa: E402
from peers_kernels import Kernels  # noqa: E402
from peers_measure import Contest, Depth, Errors, Given, Row, compare, depth_errors  # noqa: E402


WORK = tempfile.TemporaryDirectory()
FOLDER = pathlib.Path(WORK.name)
KERNELS = Kernels(WORK.name)


def tearDownModule() -> None:
    WORK.cleanup()


def packed(codes: Sequence[int], wide: bool = False) -> bytes:
    return struct.pack(f"<{len(codes)}{'I' if wide else 'H'}", *codes)


def hard_images() -> Iterator[tuple[str, list[int]]]:
    """(name, codes) of images that break run lengths, differences and the ends of words."""
    yield "one empty pixel", [0]
    yield "one pixel", [65535]
    yield "all empty", [0] * 5000
    yield "all the largest", [65535] * 5000
    yield "alternating ends", [1, 65535] * 300
    yield "alternating with empty", [0, 65535] * 300
    for run in (7, 8, 63, 64, 127, 128, 129, 511, 512, 4096, 70000):
        yield f"runs of {run}", [0] * run + [9] * run + [0] * run
    yield "every difference of a power of two", [code for bit in range(16) for code in (65535, 65535 - (1 << bit))]
    chance = random.Random(5)
    for count in range(1, 40):
        yield f"{count} random pixels", [chance.choice([0, 1, 65535, chance.randrange(65536)]) for _ in range(count)]
    yield "noise", [chance.randrange(65536) for _ in range(20000)]


class RvlTest(unittest.TestCase):
    def test_every_image_comes_back(self) -> None:
        for name, codes in hard_images():
            with self.subTest(name):
                data = packed(codes)
                out = KERNELS.rvl_decode(KERNELS.rvl_encode(data), len(codes))
                self.assertEqual(out.raw[:len(data)], data)

    def test_the_nibbles_are_those_of_the_paper(self) -> None:
        # 2 empty, 3 others with differences 5, 0, 1 as zigzag 10, 0, 2; 1 empty, 0 others.
        self.assertEqual(KERNELS.rvl_encode(packed([0, 0, 5, 5, 6, 0])), struct.pack("<I", 0x23A10210))

    def test_bytes_of_something_else_are_refused(self) -> None:
        coded = KERNELS.rvl_encode(packed([0, 5, 6] * 100))
        for wrong, pixels in ((coded[:-4], 300), (coded, 299), (b"", 1), (b"\xff" * 64, 300)):
            with self.assertRaises(ValueError):
                KERNELS.rvl_decode(wrong, pixels)
        with self.assertRaises(ValueError):
            KERNELS.rvl_decode(KERNELS.rvl_encode(packed([0] * 300)), 299)

    def test_background_becomes_empty_and_comes_back(self) -> None:
        codes = packed([0, 1, 65534, 65535])
        turned = rotated(codes, 1, 65536)
        self.assertEqual(turned, packed([1, 2, 65535, 0]))
        self.assertEqual(rotated(turned, 65535, 65536), codes)
        self.assertEqual(rotated(packed([0, 325, 326]), 1, 327), packed([1, 326, 0]))


def dealt(code: int) -> list[int]:
    """CALF 7.1, read literally: (red, green, blue)."""
    channels = [0, 0, 0]
    for i in range(24):
        channels[i % 3] |= (code >> i & 1) << (i // 3)
    return channels


class MappingTest(unittest.TestCase):
    def test_bits_are_dealt_out_in_turn(self) -> None:
        for wide, codes in ((True, [0, 1, 2, 4, 8, 0xABCDEF, 0xFFFFFF]), (False, [0, 1, 2, 4, 8, 0xABCD, 0xFFFF])):
            planes = pf.swizzle(packed(codes, wide), wide)
            green, blue, red = (planes[at:at + len(codes)] for at in range(0, len(planes), len(codes)))
            self.assertEqual([list(pixel) for pixel in zip(red, green, blue)], [dealt(code) for code in codes])
            self.assertEqual(pf.unswizzle(planes, wide), packed(codes, wide))

    def test_every_16_bit_code_comes_back(self) -> None:
        codes = packed(range(65536))
        self.assertEqual(pf.unswizzle(pf.swizzle(codes)), codes)

    def test_steps_keep_their_bound_and_the_background(self) -> None:
        film = pf.Film("codes", 256, 256, "gray16le", 2, [pf.Stream("a", "px", 0, 1)], [packed(range(65536))])
        narrowest = {0: "gray16le", 7: "gray16le", 8: "gray12le", 100: "gray10le", 300: "gray", 16000: "gray"}
        for bound, kind in narrowest.items():
            steps = pf.stepped(film, bound)
            self.assertEqual(steps.pixel_format, kind)
            [back] = [struct.unpack("<65536H", steps.back(payload)) for payload in steps.payloads]
            self.assertEqual(back[65535], 65535)
            self.assertEqual(max(abs(code - found) for code, found in enumerate(back[:65535])), min(bound, 65534))
            self.assertNotIn(65535, back[:65535])

    def test_the_narrowest_gray_holds_every_level(self) -> None:
        found = [pf.gray_of(levels) for levels in (256, 257, 1024, 1025, 4096, 4097)]
        self.assertEqual(found, ["gray", "gray10le", "gray10le", "gray12le", "gray12le", "gray16le"])

    def test_codes_of_24_bits(self) -> None:
        metres = struct.pack("<5f", 1.0, 2.0, 4.0, math.inf, 0.5)
        found = pf.codes24(metres, packed([0, 1, 65534, 65535, 0]), (1.0, 4.0))
        top = 2**24 - 2
        self.assertEqual(struct.unpack("<5I", found), (0, top // 2, top, top + 1, 0))


class ErrorTest(unittest.TestCase):
    def test_errors_are_counted_where_both_have_a_surface(self) -> None:
        found = compare(packed([0, 65534, 65535, 7]), packed([3, 65530, 5, 65535]), (1.0, math.e))
        metres = (math.exp(3 / 65534) - 1, math.e - math.exp(65530 / 65534))
        expected = (4, 9 + 16, max(metres), sum(m * m for m in metres), 2, 2)
        for got, wanted in zip(dataclasses.astuple(found), expected):
            self.assertAlmostEqual(got, wanted, 12)

    def test_metres_are_of_the_source_where_there_is_one(self) -> None:
        source = struct.pack("<2f", 1.5, 2.5)
        found = compare(packed([0, 65534]), packed([0, 65534]), (1.0, 2.0), source)
        self.assertEqual(found, Errors(0, 0, 0.5, 0.5, 2, 0))

    def test_24_bits_count_in_codes_of_16(self) -> None:
        found = compare(packed([0], True), packed([2**24 - 2], True), (1.0, 2.0), None, True)
        self.assertAlmostEqual(found.max_codes, 65534)

    def test_errors_of_streams_add_up(self) -> None:
        one, other = Errors(4, 25, 0.5, 0.25, 2, 1), Errors(1, 2, 1.5, 2.5, 3, 0)
        self.assertEqual(one + other, Errors(4, 27, 1.5, 2.75, 5, 1))
        self.assertEqual((one + other).fields()["rms_error_codes"], math.sqrt(27 / 5))


class FileTest(unittest.TestCase):
    def test_png_of_colour_and_of_16_bits(self) -> None:
        chance, path = np.random.default_rng(7), FOLDER / "image.png"
        for shape, kind in (((11, 9), np.uint16), ((11, 9, 3), np.uint8)):
            pixels = chance.integers(0, np.iinfo(kind).max, shape, kind, endpoint=True)
            PIL.Image.fromarray(pixels).save(path)
            self.assertEqual(pf.png_bytes(path), pixels.astype(pixels.dtype.newbyteorder("<")).tobytes())
        PIL.Image.new("RGBA", (9, 11)).save(path)
        with self.assertRaisesRegex(ValueError, "has alpha"):
            pf.png_bytes(path)

    def test_datasets_of_png_come_back(self) -> None:
        film, folder = color_film(), FOLDER / "dataset"
        manifest = json.dumps({"files": {"color": "{probe}/{face}.%04d.png"}})
        pf.write_dataset(folder, manifest, film, film.payloads)
        self.assertEqual(len(list(folder.rglob("*.png"))), film.frames)
        self.assertTrue((folder / "a" / "px.0004.png").is_file())
        self.assertEqual(pf.read_dataset(folder, film.streams), film.payloads)

    def test_exr_of_metres(self) -> None:
        depth, path = np.arange(105, dtype=np.float32).reshape(21, 5) / 4, FOLDER / "image.exr"

        def write(compression: Any, channels: dict[str, images.Array]) -> None:
            with OpenEXR.File({"compression": compression, "type": OpenEXR.scanlineimage}, channels) as file:
                file.write(str(path))

        for compression in (OpenEXR.NO_COMPRESSION, OpenEXR.ZIPS_COMPRESSION, OpenEXR.ZIP_COMPRESSION, OpenEXR.PIZ_COMPRESSION):
            beside: dict[str, images.Array] = {"A": depth.astype(np.float16), "Z": depth}
            for channels in (beside, {"depth": depth}):
                write(compression, channels)
                self.assertEqual(pf.exr_metres(path, (5, 21)), depth.astype("<f4").tobytes())
        with self.assertRaisesRegex(pf.NotMeasured, "size of a face"):
            pf.exr_metres(path, (21, 5))
        for channels in ({"Z": depth.astype(np.float16)}, {"A": depth, "B": depth}):  # type: ignore[assignment]
            write(OpenEXR.ZIP_COMPRESSION, channels)
            with self.assertRaisesRegex(pf.NotMeasured, "32-bit floats"):
                pf.exr_metres(path, (5, 21))
        with self.assertRaisesRegex(pf.NotMeasured, "from EXR files"):
            pf.exr_metres(FOLDER / "none.exr", (5, 21))

    def test_paths_of_frames(self) -> None:
        stream = pf.Stream("00", "px", 7, 1)
        self.assertEqual(pf.frame_path("p_{probe}/{face}.%04d.exr", stream, 0), "p_00/px.0007.exr")
        self.assertEqual(pf.frame_path("{face}.####.exr", stream, 12338), "px.12345.exr")


def small_film() -> pf.Film:
    """Two streams of three 5x3 images of codes."""
    chance = random.Random(3)
    streams = [pf.Stream("a", face, 4, 3, (1.0, 9.0)) for face in ("px", "nx")]
    payloads = [packed([chance.choice([0, 300, 65534, 65535]) for _ in range(45)]) for _ in streams]
    return pf.Film("codes", 5, 3, "gray16le", 2, streams, payloads)


def color_film() -> pf.Film:
    """Two streams of three 64x64 images of smooth colour."""
    streams = [pf.Stream("a", face, 4, 3) for face in ("px", "nx")]
    y, x = np.mgrid[:64, :64]
    image = lambda at: np.stack([2 * x, 2 * y, x + y + 9 * at], axis=2).astype(np.uint8).tobytes()
    return pf.Film("color", 64, 64, "rgb24", 3, streams, [b"".join(map(image, range(3))) for _ in streams])


class ColorTest(unittest.TestCase):
    def test_a_search_comes_near_from_both_sides(self) -> None:
        measure = lambda at: 100 - 50 * math.exp(-at / 20)
        for start in (0.5, 7.0, 59.0):
            known: dict[float, float] = {}
            for wanted in (70, 80, 90):
                found = peers_color.search(measure, wanted, Dial(start, 1.0, 0, 60), known)
                self.assertLessEqual(abs(measure(found) - wanted), peers_color.NEAR)
            # What is known of one score serves the next.
            self.assertLessEqual(len(known), 2 * peers_color.TRIES)

    def test_a_search_knows_what_cannot_be_reached(self) -> None:
        dial = Dial(30, 1.0, 0, 63)
        self.assertIsNone(peers_color.search(lambda at: at, 70, dial, {}))
        # A step in what is measured: the lowest setting above it. What does not come down is shown at its fewest.
        found = peers_color.search(lambda at: 60.0 if at < 21.5 else 75.0, 70, dial, {})
        self.assertGreaterEqual(found or 0, 21.5)
        self.assertEqual(peers_color.search(lambda at: 80 + at, 70, dial, {}), 0)

    def test_coders_have_a_file_for_each_stream(self) -> None:
        film = color_film()
        for label in CODERS:
            codec = PerStream(label, film, FOLDER)
            try:
                codec.open()
            except pf.NotMeasured as error:
                self.assertRegex(str(error), "is not installed|has no lib")
                continue
            sizes: list[int] = []
            codec.at_once = len(codec.files)
            for codec.quality in (20, 45):
                codec.encode()
                sizes.append(codec.size())
            self.assertLess(*sizes)
            self.assertEqual(len({file.read_bytes()[:4] for file in codec.files}), 1)
            wanted, found = (np.frombuffer(b"".join(payloads), np.uint8).astype(int) for payloads in (film.payloads, codec.payloads()))
            self.assertGreater(images.psnr_db(float(((wanted - found) ** 2).sum()), wanted.size), 30)

    def test_libaom_mixes_whole_steps(self) -> None:
        steps = [CODERS["libaom, cpu-used 6"].options(30.25, at / 8)[5] for at in range(8)]
        self.assertEqual(steps, ["33"] * 6 + ["32"] * 2)

    def test_the_smoothest_and_the_busiest_place_are_found(self) -> None:
        y, x, _ = np.mgrid[:64, :64, :3]
        plain, slope, noise = (codes.astype(np.uint8).tobytes() for codes in (0 * x + 9, x // 2, (x * 37 + y * 91) % 251))
        streams = [pf.Stream("a", face, 0, 1) for face in ("px", "nx", "py")]
        film = pf.Film("color", 64, 64, "rgb24", 3, streams, [noise, plain, slope])
        self.assertEqual(peers_crops.places(film), {"smoothest": (2, 0, 0, 0), "busiest": (0, 0, 0, 0)})

    def test_crops_show_each_pixel_many_times(self) -> None:
        film = color_film()
        pixels = peers_crops.crop(film.pixels(film.payloads[0], 1), 32, 48)
        self.assertEqual(pixels.shape, (16, 32, 3))
        drawn = images.enlarged(pixels, 4)
        self.assertEqual(drawn.shape, (4 * 16, 4 * 32, 3))
        self.assertEqual(drawn[0, :5].tolist(), [[64, 96, 89]] * 4 + [[66, 96, 90]])
        self.assertTrue((drawn[:3] == drawn[1:4]).all())


class CodecTest(unittest.TestCase):
    def setUp(self) -> None:
        # What a contest says of its progress is not for the output of tests.
        quiet = contextlib.redirect_stderr(io.StringIO())
        quiet.__enter__()
        self.addCleanup(quiet.__exit__, None, None, None)

    def test_codecs_give_back_what_they_got(self) -> None:
        film = small_film()
        depth = Depth(film.streams, film.payloads, [], [])
        contest = Contest("set", "depth")
        for bound in (0, 100, 300):
            steps = pf.stepped(film, bound) if bound else film
            for codec in (Xz("xz", steps, 2, bound), Zstd("zstd", steps, 2, 3, bound), Rvl("RVL", steps, 2, KERNELS, bound)):
                contest.add(codec)
        contest.encode(2)
        contest.check(lambda codec: depth_errors(depth, codec))
        contest.decode(2)
        for row in contest.rows:
            with self.subTest(f"{row.label} {row.bound}"):
                self.assertFalse(row.note)
                self.assertEqual((len(row.encode_seconds), len(row.decode_seconds)), (2, 2))
                self.assertEqual((row.max_error_codes, row.background_wrong), (row.bound, 0))

    def test_a_codec_that_fails_names_its_reason_and_the_others_go_on(self) -> None:
        class Broken(Xz):
            def decode(self) -> float:
                raise pf.NotMeasured("it broke")

        contest = Contest("set", "depth")
        contest.add(Broken("broken", small_film(), 1))
        contest.add(Xz("xz", small_film(), 1))
        contest.encode(1)
        contest.decode(1)
        self.assertEqual([row.note for row in contest.rows], ["not measured: it broke", ""])
        self.assertEqual([len(row.decode_seconds) for row in contest.rows], [0, 1])

    def test_streams_begin_with_key_frames(self) -> None:
        self.assertEqual(key_frames(small_film()), ["-force_key_frames", "0.0000,0.1100"])
        # Without it x265 goes on referring to frames before a key frame that comes within a second of the last.
        self.assertIn("-forced-idr 1", " ".join(x265(small_film(), "1", "crf=18")))

    def test_ffv1_refuses_streams_of_unequal_length(self) -> None:
        film = small_film()
        film.streams[1].frames = 2
        film.payloads[1] = film.payloads[1][:2 * film.frame_bytes]
        given = Given("lightfold", KERNELS, FOLDER, "1", FOLDER / "lightfield.json")
        contest = Contest("set", "depth")
        contest.add(Ffv1("ffv1", film, given, bound=0))
        contest.encode(1)
        self.assertRegex(contest.rows[0].note, "^not measured: (ffv1 begins each stream .* not 2 to 3 frames|ffmpeg is not)")


class TableTest(unittest.TestCase):
    def rows(self) -> list[Row]:
        found = Row("set", "depth", "lightfold --max-error 0", 0, 2_000_000, [2.0, 1.0, 3.0], [0.004], 0.0, 0.0, 0.0, 0.0, 0)
        lossy = Row("set", "depth", "x265 crf 10", None, 1_000_000, [1.0], [0.008], 12.5, 1.25, 0.5, 0.125, 3, written_percent=100.0)
        why = "not measured: cjxl is not installed (apt-get install libjxl-tools)"
        missing = Row("set", "depth", "libjxl -d 0", 0, note=why)
        color = Row("set", "color", "hap", None, 5400, [2.0], [0.5], ssimulacra2=81.25, psnr_db=math.inf, asked="–", pixels=3_000_000)
        promised = Row("set", "color", "lightfold", None, 5400, asked="every cell 40", lowest_cell_db=40.011)
        return [found, lossy, missing, color, promised]

    def test_csv_has_a_field_for_each_column(self) -> None:
        lines = peers_table.csv_rows(self.rows(), "a, b", "2000-01-01T00:00:00Z")
        self.assertEqual(lines[0], peers_table.CSV_HEAD)
        self.assertEqual({len(line) for line in lines}, {len(peers_table.CSV_HEAD)})
        first = dict(zip(*lines[:2]))
        self.assertEqual((first["encode_s"], first["encode_low_s"], first["encode_high_s"]), ("2", "1", "3"))
        self.assertEqual((first["bytes"], first["background_wrong"], first["psnr_db"]), (2_000_000, 0, ""))
        self.assertIn("cjxl", lines[3][-1])

    def test_markdown_has_a_cell_for_each_column(self) -> None:
        text, colors = (peers_table.markdown(self.rows(), "a machine", stream) for stream in ("depth", "color"))
        for table in (part for part in f"{text}\n\n{colors}".split("\n\n") if part.startswith("|")):
            self.assertEqual(len({line.count("|") for line in table.splitlines()}), 1, table)
        self.assertIn("| set | – | hap | 5 | 81.25 |  |  |  | inf |  | 1.5 | 6 |", colors)
        self.assertIn("|\n\n| set | asked |", colors)
        self.assertIn("| set | every cell 40 | lightfold | 5 |  |  |  |  |  | 40.01 |", colors)
        self.assertIn("| set | – | x265 crf 10 | 1.00 | 0.50 | 1.00 | 8.0 | 2.00 | 100.0 | 12.5 | 1.25 | 0.5 | 0.12 | 3 |", text)
        self.assertNotIn("<details>", text)
        second = [Row("other", "depth", "lightfold --max-error 0", 0, 5, [1.0], [1.0])]
        self.assertIn("<details><summary>other, depth</summary>\n\n| set |", peers_table.markdown(self.rows() + second, "a", "depth"))
        self.assertIn("| libjxl -d 0 | not measured: cjxl is not installed (apt-get install libjxl-tools) |", text)


class CommandTest(unittest.TestCase):
    def test_a_set_may_name_a_stream(self) -> None:
        path = FOLDER / "lightfield.json"
        path.write_text(json.dumps({"lightfield": 1, "name": "film", "files": {"depth": "a", "color": "b"}}))
        found = module_of("peers").manifests([f"{path}:depth", str(path), f"{path.parent}:color"])
        self.assertEqual(found, [("film", path, "depth"), ("film", path, None), ("film", path, "color")])

    def refused(self, *words: Any) -> str:
        """What the script says on standard error, in one line."""
        out, told = io.StringIO(), io.StringIO()
        with unittest.mock.patch.object(sys, "argv", ["peers", *map(str, words)]), contextlib.redirect_stdout(out), \
                contextlib.redirect_stderr(told):
            code = module_of("peers").main()
        self.assertEqual((code, out.getvalue(), told.getvalue().count("\n")), (2, "", 1), told.getvalue())
        return told.getvalue()

    def test_a_wrong_manifest_is_one_sentence(self) -> None:
        done = subprocess.run([sys.executable, HERE / "peers", "nowhere.json"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (2, "", self.refused("nowhere.json")))
        self.assertIn("nowhere.json is neither", done.stderr)
        path = FOLDER / "lightfield.json"
        for text in ("{", "[]", "{}", json.dumps({"lightfield": 2, "files": {}})):
            path.write_text(text)
            self.assertIn("is not a manifest", self.refused(path))
        self.assertIn("--bound 1,x", self.refused("--bound", "1,x"))


RATIOS = """\
threads: 2
container                streams     Mpixel   changed  plain MB/s  decode MB/s  of plain
a.lfold                  depth          7.1    20.63%       12257          492      4.1%

lerp, one thread           copy MB/s    lerp MB/s   of copy
cells in the cache            100725         9030      8.9%

packed nodes             frames     threads   Mpixel   changed   copy MB/s  decode MB/s   of copy
a.lfold                  key              2      1.2   100.00%       25339         1991      7.9%
"""


class RecordTest(unittest.TestCase):
    def test_rows_of_rays_are_found_in_what_the_bench_prints(self) -> None:
        text = ("scene      triangles build s   camera   256    512   1024   shadow random   sees shaded\n"
                "landscape     250632    0.17            4.10   4.63   5.14     1.94   1.52   1.56   1.86\n"
                "sponza.glb is not measured: it is not there\n")
        bench = module_of("bench")
        self.assertEqual(bench.rays_of(text), [["landscape", "250632", "0.17", "4.10", "4.63", "5.14", "1.94", "1.52",
                                                "1.56", "1.86"]])

    def test_rows_of_pictures_are_found_in_what_the_bench_prints(self) -> None:
        text = ("/tmp/x/sponza9.lfold: 9 views\n"
                "                                               Mpixel/s  steps a ray  refine a ray\n"
                "256²; 64 steps + 8; 9 views; pyramid              1.020         7.53          7.98\n\n")
        self.assertEqual(module_of("bench").pixels_of(text),
                         [["sponza9", "256²; 64 steps + 8; 9 views; pyramid", "1.020", "7.53", "7.98"]])

    def test_figures_are_found_in_what_the_bench_prints(self) -> None:
        figures = module_of("bench").figures_of(RATIOS)
        self.assertEqual(len(figures), 9)
        self.assertIn(["ratios: a.lfold streams depth, of plain", "4.1", "%"], figures)
        self.assertIn(["ratios: cells in the cache, lerp", "9030", "MB/s"], figures)
        self.assertIn(["ratios: a.lfold frames key threads 2, decode", "1991", "MB/s"], figures)

    def test_rows_are_appended_under_one_head(self) -> None:
        bench, path = module_of("bench"), FOLDER / "timings.csv"
        free, half = 0.25 * (os.cpu_count() or 1), 0.5 * (os.cpu_count() or 1)
        for value, load in (("1", free), ("2", half), ("3", half + 0.01)):
            bench.record([["a figure, of one", value, "s"]], "scripts/bench --record", load, path)
        lines = list(csv.reader(path.read_text().splitlines()))
        self.assertEqual(lines[0], bench.HEAD)
        wanted = [["scripts/bench --record", "a figure, of one", value, "s", note]
                  for value, note in (("1", ""), ("2", ""), ("3", "busy"))]
        self.assertEqual([line[3:] for line in lines[1:]], wanted)
        self.assertRegex(lines[1][0], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")

    def test_what_is_recorded_has_every_column(self) -> None:
        bench = module_of("bench")
        lines = list(csv.reader(bench.TIMINGS.read_text().splitlines()))
        self.assertEqual(lines[0], bench.HEAD)
        for line in lines[1:]:
            self.assertEqual(len(line), len(bench.HEAD), line)
            float(line[5])
            self.assertIn(line[7], ("", "busy"))


if __name__ == "__main__":
    unittest.main()
