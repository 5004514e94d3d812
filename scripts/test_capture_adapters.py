"""Tests of scripts/capture: python3 -m unittest discover -s scripts

What the adapters share is tested with a renderer of a few lines. The adapters themselves are run with a room whose geometry
is known, where a Python with Mitsuba or with bpy is found: this one, the interpreter that LIGHTFOLD_MITSUBA or LIGHTFOLD_BPY
names, or for Mitsuba what scripts/test installs. What is skipped is said.
"""

import array
import json
import math
import os
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
CAPTURE = HERE / "capture"
sys.path.insert(0, str(CAPTURE))
import exr  # noqa: E402
import layout  # noqa: E402

sys.path.remove(str(CAPTURE))

TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", HERE.parent / "target"))
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


def middle(axis):
    return (LOW[axis] + HIGH[axis]) / 2


def radiance(wall, point):
    """Of a point on a wall: beyond the middle of one of the wall's axes it is less."""
    axis = ("xyz".index(wall[1]) + 2) % 3
    return [value * (DIM if point[axis] > middle(axis) else 1.0) for value in WALLS[wall]]


def pieces():
    """(halves of its edges, inward normal and centre, radiance) of each half of a wall."""
    for wall in WALLS:
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
            yield edges, normal, place, radiance(wall, place)


def center(ball, frame):
    x, y, z = BALLS[ball][0]
    return (x + STEP * frame if ball == 0 else x), y, z


def room_hit(origin, direction, frame):
    """(distance, what, normal) of the first surface on a ray of length 1."""
    best = (math.inf, None, None)
    for axis, name in enumerate("xyz"):
        if direction[axis]:
            ahead = direction[axis] > 0
            distance = ((HIGH if ahead else LOW)[axis] - origin[axis]) / direction[axis]
            if distance < best[0]:
                normal = [0.0, 0.0, 0.0]
                normal[axis] = -1.0 if ahead else 1.0
                best = (distance, ("p" if ahead else "n") + name, normal)
    for ball, (_, radius, made) in enumerate(BALLS):
        off = [here - there for here, there in zip(origin, center(ball, frame))]
        toward = sum(a * b for a, b in zip(off, direction))
        rest = toward * toward - sum(a * a for a in off) + radius * radius
        if rest > 0 and 0 < -toward - math.sqrt(rest) < best[0]:
            distance = -toward - math.sqrt(rest)
            best = (distance, made, [(a + distance * b) / radius for a, b in zip(off, direction)])
    return best


def room_images(view, frame):
    """What a renderer without a filter answers."""
    found = {kind: [array.array("f") for _ in channels] for kind, channels in layout.CHANNELS.items()}
    for direction in view.directions():
        distance, what, normal = room_hit(view.camera.position, direction, frame)
        cosine = -sum(a * b for a, b in zip(normal, direction))
        reflected = layout.fresnel(cosine, IOR)
        optics = {"glass": (reflected, 1 - reflected, IOR), "mirror": (1.0, 0.0, 1.0)}.get(what, (0.0, 0.0, 1.0))
        point = [here + distance * along for here, along in zip(view.camera.position, direction)]
        color = radiance(what, point) if what in WALLS else (0, 0, 0)
        for kind, values in (("color", color), ("depth", (distance,)), ("normal", normal), ("material", optics)):
            for plane, value in zip(found[kind], values):
                plane.append(value)
    return found


class RoomRenderer:
    """Answers images of the room, and is interrupted after `views` of them."""

    def __init__(self, views=10 ** 9):
        self.left = views
        self.number = None

    def frame(self, number):
        self.number = number

    def images(self, view):
        if not self.left:
            raise KeyboardInterrupt
        self.left -= 1
        return room_images(view, self.number)


