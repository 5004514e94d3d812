"""Cells of colour, for decode.py: written from formats/color.md 2 to 4, formats/arithmetic.md 3 and 4, and from nothing else."""

import struct

import blocks
import transform
from boxes import check_unit
from container import PIXEL_BYTES, fetch
from fields import Fields, check

TRANSFORMS = {b"CTR8": 1, b"CTRH": 2}


def read_color_header(stream):
    """The table sets of a transform stream."""
    fields = Fields(stream.header)
    fields.take("d")
    if stream.codec in KEYFRAMES:
        check_unit(stream)
    if PIXEL_BYTES[0, stream.codec] == 3:
        exposure, transfer = fields.take("fI")
        check(-32 <= exposure <= 32 and transfer <= 1, "a colour header is illegal")
    else:
        check(fields.take("d") > 0, "a colour header is illegal")
    sets = None
    if stream.codec in TRANSFORMS:
        check(0 <= fields.take("d") <= 100, "the quality is illegal")
        check(fields.take("B") == 3, "the number of colour planes is illegal")
        fields.zeros(3)
        sets = transform.read_sets(fields)
    fields.finish()
    return sets


# Size of a block, and what makes the samples of its pixels (color.md 4).
KEYFRAMES = {
    b"CCB1": (8, blocks.bc1),
    b"CCB7": (16, blocks.bc7),
    b"CCB6": (16, lambda block: [struct.pack("<3H", *pixel) for pixel in blocks.bc6h(block)]),
}


def read_keyframe(fields, width, height, size, codec, as_samples):
    if as_samples:
        return fields.bytes(3 * size * width * height)
    block_size, decode = KEYFRAMES[codec]
    stored = fields.bytes(blocks.image_bytes(block_size, width, height))
    return b"".join(blocks.image(stored, block_size, decode, width, height))


def parse_cell(payload, width, height, frame_count, size, codec):
    fields = Fields(payload)
    count, flags = fields.take("HB")
    fields.zeros(1)
    weight_count = fields.take("I")
    check(1 <= count <= frame_count and flags <= 1 and weight_count <= min(frame_count, 1 << 20), "a cell's counts are illegal")
    fields.fits(count, 4)
    frames, as_samples = [fields.take("I") for _ in range(count)], [1] * count
    if codec in KEYFRAMES:
        as_samples = [row >> 31 for row in frames]
        frames = [row & 0x7FFFFFFF for row in frames]
    check(frames[0] == 0 and frames[-1] < frame_count, "keyframes are out of range")
    check(all(a < b for a, b in zip(frames, frames[1:])), "keyframes are out of order")
    weights = fields.bytes(weight_count)
    check(not any(weights[frame] for frame in frames if frame < weight_count), "a keyframe has a weight")
    check(flags or not any(weights[frames[-1]:]), "a weight leads nowhere")
    samples = [read_keyframe(fields, width, height, size, codec, raw) for raw in as_samples]
    fields.finish()
    return frames, weights, samples


def lerp(a, b, weight):
    return (a * (255 - weight) + b * weight + 127) // 255


def key_of(bits):
    return bits ^ (0xFFFF if bits >= 0x8000 else 0x8000)


def bits_of(key):
    return key ^ (0x8000 if key >= 0x8000 else 0xFFFF)


def blend(a, b, weight, size):
    if size == 1:
        return bytes(lerp(x, y, weight) for x, y in zip(a, b))
    layout = f"<{len(a) // 2}H"
    pairs = zip(struct.unpack(layout, a), struct.unpack(layout, b))
    return struct.pack(layout, *(bits_of(lerp(key_of(x), key_of(y), weight)) for x, y in pairs))


def decode_cell(data, chunks, width, height, size, codec):
    cells = [parse_cell(fetch(data, place), width, height, count, size, codec) for _first, count, place in chunks]
    for at, ((_first, count, _place), (frames, weights, samples)) in enumerate(zip(chunks, cells)):
        following = cells[at + 1][2][0] if at + 1 < len(cells) else None
        yield from show_cell(frames, weights, samples, following, count, size)


def show_cell(frames, weights, samples, following, count, size):
    """The pictures of a chunk; `following` is the first keyframe of the next one."""
    for frame in range(count):
        before = sum(first <= frame for first in frames) - 1
        weight = weights[frame] if frame < len(weights) else 0
        if weight == 0:
            yield samples[before]
            continue
        after = samples[before + 1] if before + 1 < len(frames) else following
        check(after is not None, "the last chunk leads to a next one")
        yield blend(samples[before], after, weight, size)


def decode_transform(data, chunks, width, height, size, sets):
    """The pictures of a cell (color.md 6.4)."""
    for _first, count, place in chunks:
        payload = fetch(data, place)
        check(count <= transform.MAX_FRAMES, "a chunk has too many frames")
        if payload[:1] == b"\xff":
            cell = payload[1:]
            frames, weights, samples = parse_cell(cell, width, height, count, size, None)
            check(cell[2] == 0, "a cell in a transform stream is closed by a next chunk")
            yield from show_cell(frames, weights, samples, None, count, size)
        else:
            for keys in transform.decode(payload, width, height, count, size, sets):
                yield bytes(keys) if size == 1 else struct.pack(f"<{len(keys)}H", *map(bits_of, keys))
