"""Common part of the adapters beside this file: poses of cameras, names of files, and the manifest.

Everything here is in lightfold's axes, right-handed with +Y up, and in metres. An adapter renders images of a `View`; all
the rest is here: options, cameras.json, order of work, seeds, resuming, lightfield.json.
"""

import argparse
import dataclasses
import importlib
import json
import math
import os
import pathlib
import re
import sys
import time
import zlib
from typing import Any, Callable, Protocol, Sequence

try:
    import numpy as np
except ImportError as error:
    print("error: this Python has no numpy: for mitsuba.py, python3 -m pip install -c scripts/requirements.txt mitsuba numpy; for "
          f"blender.py, Blender's own has it, and Python 3.11 after pip install bpy==4.2.23 ({error})", file=sys.stderr)
    raise SystemExit(2) from error

import exr
from exr import Array

Vector = tuple[float, float, float]
# The faces of an OpenGL cube map: forward, right and down in the image. Each is the mirror image of what a person sees there.
FACES: dict[str, tuple[Vector, Vector, Vector]] = {
    "px": ((1, 0, 0), (0, 0, -1), (0, -1, 0)),
    "nx": ((-1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "py": ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
    "ny": ((0, -1, 0), (1, 0, 0), (0, 0, -1)),
    "pz": ((0, 0, 1), (1, 0, 0), (0, -1, 0)),
    "nz": ((0, 0, -1), (-1, 0, 0), (0, -1, 0)),
}
# Forward, right and down of a viewer who looks along -Z: perspective images, and the middle of an equirectangular one.
AHEAD: tuple[Vector, Vector, Vector] = ((0, 0, -1), (1, 0, 0), (0, -1, 0))
KINDS = ["depth", "material", "normal"]
CHANNELS: dict[str, Sequence[str]] = {"color": "RGB", "depth": "Z", "normal": "XYZ", "material": ["reflect", "refract", "ior"]}
# Keys that a camera of a cameras.json may have.
KEYS = ["name", "position", "orientation", "fov_y_deg", "frames", "gain", "coverage"]
STATE = "capture.partial.json"
MANIFEST = "lightfield.json"
MAX_SIDE = 65536

EPILOG = """
Cameras are a cameras.json, as `lightfold place` writes it, or the probes of a lightfield.json:
  { "lightfold_cameras": 1, "cameras": [ { "name": "00", "position": [0, 1.5, 0] } ] }
Positions are in metres, right-handed, +Y up. What is written is a dataset: depth is the Euclidean distance in metres of what
lies behind the middle of a pixel, of one ray that no filter touches, +inf where nothing is; colour is linear Rec. 709, the mean
of a pixel, 65504 where it is more and 0 where it is no number; cube faces are those of OpenGL. The same scene, options and
release of the renderer give the same images. See that all is as it should be, and encode it:
  lightfold inspect DIR/lightfield.json --check
  lightfold encode DIR/lightfield.json -o film.lfold
"""


class Refused(SystemExit):
    """Input that cannot be worked with: one sentence, and the exit code 2."""

    def __init__(self, sentence: str):
        super().__init__(2)
        self.sentence = sentence

    def __str__(self) -> str:
        return self.sentence


def parser(prog: str, about: str) -> argparse.ArgumentParser:
    """Options that both adapters have."""
    parser = argparse.ArgumentParser(prog=prog, description=about, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cameras", metavar="FILE", required=True,
                        help="a cameras.json or a lightfield.json, - for standard input")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="folder of the dataset; new, or empty")
    parser.add_argument("--frames", metavar="A-B",
                        help="first and last frame, or a single one [default: those of the cameras, or of the scene]")
    parser.add_argument("--size", metavar="N|WxH",
                        help="pixels: the side of a face, the width of a panorama, or both sides [default: 512, for panoramas 2048]")
    parser.add_argument("--samples", metavar="N", type=int, default=64, help="rays for the colour of a pixel [default: 64]")
    parser.add_argument("--aov", metavar="KINDS", default="depth",
                        help="what comes besides colour: depth, material, normal, with commas between, or none [default: depth]")
    parser.add_argument("--projection", choices=["cube", "equirect", "perspective"], default="cube", help="[default: cube]")
    parser.add_argument("--fov", metavar="DEG", type=float, help="vertical field of view of perspective cameras that have none")
    parser.add_argument("--seed", metavar="N", type=int, default=0, help="another number is other noise [default: 0]")
    parser.add_argument("--noise", choices=["still", "moving"], default="still",
                        help="whether frames share their noise, which costs a video codec less [default: still]")
    parser.add_argument("--name", help="name of the dataset [default: that of the folder]")
    parser.add_argument("--threads", metavar="N", type=int, help="threads to render with [default: all]")
    parser.add_argument("--resume", action="store_true", help="go on with an interrupted capture of the same options")
    return parser


@dataclasses.dataclass
class Camera:
    """A probe to be. `frames` is what it shows, inclusive."""

    name: str
    position: list[float]
    orientation: list[float] | None = None
    fov_y_deg: float | None = None
    frames: list[int] | None = None


@dataclasses.dataclass
class View:
    """One image to render: its axes in the world are those of the file, mirrored where the file is.

    `tangents` are those of half the field of view, across and high.
    """

    camera: Camera
    face: str
    forward: Vector
    right: Vector
    down: Vector
    size: tuple[int, int]
    projection: str
    tangents: tuple[float, float]
    seed: int
    kinds: list[str]

    @property
    def mirrored(self) -> bool:
        """True if a camera that looks forward sees the image with left and right exchanged."""
        return self.projection == "cube"

    @property
    def up(self) -> Vector:
        x, y, z = self.down
        return -x, -y, -z

    @property
    def fov_y_deg(self) -> float:
        return math.degrees(2 * math.atan(self.tangents[1]))

    def pixels(self) -> tuple[Array, Array]:
        """u and v of the middle of each pixel: from -1 to 1 over the image, to the right and down."""
        u, v = (2 * (np.arange(side) + 0.5) / side - 1 for side in self.size)
        across, down = np.meshgrid(u, v)
        return across, down

    def directions(self) -> Array:
        """Unit directions in the world of rays through the middle of each pixel, in the last axis."""
        u, v = self.pixels()
        if self.projection == "equirect":
            lon, lat = u * math.pi, -v * math.pi / 2
            x, y, z = np.sin(lon) * np.cos(lat), -np.sin(lat), np.cos(lon) * np.cos(lat)
        else:
            x, y, z = u * self.tangents[0], v * self.tangents[1], np.ones_like(u)
        scale = 1 / np.sqrt(x * x + y * y + z * z)
        x, y, z = x * scale, y * scale, z * scale
        return np.stack([x * right + y * down + z * forward
                         for right, down, forward in zip(self.right, self.down, self.forward)], axis=-1)

    def mirror(self, planes: list[Array]) -> list[Array]:
        """Planes of the file, of those that a camera sees which looks forward: left and right are exchanged in cube maps."""
        return [plane[:, ::-1] for plane in planes] if self.mirrored else planes


def fresnel(cosine: float, ior: float) -> float:
    """The part of unpolarised light that a surface of glass reflects, met at that cosine from outside."""
    cosine = abs(cosine)
    inside = math.sqrt(max(0.0, 1 - (1 - cosine * cosine) / (ior * ior))) if ior * ior > 1 - cosine * cosine else 0.0
    if not inside:
        return 1.0
    across = (cosine - ior * inside) / (cosine + ior * inside)
    along = (inside - ior * cosine) / (inside + ior * cosine)
    return (across * across + along * along) / 2


def glass(cosine: float, ior: float, inside: bool) -> Vector:
    """reflect, refract and ior of a surface of glass. A camera inside of it looks from the dense side to the thin one."""
    reflected = fresnel(cosine, 1 / ior if inside else ior)
    return reflected, 1 - reflected, ior


def rotated(vector: Vector, orientation: Sequence[float] | None) -> Vector:
    """A vector turned by a unit quaternion x, y, z, w."""
    a, b, c = map(float, vector)
    if orientation is None:
        return a, b, c
    x, y, z, w = orientation
    # Twice the cross product of the quaternion's axis and the vector.
    i, j, k = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return a + w * i + y * k - z * j, b + w * j + z * i - x * k, c + w * k + x * j - y * i


# ---- cameras.json

def read_cameras(path: str) -> list[Camera]:
    """The cameras of a cameras.json, or of the probes of a lightfield.json."""
    try:
        text = sys.stdin.read() if path == "-" else pathlib.Path(path).read_text(encoding="utf-8")
        found = json.loads(text)
    except (OSError, ValueError) as error:
        raise Refused(f"{path}: the cameras cannot be read: {error}") from error
    known = None
    if isinstance(found, dict) and found.get("lightfield") == 1:
        listed = found.get("probes")
    elif isinstance(found, dict) and found.get("lightfold_cameras") == 1:
        listed, known = found.get("cameras"), KEYS
    else:
        raise Refused(f'{path}: neither "lightfold_cameras": 1 nor "lightfield": 1 is in it: a cameras.json was expected')
    if not isinstance(listed, list) or not listed:
        raise Refused(f"{path}: it names no camera: at least one was expected")
    digits = max(2, len(str(len(listed) - 1)))
    cameras = []
    for at, entry in enumerate(listed):
        try:
            cameras.append(camera_of(entry, f"{at:0{digits}}", known))
        except ValueError as error:
            raise Refused(f"{path}: camera {at}: {error}") from error
    names = [camera.name for camera in cameras]
    for at, name in enumerate(names):
        if name in names[:at]:
            raise Refused(f"{path}: camera {at}: there is another camera of this name, {name}")
    return cameras


def camera_of(entry: Any, number: str, known: list[str] | None) -> Camera:
    if not isinstance(entry, dict):
        raise ValueError('an object with a "position" was expected')
    for key in entry:
        if known and key not in known:
            raise ValueError(f'"{key}" is none of {", ".join(known)}')
    name = entry.get("name", number)
    if not (isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}", name)):
        raise ValueError("a name is 1 to 100 letters, digits, '.', '_' or '-', and does not begin with '.'")
    camera = Camera(name, numbers(entry, "position", 3))
    if entry.get("orientation") is not None:
        turned = numbers(entry, "orientation", 4)
        length = math.sqrt(sum(value * value for value in turned))
        if abs(length - 1) > 1e-3:
            raise ValueError('"orientation" must be a quaternion of length 1')
        camera.orientation = [value / length for value in turned]
    if entry.get("fov_y_deg") is not None:
        camera.fov_y_deg, = numbers({"fov_y_deg": [entry["fov_y_deg"]]}, "fov_y_deg", 1)
        if not 0 < camera.fov_y_deg < 180:
            raise ValueError('"fov_y_deg" must lie between 0 and 180')
    if entry.get("frames") is not None:
        camera.frames = [int(value) for value in numbers(entry, "frames", 2)]
        if camera.frames != entry["frames"] or not 0 <= camera.frames[0] <= camera.frames[1]:
            raise ValueError('"frames" must be the first and the last one, from 0 on')
    return camera


def numbers(entry: dict[str, Any], key: str, count: int) -> list[float]:
    found = entry.get(key)
    if not isinstance(found, list) or len(found) != count or not all(
            isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value) for value in found):
        raise ValueError(f'"{key}" must be {count} finite numbers')
    return [float(value) for value in found]


