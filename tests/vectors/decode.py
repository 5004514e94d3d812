#!/usr/bin/env python3
"""Decodes .lfold containers, written from the documents in formats/ and from nothing else.

Prints `stream frame crc32` for each frame of each stream, the CRC-32 being that of the image in the form that
arithmetic.md 1 gives it. For a container that breaks a rule of the documents it says so on standard error, and ends with
exit code 2.

Usage: decode.py FILE.lfold...
"""

import lzma
import math
import re
import struct
import sys
import unicodedata
import zlib

MAX_SIZE = 16384
MAX_FRAME = 1 << 31
MAX_CHUNK_BYTES = 1 << 30
MAX_EXPANSION = 16384


class Refused(Exception):
    """The file breaks a rule."""


def check(rule, message):
    if not rule:
        raise Refused(message)


class Fields:
    """Little-endian fields, one after the other (container.md 1)."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def bytes(self, count):
        check(self.at + count <= len(self.data), "the fields end early")
        self.at += count
        return self.data[self.at - count:self.at]

    def take(self, layout):
        values = struct.unpack("<" + layout, self.bytes(struct.calcsize("<" + layout)))
        check("d" not in layout or all(map(math.isfinite, values)), "an f64 is not finite")
        return values if len(values) > 1 else values[0]

    def string(self):
        try:
            return self.bytes(self.take("H")).decode("utf-8")
        except UnicodeDecodeError:
            raise Refused("a string is not UTF-8") from None

    def zeros(self, count):
        check(not any(self.bytes(count)), "a reserved byte is not zero")

    def fits(self, count, least):
        check(count * least <= len(self.data) - self.at, "a table does not fit")

    def finish(self):
        check(self.at == len(self.data), "bytes are left over")


# container.md 3 to 7 -------------------------------------------------------------------------------------------------

def read_head(data):
    fields = Fields(data[:16])
    check(fields.bytes(8) == b"\x89LFLD\r\n\x1a", "the magic is other")
    major, _minor = fields.take("HH")
    check(major == 1, "another major version")
    fields.zeros(4)


def read_foot(data):
    check(len(data) >= 56, "the file is too short")
    foot = data[-40:]
    fields = Fields(foot)
    offset, size, crc = fields.take("QQI")
    fields.zeros(4)
    file_bytes, foot_crc = fields.take("QI")
    check(fields.bytes(4) == b"LFND", "there is no foot")
    check(foot_crc == zlib.crc32(foot[:32]), "the foot's CRC-32 is other")
    check(file_bytes == len(data), "the file's size is other")
    check(offset >= 16 and offset + size == len(data) - 40, "the index is not before the foot")
    index = data[offset:offset + size]
    check(zlib.crc32(index) == crc, "the index's CRC-32 is other")
    return index, offset


def read_probe(fields):
    name = fields.string()
    check(re.fullmatch(r"[A-Za-z0-9_-][A-Za-z0-9._-]*", name), "a probe's name is illegal")
    fields.take("7d")
    first, last = fields.take("II")
    check(first <= last < MAX_FRAME, "a probe's frames are illegal")
    fields.take("4d")
    return name


class Stream:
    def __init__(self, fields, probe_count):
        self.kind, self.face, self.probe, self.codec = fields.take("BBH4s")
        self.width, self.height, self.first, self.count = fields.take("4I")
        self.unit_width, self.unit_height, header_bytes = fields.take("3I")
        self.header = fields.bytes(header_bytes)
        check(self.kind <= 2 and self.face <= 6 and self.probe < probe_count, "kind, face or probe is illegal")
        sizes = (self.width, self.height, self.unit_width, self.unit_height)
        check(all(1 <= size <= MAX_SIZE for size in sizes), "a size is illegal")
        check(self.count >= 1 and self.first + self.count <= MAX_FRAME, "the frames are illegal")
        self.columns = -(-self.width // self.unit_width)
        self.units = self.columns * -(-self.height // self.unit_height)
        self.chunks = []

    def rect(self, unit):
        x, y = unit % self.columns * self.unit_width, unit // self.columns * self.unit_height
        return x, y, min(self.unit_width, self.width - x), min(self.unit_height, self.height - y)


def read_index(index, end):
    fields = Fields(index)
    probe_count, stream_count, chunk_count, projection = fields.take("3IB")
    fields.zeros(3)
    check(projection <= 1 and fields.take("d") > 0, "projection or frame rate is illegal")
    check(not any(unicodedata.category(letter) == "Cc" for letter in fields.string()), "the name holds control characters")
    fields.fits(probe_count, 98)
    probes = [read_probe(fields) for _ in range(probe_count)]
    check(len(set(probes)) == probe_count, "two probes of one name")
    fields.fits(stream_count, 36)
    streams = [Stream(fields, probe_count) for _ in range(stream_count)]
    check(len({(s.kind, s.probe, s.face) for s in streams}) == stream_count, "two streams of one face")
    fields.fits(chunk_count, 40)
    rows = [read_row(fields, end) for _ in range(chunk_count)]
    fields.finish()
    at = 0
    for number, stream in enumerate(streams):
        for unit in range(stream.units):
            frame, chunks = stream.first, []
            while frame < stream.first + stream.count:
                check(at < chunk_count, "the chunk table ends early")
                key, place = rows[at]
                check(key[:3] == (number, unit, frame) and key[3] >= 1, "the chunk table has a gap")
                chunks.append((frame - stream.first, key[3], place))
                frame, at = frame + key[3], at + 1
            check(frame == stream.first + stream.count, "a chunk goes beyond its stream")
            stream.chunks.append(chunks)
    check(at == chunk_count, "the chunk table has rows too many")
    return streams


def read_row(fields, end):
    key = fields.take("4I")
    offset, stored, raw, crc, storage = fields.take("QIIIB")
    fields.zeros(3)
    check(storage <= 1 and 16 <= offset and offset + stored <= end, "a chunk's place is illegal")
    check(raw <= MAX_CHUNK_BYTES, "a chunk is too large")
    check(raw <= stored * MAX_EXPANSION if storage else raw == stored, "a chunk's sizes are illegal")
    return key, (offset, stored, raw, crc, storage)


def fetch(data, place):
    offset, stored, raw, crc, storage = place
    payload = data[offset:offset + stored]
    check(zlib.crc32(payload) == crc, "a chunk's CRC-32 is other")
    if storage:
        size = 1 << (max(4096, min(raw, 1 << 24)) - 1).bit_length()
        decoder = lzma.LZMADecompressor(lzma.FORMAT_RAW, filters=[{"id": lzma.FILTER_LZMA2, "dict_size": size}])
        try:
            payload = decoder.decompress(payload, raw + 1)
        except lzma.LZMAError:
            raise Refused("a chunk's LZMA2 stream is damaged") from None
        check(len(payload) == raw, "a chunk's LZMA2 stream has another size")
        check(decoder.eof and not decoder.unused_data, "a chunk's LZMA2 stream does not end where it should")
    return payload


# depth.md 3, 4 -------------------------------------------------------------------------------------------------------

def read_temporal_header(stream):
    fields = Fields(stream.header)
    if stream.codec == b"DAAB":
        near, far, background, measure = fields.take("fffI")
        check(0 < near <= far < math.inf and not math.isnan(background) and measure <= 1, "a depth header is illegal")
    window, boxes, _epsilon = fields.take("HHH")
    fields.zeros(2)
    check(1 <= window <= 255 and 1 <= boxes <= 256 and fields.take("I") >= 1, "a header is illegal")
    fields.finish()
    return window


def parse_records(payload, width, height, frame_count, size):
    """{frame: [(x, y, width, height, values)]}; `size` is that of a value."""
    fields = Fields(payload)
    count = fields.take("I")
    check(1 <= count <= frame_count, "the number of records is illegal")
    fields.fits(count, 8)
    table = [fields.take("II") for _ in range(count)]
    records, last = {}, -1
    for frame, offset in table:
        check((frame == 0 if last < 0 else frame > last) and frame < frame_count, "the records are out of order")
        check(offset == fields.at, "a record is elsewhere")
        kind = fields.take("B")
        fields.zeros(1)
        boxes = fields.take("H")
        if kind == 2 and last >= 0:
            check(1 <= boxes <= 256, "the number of boxes is illegal")
            rects = [fields.take("4H") for _ in range(boxes)]
            for i, (x, y, w, h) in enumerate(rects):
                check(w and h and x + w <= width and y + h <= height, "a box is outside of its unit")
                for u, v, s, t in rects[:i]:
                    check(x + w <= u or u + s <= x or y + h <= v or v + t <= y, "two boxes overlap")
            records[frame] = [(*r, fields.bytes(r[2] * r[3] * size)) for r in rects]
        else:
            check(kind <= 1 and boxes == 0, "a record is illegal")
            values = fields.bytes(width * height * size) if kind == 0 else fields.bytes(size) * (width * height)
            records[frame] = [(0, 0, width, height, values)]
        last = frame
    fields.finish()
    return records


def decode_temporal(data, chunks, width, height, size, window):
    """The pictures of a unit, each reached along its own path of fewest steps."""
    for _first, count, place in chunks:
        records = parse_records(fetch(data, place), width, height, count, size)
        for target in range(count):
            picture = bytearray(width * height * size)
            for frame in [*range(0, target, window), target]:
                for x, y, w, h, values in records.get(frame, ()):
                    for row in range(h):
                        start = ((y + row) * width + x) * size
                        picture[start:start + w * size] = values[row * w * size:(row + 1) * w * size]
            yield bytes(picture)


# color.md 2 to 4, arithmetic.md 3, 4 ---------------------------------------------------------------------------------

def read_color_header(stream):
    fields = Fields(stream.header)
    fields.take("d")
    if stream.codec == b"CCL8":
        exposure, transfer = fields.take("fI")
        check(-32 <= exposure <= 32 and transfer <= 1, "a colour header is illegal")
    else:
        check(fields.take("d") > 0, "a colour header is illegal")
    fields.finish()


def parse_cell(payload, pixels, frame_count, size):
    fields = Fields(payload)
    count, flags = fields.take("HB")
    fields.zeros(1)
    weight_count = fields.take("I")
    check(1 <= count <= frame_count and flags <= 1 and weight_count <= min(frame_count, 1 << 20), "a cell's counts are illegal")
    fields.fits(count, 4)
    frames = [fields.take("I") for _ in range(count)]
    check(frames[0] == 0 and frames[-1] < frame_count, "keyframes are out of range")
    check(all(a < b for a, b in zip(frames, frames[1:])), "keyframes are out of order")
    weights = fields.bytes(weight_count)
    check(not any(weights[frame] for frame in frames if frame < weight_count), "a keyframe has a weight")
    check(flags or not any(weights[frames[-1]:]), "a weight leads nowhere")
    samples = [fields.bytes(3 * size * pixels) for _ in range(count)]
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


def decode_cell(data, chunks, pixels, size):
    cells = [parse_cell(fetch(data, place), pixels, count, size) for _first, count, place in chunks]
    for at, ((_first, count, _place), (frames, weights, samples)) in enumerate(zip(chunks, cells)):
        for frame in range(count):
            before = sum(first <= frame for first in frames) - 1
            weight = weights[frame] if frame < len(weights) else 0
            if weight == 0:
                yield samples[before]
                continue
            check(before + 1 < len(frames) or at + 1 < len(cells), "the last chunk leads to a next one")
            after = samples[before + 1] if before + 1 < len(frames) else cells[at + 1][2][0]
            yield blend(samples[before], after, weight, size)


# Whole images --------------------------------------------------------------------------------------------------------

PIXEL_BYTES = {(1, b"DAAB"): 2, (2, b"MAAB"): 3, (0, b"CCL8"): 3, (0, b"CCLH"): 6}


def decode_stream(data, stream):
    pixel = PIXEL_BYTES.get((stream.kind, stream.codec))
    check(pixel, "the codec is unknown")
    window = read_color_header(stream) if stream.kind == 0 else read_temporal_header(stream)
    images = [bytearray(stream.width * stream.height * pixel) for _ in range(stream.count)]
    for unit, chunks in enumerate(stream.chunks):
        left, top, width, height = stream.rect(unit)
        if stream.kind == 0:
            pictures = decode_cell(data, chunks, width * height, pixel // 3)
        else:
            pictures = decode_temporal(data, chunks, width, height, pixel, window)
        for image, picture in zip(images, pictures):
            for row in range(height):
                start = ((top + row) * stream.width + left) * pixel
                image[start:start + width * pixel] = picture[row * width * pixel:(row + 1) * width * pixel]
    return images


def main(paths):
    refused = False
    for path in paths:
        with open(path, "rb") as file:
            data = file.read()
        try:
            read_head(data)
            images = [(n, s.first, decode_stream(data, s)) for n, s in enumerate(read_index(*read_foot(data)))]
            for number, first, frames in images:
                for at, image in enumerate(frames):
                    print(number, first + at, f"{zlib.crc32(image):08x}")
        except Refused as refusal:
            print(f"{path}: {refusal}", file=sys.stderr)
            refused = True
    return 2 if refused else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
