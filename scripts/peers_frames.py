"""The frames that all codecs of scripts/peers get: codes of lightfold's lossless containers, and what they are mapped to.

A `Film` is what a codec is handed: for each stream the bytes of its frames, one after the other, and the way back from
such bytes to codes. Mapping and its way back are outside every time that is taken.
"""

import dataclasses
import json
import math
import pathlib
import re
import subprocess
from typing import Any, Callable

import numpy as np

import images
import lightfold_runs as lf
from images import Array

BACKGROUND = 65535
# The largest code of 24 bits that is not the background.
TOP_24 = (1 << 24) - 2
# CALF 7.1: bit i goes to channel i mod 3 (red, green, blue), place i div 3. ffmpeg's gbrp has planes of green, blue and red.
PLANE_OF_CHANNEL = (2, 0, 1)


class NotMeasured(Exception):
    """Why a row of the table stays empty."""


class BadInput(Exception):
    """One sentence, for exit code 2."""


@dataclasses.dataclass
class Stream:
    """One probe and face."""

    probe: str
    face: str | None
    first_frame: int
    frames: int
    near_far: tuple[float, float] = (1.0, 1.0)
    pick: tuple[str, ...] = ()


@dataclasses.dataclass
class Film:
    """Payloads of all streams; `pixel_format` and `unit` (bytes of a pixel) as ffmpeg has them."""

    name: str
    width: int
    height: int
    pixel_format: str
    unit: int
    streams: list[Stream]
    payloads: list[bytes]
    # Bytes of a stream that came back -> its codes.
    back: Callable[[bytes], bytes] = bytes
    # Values of a pixel, where it has one channel; the largest is the background.
    values: int = 65536
    wide: bool = False

    @property
    def frame_bytes(self) -> int:
        return self.width * self.height * self.unit

    @property
    def frames(self) -> int:
        return sum(stream.frames for stream in self.streams)

    def raw(self, work: images.Path) -> pathlib.Path:
        """The path of a file with all frames."""
        path = pathlib.Path(work) / f"{self.name}.raw"
        if not path.exists():
            path.write_bytes(b"".join(self.payloads))
        return path

    def split(self, data: bytes) -> list[bytes]:
        """Payloads out of the bytes of the whole film."""
        expected = sum(map(len, self.payloads))
        if len(data) != expected:
            raise NotMeasured(f"{len(data)} bytes came back of {expected}")
        at, found = 0, []
        for payload in self.payloads:
            found.append(data[at:at + len(payload)])
            at += len(payload)
        return found

    def images(self, payload: bytes) -> list[bytes]:
        """The frames of a stream."""
        return [payload[at:at + self.frame_bytes] for at in range(0, len(payload), self.frame_bytes)]


    def pixels(self, payload: bytes, frame: int) -> Array:
        """A frame of 8-bit RGB."""
        return np.frombuffer(payload, np.uint8).reshape(-1, self.height, self.width, 3)[frame]


Change = Callable[[bytes], bytes]


def mapped(film: Film, like: Film, each: Change, back: Change) -> Film:
    """A film as `like`, whose images are `each` of those of another, and come back by `back`."""
    joined = lambda change, payload, size: b"".join(change(payload[at:at + size]) for at in range(0, len(payload), size))
    like.payloads = [joined(each, payload, film.frame_bytes) for payload in film.payloads]
    like.back = lambda payload: joined(back, payload, like.frame_bytes)
    return like


def type_of_codes(wide: bool) -> str:
    return "<u4" if wide else "<u2"


