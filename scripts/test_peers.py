"""Tests of what scripts/peers measures with, and of what scripts/bench records: python3 -m unittest discover -s scripts"""

import contextlib
import csv
import importlib.machinery
import importlib.util
import io
import itertools
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
import zlib

import peers_color
import peers_crops
import peers_frames as pf
import peers_table
import png_images
from peers_codecs import CODERS, Dial, Ffv1, PerStream, Rvl, Xz, Zstd, key_frames, x265
from peers_kernels import Kernels
from peers_measure import Contest, Depth, Row, depth_errors

HERE = pathlib.Path(__file__).resolve().parent


def setUpModule():
    global WORK, KERNELS
    WORK = tempfile.TemporaryDirectory()
    KERNELS = Kernels(WORK.name)


def tearDownModule():
    WORK.cleanup()


def packed(codes, wide=False):
    return struct.pack(f"<{len(codes)}{'I' if wide else 'H'}", *codes)


def hard_images():
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
    def test_every_image_comes_back(self):
        for name, codes in hard_images():
            with self.subTest(name):
                data = packed(codes)
                out = KERNELS.rvl_decode(KERNELS.rvl_encode(data), len(codes))
                self.assertEqual(out.raw[:len(data)], data)

    def test_the_nibbles_are_those_of_the_paper(self):
        # 2 empty, 3 others with differences 5, 0, 1 as zigzag 10, 0, 2; 1 empty, 0 others.
        self.assertEqual(KERNELS.rvl_encode(packed([0, 0, 5, 5, 6, 0])), struct.pack("<I", 0x23A10210))

    def test_bytes_of_something_else_are_refused(self):
        coded = KERNELS.rvl_encode(packed([0, 5, 6] * 100))
        for wrong, pixels in ((coded[:-4], 300), (coded, 299), (b"", 1), (b"\xff" * 64, 300)):
            with self.assertRaises(ValueError):
                KERNELS.rvl_decode(wrong, pixels)
        with self.assertRaises(ValueError):
            KERNELS.rvl_decode(KERNELS.rvl_encode(packed([0] * 300)), 299)

    def test_background_becomes_empty_and_comes_back(self):
        codes = packed([0, 1, 65534, 65535])
        turned = KERNELS.rotate(codes, 65536)
        self.assertEqual(turned, packed([1, 2, 65535, 0]))
        self.assertEqual(KERNELS.rotate(turned, 65536, back=True), codes)
        self.assertEqual(KERNELS.rotate(packed([0, 325, 326]), 327), packed([1, 326, 0]))


