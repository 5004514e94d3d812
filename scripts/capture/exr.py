"""OpenEXR scan-line files by numpy alone, as Blender's Python has no OpenEXR: written as lightfold's datasets have them, read as
blender.py has Blender write them.

An image is a dict of channel names to arrays of rows.
"""

import os
import pathlib
import struct
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
MAGIC = 20000630
# Types of samples: 1 and 2.
KINDS: dict[int, np.dtype[Any]] = {1: np.dtype("<f2"), 2: np.dtype("<f4")}
NO_COMPRESSION, ZIP = 0, 3
ZIP_ROWS = 16
MAX_HALF = 65504.0


class BadImage(ValueError):
    """A file that is not such an image."""


def half(values: Array) -> Array:
    """Half floats: what is too bright gets the largest one of its sign, and what is no number 0."""
    return np.nan_to_num(np.clip(values, -MAX_HALF, MAX_HALF), nan=0.0).astype(KINDS[1])


def write(path: str | pathlib.Path, channels: dict[str, Array]) -> None:
    """Writes channels of one type, half or 32-bit floats, in ZIP blocks. The file appears under its name when it is whole."""
    names = sorted(channels)
    # Rows, each of all channels in turn.
    rows = np.stack([channels[name] for name in names], axis=1)
    kind = next(number for number, of in KINDS.items() if of == rows.dtype.newbyteorder("<"))
    head = header(rows.shape[2], rows.shape[0], [(name, kind) for name in names])
    starts = range(0, len(rows), ZIP_ROWS)
    blocks = [squeezed(rows[start:start + ZIP_ROWS].astype(KINDS[kind]).tobytes()) for start in starts]
    offsets, offset = [], len(head) + 8 * len(blocks)
    for block in blocks:
        offsets.append(offset)
        offset += 8 + len(block)
    partial = f"{path}.partial"
    with open(partial, "wb") as file:
        file.write(head + struct.pack(f"<{len(offsets)}Q", *offsets))
        for start, block in zip(starts, blocks):
            file.write(struct.pack("<ii", start, len(block)) + block)
    os.replace(partial, path)


def header(width: int, height: int, channels: list[tuple[str, int]]) -> bytes:
    listed = b"".join(name.encode() + struct.pack("<xiB3xii", kind, 0, 1, 1) for name, kind in channels) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = [
        ("channels", "chlist", listed),
        ("compression", "compression", bytes([ZIP])),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    ]
    head = struct.pack("<ii", MAGIC, 2)
    for name, kind, value in attributes:
        head += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    return head + b"\0"


def squeezed(raw: bytes) -> bytes:
    """A ZIP block: even bytes, then odd ones, differences of neighbours, zlib; as it is where that is no gain."""
    apart = np.frombuffer(raw[0::2] + raw[1::2], np.uint8)
    steps = apart.copy()
    steps[1:] = apart[1:] - apart[:-1] + 128
    data = zlib.compress(steps.tobytes(), 6)
    return data if len(data) < len(raw) else raw


def read(path: str | pathlib.Path) -> dict[str, Array]:
    """Channels of an image whose scan lines are not compressed."""
    data = pathlib.Path(path).read_bytes()
    try:
        attributes, at = attributes_of(data)
        left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
        if attributes["compression"][0] != NO_COMPRESSION:
            raise BadImage("it is compressed")
        samples = [(name, kind, (right - left + 1,)) for name, kind in listed(attributes["channels"])]
        # Each line behind its number and length; the table of their offsets goes before.
        line = np.dtype([("", "<i4"), ("", "<i4"), *samples])
        height = bottom - top + 1
        lines = np.frombuffer(data, line, height, at + 8 * height)
        if [*np.frombuffer(data, "<u8", height, at)] != [at + 8 * height + row * line.itemsize for row in range(height)]:
            raise BadImage("lines are not in order")
    except (struct.error, IndexError, KeyError, ValueError) as error:
        raise BadImage(f"{path}: this is not an OpenEXR file of scan lines that can be read here: {error}") from error
    return {name: lines[name].astype(np.float32) for name, *_ in samples}


def attributes_of(data: bytes) -> tuple[dict[str, bytes], int]:
    """Attributes of a file's head, and where it ends."""
    magic, version = struct.unpack_from("<ii", data)
    if magic != MAGIC or version & ~0x4FF:
        raise BadImage("it has another magic number, or tiles, parts or deep pixels")
    attributes, at = {}, 8
    while data[at]:
        name, at = word(data, at)
        _, at = word(data, at)
        length, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + length]
        at += 4 + length
    return attributes, at + 1


def word(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def listed(data: bytes) -> list[tuple[str, np.dtype[Any]]]:
    """Names and types of channels, in the order in which lines have them."""
    channels, at = [], 0
    while data[at]:
        name, at = word(data, at)
        kind, = struct.unpack_from("<i", data, at)
        channels.append((name, KINDS[kind]))
        at += 16
    return channels