def plan(work, *words, cameras=CAMERAS, scene="a room"):
    file = pathlib.Path(work) / "cameras.json"
    file.write_text(json.dumps(cameras))
    options = layout.parser("test", "").parse_args(["--cameras", str(file), "-o", str(pathlib.Path(work) / "out"), *words])
    return layout.Plan(options, {"renderer": scene}, [0, 1], 24.0)


def files_of(folder):
    folder = pathlib.Path(folder)
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


# ---- reading what an adapter wrote, and holding it against the room

class Compared:
    """Counts of the pixels of a dataset that are as the room is."""

    def __init__(self, folder, near_enough=1e-5):
        self.folder = pathlib.Path(folder)
        self.manifest = json.loads((self.folder / layout.MANIFEST).read_text())
        self.near_enough = near_enough
        self.pixels = self.depth = self.normal = self.material = self.walls = self.color = 0
        self.surfaces = set()
        projection = self.manifest["projection"].replace("cubemap", "cube")
        for probe in self.manifest["probes"]:
            camera = layout.Camera(probe["name"], probe["position"])
            high = math.tan(math.radians(probe["fov_y_deg"]) / 2) if projection == "perspective" else 1.0
            size = self.manifest["size"]
            for frame in range(self.manifest["frames"][0], self.manifest["frames"][1] + 1):
                for face in layout.FACES if projection == "cube" else ["view"]:
                    axes = [layout.rotated(axis, probe.get("orientation")) for axis in layout.FACES.get(face, layout.AHEAD)]
                    view = layout.View(camera, face, *axes, size, projection, (high * size[0] / size[1], high), 0, [])
                    self.compare(view, frame)

    def planes(self, kind, view, frame):
        files = self.manifest["files"]
        name = files[kind].replace("{probe}", view.camera.name).replace("{face}", view.face) % frame
        size, channels = exr.read(self.folder / name)
        assert size == tuple(view.size), (size, view.size)
        return [channels[channel] for channel in layout.CHANNELS[kind]]

    def compare(self, view, frame):
        expected = room_images(view, frame)
        found = {kind: list(zip(*self.planes(kind, view, frame))) for kind in layout.CHANNELS}
        whats = [room_hit(view.camera.position, direction, frame)[1] for direction in view.directions()]
        expected = {kind: list(zip(*planes)) for kind, planes in expected.items()}
        for at, what in enumerate(whats):
            self.pixels += 1
            self.surfaces.add(what)
            depth, wanted = found["depth"][at][0], expected["depth"][at][0]
            self.depth += abs(depth - wanted) <= self.near_enough * wanted
            self.normal += close(found["normal"][at], expected["normal"][at], 1e-3 + 10 * self.near_enough)
            self.material += close(found["material"][at], expected["material"][at], 1e-3 + 20 * self.near_enough)
            if what in WALLS:
                self.walls += 1
                self.color += close(found["color"][at], expected["color"][at], 2e-3)


def close(found, expected, bound):
    return all(abs(a - b) <= bound for a, b in zip(found, expected))


def lightfold():
    """The program, where it has been built."""
    named = [os.environ.get("LIGHTFOLD")] + [str(TARGET / kind / "lightfold") for kind in ("debug", "release")]
    return next((path for path in named if path and shutil.which(path)), None)


def setUpModule():
    if not lightfold():
        print(f"\nNOT RUN: lightfold inspect --check: no program in {TARGET}; run cargo build", file=sys.stderr)