def dealt(code):
    """CALF 7.1, read literally: (red, green, blue)."""
    channels = [0, 0, 0]
    for i in range(24):
        channels[i % 3] |= (code >> i & 1) << (i // 3)
    return channels


class MappingTest(unittest.TestCase):
    def test_bits_are_dealt_out_in_turn(self):
        for wide, codes in ((True, [0, 1, 2, 4, 8, 0xABCDEF, 0xFFFFFF]), (False, [0, 1, 2, 4, 8, 0xABCD, 0xFFFF])):
            planes = KERNELS.swizzle(packed(codes, wide), wide)
            green, blue, red = (planes[at:at + len(codes)] for at in range(0, len(planes), len(codes)))
            self.assertEqual([list(pixel) for pixel in zip(red, green, blue)], [dealt(code) for code in codes])
            self.assertEqual(KERNELS.unswizzle(planes, wide), packed(codes, wide))

    def test_every_16_bit_code_comes_back(self):
        codes = packed(range(65536))
        self.assertEqual(KERNELS.unswizzle(KERNELS.swizzle(codes)), codes)

    def test_steps_keep_their_bound_and_the_background(self):
        film = pf.Film("codes", 256, 256, "gray16le", 2, [pf.Stream("a", "px", 0, 1)], [packed(range(65536))])
        narrowest = {0: "gray16le", 7: "gray16le", 8: "gray12le", 100: "gray10le", 300: "gray", 16000: "gray"}
        for bound, kind in narrowest.items():
            steps = pf.stepped(film, bound)
            self.assertEqual(steps.pixel_format, kind)
            [back] = [struct.unpack("<65536H", steps.back(payload)) for payload in steps.payloads]
            self.assertEqual(back[65535], 65535)
            self.assertEqual(max(abs(code - found) for code, found in enumerate(back[:65535])), min(bound, 65534))
            self.assertNotIn(65535, back[:65535])

    def test_the_narrowest_gray_holds_every_level(self):
        found = [pf.gray_of(levels) for levels in (256, 257, 1024, 1025, 4096, 4097)]
        self.assertEqual(found, ["gray", "gray10le", "gray10le", "gray12le", "gray12le", "gray16le"])

    def test_codes_of_24_bits(self):
        metres = struct.pack("<5f", 1.0, 2.0, 4.0, math.inf, 0.5)
        found = KERNELS.codes24(metres, packed([0, 1, 65534, 65535, 0]), 1.0, 4.0)
        top = 2**24 - 2
        self.assertEqual(struct.unpack("<5I", found), (0, top // 2, top, top + 1, 0))


class ErrorTest(unittest.TestCase):
    def test_errors_are_counted_where_both_have_a_surface(self):
        found = KERNELS.compare(packed([0, 65534, 65535, 7]), packed([3, 65530, 5, 65535]), (1.0, math.e))
        metres = (math.exp(3 / 65534) - 1, math.e - math.exp(65530 / 65534))
        expected = (4, 9 + 16, max(metres), sum(m * m for m in metres), 2, 2)
        for got, wanted in zip(found, expected):
            self.assertAlmostEqual(got, wanted, 12)

    def test_metres_are_of_the_source_where_there_is_one(self):
        source = struct.pack("<2f", 1.5, 2.5)
        found = KERNELS.compare(packed([0, 65534]), packed([0, 65534]), (1.0, 2.0), source)
        self.assertEqual(found, (0, 0, 0.5, 0.5, 2, 0))

    def test_24_bits_count_in_codes_of_16(self):
        found = KERNELS.compare(packed([0], True), packed([2**24 - 2], True), (1.0, 2.0), None, True)
        self.assertAlmostEqual(found[0], 65534)


def filtered(rows, step):
    """Rows of a PNG, with every filter in turn."""
    above, out = bytes(len(rows[0])), b""
    for row, kind in zip(rows, itertools.cycle(range(5))):
        line = []
        for x, value in enumerate(row):
            left = row[x - step] if x >= step else 0
            corner = above[x - step] if x >= step else 0
            near = min((left, above[x], corner), key=lambda guess: abs(left + above[x] - corner - guess))
            line.append((value - (0, left, above[x], (left + above[x]) // 2, near)[kind]) % 256)
        out += bytes([kind, *line])
        above = row
    return out


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def exr(width, rows, compression):
    """An EXR file with a channel A of half and Z of float; `rows` of floats."""
    head = b"v/1\x01\x02\0\0\0"
    kinds = b"".join(name + b"\0" + struct.pack("<IIII", kind, 0, 1, 1) for name, kind in ((b"A", 1), (b"Z", 2))) + b"\0"
    for name, kind, value in (
        (b"channels", b"chlist", kinds), (b"compression", b"compression", bytes([compression])),
        (b"dataWindow", b"box2i", struct.pack("<4i", 0, 0, width - 1, len(rows) - 1)),
    ):
        head += name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value
    head += b"\0"
    lines = 16 if compression == 3 else 1
    blocks = []
    for y in range(0, len(rows), lines):
        body = b"".join(struct.pack(f"<{width}e{width}f", *[0.5] * width, *row) for row in rows[y:y + lines])
        if compression == 3:
            halves = body[0::2] + body[1::2]
            body = zlib.compress(bytes([halves[0]] + [(b - a + 128) % 256 for a, b in zip(halves, halves[1:])]))
        blocks.append(struct.pack("<iI", y, len(body)) + body)
    offsets, at = b"", len(head) + 8 * len(blocks)
    for block in blocks:
        offsets += struct.pack("<Q", at)
        at += len(block)
    return head + offsets + b"".join(blocks)


class FileTest(unittest.TestCase):
    def test_png_with_every_filter(self):
        chance = random.Random(7)
        path = pathlib.Path(WORK.name) / "image.png"
        for bits, color, step in ((16, 0, 2), (8, 2, 3)):
            rows = [bytes(chance.choice([0, 1, 2, 9, 255]) for _ in range(9 * step)) for _ in range(11)]
            head = chunk(b"IHDR", struct.pack(">IIBBBBB", 9, 11, bits, color, 0, 0, 0))
            body = zlib.compress(filtered(rows, step))
            chunks = [head, chunk(b"IDAT", body[:20]), chunk(b"IDAT", body[20:]), chunk(b"IEND", b"")]
            path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))
            plain = b"".join(rows)
            if bits == 16:
                plain = struct.pack("<99H", *struct.unpack(">99H", plain))
            self.assertEqual(pf.png_image(KERNELS, path), plain)

    def test_datasets_of_png_come_back(self):
        film, folder = color_film(), pathlib.Path(WORK.name) / "dataset"
        manifest = json.dumps({"files": {"color": "{probe}/{face}.%04d.png"}})
        pf.write_dataset(folder, manifest, film, film.payloads)
        self.assertEqual(len(list(folder.rglob("*.png"))), film.frames)
        self.assertTrue((folder / "a" / "px.0004.png").is_file())
        self.assertEqual(pf.read_dataset(KERNELS, folder, film.streams), film.payloads)

    def test_exr_plain_and_in_zip(self):
        rows = [[0.25 * (x + 5 * y) for x in range(5)] for y in range(21)]
        wanted = struct.pack("<105f", *itertools.chain(*rows))
        path = pathlib.Path(WORK.name) / "image.exr"
        for compression in (0, 3):
            path.write_bytes(exr(5, rows, compression))
            self.assertEqual(pf.exr_floats(KERNELS, path), (5, 21, wanted))
        path.write_bytes(exr(5, rows, 4))
        with self.assertRaises(pf.NotMeasured):
            pf.exr_floats(KERNELS, path)

    def test_paths_of_frames(self):
        self.assertEqual(pf.frame_path("p_{probe}/{face}.%04d.exr", "00", "px", 7), "p_00/px.0007.exr")
        self.assertEqual(pf.frame_path("{face}.####.exr", "00", "px", 12345), "px.12345.exr")


def small_film():
    """Two streams of three 5x3 images of codes."""
    chance = random.Random(3)
    streams = [pf.Stream("a", face, 4, 3, (1.0, 9.0)) for face in ("px", "nx")]
    payloads = [packed([chance.choice([0, 300, 65534, 65535]) for _ in range(45)]) for _ in streams]
    return pf.Film("codes", 5, 3, "gray16le", 2, streams, payloads)


def color_film():
    """Two streams of three 64x64 images of smooth colour."""
    streams = [pf.Stream("a", face, 4, 3) for face in ("px", "nx")]
    image = lambda at: bytes(value for y in range(64) for x in range(64) for value in (2 * x, 2 * y, x + y + 9 * at))
    return pf.Film("color", 64, 64, "rgb24", 3, streams, [b"".join(map(image, range(3))) for _ in streams])


class ColorTest(unittest.TestCase):
    def test_a_search_comes_near_from_both_sides(self):
        measure = lambda at: 100 - 50 * math.exp(-at / 20)
        for start in (0.5, 7.0, 59.0):
            known = {}
            for wanted in (70, 80, 90):
                found = peers_color.search(measure, wanted, Dial(start, 1.0, 0, 60), known)
                self.assertLessEqual(abs(measure(found) - wanted), peers_color.NEAR)
            # What is known of one score serves the next.
            self.assertLessEqual(len(known), 2 * peers_color.TRIES)

    def test_a_search_knows_what_cannot_be_reached(self):
        dial = Dial(30, 1.0, 0, 63)
        self.assertIsNone(peers_color.search(lambda at: at, 70, dial, {}))
        # A step in what is measured: the lowest setting above it. What does not come down is shown at its fewest.
        found = peers_color.search(lambda at: 60.0 if at < 21.5 else 75.0, 70, dial, {})
        self.assertGreaterEqual(found, 21.5)
        self.assertEqual(peers_color.search(lambda at: 80 + at, 70, dial, {}), 0)

    def test_coders_have_a_file_for_each_stream(self):
        film = color_film()
        for label in CODERS:
            codec = PerStream(label, film, WORK.name)
            try:
                codec.open()
            except pf.NotMeasured as error:
                self.assertRegex(str(error), "is not installed|has no lib")
                continue
            sizes = []
            for codec.quality in (20, 45):
                codec.encode()
                sizes.append(codec.size())
            self.assertLess(*sizes)
            self.assertEqual(len({file.read_bytes()[:4] for file in codec.files}), 1)
            wanted, found = (b"".join(payloads) for payloads in (film.payloads, codec.payloads()))
            squares = sum((a - b) ** 2 for a, b in zip(wanted, found))
            self.assertGreater(png_images.psnr_db(squares, len(wanted)), 30)

    def test_libaom_mixes_whole_steps(self):
        steps = [CODERS["libaom, cpu-used 6"].options(30.25, at / 8)[5] for at in range(8)]
        self.assertEqual(steps, ["33"] * 6 + ["32"] * 2)

    def test_the_smoothest_and_the_busiest_place_are_found(self):
        plain, slope, noise = (bytes(of(x, y) for y in range(64) for x in range(64) for _ in range(3)) for of in (
            lambda x, y: 9, lambda x, y: x // 2, lambda x, y: (x * 37 + y * 91) % 251))
        streams = [pf.Stream("a", face, 0, 1) for face in ("px", "nx", "py")]
        film = pf.Film("color", 64, 64, "rgb24", 3, streams, [noise, plain, slope])
        self.assertEqual(peers_crops.places(film), {"smoothest": (2, 0, 0, 0), "busiest": (0, 0, 0, 0)})

    def test_crops_show_each_pixel_many_times(self):
        film = color_film()
        rows = peers_crops.crop(film, film.payloads[0], 1, 32, 48)
        self.assertEqual((len(rows), {len(row) for row in rows}), (16, {3 * 32}))
        drawn, line = png_images.enlarged(b"".join(rows), 32, 4), 3 * 4 * 32
        self.assertEqual(len(drawn), 4 * 16 * line)
        self.assertEqual(drawn[:15], bytes([64, 96, 89] * 4 + [66, 96, 90]))
        self.assertEqual(drawn[:3 * line], drawn[line:4 * line])


class CodecTest(unittest.TestCase):
    def setUp(self):
        # What a contest says of its progress is not for the output of tests.
        quiet = contextlib.redirect_stderr(io.StringIO())
        quiet.__enter__()
        self.addCleanup(quiet.__exit__, None, None, None)

    def test_codecs_give_back_what_they_got(self):
        film = small_film()
        depth = Depth(film.streams, film.payloads, [], [])
        contest = Contest("set", "depth")
        for bound in (0, 100, 300):
            steps = pf.stepped(film, bound) if bound else film
            for codec in (Xz("xz", steps, 2, bound), Zstd("zstd", steps, 2, 3, bound), Rvl("RVL", steps, 2, KERNELS, bound)):
                contest.add(codec)
        contest.encode(2)
        contest.check(lambda codec: depth_errors(KERNELS, depth, codec))
        contest.decode(2)
        for row in contest.rows:
            with self.subTest(f"{row.label} {row.bound}"):
                self.assertFalse(row.note)
                self.assertEqual((len(row.encode_seconds), len(row.decode_seconds)), (2, 2))
                self.assertEqual((row.max_error_codes, row.background_wrong), (row.bound, 0))

    def test_a_codec_that_fails_names_its_reason_and_the_others_go_on(self):
        class Broken(Xz):
            def decode(self):
                raise pf.NotMeasured("it broke")

        contest = Contest("set", "depth")
        contest.add(Broken("broken", small_film(), 1))
        contest.add(Xz("xz", small_film(), 1))
        contest.encode(1)
        contest.decode(1)
        self.assertEqual([row.note for row in contest.rows], ["not measured: it broke", ""])
        self.assertEqual([len(row.decode_seconds) for row in contest.rows], [0, 1])

    def test_streams_begin_with_key_frames(self):
        self.assertEqual(key_frames(small_film()), ["-force_key_frames", "0.0000,0.1100"])
        # Without it x265 goes on referring to frames before a key frame that comes within a second of the last.
        self.assertIn("-forced-idr 1", " ".join(x265(small_film(), 1, "crf=18")))

    def test_ffv1_refuses_streams_of_unequal_length(self):
        film = small_film()
        film.streams[1].frames = 2
        film.payloads[1] = film.payloads[1][:2 * film.frame_bytes]
        contest = Contest("set", "depth")
        contest.add(Ffv1("ffv1", film, "1", WORK.name, bound=0))
        contest.encode(1)
        self.assertRegex(contest.rows[0].note, "^not measured: (ffv1 begins each stream .* not 2 to 3 frames|ffmpeg is not)")


class TableTest(unittest.TestCase):
    def rows(self):
        found = Row("set", "depth", "lightfold --max-error 0", 0, 2_000_000, [2.0, 1.0, 3.0], [0.004], 0.0, 0.0, 0.0, 0.0, 0)
        lossy = Row("set", "depth", "x265 crf 10", None, 1_000_000, [1.0], [0.008], 12.5, 1.25, 0.5, 0.125, 3, written_percent=100.0)
        why = "not measured: cjxl is not installed (apt-get install libjxl-tools)"
        missing = Row("set", "depth", "libjxl -d 0", 0, note=why)
        color = Row("set", "color", "hap", None, 5400, [2.0], [0.5], ssimulacra2=81.25, psnr_db=math.inf, asked="–", pixels=3_000_000)
        promised = Row("set", "color", "lightfold", None, 5400, asked="every cell 40", lowest_cell_db=40.011)
        return [found, lossy, missing, color, promised]

    def test_csv_has_a_field_for_each_column(self):
        lines = peers_table.csv_rows(self.rows(), "a, b", "2000-01-01T00:00:00Z")
        self.assertEqual(lines[0], peers_table.CSV_HEAD)
        self.assertEqual({len(line) for line in lines}, {len(peers_table.CSV_HEAD)})
        first = dict(zip(*lines[:2]))
        self.assertEqual((first["encode_s"], first["encode_low_s"], first["encode_high_s"]), ("2", "1", "3"))
        self.assertEqual((first["bytes"], first["background_wrong"], first["psnr_db"]), (2_000_000, 0, ""))
        self.assertIn("cjxl", lines[3][-1])

    def test_markdown_has_a_cell_for_each_column(self):
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
    def test_a_set_may_name_a_stream(self):
        path = pathlib.Path(WORK.name) / "lightfield.json"
        path.write_text(json.dumps({"lightfield": 1, "name": "film", "files": {"depth": "a", "color": "b"}}))
        found = script("peers").manifests([f"{path}:depth", str(path), f"{path.parent}:color"])
        self.assertEqual(found, [("film", path, "depth"), ("film", path, None), ("film", path, "color")])

    def refused(self, *words):
        done = subprocess.run([sys.executable, HERE / "peers", *words], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1), done.stderr)
        return done.stderr

    def test_a_wrong_manifest_is_one_sentence(self):
        path = pathlib.Path(WORK.name) / "lightfield.json"
        self.assertIn("nowhere.json is neither", self.refused("nowhere.json"))
        for text in ("{", "[]", "{}", json.dumps({"lightfield": 2, "files": {}})):
            path.write_text(text)
            self.assertIn("is not a manifest", self.refused(path))
        self.assertIn("--bound 1,x", self.refused("--bound", "1,x"))


def script(name):
    """A script without an ending as a module."""
    loader = importlib.machinery.SourceFileLoader(name, str(HERE / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


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
    def test_rows_of_rays_are_found_in_what_the_bench_prints(self):
        text = ("scene      triangles build s   camera   256    512   1024   shadow random   sees shaded\n"
                "landscape     250632    0.17            4.10   4.63   5.14     1.94   1.52   1.56   1.86\n"
                "sponza.glb is not measured: it is not there\n")
        bench = script("bench")
        self.assertEqual(bench.rays_of(text), [["landscape", "250632", "0.17", "4.10", "4.63", "5.14", "1.94", "1.52",
                                                "1.56", "1.86"]])

    def test_rows_of_pictures_are_found_in_what_the_bench_prints(self):
        text = ("/tmp/x/sponza9.lfold: 9 views\n"
                "                                               Mpixel/s  steps a ray  refine a ray\n"
                "256²; 64 steps + 8; 9 views; pyramid              1.020         7.53          7.98\n\n")
        self.assertEqual(script("bench").pixels_of(text),
                         [["sponza9", "256²; 64 steps + 8; 9 views; pyramid", "1.020", "7.53", "7.98"]])

    def test_figures_are_found_in_what_the_bench_prints(self):
        figures = script("bench").figures_of(RATIOS)
        self.assertEqual(len(figures), 9)
        self.assertIn(["ratios: a.lfold streams depth, of plain", "4.1", "%"], figures)
        self.assertIn(["ratios: cells in the cache, lerp", "9030", "MB/s"], figures)
        self.assertIn(["ratios: a.lfold frames key threads 2, decode", "1991", "MB/s"], figures)

    def test_rows_are_appended_under_one_head(self):
        bench, path = script("bench"), pathlib.Path(WORK.name) / "timings.csv"
        free, half = 0.25 * os.cpu_count(), 0.5 * os.cpu_count()
        for value, load in (("1", free), ("2", half), ("3", half + 0.01)):
            bench.record([["a figure, of one", value, "s"]], "scripts/bench --record", load, path)
        lines = list(csv.reader(path.open()))
        self.assertEqual(lines[0], bench.HEAD)
        wanted = [["scripts/bench --record", "a figure, of one", value, "s", note]
                  for value, note in (("1", ""), ("2", ""), ("3", "busy"))]
        self.assertEqual([line[3:] for line in lines[1:]], wanted)
        self.assertRegex(lines[1][0], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")

    def test_what_is_recorded_has_every_column(self):
        bench = script("bench")
        lines = list(csv.reader(bench.TIMINGS.open()))
        self.assertEqual(lines[0], bench.HEAD)
        for line in lines[1:]:
            self.assertEqual(len(line), len(bench.HEAD), line)
            float(line[5])
            self.assertIn(line[7], ("", "busy"))


if __name__ == "__main__":
    unittest.main()
