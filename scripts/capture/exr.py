"""OpenEXR scan-line files in Python's own library: written as lightfold's datasets have them, read as renderers leave them.

An image is a dict of channel names to `array("f")`, row 0 first. What is written are ZIP blocks of 16 rows; what can be read
is that, single rows of it, and rows that are not compressed, of 16- and 32-bit floats.
"""

import array
import itertools
import os
import struct
import sys
import zlib

MAGIC = 20000630
HALF, FLOAT = 1, 2
ROWS = {0: 1, 2: 1, 3: 16}
ZIP = 3
# A half holds no more; what is brighter is written as this.
LARGEST_HALF = 65504.0


class BadImage(ValueError):
    """A file that is not such an image."""


def write(path, size, channels, kind):
    """Writes channels of one type, HALF or FLOAT. The file appears under its name when it is whole."""
    width, height = size
    names = sorted(channels)
    pack = packed_half if kind == HALF else packed_float
    rows = {name: pack(channels[name]) for name in names}
    stride = width * (2 if kind == HALF else 4)
    blocks = []
    for first in range(0, height, ROWS[ZIP]):
        lines = range(first, min(first + ROWS[ZIP], height))
        raw = b"".join(rows[name][line * stride:(line + 1) * stride] for line in lines for name in names)
        blocks.append((first, squeezed(raw)))
    head = header(width, height, [(name, kind) for name in names])
    offset = len(head) + 8 * len(blocks)
    offsets = []
    for _, data in blocks:
        offsets.append(offset)
        offset += 8 + len(data)
    partial = f"{path}.partial"
    with open(partial, "wb") as file:
        file.write(head + struct.pack(f"<{len(offsets)}Q", *offsets))
        for first, data in blocks:
            file.write(struct.pack("<ii", first, len(data)) + data)
    os.replace(partial, path)


def header(width, height, channels):
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


def packed_half(values):
    clipped = [value if -LARGEST_HALF <= value <= LARGEST_HALF else half_of_odd(value) for value in values]
    return struct.pack(f"<{len(clipped)}e", *clipped)


def half_of_odd(value):
    """What becomes of values that no half holds: the largest one of their sign, and 0 for what is no number."""
    return LARGEST_HALF if value > 0 else -LARGEST_HALF if value < 0 else 0.0


def packed_float(values):
    found = array.array("f", values)
    if sys.byteorder == "big":
        found.byteswap()
    return found.tobytes()


def squeezed(raw):
    """A block as ZIP has it: even bytes, then odd ones, differences of neighbours, zlib; as it is where that is no gain."""
    apart = raw[0::2] + raw[1::2]
    steps = apart[:1] + bytes([(this - last + 128) & 255 for last, this in zip(apart, apart[1:])])
    data = zlib.compress(steps, 6)
    return data if len(data) < len(raw) else raw


def unsqueezed(data, length):
    steps = zlib.decompressobj().decompress(data, length + 1)
    if len(steps) != length:
        raise BadImage("a block has not the length of its rows")
    apart = bytes(itertools.accumulate(steps, lambda last, step: (last + step - 128) & 255))
    half = (length + 1) // 2
    raw = bytearray(length)
    raw[0::2], raw[1::2] = apart[:half], apart[half:]
    return bytes(raw)


def read(path):
    """((width, height), channels) of the image."""
    with open(path, "rb") as file:
        data = file.read()
    try:
        return parsed(data)
    except (struct.error, IndexError, KeyError, ValueError, zlib.error) as error:
        raise BadImage(f"{path}: this is not an OpenEXR file of scan lines that can be read here: {error}") from error


def parsed(data):
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
    at += 1
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    channels = listed(attributes["channels"])
    compression = attributes["compression"][0]
    rows = ROWS[compression]
    planes = {name: bytearray() for name, _ in channels}
    for offset in struct.unpack_from(f"<{-(-height // rows)}Q", data, at):
        first, length = struct.unpack_from("<ii", data, offset)
        lines = min(rows, bottom + 1 - first)
        whole = lines * sum(width * pixel_bytes(kind) for _, kind in channels)
        block = data[offset + 8:offset + 8 + length]
        raw = unsqueezed(block, whole) if compression and length < whole else block
        if len(block) != length or len(raw) != whole:
            raise BadImage("a block ends early")
        start = 0
        for _ in range(lines):
            for name, kind in channels:
                end = start + width * pixel_bytes(kind)
                planes[name] += raw[start:end]
                start = end
    formats = {name: "e" if kind == HALF else "f" for name, kind in channels}
    values = {name: array.array("f", struct.unpack(f"<{width * height}{formats[name]}", planes[name])) for name in planes}
    return (width, height), values


def word(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def listed(data):
    channels, at = [], 0
    while data[at]:
        name, at = word(data, at)
        kind, = struct.unpack_from("<i", data, at)
        if kind not in (HALF, FLOAT):
            raise BadImage(f"channel {name} is of integers")
        channels.append((name, kind))
        at += 16
    return channels


def pixel_bytes(kind):
    return 2 if kind == HALF else 4
