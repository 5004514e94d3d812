"""Codes and bytes in boxes, for decode.py: written from formats/depth.md 3, 4 and 14 and from nothing else."""

import math

import blocks
from container import fetch
from fields import Fields, check


def read_depth_fields(fields):
    near, far, background, measure = fields.take("fffI")
    check(0 < near <= far < math.inf and not math.isnan(background) and measure <= 1, "a depth header is illegal")


def read_temporal_header(stream):
    fields = Fields(stream.header)
    if stream.kind == 1:
        read_depth_fields(fields)
    if stream.codec in PIECES:
        check_unit(stream)
    window, boxes, _epsilon = fields.take("HHH")
    fields.zeros(2)
    check(1 <= window <= 255 and 1 <= boxes <= 256 and fields.take("I") >= 1, "a header is illegal")
    fields.finish()
    return window


def read_record_table(fields, frame_count):
    count = fields.take("I")
    check(1 <= count <= frame_count, "the number of records is illegal")
    fields.fits(count, 8)
    table = [fields.take("II") for _ in range(count)]
    frames = [frame for frame, _ in table]
    check(frames[0] == 0 and frames[-1] < frame_count, "records are out of range")
    check(all(a < b for a, b in zip(frames, frames[1:])), "the records are out of order")
    return table


def check_unit(stream):
    check(stream.unit_width % 4 == stream.unit_height % 4 == 0, "a unit's sides are no multiples of 4")


# Size of a block, and what makes values of its pixels (depth.md 14).
PIECES = {
    b"DAB5": (16, lambda block: [bytes((low, high)) for high, low in blocks.bc5(block)]),
    b"MAB1": (8, blocks.bc1),
}


def read_pieces(fields, width, height, size, codec):
    """The values of a rectangle that is cut into pieces (depth.md 14)."""
    block_size, decode = PIECES[codec]
    rects = [(x, y, min(16, width - x), min(16, height - y)) for y in range(0, height, 16) for x in range(0, width, 16)]
    of_pieces = int.from_bytes(fields.bytes(-(-len(rects) // 8)), "little")
    check(of_pieces >> len(rects) == 0, "spare bits of a map are not zero")
    values = bytearray(width * height * size)
    for at, (x, y, w, h) in enumerate(rects):
        if of_pieces >> at & 1:
            stored = fields.bytes(blocks.image_bytes(block_size, w, h))
            piece = b"".join(blocks.image(stored, block_size, decode, w, h))
        else:
            piece = fields.bytes(w * h * size)
        for row in range(h):
            start = ((y + row) * width + x) * size
            values[start:start + w * size] = piece[row * w * size:(row + 1) * w * size]
    return bytes(values)


def parse_records(payload, width, height, frame_count, size, codec):
    """{frame: [(x, y, width, height, values)]}; `size` is that of a value."""
    if codec in PIECES:
        grid, read = 4, lambda w, h: read_pieces(fields, w, h, size, codec)
    else:
        grid, read = 1, lambda w, h: fields.bytes(w * h * size)
    fields = Fields(payload)
    records, last = {}, -1
    for frame, offset in read_record_table(fields, frame_count):
        check(offset == fields.at, "a record is elsewhere")
        kind = fields.take("B")
        fields.zeros(1)
        boxes = fields.take("H")
        if kind == 2 and last >= 0:
            check(1 <= boxes <= 256, "the number of boxes is illegal")
            rects = [fields.take("4H") for _ in range(boxes)]
            for i, (x, y, w, h) in enumerate(rects):
                check(w and h and x + w <= width and y + h <= height, "a box is outside of its unit")
                check(x % grid == 0 and (w % grid == 0 or x + w == width), "a box cuts blocks")
                check(y % grid == 0 and (h % grid == 0 or y + h == height), "a box cuts blocks")
                for u, v, s, t in rects[:i]:
                    check(x + w <= u or u + s <= x or y + h <= v or v + t <= y, "two boxes overlap")
            records[frame] = [(*r, read(r[2], r[3])) for r in rects]
        else:
            check(kind <= 1 and boxes == 0, "a record is illegal")
            values = read(width, height) if kind == 0 else fields.bytes(size) * (width * height)
            records[frame] = [(0, 0, width, height, values)]
        last = frame
    fields.finish()
    return records


def decode_temporal(data, chunks, width, height, size, window, codec):
    """The pictures of a unit, each reached along its own path of fewest steps."""
    for _first, count, place in chunks:
        records = parse_records(fetch(data, place), width, height, count, size, codec)
        for target in range(count):
            picture = bytearray(width * height * size)
            for frame in [*range(0, target, window), target]:
                for x, y, w, h, values in records.get(frame, ()):
                    for row in range(h):
                        start = ((y + row) * width + x) * size
                        picture[start:start + w * size] = values[row * w * size:(row + 1) * w * size]
            yield bytes(picture)
