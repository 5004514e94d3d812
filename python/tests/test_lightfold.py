"""Encodes arrays, and decodes them again."""

import signal
import tempfile
import threading
import unittest
from pathlib import Path

import numpy as np

import film
import lightfold
from film import FRAMES, SIDE


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "film.lfold"

    def encode(self, *arguments, **settings):
        lightfold.encode(self.path, *arguments, **settings)
        return lightfold.open(self.path)


class Decode(Folder):
    def setUp(self):
        super().setUp()
        film.write(self.path, max_error=0, psnr=40)
        self.film = lightfold.open(str(self.path))

    def test_what_a_container_tells(self):
        self.assertEqual((self.film.name, self.film.fps), ("film", 24.0))
        self.assertEqual(self.film.probes, [lightfold.Probe("00", position=(0, 1.5, 0))])
        kinds = [(stream.kind, stream.face) for stream in self.film.streams]
        self.assertEqual(kinds, [(kind, face) for kind in ["color", "depth"] for face in lightfold.FACES])
        stream = self.film.stream("depth", "00", "ny")
        self.assertIs(stream, self.film.streams[9])
        self.assertEqual((stream.probe, stream.size, stream.shape), ("00", (SIDE, SIDE), (SIDE, SIDE)))
        self.assertEqual((stream.frames, stream.codec), (range(FRAMES), "predictive"))
        self.assertEqual((stream.near_m, stream.far_m, stream.error_bound_codes), (2.0, 5.0, 0))
        color = self.film.stream("color", face="px")
        self.assertEqual((color.shape, color.dtype, color.near_m), ((SIDE, SIDE, 3), np.uint8, None))

    def test_depth(self):
        for face in lightfold.FACES:
            stream = self.film.stream("depth", face=face)
            for frame in [0, 3, 1, 2]:
                source = film.depth_of(face, frame)
                metres = stream.decode(frame)
                self.assertEqual(metres.dtype, np.float32)
                np.testing.assert_allclose(metres, source, rtol=1e-5)
                codes = stream.decode(frame, np.uint16)
                np.testing.assert_array_equal(codes, np.where(source < 3, 0, 65534))

    def test_color(self):
        stream = self.film.stream("color", face="pz")
        for frame in stream.frames:
            codes, half, single = (stream.decode(frame, dtype) for dtype in [None, "float16", np.dtype(np.float32)])
            self.assertEqual([array.dtype for array in [codes, half, single]], [np.uint8, np.float16, np.float32])
            np.testing.assert_array_equal(half.astype(np.float32), single)
            np.testing.assert_allclose(single, srgb_decoded(codes), atol=1e-3)
            error = codes / 255 - srgb_encoded(film.color_of("pz", frame))
            self.assertGreater(-10 * np.log10(np.mean(error**2)), 40)

    def test_into_an_array(self):
        stream = self.film.stream("depth", face="px")
        out = np.empty((2, SIDE, SIDE), np.uint16)
        self.assertIs(stream.decode(1, out=out[0]).base, out)
        np.testing.assert_array_equal(out[0], stream.decode(1, np.uint16))
        for wrong in [out, out[0].T, out[0, :8], out[0].astype(np.float32)[::-1], "word", out[0].astype(np.int16)]:
            with self.assertRaises(lightfold.Error):
                stream.decode(1, out=wrong)
        with self.assertRaisesRegex(lightfold.Error, "`out` is no contiguous array of shape"):
            stream.decode(1, np.float32, out=out[0])
        out.flags.writeable = False
        with self.assertRaisesRegex(lightfold.Error, "not writeable"):
            stream.decode(1, out=out[0])

    def test_threads_decode_at_once(self):
        streams = self.film.streams
        found = {}

        def work(at):
            found[at] = [streams[at % 12].decode(frame).copy() for frame in range(FRAMES)]

        threads = [threading.Thread(target=work, args=(at,)) for at in range(24)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for at in range(24):
            for frame in range(FRAMES):
                np.testing.assert_array_equal(found[at][frame], streams[at % 12].decode(frame))

    def test_what_is_not_there(self):
        stream = self.film.stream("depth", face="px")
        for frame in [-1, 4, 1 << 40]:
            with self.assertRaisesRegex(IndexError, f"frame {frame} is not one of the stream's frames 0-3"):
                stream.decode(frame)
        for arguments in [("depth",), ("depth", "01"), ("depth", "00", "view"), ("normal",)]:
            with self.assertRaises(KeyError):
                self.film.stream(*arguments)
        with self.assertRaisesRegex(lightfold.Error, "does not decode to uint8: float32 and uint16 are possible"):
            stream.decode(0, np.uint8)
        with self.assertRaises(TypeError):
            stream.decode(0, "no type")
        self.assertTrue(issubclass(lightfold.Error, ValueError))

    def test_files_that_cannot_be_read(self):
        missing = self.path.with_name("missing.lfold")
        with self.assertRaises(FileNotFoundError) as caught:
            lightfold.open(missing)
        self.assertEqual(caught.exception.filename, str(missing))
        data = bytearray(self.path.read_bytes())
        self.path.write_bytes(data[:-1])
        with self.assertRaisesRegex(lightfold.Error, "film.lfold: "):
            lightfold.open(self.path)
        data[100] ^= 1
        self.path.write_bytes(data)
        with self.assertRaisesRegex(lightfold.Error, "damaged"):
            lightfold.open(self.path).statistics()

    def test_statistics(self):
        statistics = self.film.statistics()
        self.assertEqual(statistics["file_bytes"], self.path.stat().st_size)
        self.assertEqual(statistics["frames"], 2 * 6 * FRAMES)
        stored = sum(stream["bytes"] for stream in statistics["streams"])
        self.assertEqual(stored + statistics["overhead_bytes"], statistics["file_bytes"])
        self.assertEqual(statistics["streams"][6]["background"], float("inf"))


class Encode(Folder):
    def test_views_of_two_probes(self):
        rng = np.random.default_rng(1)
        depth = rng.uniform(1, 2, (2, 3, 16, 24))
        depth[1, 0, 2, 5] = np.inf
        probes = ["left", lightfold.Probe("right", (0.5, 0, 0), (0, 1, 0, 0), (20, 20, 12, 8))]
        found = self.encode(probes, depth=depth, max_error=0, fps=30, name="room", first_frame=7)
        self.assertEqual((found.name, found.fps), ("room", 30.0))
        self.assertEqual(found.probes, [lightfold.Probe("left"), probes[1]])
        stream = found.stream("depth", "right")
        self.assertEqual((stream.face, stream.frames, stream.shape), ("view", range(7, 10), (16, 24)))
        for at, frame in enumerate(stream.frames):
            np.testing.assert_allclose(stream.decode(frame), depth[1, at], rtol=1e-5)

    def test_probes_without_some_images(self):
        depth, color = np.ones((1, 8, 8)), np.ones((2, 8, 8, 3))
        found = self.encode(["a", "b"], depth=[None, depth], color=[color, color])
        self.assertEqual([(s.kind, s.probe) for s in found.streams], [("color", "a"), ("color", "b"), ("depth", "b")])

    def test_frames_from_a_generator(self):
        found = self.encode(depth=[(np.full((8, 8), 1.0 + frame) for frame in range(3))])
        self.assertEqual([round(float(found.streams[0].decode(frame)[0, 0])) for frame in range(3)], [1, 2, 3])

    def test_codes_of_color_stay(self):
        codes = np.arange(256, dtype=np.uint8).reshape(1, 16, 16, 1).repeat(3, 3)
        stream = self.encode(color=[codes], color_qp=0).stream("color")
        self.assertLessEqual(np.abs(stream.decode(0).astype(int) - codes[0]).max(), 1)
        stream = self.encode(color=[codes[:, ::-1]], psnr=200).stream("color")
        np.testing.assert_array_equal(stream.decode(0), codes[0, ::-1])

    def test_half_floats(self):
        light = np.linspace(0, 8, 16 * 16 * 3).reshape(1, 16, 16, 3)
        stream = self.encode(color=[light], hdr=True, psnr=60).stream("color")
        self.assertEqual((stream.dtype, stream.codec), (np.float16, "transform-half"))
        for dtype in [np.float16, np.float32]:
            np.testing.assert_allclose(stream.decode(0, dtype), light[0], rtol=0.05, atol=0.01)
        with self.assertRaisesRegex(lightfold.Error, "float16 and float32 are possible"):
            stream.decode(0, np.uint8)

    def test_material(self):
        material = np.broadcast_to(np.array([0.5, 0.25, 1.5]), (2, 8, 8, 3))
        stream = self.encode(material=[material]).stream("material")
        np.testing.assert_allclose(stream.decode(1), material[1], atol=0.005)
        self.assertEqual(stream.decode(1, np.uint8)[0, 0].tolist()[:2], [128, 64])

    def test_alpha(self):
        alpha = np.broadcast_to(np.linspace(0, 1, 8), (2, 4, 8))
        stream = self.encode(alpha=[alpha]).stream("alpha")
        self.assertEqual((stream.dtype, stream.shape), (np.float32, (4, 8)))
        np.testing.assert_allclose(stream.decode(1), alpha[1], atol=0.5 / 255 + 1e-6)
        np.testing.assert_array_equal(stream.decode(0, np.uint8), np.round(255 * alpha[0]).astype(np.uint8))
        with self.assertRaisesRegex(lightfold.Error, "has an alpha of 2: 0 to 1 was expected"):
            self.encode(alpha=[2 * np.ones((1, 4, 8))])

    def test_depth_outside_near_and_far(self):
        depth = np.broadcast_to(np.linspace(1, 4, 256).reshape(1, 16, 16), (1, 16, 16))
        with self.assertRaisesRegex(lightfold.Error, "outside the range"):
            self.encode(depth=[depth], near=2.0, far=3.0)
        for rule, values in (("near", (2.0, 3.0)), ("far", (np.inf, np.inf))):
            decoded = self.encode(depth=[depth], near=2.0, far=3.0, invalid_depth=rule, max_error=0).stream("depth").decode(0)
            np.testing.assert_allclose(decoded.ravel()[[0, -1]], values, rtol=1e-5)

    def test_settings_reach_the_stream(self):
        depth = np.broadcast_to(np.linspace(1, 4, 256).reshape(1, 16, 16), (2, 16, 16))
        light = np.broadcast_to(np.linspace(0, 1, 768).reshape(16, 16, 3), (2, 16, 16, 3))
        settings = {
            "depth_codec": "quadtree", "max_error": 7, "depth_window": 3, "keyframe_interval": 9, "optimize": "size",
            "near": 0.5, "far": 8.0, "depth_domain": "inverse", "depth_tile": 8, "update_threshold": 2,
            "color_block": "bc7", "color_cell": 8, "psnr": 45, "psnr_final": 30, "exposure": 1, "transfer": "linear",
            "lookahead": 4, "effort": "fast", "lzma2": 3, "min_children": 2, "memory": 1 << 30,
        }  # fmt: skip
        color, depth = self.encode(depth=[depth], color=[light], **settings).statistics()["streams"]
        expected = {
            "codec": "quadtree", "max_error_codes": 7, "window": 3, "keyframe_interval": 9, "near_m": 0.5, "far_m": 8.0,
            "domain": "inverse", "unit_width": 8, "epsilon": 2, "zstd_chunks": 0,
        }  # fmt: skip
        self.assertEqual({key: depth[key] for key in expected}, expected)
        expected = {"unit_width": 8, "min_psnr_db": 30.0, "transfer": "linear", "exposure_ev": 1.0}
        self.assertEqual({key: color[key] for key in expected}, expected)
        self.assertTrue(color["codec"].startswith("cells"))

    def test_the_same_arrays_become_the_same_bytes(self):
        film.write(self.path)
        first = self.path.read_bytes()
        film.write(self.path)
        self.assertEqual(self.path.read_bytes(), first)

    def test_refusals(self):
        depth, color = np.ones((1, 8, 8)), np.ones((1, 8, 8, 3))
        cases = [
            ({}, "no stream of the selected kinds"),
            ({"depth": depth[0]}, "`depth` has 8 entries, there are 1 probes"),
            ({"depth": depth}, "frame 0 has the shape"),
            ({"depth": [depth.astype(np.uint16)]}, "`depth`: an array of uint16, floats were expected"),
            ({"color": [color.astype(np.uint16)]}, "`color`: an array of uint16, floats or uint8 were expected"),
            ({"color": [color[..., :1]]}, r"face view: frame 0 has the shape \[8, 8, 1\], \(height, width, 3\)"),
            ({"color": [color * np.nan]}, "not finite"),
            ({"depth": [[depth[0], depth[0, :4]]]}, "an image of"),
            ({"depth": [-depth]}, r"`depth` of probe 00, face view: pixel \(0, 0\) of frame 0 lies at -1 m"),
            ({"depth": [{"left": depth}]}, '"left" is no face'),
            ({"depth": [{"px": depth[:, :4]}]}, "square"),
            ({"depth": [depth], "fps": 0}, "`fps` 0"),
            ({"depth": [depth], "max_error": 65536}, "`max_error` 65536: "),
            ({"depth": [depth], "max_error": 1, "max_error_relative": 0.1}, "give one of `max_error`"),
            ({"depth": [depth], "depth_codec": "jpeg"}, "`depth_codec` \"jpeg\": one of predictive, quadtree"),
            ({"depth": [depth], "depth_window": 0}, "depth window must be 1 to 255"),
            ({"depth": [depth], "near": 3.0}, "hold no depth"),
            ({"color": [color], "psnr": 300}, "`psnr` 300: 0 to 200 dB"),
            ({"color": [color], "color_qp": 241}, "`color_qp` 241: 0 to 240"),
            ({"color": [color], "exposure": 9}, "`exposure` 9: -8 to 8 stops"),
            ({"color": [color], "hdr": True, "white": -1}, "white"),
            ({"color": [color], "hdr": True, "color_block": "bc7"}, "use bc6h with `hdr`"),
            ({"color": [color], "zstd": 20}, "`zstd` 20: 1 to 19"),
            ({"depth": [depth], "memory": 1}, "`memory`"),
        ]
        for arguments, words in cases:
            with self.subTest(words), self.assertRaisesRegex(lightfold.Error, words):
                self.encode(**arguments)
        for arguments in [{"max_error": "many"}, {"hdr": "yes"}, {"psnrr": 40}]:
            with self.subTest(arguments), self.assertRaisesRegex(TypeError, next(iter(arguments))):
                self.encode(depth=[depth], **arguments)
        with self.assertRaisesRegex(lightfold.Error, "not a new probe name"):
            self.encode(["a", "a"], depth=[depth, depth])
        self.assertEqual(list(self.path.parent.iterdir()), [])

    def test_a_folder_that_is_not_there(self):
        with self.assertRaises(FileNotFoundError):
            lightfold.encode(self.path.with_name("no") / "film.lfold", depth=[np.ones((1, 8, 8))])

    @unittest.skipUnless(hasattr(signal, "pthread_kill"), "signals of threads are of POSIX")
    def test_interruption_leaves_no_file(self):
        # A shell may have started Python with the signal ignored.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        # Signals are looked for between streams.
        light = np.random.default_rng(2).uniform(0, 1, (200, 1, 128, 128, 3)).astype(np.float16)
        probes = [str(at) for at in range(len(light))]
        main = threading.main_thread().ident
        timer = threading.Timer(0.3, signal.pthread_kill, (main, signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            self.encode(probes, color=light)
        timer.join()
        self.assertEqual(list(self.path.parent.iterdir()), [])


def srgb_encoded(light):
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def srgb_decoded(codes):
    value = codes / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


if __name__ == "__main__":
    unittest.main()
