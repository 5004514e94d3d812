"""Tests of scripts/capture: python3 -m unittest discover -s scripts

What the adapters share is tested with a renderer of a few lines. The adapters themselves are run with a room whose geometry
is known, where a Python with Mitsuba or with bpy is found: this one, or the interpreter that LIGHTFOLD_MITSUBA or LIGHTFOLD_BPY
names. Skipped tests are reported.
"""

import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
from typing import Any, Iterator

from for_tests import HERE, TARGET, Folder, lightfold, need_packages

need_packages()
import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402

import images  # noqa: E402
from images import Array  # noqa: E402

CAPTURE = HERE / "capture"
sys.path.insert(0, str(CAPTURE))
import exr  # noqa: E402
import layout  # noqa: E402

sys.path.remove(str(CAPTURE))

Vector = tuple[float, float, float]
# A turn of 86 degrees about an axis of no face.
TURN = [value / math.sqrt(30) for value in (1, 2, 3, 4)]
CAMERAS = {"lightfold_cameras": 1, "cameras": [
    {"position": [0.2, 1.5, 0.1], "gain": 0.5, "coverage": 0.5},
    {"name": "turned", "position": [0.6, 1.1, -0.3], "orientation": TURN, "fov_y_deg": 80}]}


# ---- a room whose geometry is known

LOW, HIGH = (-2.0, 0.0, -4.0), (3.0, 2.5, 1.5)
# What each wall radiates, by the face that it fills: half of it, and the other half DIM times as much.
WALLS = {"px": (0.8, 0.1, 0.2), "nx": (0.1, 0.7, 0.3), "py": (0.2, 0.1, 0.9), "ny": (0.9, 0.6, 0.1), "pz": (0.3, 0.8, 1.5),
         "nz": (1.2, 0.2, 0.6)}
# Centre, radius, what it is made of. The first one moves by STEP from frame to frame.
BALLS = [((-1.0, 0.5, -2.5), 0.5, "black"), ((2.0, 0.6, -2.0), 0.4, "glass"), ((-1.0, 0.6, 0.6), 0.4, "mirror")]
STEP = 1.0
DIM = 0.25
IOR = 1.5


def middle(axis: int) -> float:
    return (LOW[axis] + HIGH[axis]) / 2


def pieces() -> Iterator[tuple[list[list[float]], list[float], list[float], list[float]]]:
    """(halves of its edges, inward normal and centre, radiance) of each half of a wall."""
    for wall, light in WALLS.items():
        axis = "xyz".index(wall[1])
        one, other = (axis + 1) % 3, (axis + 2) % 3
        for dim in (False, True):
            edges = [[0.0] * 3, [0.0] * 3]
            edges[0][one], edges[1][other] = (HIGH[one] - LOW[one]) / 2, (HIGH[other] - LOW[other]) / 4
            normal, place = [0.0] * 3, [0.0] * 3
            normal[axis] = -1.0 if wall[0] == "p" else 1.0
            place[axis] = (HIGH if wall[0] == "p" else LOW)[axis]
            place[one] = middle(one)
            place[other] = middle(other) + (edges[1][other] if dim else -edges[1][other])
            yield edges, normal, place, [value * (DIM if place[other] > middle(other) else 1.0) for value in light]


def center(ball: int, frame: float) -> Vector:
    x, y, z = BALLS[ball][0]
    return (x + STEP * frame if ball == 0 else x), y, z


def room_hit(view: layout.View, frame: int) -> tuple[Array, Array, Array]:
    """(distance, what, normal) of the first surface on the ray of each pixel."""
    directions, origin = view.directions(), np.array(view.camera.position)
    distance = np.full(directions.shape[:2], np.inf)
    what, normal = np.full(distance.shape, "", "U6"), np.zeros(directions.shape)
    for axis, name in enumerate("xyz"):
        along = directions[..., axis]
        with np.errstate(divide="ignore"):
            ahead = np.where(along == 0, np.inf, (np.where(along > 0, HIGH[axis], LOW[axis]) - origin[axis]) / along)
        first = ahead < distance
        distance[first], what[first] = ahead[first], np.where(along > 0, "p" + name, "n" + name)[first]
        normal[first] = 0
        normal[first, axis] = np.where(along > 0, -1.0, 1.0)[first]
    for ball, (_, radius, made) in enumerate(BALLS):
        off = origin - center(ball, frame)
        toward = directions @ off
        rest = toward * toward - off @ off + radius * radius
        near = -toward - np.sqrt(np.maximum(rest, 0))
        first = (rest > 0) & (near > 0) & (near < distance)
        distance[first], what[first] = near[first], made
        normal[first] = ((off + near[..., np.newaxis] * directions) / radius)[first]
    return distance, what, normal


