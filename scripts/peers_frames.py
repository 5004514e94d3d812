"""The frames that all codecs of scripts/peers get: codes of lightfold's lossless containers, and what they are mapped to.

A `Film` is what a codec is handed: for each stream the bytes of its frames, one after the other, and the way back from
such bytes to codes. Mapping and its way back are outside every time that is taken.
"""

import array
import dataclasses
import json
import pathlib
import re
import struct
import subprocess
import typing
import zlib

import png_images

BACKGROUND = 65535


class NotMeasured(Exception):
    """Why a row of the table stays empty."""


class BadInput(Exception):
    """One sentence, for exit code 2."""


@dataclasses.dataclass
class Stream:
    """One probe and face."""

    probe: str
    face: str
    first_frame: int
    frames: int
    near_far: tuple = (1.0, 1.0)
    pick: tuple = ()


@dataclasses.dataclass
class Film:
    """Payloads of all streams; `pixel_format` and `unit` (bytes of a pixel) as ffmpeg has them."""

    name: str
    width: int
    height: int
    pixel_format: str
    unit: int
    streams: list
    payloads: list
    # Bytes of a stream that came back -> its codes.
    back: typing.Callable = staticmethod(lambda payload: payload)
    # Values of a pixel, where it has one channel; the largest is the background.
    values: int = 65536
    wide: bool = False

    @property
    def frame_bytes(self):
        return self.width * self.height * self.unit

    @property
    def frames(self):
        return sum(stream.frames for stream in self.streams)

    def raw(self, work):
        """The path of a file with all frames."""
        path = pathlib.Path(work) / f"{self.name}.raw"
        if not path.exists():
            path.write_bytes(b"".join(self.payloads))
        return path

    def split(self, data):
        """Payloads out of the bytes of the whole film."""
        expected = sum(map(len, self.payloads))
        if len(data) != expected:
            raise NotMeasured(f"{len(data)} bytes came back of {expected}")
        at, found = 0, []
        for payload in self.payloads:
            found.append(data[at:at + len(payload)])
            at += len(payload)
        return found

    def images(self, payload):
        """The frames of a stream."""
        return [payload[at:at + self.frame_bytes] for at in range(0, len(payload), self.frame_bytes)]


def mapped(film, name, pixel_format, unit, each, back, **more):
    """A film whose images are `each` of those of another, and come back by `back`."""
    joined = lambda change, payload, size: b"".join(
        change(payload[at:at + size]) for at in range(0, len(payload), size))
    made = Film(name, film.width, film.height, pixel_format, unit, film.streams, [], **more)
    made.payloads = [joined(each, payload, film.frame_bytes) for payload in film.payloads]
    made.back = lambda payload: joined(back, payload, made.frame_bytes)
    return made


def swizzled(kernels, film):
    """Codes dealt out to red, green and blue, bit by bit (CALF 7.1)."""
    return mapped(film, film.name + "-rgb", "gbrp", 3, lambda image: kernels.swizzle(image, film.wide),
                  lambda image: kernels.unswizzle(image, film.wide), wide=film.wide)