# ---- options

def frames_of(words: str) -> list[int]:
    """First and last frame of `A-B` or `A`."""
    found = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", words)
    first, last = (int(found[1]), int(found[2] or found[1])) if found else (1, 0)
    if first > last:
        raise Refused(f"--frames {words}: a frame, or the first and the last with - between them, was expected")
    return [first, last]


def size_of(words: str | None, projection: str) -> tuple[int, int]:
    words = words or ("2048" if projection == "equirect" else "512")
    found = re.fullmatch(r"(\d{1,6})(?:x(\d{1,6}))?", words)
    width = int(found[1]) if found else 0
    height = int(found[2]) if found and found[2] else width // 2 if projection == "equirect" else width
    if not (0 < width <= MAX_SIDE and 0 < height <= MAX_SIDE):
        raise Refused(f"--size {words}: sides of 1 to {MAX_SIDE} pixels were expected, such as 512 or 640x480")
    if projection == "cube" and width != height:
        raise Refused(f"--size {words}: the faces of a cube are square")
    if projection == "equirect" and width != 2 * height:
        raise Refused(f"--size {words}: a panorama is twice as wide as it is high")
    return width, height


def kinds_of(words: str) -> list[str]:
    found = [] if words == "none" else words.split(",")
    for kind in found:
        if kind not in KINDS:
            raise Refused(f"--aov {words}: {kind or 'nothing'} is none of {', '.join(KINDS)}")
    return ["color"] + [kind for kind in KINDS if kind in found]