class AdapterTest(unittest.TestCase):
    def setUp(self):
        work = tempfile.TemporaryDirectory()
        self.addCleanup(work.cleanup)
        self.work = pathlib.Path(work.name)
        quiet = unittest.mock.patch.object(layout, "say")
        quiet.start()
        self.addCleanup(quiet.stop)

    def assert_is_the_room(self, folder, near_enough=1e-5):
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

    def assert_fine(self, folder):
        """That the program suspects nothing, and encodes it."""
        binary = lightfold()
        if not binary:
            return
        manifest = str(pathlib.Path(folder) / layout.MANIFEST)
        done = subprocess.run([binary, "inspect", manifest, "--check"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("No check is suspect", done.stdout)
        command = [binary, "encode", manifest, "--clip", "-o", str(self.work / "out.lfold"), "--quiet"]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)


class ExrTest(AdapterTest):
    def test_what_is_written_is_read_again(self):
        chance = random.Random(3)
        for width, height in ((1, 1), (3, 5), (16, 16), (17, 33), (64, 20)):
            for kind in (exr.HALF, exr.FLOAT):
                with self.subTest(width=width, height=height, kind=kind):
                    count = width * height
                    halves = struct.pack(f"<{count}e", *(chance.uniform(-9, 9) for _ in range(count)))
                    noise = array.array("f", struct.unpack(f"<{count}e", halves))
                    planes = {"Z": noise, "A": array.array("f", [math.inf if kind == exr.FLOAT else 0.5] * count)}
                    exr.write(self.work / "a.exr", (width, height), planes, kind)
                    self.assertEqual(exr.read(self.work / "a.exr"), ((width, height), planes))
        self.assertEqual([path.name for path in self.work.iterdir()], ["a.exr"])

    def test_halves_hold_what_they_can(self):
        values = array.array("f", [65504, 65519, 65520, 1e30, math.inf, -1e30, math.nan, 1e-9])
        exr.write(self.work / "a.exr", (8, 1), {"R": values}, exr.HALF)
        self.assertEqual(list(exr.read(self.work / "a.exr")[1]["R"]), [65504] * 5 + [-65504, 0, 0])

    def test_files_of_something_else_are_refused(self):
        exr.write(self.work / "a.exr", (20, 20), {"Z": array.array("f", range(400))}, exr.FLOAT)
        whole = (self.work / "a.exr").read_bytes()
        for wrong in (b"", b"\x89PNG" + whole[4:], whole[:100], whole[:-1], whole[:5] + b"\x10" + whole[6:]):
            (self.work / "b.exr").write_bytes(wrong)
            with self.assertRaises(exr.BadImage):
                exr.read(self.work / "b.exr")


class LayoutTest(AdapterTest):
    def test_faces_are_those_of_opengl(self):
        """Against the formulas of the OpenGL specification, where s and t of a direction are by its major axis."""
        majors = {"px": lambda x, y, z: (-z, -y, x), "nx": lambda x, y, z: (z, -y, -x), "py": lambda x, y, z: (x, z, y),
                  "ny": lambda x, y, z: (x, -z, -y), "pz": lambda x, y, z: (x, -y, z), "nz": lambda x, y, z: (-x, -y, -z)}
        made = plan(self.work, "--size", "4")
        for face, major in majors.items():
            view = made.view(layout.Camera("a", [0, 0, 0]), face, 0, [])
            for at, direction in enumerate(view.directions()):
                s, t, length = major(*direction)
                self.assertAlmostEqual((s / length + 1) / 2, (at % 4 + 0.5) / 4)
                self.assertAlmostEqual((t / length + 1) / 2, (at // 4 + 0.5) / 4)
                self.assertAlmostEqual(math.hypot(*direction), 1)

    def test_panoramas_and_pictures_look_along_minus_z(self):
        view = plan(self.work, "--size", "8", "--projection", "equirect").view(layout.Camera("a", [0, 0, 0]), "view", 0, [])
        self.assertEqual(view.size, (8, 4))
        for at, direction in enumerate(view.directions()):
            lon, lat = (2 * (at % 8 + 0.5) / 8 - 1) * math.pi, (0.5 - (at // 8 + 0.5) / 4) * math.pi
            expected = math.sin(lon) * math.cos(lat), math.sin(lat), -math.cos(lon) * math.cos(lat)
            self.assertTrue(close(direction, expected, 1e-12))
        made = plan(self.work, "--size", "6x2", "--projection", "perspective", "--fov", "50")
        directions = list(made.view(made.cameras[1], "view", 0, []).directions())
        high = math.tan(math.radians(40)) / 2
        expected = layout.rotated((3 * high * 2 * 5 / 6, -high, -1), TURN)
        self.assertTrue(close(directions[11], [value / math.hypot(*expected) for value in expected], 1e-12))

    def test_quaternions_turn(self):
        half = math.sqrt(0.5)
        self.assertTrue(close(layout.rotated((0, 0, -1), (0, half, 0, half)), (-1, 0, 0), 1e-12))
        self.assertTrue(close(layout.rotated((0, 1, 0), (half, 0, 0, half)), (0, 0, 1), 1e-12))

    def test_glass_reflects_as_fresnel_says(self):
        self.assertAlmostEqual(layout.fresnel(1, 1.5), 0.04)
        self.assertAlmostEqual(layout.fresnel(-1, 1.5), 0.04)
        self.assertAlmostEqual(layout.fresnel(0, 1.5), 1)
        # At Brewster's angle, light of one polarisation is not reflected.
        brewster = math.cos(math.atan(1.5))
        self.assertAlmostEqual(layout.fresnel(brewster, 1.5), ((1.5 ** 2 - 1) / (1.5 ** 2 + 1)) ** 2 / 2)
        self.assertEqual(layout.fresnel(0.5, 1 / 1.5), 1)

    def test_glass_is_left_through_its_dense_side(self):
        self.assertEqual(layout.glass(0.5, 1.5, inside=True), (1, 0, 1.5))
        reflect, refract, ior = layout.glass(0.5, 1.5, inside=False)
        self.assertLess(reflect, 0.1)
        self.assertEqual((reflect + refract, ior), (1, 1.5))
        # Along the normal both sides are alike.
        self.assertAlmostEqual(layout.glass(1, 1.5, inside=True)[0], 0.04)

    def test_a_capture_is_a_dataset_of_the_room(self):
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

    def test_frames_of_a_camera_are_kept(self):
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

    def test_an_interrupted_capture_goes_on_to_the_same_bytes(self):
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

    def test_noise_is_still_or_moves(self):
        def seeds(*words):
            made = plan(self.work, "--size", "2", *words)
            return [view.seed for frame in (0, 1) for view in made.missing(frame)]
        still, moving = seeds(), seeds("--noise", "moving")
        self.assertEqual(still[:12], still[12:])
        self.assertEqual((len(set(still)), len(set(moving))), (12, 24))
        self.assertFalse(set(still) & set(seeds("--seed", "1")))

    def test_cameras_that_make_no_sense_are_refused(self):
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

    def test_the_probes_of_a_dataset_are_cameras(self):
        (self.work / "c.json").write_text('{"lightfield": 1, "probes": [{"name": "a", "position": [1, 2, 3], "extra": {}}]}')
        self.assertEqual(layout.read_cameras(str(self.work / "c.json")), [layout.Camera("a", [1.0, 2.0, 3.0])])

    def test_options_that_make_no_sense_are_refused(self):
        for words, says in [
            (["--frames", "3-1"], "--frames 3-1"), (["--frames", "a"], "--frames a"), (["--size", "0"], "--size 0"),
            (["--size", "99999"], "--size 99999"), (["--size", "4x5"], "square"),
            (["--size", "5", "--projection", "equirect"], "twice as wide"),
            (["--projection", "perspective"], "camera 00 has no field of view"), (["--aov", "depth,albedo"], "albedo is none of"),
            (["--samples", "0"], "--samples 0"), (["--fov", "180"], "--fov 180"), (["--threads", "0"], "--threads 0"),
        ]:
            with self.subTest(words), self.assertRaisesRegex(layout.Refused, says):
                plan(self.work, *words)

    def test_a_missing_renderer_is_one_sentence(self):
        # Without site packages there is neither.
        (self.work / "c.json").write_text(json.dumps(CAMERAS))
        for script, says in (("mitsuba.py", "requirements.txt"), ("blender.py", "pip install bpy==")):
            words = [sys.executable, "-S", "-B", str(CAPTURE / script), "a", "--cameras", str(self.work / "c.json"), "-o",
                     str(self.work / "out")]
            done = subprocess.run(words, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": ""})
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
            self.assertIn(says, done.stderr)


# ---- the renderers, where they are

def python_with(package, variable, *more):
    """A Python that has the package, or None."""
    for python in [os.environ.get(variable), sys.executable, *map(str, more)]:
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


def mitsuba_room(frame):
    """The room at a frame as XML; walls radiate and reflect nothing, so that no noise is in their colour."""
    text = '<scene version="3.0.0"><integrator type="path"/>'
    for edges, normal, place, light in pieces():
        columns = [*edges, normal, place]
        matrix = " ".join(str(column[row]) for row in range(3) for column in columns) + " 0 0 0 1"
        text += (f'<shape type="rectangle"><transform name="to_world"><matrix value="{matrix}"/></transform>{MITSUBA_BALLS["black"]}'
                 f'<emitter type="area"><rgb name="radiance" value="{",".join(map(str, light))}"/></emitter></shape>')
    for ball, (_, radius, made) in enumerate(BALLS):
        x, y, z = center(ball, frame) if frame != "time" else BALLS[ball][0]
        moved = '<translate x="$time"/>' if frame == "time" and ball == 0 else ""
        text += (f'<shape type="sphere"><float name="radius" value="{radius}"/><transform name="to_world">'
                 f'<translate x="{x}" y="{y}" z="{z}"/>{moved}</transform>{MITSUBA_BALLS[made]}</shape>')
    return text + "</scene>"


class MitsubaTest(AdapterTest):
    @classmethod
    def setUpClass(cls):
        cls.python = python_with("mitsuba", "LIGHTFOLD_MITSUBA", TARGET / "capture" / "bin" / "python")
        if not cls.python:
            raise unittest.SkipTest("no Python with Mitsuba")

    def capture(self, scene, *words):
        (self.work / "c.json").write_text(json.dumps(CAMERAS))
        return subprocess.run([self.python, "-B", str(CAPTURE / "mitsuba.py"), str(self.work / scene), "--cameras",
                               str(self.work / "c.json"), "-o", str(self.work / "out"), "--samples", "4", *words],
                              capture_output=True, text=True)

    def assert_captured(self, scene, *words):
        done = self.capture(scene, "--aov", "depth,material,normal", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_is_the_room(self.work / "out")
        self.assert_fine(self.work / "out")

    def test_cube_maps_of_a_file_for_each_frame(self):
        for frame in (0, 1):
            (self.work / f"room.{frame:04}.xml").write_text(mitsuba_room(frame))
        self.assert_captured("room.%04d.xml", "--size", "24", "--frames", "0-1")
        first = files_of(self.work / "out")
        shutil.rmtree(self.work / "out")
        # Without --frames, those that there are.
        self.assert_captured("room.####.xml", "--size", "24")
        self.assertEqual(files_of(self.work / "out"), first)

    def test_panoramas_and_pictures_of_a_file_that_uses_the_time(self):
        (self.work / "room.xml").write_text(mitsuba_room("time"))
        self.assert_captured("room.xml", "--size", "64", "--frames", "1", "--fps", "1", "--projection", "equirect")
        shutil.rmtree(self.work / "out")
        self.assert_captured("room.xml", "--size", "96x64", "--frames", "0", "--fps", "1", "--projection", "perspective", "--fov", "100")

    def test_other_axes_and_units_and_holes(self):
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
        _, found = exr.read(self.work / "out" / "probe_00" / "face_py" / "depth.0000.exr")
        planar = {}
        for at, distance in enumerate(found["Z"]):
            u, v = 2 * (at % 16 + 0.5) / 16 - 1, 2 * (at // 16 + 0.5) / 16 - 1
            seen = round(distance / math.sqrt(1 + u * u + v * v), 4)
            planar.setdefault(seen, []).append((u, v))
        self.assertEqual(set(planar), {1.0, 2.5, math.inf})
        on_the_pane = len(planar[1.0]) + sum(max(map(abs, place)) < 0.5 for place in planar[math.inf])
        # Half of the 8x8 pixels of the pane are there; through the others one sees the wall, of 3.2x3.2 pixels.
        self.assertEqual((len(planar[1.0]), on_the_pane + len(planar[2.5])), (32, 64))
        self.assertTrue(all(max(map(abs, place)) < 0.2 for place in planar[2.5]))

    def test_scenes_that_cannot_be_read_are_one_sentence(self):
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

    @classmethod
    def setUpClass(cls):
        cls.python = python_with("bpy", "LIGHTFOLD_BPY")
        if not cls.python:
            raise unittest.SkipTest("no Python with bpy")

    def setUp(self):
        super().setUp()
        signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        walls = [([[p + a * u + b * v for p, u, v in zip(place, *edges)] for a, b in signs], light)
                 for edges, _, place, light in pieces()]
        text = f"WALLS = {walls!r}\nBALLS = {BALLS!r}\nSTEP = {STEP}\nIOR = {IOR}\n{BLENDER_ROOM}"
        (self.work / "room.py").write_text(text)
        subprocess.run([self.python, str(self.work / "room.py"), str(self.work / "room.blend")], check=True, capture_output=True)
        (self.work / "c.json").write_text(json.dumps(CAMERAS))

    def words(self, *words):
        return ["--cameras", str(self.work / "c.json"), "-o", str(self.work / "out"), "--samples", "4", "--aov",
                "depth,material,normal", *words]

    def assert_captured(self, command):
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        # Spheres are made of flat pieces.
        self.assert_is_the_room(self.work / "out", near_enough=1e-3)
        self.assert_fine(self.work / "out")
        shutil.rmtree(self.work / "out")

    def test_cube_maps_panoramas_and_pictures(self):
        command = [self.python, "-B", str(CAPTURE / "blender.py"), str(self.work / "room.blend")]
        self.assert_captured(command + self.words("--size", "24", "--cycles-device", "CPU"))
        self.assert_captured(command + self.words("--size", "64", "--projection", "equirect", "--frames", "1"))
        self.assert_captured(command + self.words("--size", "96x64", "--projection", "perspective", "--frames", "0", "--fov", "100"))

    def test_a_camera_inside_of_glass_looks_from_the_dense_side(self):
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
            _, channels = exr.read(self.work / "out" / (name.replace("{face}", face) % 0))
            for direction, reflect, ior in zip(view.directions(), channels["reflect"], channels["ior"]):
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

    def test_what_cannot_be_rendered_is_one_sentence(self):
        (self.work / "bad.blend").write_bytes(b"BLENDER no more")
        for scene, words, says in (("none.blend", [], "cannot be read"), ("bad.blend", [], "cannot open it"),
                                   ("room.blend", ["--cycles-device", "ABACUS"], "ABACUS: one of CPU, CUDA")):
            command = [self.python, "-B", str(CAPTURE / "blender.py"), str(self.work / scene), *self.words(*words)]
            done = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(says, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_it_is_run_as_blender_runs_scripts(self):
        script = str(CAPTURE / "blender.py")
        words = ["blender", "-b", "room.blend", "-P", script, "--", *self.words("--size", "24", "--frames", "0")]
        command = f"import bpy, sys, runpy; bpy.ops.wm.open_mainfile(filepath={str(self.work / 'room.blend')!r}); " \
                  f"sys.argv = {words!r}; runpy.run_path({script!r}, run_name='__main__')"
        self.assert_captured([self.python, "-B", "-c", command])


if __name__ == "__main__":
    unittest.main()