def step_tables(bound):
    """(levels, code -> level, level -> code): levels are 2 * bound + 1 codes wide, the background is a level of its own."""
    step = 2 * bound + 1
    levels = (BACKGROUND - 1) // step + 2
    down = [code // step for code in range(BACKGROUND)] + [levels - 1]
    up = [min(level * step + bound, BACKGROUND - 1) for level in range(levels - 1)] + [BACKGROUND]
    return levels, down, up


def gray_of(levels):
    """The narrowest gray of ffmpeg that holds so many levels."""
    for bits, name in ((8, "gray"), (10, "gray10le"), (12, "gray12le")):
        if levels <= 1 << bits:
            return name
    return "gray16le"


def stepped(film, bound):
    """Codes in steps of 2 * bound + 1: within the bound, and the background is kept."""
    levels, down, up = step_tables(bound)
    kind = gray_of(levels)
    unit = 1 if kind == "gray" else 2
    letter = "B" if unit == 1 else "H"

    def translate(table, given, made):
        return lambda image: array.array(made, map(table.__getitem__, array.array(given, image))).tobytes()

    # A lossy codec could give back more than there are levels.
    up = up + [BACKGROUND] * ((1 << 8 * unit) - len(up))
    return mapped(film, f"steps-{bound}", kind, unit, translate(down, "H", letter), translate(up, letter, "H"),
                  values=levels)


def png_image(kernels, path):
    """Samples of a PNG of 8-bit colour or 16-bit gray; 16 bits in this order: low byte first."""
    _, _, step, samples = png_images.read(path, kernels.png_rows)
    if step == 4:
        raise ValueError(f"{path} has alpha; colour without was expected")
    return samples


def write_dataset(folder, manifest, film, payloads):
    """Frames of 8-bit colour as files of a manifest that `decode` wrote."""
    folder.mkdir(exist_ok=True)
    (folder / "lightfield.json").write_text(manifest)
    pattern = json.loads(manifest)["files"]["color"]
    for stream, payload in zip(film.streams, payloads):
        for at, image in enumerate(film.images(payload)):
            path = folder / frame_path(pattern, stream.probe, stream.face, stream.first_frame + at)
            path.parent.mkdir(parents=True, exist_ok=True)
            png_images.write(path, film.width, image)


def read_dataset(kernels, folder, streams):
    """8-bit colour of every stream, out of the folder that `decode` wrote."""
    pattern = json.loads((folder / "lightfield.json").read_text())["files"]["color"]
    path = lambda stream, at: folder / frame_path(pattern, stream.probe, stream.face, stream.first_frame + at)
    return [b"".join(png_image(kernels, path(stream, at)) for at in range(stream.frames)) for stream in streams]


def decoded_payloads(binary, kernels, container, kind, streams, work):
    """Codes or 8-bit colour of every stream of a container, through the PNG files that `decode` writes."""
    folder = pathlib.Path(work) / "png"
    payloads = []
    for stream in streams:
        command = [binary, "decode", container, "--stream", kind, *stream.pick, "--format", "png", "-q"]
        done = subprocess.run([*command, "-o", folder / "f.%06d.png"], capture_output=True, text=True)
        if done.returncode:
            raise NotMeasured(done.stderr.strip())
        files = sorted(folder.iterdir())
        payloads.append(b"".join(png_image(kernels, file) for file in files))
        for file in files:
            file.unlink()
    return payloads


def streams_of(report):
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
    return streams, *sizes.pop()


def frame_path(pattern, probe, face, frame):
    """The file of a frame by a manifest's pattern."""
    text = pattern.replace("{probe}", str(probe)).replace("{face}", str(face))
    text = re.sub(r"%0?(\d*)d", lambda found: str(frame).zfill(int(found[1] or 1)), text)
    return re.sub(r"#+", lambda found: str(frame).zfill(len(found[0])), text)


COMPRESSION = {0: ("none", 1), 2: ("ZIPS", 1), 3: ("ZIP", 16)}
SAMPLE_BYTES = {0: 4, 1: 2, 2: 4}


def exr_attributes(data):
    """(attributes, where they end) of an EXR file of one part in scan lines."""
    if data[:4] != b"v/1\x01" or len(data) < 8 or data[5] & 0b1010:
        raise NotMeasured("24-bit codes are made from EXR files of scan lines, of one part")
    at, found = 8, {}
    while data[at]:
        name, kind, rest = data[at:at + 600].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        [size] = struct.unpack_from("<I", data, at)
        found[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def exr_channels(words):
    """(name, bytes of a sample, is it a 32-bit float) in the order in which lines hold them."""
    at, found = 0, []
    while words[at]:
        name = words[at:].split(b"\0", 1)[0]
        at += len(name) + 1
        [kind] = struct.unpack_from("<I", words, at)
        found.append((name.decode(), SAMPLE_BYTES[kind], kind == 2))
        at += 16
    return found


def exr_floats(kernels, path):
    """(width, height, bytes of 32-bit floats) of the depth of an EXR file: its channel Z, or the only one."""
    data = pathlib.Path(path).read_bytes()
    attributes, at = exr_attributes(data)
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = exr_channels(attributes["channels"])
    wanted = [name for name, _, _ in channels if name == "Z" or len(channels) == 1]
    packed_as = attributes["compression"][0]
    if not wanted or packed_as not in COMPRESSION:
        raise NotMeasured("24-bit codes are made from the channel Z, or an only one, of plain EXR files and of those in ZIP")
    before = sum(size for name, size, _ in channels if name < wanted[0]) * width
    if not dict((name, is_float) for name, _, is_float in channels)[wanted[0]]:
        raise NotMeasured("24-bit codes are made from depth of 32-bit floats")
    line = sum(size for _, size, _ in channels) * width
    lines = COMPRESSION[packed_as][1]
    rows = {}
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, at):
        y, size = struct.unpack_from("<iI", data, offset)
        body, count = data[offset + 8:offset + 8 + size], min(lines, y1 + 1 - y)
        if len(body) < count * line:
            body = kernels.exr_unpredict(zlib.decompress(body))
        for row in range(count):
            rows[y + row] = body[row * line + before:row * line + before + 4 * width]
    return width, height, b"".join(rows[y] for y in sorted(rows))


def source_metres(kernels, manifest, streams, size):
    """32-bit metres of every stream out of the source's files, or NotMeasured where this script cannot read them."""
    said = json.loads(pathlib.Path(manifest).read_text())
    depth = said.get("depth", {})
    if said["projection"] == "equirect" or depth.get("kind", "distance") != "distance" or depth.get("unit", "m") != "m":
        raise NotMeasured("24-bit codes are made from files of distances in metres, one for each face")
    pattern = said["files"]["depth"]
    payloads = []
    for stream in streams:
        frames = []
        for frame in range(stream.first_frame, stream.first_frame + stream.frames):
            path = pathlib.Path(manifest).parent / frame_path(pattern, stream.probe, stream.face, frame)
            if path.suffix != ".exr" or not path.is_file():
                raise NotMeasured("24-bit codes are made from EXR files, one for each face and frame")
            *found, floats = exr_floats(kernels, path)
            if tuple(found) != size:
                raise NotMeasured("24-bit codes are made from files of the size of a face")
            frames.append(floats)
        payloads.append(b"".join(frames))
    return payloads
