"""PNG files and 8-bit RGB pictures, with the standard library alone."""

import math
import pathlib
import struct
import zlib

# Bytes of a pixel by bits and kind of colour: 8-bit RGB and RGBA, 16-bit gray.
STEPS = {(8, 2): 3, (8, 6): 4, (16, 0): 2}


class NotRead(ValueError):
    """A file that is none of these PNGs."""


def read(path, unfilter=None):
    """(width, height, bytes of a pixel, samples) of a PNG of 8-bit RGB or RGBA, or of 16-bit gray: low byte first.

    `unfilter` does what `unfiltered` does.
    """
    data = pathlib.Path(path).read_bytes()
    at, packed, head = 8, [], None
    while at + 8 <= len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        at += 12 + size
        if kind == b"IHDR":
            head = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed.append(body)
    if head is None or head[2:4] not in STEPS or head[6]:
        raise NotRead(f"{path}: a PNG of 8-bit colour or 16-bit gray was expected")
    width, height, step = *head[:2], STEPS[head[2:4]]
    try:
        samples = (unfilter or unfiltered)(zlib.decompress(b"".join(packed)), height, width * step, step)
    except (ValueError, zlib.error) as error:
        raise NotRead(f"{path}: {error}") from error
    if step == 2:
        swapped = bytearray(samples)
        swapped[0::2], swapped[1::2] = samples[1::2], samples[0::2]
        samples = bytes(swapped)
    return width, height, step, samples


def unfiltered(raw, rows, row_bytes, step):
    """Rows of a PNG without their filters; `step` is the bytes of a pixel."""
    if len(raw) != rows * (row_bytes + 1):
        raise ValueError("a PNG holds more or fewer rows than it says")
    out, above = bytearray(), bytearray(row_bytes)
    for start in range(0, len(raw), row_bytes + 1):
        kind, row = raw[start], bytearray(raw[start + 1:start + 1 + row_bytes])
        if kind == 2:
            row = bytearray((value + up) & 255 for value, up in zip(row, above))
        elif kind:
            for i in range(row_bytes):
                left, corner = (row[i - step], above[i - step]) if i >= step else (0, 0)
                row[i] = (row[i] + predicted(kind, left, above[i], corner)) & 255
        out += row
        above = row
    return out


def predicted(kind, left, up, corner):
    """What a filter of PNG, other than none, predicts."""
    if kind == 1:
        return left
    if kind == 3:
        return (left + up) // 2
    ahead = left + up - corner
    return min((abs(ahead - left), 0, left), (abs(ahead - up), 1, up), (abs(ahead - corner), 2, corner))[2]


def write(path, width, rgb, level=1):
    """A PNG of 8-bit colour, rows without a filter, compressed at a level of zlib."""
    rows = b"".join(b"\0" + rgb[at:at + 3 * width] for at in range(0, len(rgb), 3 * width))
    head = struct.pack(">IIBBBBB", width, len(rgb) // (3 * width), 8, 2, 0, 0, 0)
    parts = ((b"IHDR", head), (b"IDAT", zlib.compress(rows, level)), (b"IEND", b""))
    chunks = (struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in parts)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))


def enlarged(picture, width, times):
    """Each pixel drawn `times` times in each direction."""
    drawn = bytearray()
    for start in range(0, len(picture), 3 * width):
        row = picture[start:start + 3 * width]
        drawn += b"".join(row[x:x + 3] * times for x in range(0, len(row), 3)) * times
    return drawn


def psnr_db(squares, samples):
    """PSNR of so many 8-bit codes whose differences have this sum of squares."""
    return 10 * math.log10(255 * 255 * samples / squares) if squares else math.inf