class Plan:
    """Everything that is to be rendered, and where it goes.

    `options` are those of `parser`; `scene` is what the renderer says of itself and its input, for a capture that is gone on
    with; `frames` and `fps` are those of the scene.
    """

    def __init__(self, options: argparse.Namespace, scene: dict[str, Any], frames: list[int], fps: float):
        self.options = options
        self.scene = scene
        self.fps = fps
        self.folder = pathlib.Path(options.output)
        self.cameras = read_cameras(options.cameras)
        self.size = size_of(options.size, options.projection)
        self.kinds = kinds_of(options.aov)
        looked = [camera.frames for camera in self.cameras if camera.frames]
        if options.frames:
            frames = frames_of(options.frames)
        elif len(looked) == len(self.cameras):
            frames = [min(first for first, _ in looked), max(last for _, last in looked)]
        if options.samples < 1:
            raise Refused(f"--samples {options.samples}: at least 1 was expected")
        if options.fov is not None and not 0 < options.fov < 180:
            raise Refused(f"--fov {options.fov}: it must lie between 0 and 180 degrees")
        if options.threads is not None and options.threads < 1:
            raise Refused(f"--threads {options.threads}: at least 1 was expected")
        seen = [self.complete(camera, frames) for camera in self.cameras]
        self.frames = [min(first for first, _ in seen), max(last for _, last in seen)]
        self.range_m = [math.inf, 0.0]

    def complete(self, camera: Camera, frames: list[int]) -> list[int]:
        """Gives a camera the frames, of those of the capture, and the field of view that it has not; returns the frames."""
        first, last = camera.frames or frames
        camera.frames = [max(first, frames[0]), min(last, frames[1])]
        if camera.frames[0] > camera.frames[1]:
            raise Refused(f"camera {camera.name} looks in the frames {first}-{last}, the capture is of {frames[0]}-{frames[1]}")
        if self.options.projection == "perspective":
            camera.fov_y_deg = camera.fov_y_deg or self.options.fov
            if camera.fov_y_deg is None:
                raise Refused(f"camera {camera.name} has no field of view: give one with --fov to all that have none")
        return camera.frames

    @property
    def faces(self) -> list[str]:
        return list(FACES) if self.options.projection == "cube" else ["view"]

    def pattern(self, kind: str) -> str:
        folder = "probe_{probe}/face_{face}" if self.options.projection == "cube" else "probe_{probe}"
        return f"{folder}/{kind}.%04d.exr"

    def path(self, kind: str, camera: Camera, face: str, frame: int) -> pathlib.Path:
        pattern = self.pattern(kind).replace("{probe}", camera.name).replace("{face}", face)
        return self.folder / (pattern % frame)

    def view(self, camera: Camera, face: str, frame: int, kinds: list[str]) -> View:
        forward, right, down = (rotated(axis, camera.orientation) for axis in FACES.get(face, AHEAD))
        high = math.tan(math.radians(camera.fov_y_deg) / 2) if camera.fov_y_deg and self.options.projection == "perspective" else 1.0
        noise = frame if self.options.noise == "moving" else 0
        seed = zlib.crc32(f"{self.options.seed} {camera.name} {face} {noise}".encode()) & 0x7FFFFFFF
        tangents = (high * self.size[0] / self.size[1], high)
        return View(camera, face, forward, right, down, self.size, self.options.projection, tangents, seed, kinds)

    def missing(self, frame: int) -> list[View]:
        """Views of a frame with the kinds of image that are not there."""
        found = []
        for camera in self.cameras:
            if camera.frames and camera.frames[0] <= frame <= camera.frames[1]:
                for face in self.faces:
                    kinds = [kind for kind in self.kinds if not is_there(self.path(kind, camera, face, frame))]
                    if kinds:
                        found.append(self.view(camera, face, frame, kinds))
        return found

    def state(self) -> dict[str, Any]:
        options = self.options
        cameras = [dataclasses.asdict(camera) for camera in self.cameras]
        return {"scene": self.scene, "cameras": cameras, "frames": self.frames, "fps": self.fps, "size": list(self.size),
                "samples": options.samples, "kinds": self.kinds, "projection": options.projection, "seed": options.seed,
                "noise": options.noise}

    def claim(self) -> None:
        """Makes the folder, or finds what an interrupted capture left there."""
        state = self.folder / STATE
        if self.folder.exists() and not self.folder.is_dir():
            raise Refused(f"{self.folder} is a file: a folder was expected")
        if not self.folder.exists() or not any(self.folder.iterdir()):
            self.folder.mkdir(parents=True, exist_ok=True)
            state.write_text(json.dumps(self.state(), indent=1) + "\n")
            return
        if not self.options.resume:
            hint = "add --resume to go on with it, or name another folder" if state.is_file() else "name another folder"
            raise Refused(f"{self.folder} is not empty: {hint}")
        if not state.is_file():
            raise Refused(f"{self.folder} holds no capture that was interrupted: there is no {STATE} in it")
        try:
            left = json.loads(state.read_text())
        except ValueError as error:
            raise Refused(f"{state}: it is damaged; name another folder") from error
        # Through JSON, as the other went.
        wanted = json.loads(json.dumps(self.state()))
        for key in wanted:
            if left.get(key) != wanted[key]:
                raise Refused(f"{self.folder}: the interrupted capture was of other {key}: give the same, or name another folder")

    def store(self, view: View, frame: int, images: dict[str, list[Array]]) -> None:
        """Writes the images of a view, planes by kind."""
        for kind in view.kinds:
            planes = dict(zip(CHANNELS[kind], (plane.astype(np.float32) for plane in images[kind])))
            if kind == "depth":
                self.see(planes["Z"])
            else:
                planes = {name: exr.half(plane) for name, plane in planes.items()}
            path = self.path(kind, view.camera, view.face, frame)
            path.parent.mkdir(parents=True, exist_ok=True)
            exr.write(path, planes)

    def see(self, depth: Array) -> None:
        seen = depth[depth < math.inf]
        if seen.size:
            self.range_m = [min(self.range_m[0], float(seen.min())), max(self.range_m[1], float(seen.max()))]

    def manifest(self) -> dict[str, Any]:
        """Contents of lightfield.json."""
        def probe(camera: Camera) -> dict[str, Any]:
            said: dict[str, Any] = {"name": camera.name, "position": camera.position}
            if camera.frames != self.frames:
                said["frames"] = camera.frames
            if camera.orientation is not None:
                said["orientation"] = camera.orientation
            if self.options.projection == "perspective":
                said["fov_y_deg"] = camera.fov_y_deg
            return said

        projection = "cubemap" if self.options.projection == "cube" else self.options.projection
        name = self.options.name or self.folder.resolve().name or "capture"
        said: dict[str, Any] = {"lightfield": 1, "name": name, "fps": self.fps, "frames": self.frames, "projection": projection,
                                "size": list(self.size)}
        if projection == "cubemap":
            said["faces"] = "opengl-cube"
        if "depth" in self.kinds:
            said["depth"] = {"kind": "distance", "unit": "m", "background": "inf"}
        said["color"] = {"space": "linear-rec709"}
        if "material" in self.kinds:
            said["material"] = {"channels": {"reflection": "reflect", "refraction": "refract", "ior": "ior"}}
        said["files"] = {kind: self.pattern(kind) for kind in self.kinds}
        said["probes"] = [probe(camera) for camera in self.cameras]
        said["extra"] = {"renderer": self.scene["renderer"], "samples": self.options.samples, "seed": self.options.seed,
                         "noise": self.options.noise}
        return said

    def finish(self) -> None:
        (self.folder / MANIFEST).write_text(json.dumps(self.manifest(), indent=1) + "\n")
        (self.folder / STATE).unlink()