def room_images(view: layout.View, frame: int) -> dict[str, list[Array]]:
    """What a renderer without a filter answers."""
    distance, what, normal = room_hit(view, frame)
    directions = view.directions()
    optics, color = np.zeros(normal.shape), np.zeros(normal.shape)
    optics[what == "mirror", 0], optics[..., 2] = 1, 1
    for pixel in zip(*np.nonzero(what == "glass")):
        optics[pixel] = layout.glass(-float(normal[pixel] @ directions[pixel]), IOR, False)
    point = view.camera.position + distance[..., np.newaxis] * directions
    for wall, light in WALLS.items():
        # Beyond the middle of one of the wall's axes it radiates less.
        axis = ("xyz".index(wall[1]) + 2) % 3
        color[what == wall] = np.where(point[..., axis, np.newaxis] > middle(axis), DIM, 1.0)[what == wall] * light
    planes = lambda values: list(np.moveaxis(values, -1, 0))
    return {"color": planes(color), "depth": [distance], "normal": planes(normal), "material": planes(optics)}


class RoomRenderer:
    """Answers images of the room, and is interrupted after `views` of them."""

    def __init__(self, views: int = 10 ** 9):
        self.left = views
        self.number = 0

    def frame(self, number: int) -> None:
        self.number = number

    def images(self, view: layout.View) -> dict[str, list[Array]]:
        if not self.left:
            raise KeyboardInterrupt
        self.left -= 1
        return room_images(view, self.number)


def plan(work: pathlib.Path, *words: str, cameras: Any = CAMERAS, scene: str = "a room") -> layout.Plan:
    file = work / "cameras.json"
    file.write_text(json.dumps(cameras))
    options = layout.parser("test", "").parse_args(["--cameras", str(file), "-o", str(work / "out"), *words])
    return layout.Plan(options, {"renderer": scene}, [0, 1], 24.0)