def swizzle(codes: bytes, wide: bool = False) -> bytes:
    """Planes of green, blue and red of the codes of one image."""
    values = np.frombuffer(codes, type_of_codes(wide)).astype(np.uint32)
    planes = np.zeros((3, values.size), np.uint8)
    for bit in range(24):
        planes[PLANE_OF_CHANNEL[bit % 3]] |= ((values >> bit & 1) << bit // 3).astype(np.uint8)
    return planes.tobytes()


def unswizzle(planes: bytes, wide: bool = False) -> bytes:
    """Codes of one image. A lossy codec may set bits that 16-bit codes do not have: such a pixel gets the largest code."""
    values = np.frombuffer(planes, np.uint8).reshape(3, -1).astype(np.uint32)
    codes = np.zeros(values.shape[1], np.uint32)
    for bit in range(24):
        codes |= (values[PLANE_OF_CHANNEL[bit % 3]] >> bit // 3 & 1) << bit
    return (codes if wide else np.minimum(codes, BACKGROUND)).astype(type_of_codes(wide)).tobytes()


def swizzled(film: Film) -> Film:
    """Codes dealt out to red, green and blue, bit by bit (CALF 7.1)."""
    like = Film(film.name + "-rgb", film.width, film.height, "gbrp", 3, film.streams, [], wide=film.wide)
    return mapped(film, like, lambda image: swizzle(image, film.wide), lambda image: unswizzle(image, film.wide))


def codes24(metres: bytes, codes: bytes, near_far: tuple[float, float]) -> bytes:
    """24-bit codes in 32 bits, of 32-bit floats, by equation 13 as formats/depth.md 2 has it; 16-bit `codes` have the background."""
    near_m, far_m = near_far
    span = math.log1p((far_m - near_m) / near_m)
    with np.errstate(invalid="ignore", divide="ignore"):
        place = np.log1p((np.frombuffer(metres, "<f4").astype(float) - near_m) / near_m) / span if span > 0 else 0.0
    finer = np.floor(np.fmin(np.fmax(place, 0), 1) * TOP_24 + 0.5)
    return np.where(np.frombuffer(codes, "<u2") == BACKGROUND, TOP_24 + 1, finer).astype("<u4").tobytes()


def step_tables(bound: int) -> tuple[Array, Array]:
    """(code -> level, level -> code): levels are 2 * bound + 1 codes wide, the background is a level of its own."""
    step = 2 * bound + 1
    levels = (BACKGROUND - 1) // step + 2
    down = np.append(np.arange(BACKGROUND) // step, levels - 1)
    return down, np.append(np.minimum(np.arange(levels - 1) * step + bound, BACKGROUND - 1), BACKGROUND)


def gray_of(levels: int) -> str:
    """The narrowest gray of ffmpeg that holds so many levels."""
    for bits, name in ((8, "gray"), (10, "gray10le"), (12, "gray12le")):
        if levels <= 1 << bits:
            return name
    return "gray16le"


def stepped(film: Film, bound: int) -> Film:
    """Codes in steps of 2 * bound + 1: within the bound, and the background is kept."""
    down, up = step_tables(bound)
    kind = gray_of(len(up))
    unit = 1 if kind == "gray" else 2
    narrow = "<u1" if unit == 1 else "<u2"
    like = Film(f"steps-{bound}", film.width, film.height, kind, unit, film.streams, [], values=len(up))

    def translate(table: Array, given: str, made: str) -> Change:
        # A lossy codec may give back more than there are levels.
        return lambda image: table.take(np.frombuffer(image, given), mode="clip").astype(made).tobytes()

    return mapped(film, like, translate(down, "<u2", narrow), translate(up, narrow, "<u2"))


def png_bytes(path: images.Path) -> bytes:
    """Samples of a PNG of 8-bit colour or 16-bit gray; 16 bits in this order: low byte first."""
    pixels = images.read_png(path)
    if pixels.shape[2:] == (4,):
        raise ValueError(f"{path} has alpha; colour without was expected")
    return pixels.astype(pixels.dtype.newbyteorder("<")).tobytes()


def write_dataset(folder: pathlib.Path, manifest: str, film: Film, payloads: list[bytes]) -> None:
    """Frames of 8-bit colour as files of a manifest that `decode` wrote."""
    folder.mkdir(exist_ok=True)
    (folder / "lightfield.json").write_text(manifest)
    pattern = json.loads(manifest)["files"]["color"]
    for stream, payload in zip(film.streams, payloads):
        for at in range(stream.frames):
            path = folder / frame_path(pattern, stream, at)
            path.parent.mkdir(parents=True, exist_ok=True)
            images.write_png(path, film.pixels(payload, at))


def read_dataset(folder: pathlib.Path, streams: list[Stream]) -> list[bytes]:
    """8-bit colour of every stream, out of the folder that `decode` wrote."""
    pattern = json.loads((folder / "lightfield.json").read_text())["files"]["color"]
    return [b"".join(png_bytes(folder / frame_path(pattern, stream, at)) for at in range(stream.frames)) for stream in streams]


def decoded_payloads(binary: lf.Binary, container: pathlib.Path, kind: str, streams: list[Stream], work: images.Path) -> list[bytes]:
    """Codes or 8-bit colour of every stream of a container, through the PNG files that `decode` writes."""
    folder = pathlib.Path(work) / "png"
    payloads = []
    for stream in streams:
        command = [binary, "decode", container, "--stream", kind, *stream.pick, "--format", "png", "-q"]
        done = subprocess.run([*command, "-o", folder / "f.%06d.png"], capture_output=True, text=True)
        if done.returncode:
            raise NotMeasured(done.stderr.strip())
        files = sorted(folder.iterdir())
        payloads.append(b"".join(map(png_bytes, files)))
        for file in files:
            file.unlink()
    return payloads


def streams_of(report: dict[str, Any]) -> tuple[list[Stream], int, int]:
    """(streams, width, height) of a container's `inspect --json`."""
    sizes = {(stream["width"], stream["height"]) for stream in report["streams"]}
    if len(sizes) != 1:
        raise BadInput(f"streams of one size were expected, not of {sorted(sizes)}")
    streams = []
    for stream in report["streams"]:
        pick = ["--probe", stream["probe"]]
        if stream.get("face"):
            pick += ["--face", stream["face"]]
        near_far = (stream.get("near_m", 1.0), stream.get("far_m", 1.0))
        counts = (stream["first_frame"], stream["frames"])
        streams.append(Stream(stream["probe"], stream.get("face"), *counts, near_far, tuple(pick)))
    width, height = sizes.pop()
    return streams, width, height


def frame_path(pattern: str, stream: Stream, at: int) -> str:
    """The file of a frame of a stream, counted from its first, by a manifest's pattern."""
    text = pattern.replace("{probe}", stream.probe).replace("{face}", str(stream.face))
    frame = str(stream.first_frame + at)
    text = re.sub(r"%0?(\d*)d", lambda found: frame.zfill(int(found[1] or 1)), text)
    return re.sub(r"#+", lambda found: frame.zfill(len(found[0])), text)


def exr_metres(path: pathlib.Path, size: tuple[int, int]) -> bytes:
    """32-bit floats of the depth of an EXR file of that size: its channel Z, or the only one."""
    if path.suffix != ".exr" or not path.is_file():
        raise NotMeasured("24-bit codes are made from EXR files, one for each face and frame")
    try:
        channels = images.read_exr(path)
    except images.NotRead as error:
        raise NotMeasured(str(error)) from error
    depth = channels.get("Z", next(iter(channels.values())) if len(channels) == 1 else None)
    if depth is None or depth.dtype != np.float32:
        raise NotMeasured("24-bit codes are made from the channel Z, or an only one, of 32-bit floats")
    if depth.shape[::-1] != size:
        raise NotMeasured("24-bit codes are made from files of the size of a face")
    return depth.astype("<f4").tobytes()


def source_metres(manifest: images.Path, streams: list[Stream], size: tuple[int, int]) -> list[bytes]:
    """32-bit metres of every stream out of the source's files, or NotMeasured where this script cannot read them."""
    said = json.loads(pathlib.Path(manifest).read_text())
    depth = said.get("depth", {})
    if said["projection"] == "equirect" or depth.get("kind", "distance") != "distance" or depth.get("unit", "m") != "m":
        raise NotMeasured("24-bit codes are made from files of distances in metres, one for each face")
    folder, pattern = pathlib.Path(manifest).parent, said["files"]["depth"]
    return [b"".join(exr_metres(folder / frame_path(pattern, stream, at), size) for at in range(stream.frames)) for stream in streams]