class Renderer(Protocol):
    """Renderer of an adapter."""

    def frame(self, number: int) -> None:
        """Goes to a frame."""

    def images(self, view: View) -> dict[str, list[Array]]:
        """Planes of each kind that the view asks for, and maybe of others."""


def package(name: str, hint: str) -> Any:
    """A renderer's package, or the hint of how to get it."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise Refused(f"{hint} ({error})") from error


def is_there(path: pathlib.Path) -> bool:
    """True if an image was written: it has its name only when it is whole."""
    return path.is_file() and path.stat().st_size > 0


def capture(plan: Plan, renderer: Renderer) -> None:
    """Renders all that is missing."""
    plan.claim()
    frames = range(plan.frames[0], plan.frames[1] + 1)
    count = sum(len(plan.missing(frame)) for frame in frames)
    done, began = 0, time.monotonic()
    for frame in frames:
        views = plan.missing(frame)
        if views:
            renderer.frame(frame)
        for view in views:
            plan.store(view, frame, renderer.images(view))
            done += 1
            left = (time.monotonic() - began) / done * (count - done)
            say(f"frame {frame} probe {view.camera.name} {view.face}: {done} of {count}, {left:.0f} s to go")
    plan.finish()
    seen = f", surfaces {plan.range_m[0]:.4g} m to {plan.range_m[1]:.4g} m away" if plan.range_m[1] else ""
    say(f"{plan.folder / MANIFEST}: {len(plan.cameras)} probes, frames {plan.frames[0]}-{plan.frames[1]}, {count} views "
        f"in {time.monotonic() - began:.1f} s{seen}")


def say(words: str) -> None:
    print(words, file=sys.stderr, flush=True)


def run(main: Callable[[], None]) -> None:
    """Calls `main`; a refusal is one line and exit code 2, an interruption says how to go on, and any other error is 1.

    Blender ends with 0 after an exception that nobody caught, so all are caught.
    """
    code: Any = 1
    try:
        main()
        code = 0
    except Refused as refusal:
        say(f"error: {refusal}")
        code = 2
    except KeyboardInterrupt:
        say("interrupted: the same command with --resume goes on with it")
        code = 130
    except SystemExit as leaving:
        code = leaving.code
    except Exception:
        import traceback
        traceback.print_exc()
    sys.exit(code)


def scene_stamp(path: str) -> dict[str, Any]:
    """Identity of a scene's file: its name, length and time of change."""
    try:
        found = os.stat(path)
    except OSError as error:
        raise Refused(f"{path}: the scene cannot be read: {error.strerror}") from error
    return {"file": str(pathlib.Path(path).resolve()), "bytes": found.st_size, "changed_ns": found.st_mtime_ns}