def files_of(folder: pathlib.Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


# ---- reading what an adapter wrote, and holding it against the room

class Compared:
    """Counts of the pixels of a dataset that are as the room is."""

    def __init__(self, folder: pathlib.Path, near_enough: float = 1e-5):
        self.folder, self.near_enough = folder, near_enough
        self.manifest = json.loads((self.folder / layout.MANIFEST).read_text())
        self.pixels = self.depth = self.normal = self.material = self.walls = self.color = 0
        self.surfaces: set[str] = set()
        first, last = self.manifest["frames"]
        for probe in self.manifest["probes"]:
            for frame in range(first, last + 1):
                for face in layout.FACES if self.manifest["projection"] == "cubemap" else ["view"]:
                    self.compare(self.view(probe, face), frame)

    def view(self, probe: dict[str, Any], face: str) -> layout.View:
        projection, (width, height) = self.manifest["projection"].replace("cubemap", "cube"), self.manifest["size"]
        high = math.tan(math.radians(probe["fov_y_deg"]) / 2) if projection == "perspective" else 1.0
        forward, right, down = (layout.rotated(axis, probe.get("orientation")) for axis in layout.FACES.get(face, layout.AHEAD))
        camera = layout.Camera(probe["name"], probe["position"])
        return layout.View(camera, face, forward, right, down, (width, height), projection, (high * width / height, high), 0, [])

    def planes(self, kind: str, view: layout.View, frame: int) -> Array:
        name = self.manifest["files"][kind].replace("{probe}", view.camera.name).replace("{face}", view.face) % frame
        channels = images.read_exr(self.folder / name)
        return np.stack([channels[channel] for channel in layout.CHANNELS[kind]]).astype(float)

    def compare(self, view: layout.View, frame: int) -> None:
        _, what, _ = room_hit(view, frame)
        width, height = view.size
        expected = {kind: np.stack(planes) for kind, planes in room_images(view, frame).items()}
        found = {kind: self.planes(kind, view, frame) for kind in layout.CHANNELS}
        off = {kind: np.abs(found[kind] - expected[kind]).max(axis=0) for kind in found}
        assert off["depth"].shape == (height, width), (off["depth"].shape, view.size)
        self.pixels += what.size
        self.surfaces |= set(np.unique(what).tolist())
        self.depth += int((off["depth"] <= self.near_enough * expected["depth"][0]).sum())
        self.normal += int((off["normal"] <= 1e-3 + 10 * self.near_enough).sum())
        self.material += int((off["material"] <= 1e-3 + 20 * self.near_enough).sum())
        on_walls = np.isin(what, list(WALLS))
        self.walls += int(on_walls.sum())
        self.color += int((off["color"] <= 2e-3)[on_walls].sum())


def close(found: Any, expected: Any, bound: float) -> bool:
    return all(abs(a - b) <= bound for a, b in zip(found, expected))


def setUpModule() -> None:
    if not lightfold():
        print(f"\nNOT RUN: lightfold inspect --check: no program in {TARGET}; run cargo build", file=sys.stderr)


class AdapterTest(Folder):
    def setUp(self) -> None:
        super().setUp()
        quiet = unittest.mock.patch.object(layout, "say")
        quiet.start()
        self.addCleanup(quiet.stop)

    def assert_is_the_room(self, folder: pathlib.Path, near_enough: float = 1e-5) -> None:
        found = Compared(folder, near_enough)
        if found.manifest["projection"] == "perspective":
            self.assertGreater(len(found.surfaces), 5)
        else:
            self.assertEqual(found.surfaces, set(WALLS) | {made for _, _, made in BALLS})
        # Where the ray passes an edge within the precision of floats, either side may answer.
        for name in ("depth", "normal", "material"):
            self.assertGreater(getattr(found, name), 0.998 * found.pixels, name)
        # Pixels of a wall beside another surface are the mean of both.
        self.assertGreater(found.color, 0.85 * found.walls)

    def assert_fine(self, folder: pathlib.Path) -> None:
        """The program suspects nothing, and encodes it."""
        binary = lightfold()
        if not binary:
            return
        manifest = str(folder / layout.MANIFEST)
        done = subprocess.run([binary, "inspect", manifest, "--check"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("No check is suspect", done.stdout)
        command = [binary, "encode", manifest, "--clip", "-o", str(self.work / "out.lfold"), "--quiet"]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)


class ExrTest(AdapterTest):
    def test_openexr_reads_what_is_written(self) -> None:
        chance = np.random.default_rng(3)
        for width, height in ((1, 1), (3, 5), (16, 16), (17, 33), (64, 20)):
            for kind in (np.float16, np.float32):
                with self.subTest(width=width, height=height, kind=kind):
                    planes = {"Z": chance.uniform(-9, 9, (height, width)).astype(kind), "A": np.full((height, width), np.inf, kind)}
                    exr.write(self.work / "a.exr", planes)
                    found = images.read_exr(self.work / "a.exr")
                    self.assertEqual(list(found), ["A", "Z"])
                    for name, plane in planes.items():
                        self.assertEqual(found[name].dtype, kind)
                        np.testing.assert_array_equal(found[name], plane)
        self.assertEqual([path.name for path in self.work.iterdir()], ["a.exr"])

    def plain(self, planes: dict[str, Array], compression: Any = OpenEXR.NO_COMPRESSION) -> pathlib.Path:
        """A file that OpenEXR writes."""
        path = self.work / "plain.exr"
        with OpenEXR.File({"compression": compression, "type": OpenEXR.scanlineimage}, planes) as file:
            file.write(str(path))
        return path

    def test_plain_lines_of_openexr_are_read(self) -> None:
        depth = np.arange(20 * 33, dtype=np.float32).reshape(20, 33)
        found = exr.read(self.plain({"View.Depth.Z": depth, "View.Combined.R": (depth / 7).astype(np.float16)}))
        np.testing.assert_array_equal(found["View.Depth.Z"], depth)
        np.testing.assert_array_equal(found["View.Combined.R"], (depth / 7).astype(np.float16))

    def test_halves_hold_what_they_can(self) -> None:
        values = np.array([65504, 65519, 65520, 1e30, np.inf, -1e30, np.nan, 1e-9], np.float32)
        self.assertEqual(exr.half(values).tolist(), [65504] * 5 + [-65504, 0, 0])

    def test_files_of_something_else_are_refused(self) -> None:
        depth = np.arange(400, dtype=np.float32).reshape(20, 20)
        whole = self.plain({"Z": depth}).read_bytes()
        packed = self.plain({"Z": depth}, OpenEXR.ZIP_COMPRESSION).read_bytes()
        integers = self.plain({"Z": depth.astype(np.uint32)}).read_bytes()
        for wrong in (b"", b"\x89PNG" + whole[4:], whole[:100], whole[:-1], whole[:5] + b"\x10" + whole[6:], packed, integers):
            (self.work / "b.exr").write_bytes(wrong)
            with self.assertRaises(exr.BadImage):
                exr.read(self.work / "b.exr")


class LayoutTest(AdapterTest):
    def test_faces_are_those_of_opengl(self) -> None:
        """Against the formulas of the OpenGL specification, where s and t of a direction are by its major axis."""
        majors = {"px": lambda x, y, z: (-z, -y, x), "nx": lambda x, y, z: (z, -y, -x), "py": lambda x, y, z: (x, z, y),
                  "ny": lambda x, y, z: (x, -z, -y), "pz": lambda x, y, z: (x, -y, z), "nz": lambda x, y, z: (-x, -y, -z)}
        made = plan(self.work, "--size", "4")
        for face, major in majors.items():
            view = made.view(layout.Camera("a", [0, 0, 0]), face, 0, [])
            for at, direction in enumerate(view.directions().reshape(-1, 3)):
                s, t, length = major(*direction)
                self.assertAlmostEqual((s / length + 1) / 2, (at % 4 + 0.5) / 4)
                self.assertAlmostEqual((t / length + 1) / 2, (at // 4 + 0.5) / 4)
                self.assertAlmostEqual(math.hypot(*direction), 1)

    def test_panoramas_and_pictures_look_along_minus_z(self) -> None:
        view = plan(self.work, "--size", "8", "--projection", "equirect").view(layout.Camera("a", [0, 0, 0]), "view", 0, [])
        self.assertEqual(view.size, (8, 4))
        for at, direction in enumerate(view.directions().reshape(-1, 3)):
            lon, lat = (2 * (at % 8 + 0.5) / 8 - 1) * math.pi, (0.5 - (at // 8 + 0.5) / 4) * math.pi
            expected = math.sin(lon) * math.cos(lat), math.sin(lat), -math.cos(lon) * math.cos(lat)
            self.assertTrue(close(direction, expected, 1e-12))
        made = plan(self.work, "--size", "6x2", "--projection", "perspective", "--fov", "50")
        directions = made.view(made.cameras[1], "view", 0, []).directions().reshape(-1, 3)
        high = math.tan(math.radians(40)) / 2
        expected = layout.rotated((3 * high * 2 * 5 / 6, -high, -1), TURN)
        self.assertTrue(close(directions[11], [value / math.hypot(*expected) for value in expected], 1e-12))

    def test_quaternions_turn(self) -> None:
        half = math.sqrt(0.5)
        self.assertTrue(close(layout.rotated((0, 0, -1), (0, half, 0, half)), (-1, 0, 0), 1e-12))
        self.assertTrue(close(layout.rotated((0, 1, 0), (half, 0, 0, half)), (0, 0, 1), 1e-12))

    def test_glass_reflects_as_fresnel_says(self) -> None:
        self.assertAlmostEqual(layout.fresnel(1, 1.5), 0.04)
        self.assertAlmostEqual(layout.fresnel(-1, 1.5), 0.04)
        self.assertAlmostEqual(layout.fresnel(0, 1.5), 1)
        # At Brewster's angle, light of one polarisation is not reflected.
        brewster = math.cos(math.atan(1.5))
        self.assertAlmostEqual(layout.fresnel(brewster, 1.5), ((1.5 ** 2 - 1) / (1.5 ** 2 + 1)) ** 2 / 2)
        self.assertEqual(layout.fresnel(0.5, 1 / 1.5), 1)

    def test_glass_is_left_through_its_dense_side(self) -> None:
        self.assertEqual(layout.glass(0.5, 1.5, inside=True), (1, 0, 1.5))
        reflect, refract, ior = layout.glass(0.5, 1.5, inside=False)
        self.assertLess(reflect, 0.1)
        self.assertEqual((reflect + refract, ior), (1, 1.5))
        # Along the normal both sides are alike.
        self.assertAlmostEqual(layout.glass(1, 1.5, inside=True)[0], 0.04)

    def test_a_capture_is_a_dataset_of_the_room(self) -> None:
        for words in (["--size", "24"], ["--projection", "equirect", "--size", "64"],
                      ["--projection", "perspective", "--size", "32x24", "--fov", "60"]):
            with self.subTest(words):
                made = plan(self.work, "--aov", "depth,material,normal", *words)
                made.folder = self.work / words[1]
                layout.capture(made, RoomRenderer())
                found = Compared(made.folder)
                self.assertEqual((found.depth, found.color), (found.pixels, found.walls))
                self.assertGreater(found.walls, 0)
                self.assertFalse((made.folder / layout.STATE).exists())
                self.assert_fine(made.folder)

    def test_frames_of_a_camera_are_kept(self) -> None:
        cameras = json.loads(json.dumps(CAMERAS))
        cameras["cameras"][1]["frames"] = [1, 7]
        made = plan(self.work, "--size", "2", "--aov", "none", cameras=cameras)
        layout.capture(made, RoomRenderer())
        manifest = json.loads((made.folder / layout.MANIFEST).read_text())
        self.assertEqual(manifest["frames"], [0, 1])
        self.assertEqual([probe.get("frames") for probe in manifest["probes"]], [None, [1, 1]])
        self.assertEqual(len(list(made.folder.rglob("*.exr"))), 3 * 6)
        self.assertEqual(list(manifest["files"]), ["color"])
        cameras["cameras"][1]["frames"] = [2, 7]
        with self.assertRaisesRegex(layout.Refused, "looks in the frames 2-7, the capture is of 0-1"):
            plan(self.work, "--frames", "0-1", cameras=cameras)
        # Without --frames, those that the cameras ask for where all do.
        cameras["cameras"][0]["frames"] = [5, 5]
        self.assertEqual(plan(self.work, cameras=cameras).frames, [2, 7])

    def test_an_interrupted_capture_goes_on_to_the_same_bytes(self) -> None:
        words = ["--size", "4", "--frames", "0-1"]
        whole = plan(self.work, *words)
        layout.capture(whole, RoomRenderer())
        expected = files_of(whole.folder)
        shutil.rmtree(whole.folder)
        with self.assertRaises(KeyboardInterrupt):
            layout.capture(plan(self.work, *words), RoomRenderer(views=7))
        self.assertFalse((whole.folder / layout.MANIFEST).exists())
        with self.assertRaisesRegex(layout.Refused, "not empty: add --resume"):
            layout.capture(plan(self.work, *words), RoomRenderer())
        for other, key in ((["--samples", "3"], "samples"), (["--seed", "3"], "seed"), (["--aov", "normal"], "kinds")):
            with self.assertRaisesRegex(layout.Refused, f"of other {key}"):
                layout.capture(plan(self.work, *words, *other, "--resume"), RoomRenderer())
        with self.assertRaisesRegex(layout.Refused, "of other scene"):
            layout.capture(plan(self.work, *words, "--resume", scene="another"), RoomRenderer())
        rest = RoomRenderer(views=24 - 7)
        layout.capture(plan(self.work, *words, "--resume"), rest)
        self.assertEqual((rest.left, files_of(whole.folder)), (0, expected))
        with self.assertRaisesRegex(layout.Refused, "no capture that was interrupted"):
            layout.capture(plan(self.work, *words, "--resume"), RoomRenderer())

    def test_noise_is_still_or_moves(self) -> None:
        def seeds(*words: str) -> list[int]:
            made = plan(self.work, "--size", "2", *words)
            return [view.seed for frame in (0, 1) for view in made.missing(frame)]
        still, moving = seeds(), seeds("--noise", "moving")
        self.assertEqual(still[:12], still[12:])
        self.assertEqual((len(set(still)), len(set(moving))), (12, 24))
        self.assertFalse(set(still) & set(seeds("--seed", "1")))

    def test_cameras_that_make_no_sense_are_refused(self) -> None:
        camera = '{"position": [0, 0, 0]}'
        for text, says in [
            ("", "cannot be read"), ("[]", "a cameras.json was expected"), ('{"lightfold_cameras": 2}', "was expected"),
            ('{"lightfold_cameras": 1, "cameras": []}', "no camera"),
            *((f'{{"lightfold_cameras": 1, "cameras": [{cameras}]}}', says) for cameras, says in [
                ("5", "an object"), ('{"position": [0, 0]}', "3 finite numbers"), ('{"position": [0, 0, 1e999]}', "3 finite numbers"),
                ('{"position": [0, true, 0]}', "3 finite numbers"), ('{"position": [0, 0, 0], "name": "../a"}', "letters"),
                ('{"position": [0, 0, 0], "name": 5}', "letters"), ('{"position": [0, 0, 0], "colour": 1}', "colour"),
                (f'{{"position": [0, 0, 0], "name": "01"}}, {camera}', "another camera of this name, 01"),
                ('{"position": [0, 0, 0], "orientation": [0, 0, 0, 2]}', "length 1"),
                ('{"position": [0, 0, 0], "fov_y_deg": 180}', "fov_y_deg"), ('{"position": [0, 0, 0], "fov_y_deg": "a"}', "fov_y_deg"),
                ('{"position": [0, 0, 0], "frames": [2, 1]}', "frames"), ('{"position": [0, 0, 0], "frames": 1}', "frames"),
                ('{"position": [0, 0, 0], "frames": [0.5, 1]}', "frames")]),
        ]:
            with self.subTest(text):
                (self.work / "c.json").write_text(text)
                with self.assertRaisesRegex(layout.Refused, says):
                    layout.read_cameras(str(self.work / "c.json"))
        with self.assertRaisesRegex(layout.Refused, "cannot be read"):
            layout.read_cameras(str(self.work / "none.json"))

    def test_the_probes_of_a_dataset_are_cameras(self) -> None:
        (self.work / "c.json").write_text('{"lightfield": 1, "probes": [{"name": "a", "position": [1, 2, 3], "extra": {}}]}')
        self.assertEqual(layout.read_cameras(str(self.work / "c.json")), [layout.Camera("a", [1.0, 2.0, 3.0])])

    def test_options_that_make_no_sense_are_refused(self) -> None:
        for words, says in [
            (["--frames", "3-1"], "--frames 3-1"), (["--frames", "a"], "--frames a"), (["--size", "0"], "--size 0"),
            (["--size", "99999"], "--size 99999"), (["--size", "4x5"], "square"),
            (["--size", "5", "--projection", "equirect"], "twice as wide"),
            (["--projection", "perspective"], "camera 00 has no field of view"), (["--aov", "depth,albedo"], "albedo is none of"),
            (["--samples", "0"], "--samples 0"), (["--fov", "180"], "--fov 180"), (["--threads", "0"], "--threads 0"),
        ]:
            with self.subTest(words), self.assertRaisesRegex(layout.Refused, says):
                plan(self.work, *words)

    def test_a_missing_renderer_is_one_sentence(self) -> None:
        # Without site packages there is neither.
        (self.work / "c.json").write_text(json.dumps(CAMERAS))
        for script, says in (("mitsuba.py", "requirements.txt"), ("blender.py", "pip install bpy==")):
            words = [sys.executable, "-S", "-B", str(CAPTURE / script), "a", "--cameras", str(self.work / "c.json"), "-o",
                     str(self.work / "out")]
            done = subprocess.run(words, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": ""})
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
            self.assertIn(says, done.stderr)


# ---- the renderers, where they are

def python_with(package: str, variable: str) -> str | None:
    """A Python that has the package, or None."""
    for python in (os.environ.get(variable), sys.executable):
        if python and shutil.which(python):
            done = subprocess.run([python, "-c", f"import importlib.util as u; raise SystemExit(u.find_spec('{package}') is None)"],
                                  cwd=tempfile.gettempdir())
            if done.returncode == 0:
                return python
    print(f"\nNOT RUN: tests with {package}: no Python with it was found ({variable} may name one)", file=sys.stderr)
    return None


MITSUBA_BALLS = {"black": '<bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>',
                 "glass": f'<bsdf type="dielectric"><float name="int_ior" value="{IOR}"/><float name="ext_ior" value="1"/></bsdf>',
                 "mirror": '<bsdf type="twosided"><bsdf type="conductor"><string name="material" value="none"/></bsdf></bsdf>'}


def mitsuba_room(frame: int | str) -> str:
    """The room at a frame as XML; walls radiate and reflect nothing, so that no noise is in their colour."""
    text = '<scene version="3.0.0"><integrator type="path"/>'
    for edges, normal, place, light in pieces():
        columns = [*edges, normal, place]
        matrix = " ".join(str(column[row]) for row in range(3) for column in columns) + " 0 0 0 1"
        text += (f'<shape type="rectangle"><transform name="to_world"><matrix value="{matrix}"/></transform>{MITSUBA_BALLS["black"]}'
                 f'<emitter type="area"><rgb name="radiance" value="{",".join(map(str, light))}"/></emitter></shape>')
    for ball, (_, radius, made) in enumerate(BALLS):
        x, y, z = center(ball, frame) if isinstance(frame, int) else BALLS[ball][0]
        moved = '<translate x="$time"/>' if frame == "time" and ball == 0 else ""
        text += (f'<shape type="sphere"><float name="radius" value="{radius}"/><transform name="to_world">'
                 f'<translate x="{x}" y="{y}" z="{z}"/>{moved}</transform>{MITSUBA_BALLS[made]}</shape>')
    return text + "</scene>"


class MitsubaTest(AdapterTest):
    python: str

    @classmethod
    def setUpClass(cls) -> None:
        cls.python = python_with("mitsuba", "LIGHTFOLD_MITSUBA") or ""
        if not cls.python:
            raise unittest.SkipTest("no Python with Mitsuba")

    def capture(self, scene: str, *words: str) -> subprocess.CompletedProcess[str]:
        (self.work / "c.json").write_text(json.dumps(CAMERAS))
        return subprocess.run([self.python, "-B", str(CAPTURE / "mitsuba.py"), str(self.work / scene), "--cameras",
                               str(self.work / "c.json"), "-o", str(self.work / "out"), "--samples", "4", *words],
                              capture_output=True, text=True)

    def assert_captured(self, scene: str, *words: str) -> None:
        done = self.capture(scene, "--aov", "depth,material,normal", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_is_the_room(self.work / "out")
        self.assert_fine(self.work / "out")

    def test_cube_maps_of_a_file_for_each_frame(self) -> None:
        for frame in (0, 1):
            (self.work / f"room.{frame:04}.xml").write_text(mitsuba_room(frame))
        self.assert_captured("room.%04d.xml", "--size", "24", "--frames", "0-1")
        first = files_of(self.work / "out")
        shutil.rmtree(self.work / "out")
        # Without --frames, those that there are.
        self.assert_captured("room.####.xml", "--size", "24")
        self.assertEqual(files_of(self.work / "out"), first)

    def test_panoramas_and_pictures_of_a_file_that_uses_the_time(self) -> None:
        (self.work / "room.xml").write_text(mitsuba_room("time"))
        self.assert_captured("room.xml", "--size", "64", "--frames", "1", "--fps", "1", "--projection", "equirect")
        shutil.rmtree(self.work / "out")
        self.assert_captured("room.xml", "--size", "96x64", "--frames", "0", "--fps", "1", "--projection", "perspective", "--fov", "100")

    def test_other_axes_and_units_and_holes(self) -> None:
        """A pane of which half is cut out, before a wall, at z = 250 cm, in a scene of centimetres with +Z up; the rest is empty."""
        (self.work / "pane.py").write_text("""
import mitsuba as mi
def scene(time):
    matt = {"type": "twosided", "nested": {"type": "diffuse"}}
    holes = {"type": "checkerboard", "color0": 0.2, "color1": 0.8, "to_uv": mi.ScalarTransform4f().scale([1, 0.5, 1])}
    square = lambda z: mi.ScalarTransform4f().translate([20, -10, z]).scale([50, 50, 1])
    return {"type": "scene", "integrator": {"type": "path"}, "light": {"type": "constant"},
            "pane": {"type": "rectangle", "to_world": square(250), "bsdf": {"type": "mask", "opacity": holes, "nested": matt}},
            "wall": {"type": "rectangle", "to_world": square(400), "bsdf": matt}}
""")
        done = self.capture("pane.py", "--up", "z", "--unit", "0.01", "--size", "16")
        self.assertEqual(done.returncode, 0, done.stderr)
        # The first camera stands at (20, -10, 150) cm; what is above it is the face py.
        depth = images.read_exr(self.work / "out" / "probe_00" / "face_py" / "depth.0000.exr")["Z"]
        planar: dict[float, list[tuple[float, float]]] = {}
        for at, distance in enumerate(depth.ravel().tolist()):
            u, v = 2 * (at % 16 + 0.5) / 16 - 1, 2 * (at // 16 + 0.5) / 16 - 1
            seen = round(distance / math.sqrt(1 + u * u + v * v), 4)
            planar.setdefault(seen, []).append((u, v))
        self.assertEqual(set(planar), {1.0, 2.5, math.inf})
        on_the_pane = len(planar[1.0]) + sum(max(map(abs, place)) < 0.5 for place in planar[math.inf])
        # Half of the 8x8 pixels of the pane are there; through the others one sees the wall, of 3.2x3.2 pixels.
        self.assertEqual((len(planar[1.0]), on_the_pane + len(planar[2.5])), (32, 64))
        self.assertTrue(all(max(map(abs, place)) < 0.2 for place in planar[2.5]))

    def test_scenes_that_cannot_be_read_are_one_sentence(self) -> None:
        (self.work / "bad.xml").write_text("<scene version='3.0.0'><shape type='none'/></scene>")
        (self.work / "bad.py").write_text("scenes = 5")
        for scene, words, says in (("none.xml", [], "cannot be read"), ("bad.xml", [], "Mitsuba cannot load it"),
                                   ("none.%d.xml", [], "no file of that name"), ("bad.py", [], "scene(time)"),
                                   ("bad.xml", ["--variant", "x"], "--variant x")):
            done = self.capture(scene, *words)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(says, done.stderr)
            self.assertNotIn("Traceback", done.stderr)


BLENDER_ROOM = """
import bpy, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.unit_settings.system, scene.unit_settings.scale_length = "METRIC", 0.01

def there(x, y, z):
    return 100 * x, -100 * z, 100 * y

def material(name, kind, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.node_tree.nodes.clear()
    output = made.node_tree.nodes.new("ShaderNodeOutputMaterial")
    node = made.node_tree.nodes.new(kind)
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    made.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made

for corners, radiance in WALLS:
    mesh = bpy.data.meshes.new("wall")
    mesh.from_pydata([there(*corner) for corner in corners], [], [(0, 1, 2, 3)])
    mesh.materials.append(material("wall", "ShaderNodeEmission", Color=(*radiance, 1), Strength=1))
    scene.collection.objects.link(bpy.data.objects.new("wall", mesh))
MADE = {"black": material("black", "ShaderNodeBsdfDiffuse", Color=(0, 0, 0, 1)),
        "glass": material("glass", "ShaderNodeBsdfGlass", Roughness=0, IOR=IOR),
        "mirror": material("mirror", "ShaderNodeBsdfPrincipled", Metallic=1, Roughness=0)}
for number, (center, radius, made) in enumerate(BALLS):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128, radius=100 * radius, location=there(*center))
    ball = bpy.context.active_object
    ball.data.materials.append(MADE[made])
    bpy.ops.object.shade_smooth()
    if number == 0:
        ball.keyframe_insert("location", frame=0)
        ball.location.x += 100 * STEP
        ball.keyframe_insert("location", frame=1)
scene.frame_start, scene.frame_end = 0, 1
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1])
"""


class BlenderTest(AdapterTest):
    """Only where bpy is installed already: it is a third of a gigabyte."""

    python: str
    blend: pathlib.Path

    @classmethod
    def setUpClass(cls) -> None:
        cls.python = python_with("bpy", "LIGHTFOLD_BPY") or ""
        if not cls.python:
            raise unittest.SkipTest("no Python with bpy")
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.blend = pathlib.Path(folder.name) / "room.blend"
        signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        walls = [([[p + a * u + b * v for p, u, v in zip(place, *edges)] for a, b in signs], light)
                 for edges, _, place, light in pieces()]
        script = cls.blend.with_name("room.py")
        script.write_text(f"WALLS = {walls!r}\nBALLS = {BALLS!r}\nSTEP = {STEP}\nIOR = {IOR}\n{BLENDER_ROOM}")
        subprocess.run([cls.python, str(script), str(cls.blend)], check=True, capture_output=True)

    def setUp(self) -> None:
        super().setUp()
        shutil.copy(self.blend, self.work)
        (self.work / "c.json").write_text(json.dumps(CAMERAS))

    def words(self, *words: str) -> list[str]:
        return ["--cameras", str(self.work / "c.json"), "-o", str(self.work / "out"), "--samples", "4", "--aov",
                "depth,material,normal", *words]

    def assert_captured(self, command: list[str]) -> None:
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        # Spheres are made of flat pieces.
        self.assert_is_the_room(self.work / "out", near_enough=1e-3)
        self.assert_fine(self.work / "out")
        shutil.rmtree(self.work / "out")

    def test_cube_maps_panoramas_and_pictures(self) -> None:
        command = [self.python, "-B", str(CAPTURE / "blender.py"), str(self.work / "room.blend")]
        self.assert_captured(command + self.words("--size", "24", "--cycles-device", "CPU"))
        self.assert_captured(command + self.words("--size", "64", "--projection", "equirect", "--frames", "1"))
        self.assert_captured(command + self.words("--size", "96x64", "--projection", "perspective", "--frames", "0", "--fov", "100"))

    def test_a_camera_inside_of_glass_looks_from_the_dense_side(self) -> None:
        place, radius, _ = BALLS[1]
        cameras = {"lightfold_cameras": 1, "cameras": [{"position": [place[0] + 0.75 * radius, *place[1:]]}]}
        made = plan(self.work, "--size", "16", cameras=cameras)
        command = [self.python, "-B", str(CAPTURE / "blender.py"), str(self.work / "room.blend"), "--cameras",
                   str(self.work / "cameras.json"), "-o", str(self.work / "out"), "--size", "16", "--frames", "0",
                   "--aov", "material", "--samples", "1"]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        name = json.loads((self.work / "out" / layout.MANIFEST).read_text())["files"]["material"].replace("{probe}", "00")
        whole = 0
        for face in layout.FACES:
            view = made.view(made.cameras[0], face, 0, [])
            channels = images.read_exr(self.work / "out" / (name.replace("{face}", face) % 0))
            rays = zip(view.directions().reshape(-1, 3).tolist(), channels["reflect"].ravel().tolist(), channels["ior"].ravel().tolist())
            for direction, reflect, ior in rays:
                off = [here - there for here, there in zip(view.camera.position, place)]
                toward = sum(a * b for a, b in zip(off, direction))
                ahead = math.sqrt(toward * toward - sum(a * a for a in off) + radius * radius) - toward
                cosine = sum((a + ahead * b) / radius * b for a, b in zip(off, direction))
                self.assertEqual(ior, IOR)
                # Where all is reflected from, a ball of flat pieces has another edge.
                if abs(cosine - math.sqrt(1 - 1 / IOR ** 2)) > 0.05:
                    self.assertAlmostEqual(reflect, layout.glass(cosine, IOR, True)[0], delta=0.02)
                    whole += reflect == 1
        self.assertGreater(whole, 100)

    def test_what_cannot_be_rendered_is_one_sentence(self) -> None:
        (self.work / "bad.blend").write_bytes(b"BLENDER no more")
        for scene, words, says in (("none.blend", [], "cannot be read"), ("bad.blend", [], "cannot open it"),
                                   ("room.blend", ["--cycles-device", "ABACUS"], "ABACUS: one of CPU, CUDA")):
            command = [self.python, "-B", str(CAPTURE / "blender.py"), str(self.work / scene), *self.words(*words)]
            done = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(says, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_it_is_run_as_blender_runs_scripts(self) -> None:
        script = str(CAPTURE / "blender.py")
        words = ["blender", "-b", "room.blend", "-P", script, "--", *self.words("--size", "24", "--frames", "0")]
        command = f"import bpy, sys, runpy; bpy.ops.wm.open_mainfile(filepath={str(self.work / 'room.blend')!r}); " \
                  f"sys.argv = {words!r}; runpy.run_path({script!r}, run_name='__main__')"
        self.assert_captured([self.python, "-B", "-c", command])


if __name__ == "__main__":
    unittest.main()
