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

import blocks
import transform
import zstandard
from fields import Fields, Refused, check

MAX_SIZE = 16384
MAX_FRAME = 1 << 31
MAX_CHUNK_BYTES = 1 << 30
# Payload bytes for each stored byte, by storage.
EXPANSION = (1, 16384, 32768)


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
    offset, size, crc, form = fields.take("QQIB")
    fields.zeros(3)
    check(form <= 1, "the index has an unknown form")
    file_bytes, foot_crc = fields.take("QI")
    check(fields.bytes(4) == b"LFND", "there is no foot")
    check(foot_crc == zlib.crc32(foot[:32]), "the foot's CRC-32 is other")
    check(file_bytes == len(data), "the file's size is other")
    check(offset >= 16 and offset + size == len(data) - 40, "the index is not before the foot")
    index = data[offset:offset + size]
    check(zlib.crc32(index) == crc, "the index's CRC-32 is other")
    return index, offset, form


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
        self.check(probe_count)

    def check(self, probe_count):
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


def read_dataset(fields):
    projection = fields.take("B")
    fields.zeros(3)
    check(projection <= 1 and fields.take("d") > 0, "projection or frame rate is illegal")
    check(not any(unicodedata.category(letter) == "Cc" for letter in fields.string()), "the name holds control characters")


def read_index(index, end, form):
    fields = Fields(index)
    probes, streams, rows = (read_tables, read_compact_tables)[form](fields, end)
    fields.finish()
    check(len(set(probes)) == len(probes), "two probes of one name")
    check(len({(s.kind, s.probe, s.face) for s in streams}) == len(streams), "two streams of one face")
    at = 0
    for number, stream in enumerate(streams):
        for unit in range(stream.units):
            frame, chunks = stream.first, []
            while frame < stream.first + stream.count:
                check(at < len(rows), "the chunk table ends early")
                key, place = rows[at]
                check(key[:3] == (number, unit, frame) and key[3] >= 1, "the chunk table has a gap")
                chunks.append((frame - stream.first, key[3], place))
                frame, at = frame + key[3], at + 1
            check(frame == stream.first + stream.count, "a chunk goes beyond its stream")
            stream.chunks.append(chunks)
    check(at == len(rows), "the chunk table has rows too many")
    return streams


def read_tables(fields, end):
    probe_count, stream_count, chunk_count = fields.take("3I")
    read_dataset(fields)
    fields.fits(probe_count, 98)
    probes = [read_probe(fields) for _ in range(probe_count)]
    fields.fits(stream_count, 36)
    streams = [Stream(fields, probe_count) for _ in range(stream_count)]
    fields.fits(chunk_count, 40)
    return probes, streams, [read_row(fields, end) for _ in range(chunk_count)]


def read_row(fields, end):
    key = fields.take("4I")
    offset, stored, raw, crc, storage = fields.take("QIIIB")
    fields.zeros(3)
    check(storage <= 1, "a chunk's storage is unknown")
    return key, check_place((offset, stored, raw, crc, storage), end)


def check_place(place, end):
    offset, stored, raw, _crc, storage = place
    check(16 <= offset and offset + stored <= end, "a chunk's place is illegal")
    check(raw <= MAX_CHUNK_BYTES, "a chunk is too large")
    check(raw <= stored * EXPANSION[storage] if storage else raw == stored, "a chunk's sizes are illegal")
    return place


# container.md 6.3 ----------------------------------------------------------------------------------------------------

def read_compact_tables(fields, end):
    probe_count, stream_count, chunk_count = (fields.varint() for _ in range(3))
    order = fields.take("B")
    check(order <= 1, "the order of the chunk table is unknown")
    read_dataset(fields)
    fields.fits(probe_count, 27)
    probes, frames = [], (0, 0)
    for _ in range(probe_count):
        name, frames = read_compact_probe(fields, frames)
        probes.append(name)
    fields.fits(stream_count, 2)
    streams = []
    for _ in range(stream_count):
        streams.append(CompactStream(fields, streams, probe_count))
    fields.fits(chunk_count, 1)
    return probes, streams, read_compact_rows(fields, streams, chunk_count, order, end)


def read_compact_probe(fields, frames):
    flags, name = fields.take("B"), fields.string()
    check(flags < 8, "a probe's flags are unknown")
    check(re.fullmatch(r"[A-Za-z0-9_-][A-Za-z0-9._-]*", name), "a probe's name is illegal")
    fields.take("3d")
    if flags & 1:
        fields.take("4d")
    if flags & 2:
        frames = fields.varint(), fields.varint()
        check(frames[0] <= frames[1] < MAX_FRAME, "a probe's frames are illegal")
    if flags & 4:
        fields.take("4d")
    return name, frames


class CompactStream(Stream):
    def __init__(self, fields, rows, probe_count):
        self.kind, self.codec, self.probe, self.face, self.header = 0, bytes(4), 0, -1, b""
        self.width = self.height = self.first = self.count = self.unit_width = self.unit_height = self.chunk_frames = 0
        if rows:
            self.__dict__.update(rows[-1].__dict__)
        self.face += 1
        flags = fields.take("B")
        if flags & 1:
            self.kind, self.codec = fields.take("B4s")
        if flags & 2:
            self.probe = fields.varint()
        if flags & 4:
            self.face = fields.take("B")
        if flags & 8:
            self.width, self.height = fields.varint(), fields.varint()
        if flags & 16:
            self.first, self.count = fields.varint(), fields.varint()
        if flags & 32:
            self.unit_width, self.unit_height = fields.varint(), fields.varint()
        if flags & 64:
            back = fields.varint()
            check(back <= len(rows), "a codec header before the first row")
            self.header = rows[-back].header if back else fields.bytes(fields.varint())
        if flags & 128:
            self.chunk_frames = fields.varint()
        self.check(probe_count)


def read_compact_rows(fields, streams, chunk_count, order, end):
    check(sum(stream.units for stream in streams) <= chunk_count, "more units than chunks")
    # Stream, unit and the first frame that is left of each unit.
    units = [[at, unit, stream.first] for at, stream in enumerate(streams) for unit in range(stream.units)]
    check(units or chunk_count == 0, "chunks of no stream")
    rows, offset, predicted = [], 16, 0
    for _ in range(chunk_count):
        head, step = fields.varint((1 << 35) - 1), 0
        if head & 4:
            step = fields.varint()
            check(1 <= step < len(units), "a step is illegal")
        number = (predicted + step) % len(units)
        at, unit, frame = units[number]
        stream = streams[at]
        left = stream.first + stream.count - frame
        frame_count = min(stream.chunk_frames, left) if stream.chunk_frames else fields.varint()
        check(1 <= frame_count <= left, "the frames of a chunk are illegal")
        units[number][2] += frame_count
        size, storage = head >> 3, head & 3
        if storage == 3:
            check(size < len(rows), "a chunk is that of a row before the first")
            place = rows[-1 - size][1]
        else:
            raw = fields.varint() if storage else size
            place = check_place((offset, size, raw, fields.take("I"), storage), end)
            offset += size
        rows.append(((at, unit, frame, frame_count), place))
        predicted = number if order == 1 and frame_count < left else (number + 1) % len(units)
    check(offset == end, "the chunks do not end where the index starts")
    return sorted(rows)


def fetch(data, place):
    offset, stored, raw, crc, storage = place
    payload = data[offset:offset + stored]
    check(zlib.crc32(payload) == crc, "a chunk's CRC-32 is other")
    if storage == 2:
        try:
            payload = zstandard.decompress(payload, raw)
        except zstandard.Damaged as error:
            raise Refused(f"a chunk's Zstandard frame: {error}") from None
    elif storage:
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


# depth.md 7 to 12, arithmetic.md 6, 7 --------------------------------------------------------------------------------

MARKER = b"\xff\xff\xff\xff"

# log2(1 + i/256) in 24 fraction bits.
LOG_TABLE = (
    0, 94364, 188362, 281996, 375270, 468185, 560745, 652952,
    744810, 836320, 927485, 1018309, 1108793, 1198939, 1288752, 1378232,
    1467383, 1556207, 1644705, 1732882, 1820738, 1908277, 1995500, 2082410,
    2169009, 2255299, 2341283, 2426963, 2512340, 2597417, 2682196, 2766679,
    2850868, 2934766, 3018374, 3101694, 3184728, 3267478, 3349946, 3432134,
    3514044, 3595678, 3677038, 3758124, 3838941, 3919488, 3999768, 4079782,
    4159533, 4239023, 4318251, 4397222, 4475935, 4554394, 4632599, 4710552,
    4788255, 4865709, 4942916, 5019878, 5096595, 5173071, 5249305, 5325300,
    5401057, 5476578, 5551864, 5626916, 5701737, 5776327, 5850688, 5924821,
    5998727, 6072409, 6145867, 6219103, 6292118, 6364913, 6437490, 6509850,
    6581994, 6653924, 6725641, 6797146, 6868440, 6939525, 7010402, 7081072,
    7151536, 7221795, 7291852, 7361706, 7431359, 7500812, 7570066, 7639123,
    7707984, 7776649, 7845119, 7913397, 7981483, 8049377, 8117082, 8184598,
    8251926, 8319067, 8386022, 8452793, 8519380, 8585785, 8652008, 8718050,
    8783912, 8849596, 8915102, 8980431, 9045584, 9110562, 9175366, 9239998,
    9304457, 9368745, 9432863, 9496811, 9560591, 9624203, 9687648, 9750928,
    9814042, 9876993, 9939780, 10002404, 10064867, 10127170, 10189312, 10251295,
    10313120, 10374787, 10436298, 10497652, 10558852, 10619897, 10680789, 10741528,
    10802114, 10862550, 10922835, 10982970, 11042956, 11102794, 11162484, 11222028,
    11281425, 11340677, 11399784, 11458748, 11517568, 11576245, 11634780, 11693175,
    11751428, 11809542, 11867517, 11925353, 11983051, 12040612, 12098037, 12155325,
    12212479, 12269497, 12326382, 12383133, 12439752, 12496238, 12552593, 12608817,
    12664911, 12720875, 12776710, 12832416, 12887994, 12943445, 12998770, 13053968,
    13109041, 13163988, 13218811, 13273511, 13328087, 13382540, 13436871, 13491080,
    13545168, 13599135, 13652983, 13706711, 13760320, 13813810, 13867183, 13920438,
    13973576, 14026597, 14079503, 14132294, 14184969, 14237530, 14289978, 14342312,
    14394532, 14446641, 14498638, 14550523, 14602297, 14653961, 14705514, 14756958,
    14808293, 14859519, 14910637, 14961648, 15012551, 15063347, 15114037, 15164621,
    15215099, 15265473, 15315742, 15365906, 15415967, 15465925, 15515779, 15565531,
    15615181, 15664730, 15714177, 15763523, 15812769, 15861915, 15910962, 15959909,
    16008758, 16057508, 16106160, 16154714, 16203172, 16251532, 16299796, 16347964,
    16396036, 16444013, 16491896, 16539683, 16587377, 16634976, 16682482, 16729896,
    16777216,
)


def read_node_header(stream):
    """Window, and domain with its base and scale."""
    check(stream.unit_width <= 1024 and stream.unit_height <= 1024, "the units are too large")
    fields = Fields(stream.header)
    read_depth_fields(fields)
    window, domain = 1, None
    if stream.codec != b"DB4W":
        window, _epsilon, interval, _bound, kind, base, scale = fields.take("HHIHHII")
        check(1 <= window <= (1 if stream.codec == b"DQTR" else 255) and interval >= 1, "a header is illegal")
        check(kind <= 2, "the domain is unknown")
        check(base < 24 << 24 and scale > 0 if kind else base == scale == 0, "base or scale is illegal")
        domain = kind, base, scale
    fields.finish()
    return window, domain


def wrap(number):
    return ((number + (1 << 31)) & 0xFFFFFFFF) - (1 << 31)


def log_of(v):
    e = v.bit_length() - 1
    f = (v - (1 << e)) << (23 - e)
    i, t = f >> 15, f & 32767
    return (e << 24) + LOG_TABLE[i] + (((LOG_TABLE[i + 1] - LOG_TABLE[i]) * t + 16384) >> 15)


def code_of(r, domain):
    kind, base, scale = domain
    if kind == 0:
        return min(max(wrap(r + 8192) >> 14, 0), 65535)
    v = wrap(r + 32) >> 6
    if v >= 1 << 24 if kind == 1 else v <= 0:
        return 65535
    log = log_of(min(max(v, 1), (1 << 24) - 1))
    return min((max(log - base if kind == 1 else base - log, 0) * scale + (1 << 31)) >> 32, 65534)


def surface(a, x, y):
    a0, a1, a2, a3, a4, a5 = a
    u = wrap(a0 + (wrap(a2 * y + a3 * x + 128) >> 8))
    v = wrap(a1 + (wrap(a4 * y + 128) >> 8))
    return wrap(a5 + u * x + v * y)


def side_b(line, side, x, y):
    x0, y0, x1, y1 = line
    return (x1 - x0) * ((2 * y + 1) * 256 - y0 * 2 * side) > (y1 - y0) * ((2 * x + 1) * 256 - x0 * 2 * side)


def block_codes(block):
    """The 64 codes of a BC4w block (depth.md 8)."""
    check(block[28:] != MARKER, "a block ends like another function")
    bits = int.from_bytes(block, "little")
    ends = [bits >> (192 + 13 * i) & 8191 for i in range(4)]
    x0, y0, x1, y1 = (bits >> (244 + 3 * i) & 7 for i in range(4))
    palettes = []
    for e0, e1 in (ends[:2], ends[2:]):
        d0, d1 = (e << 3 | e >> 10 for e in (e0, e1))
        if e0 > e1:
            palettes.append([d0, d1] + [((8 - i) * d0 + (i - 1) * d1 + 3) // 7 for i in range(2, 8)])
        else:
            palettes.append([d0, d1] + [((6 - i) * d0 + (i - 1) * d1 + 2) // 5 for i in range(2, 6)] + [0, 65535])
    return [
        palettes[(x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0][bits >> (3 * (8 * y + x)) & 7]
        for y in range(8) for x in range(8)
    ]


class Bits:
    """Bits of bytes that are read as they are needed, from the least significant on."""

    def __init__(self, fields):
        self.fields, self.held, self.left = fields, 0, 0

    def take(self):
        if self.left == 0:
            self.held, self.left = self.fields.take("B"), 8
        bit, self.held, self.left = self.held & 1, self.held >> 1, self.left - 1
        return bit

    def finish(self):
        check(self.held == 0, "spare bits are not zero")


def root_of(width, height):
    return next(level for level in range(9) if 4 << level >= max(width, height))


def children(level, column, row):
    return [(level - 1, 2 * column + right, 2 * row + down) for down in (0, 1) for right in (0, 1)]


def walk_nodes(fields, width, height):
    """The places of a packed record's nodes."""
    coverage, bits, nodes = fields.take("B"), Bits(fields), []
    check(coverage <= 1, "a coverage is unknown")

    def visit(place):
        level, column, row = place
        side = 4 << level
        if column * side >= width or row * side >= height or (coverage and not bits.take()):
            return
        if level == 0 or bits.take():
            nodes.append(place)
        else:
            for child in children(*place):
                visit(child)

    visit((root_of(width, height), 0, 0))
    bits.finish()
    return coverage, nodes


def walk_tree(fields, width, height, whole):
    """The places of an intermediate record's leaves, and of its functions."""
    bits, leaves, functions = Bits(fields), [], []

    def visit(place):
        level, column, row = place
        side = 4 << level
        if column * side >= width or row * side >= height:
            return
        if not bits.take():
            check(not whole, "the first record lacks leaves")
        elif level == 0:
            leaves.append(place)
        else:
            if bits.take():
                functions.append(place)
            for child in children(*place):
                visit(child)

    visit((root_of(width, height), 0, 0))
    bits.finish()
    return leaves, functions


def read_number(fields, shift):
    value = 0
    for group in range(5):
        byte = fields.take("B")
        check(group < 4 or byte < 16, "a number is too long")
        value |= (byte & 127) << 7 * group
        if byte < 128:
            break
    number = (-(value + 1) // 2 if value & 1 else value // 2) << shift
    check(-(1 << 31) <= number < 1 << 31, "a number does not fit 32 bits")
    return number


def read_numbers(fields, count, level, p):
    """a0 to a5, of which `count` are stored."""
    shift = [max(0, p + 6 - (level + 2)), max(0, p + 15 - 2 * (level + 2)), p + 5] if p else [0, 0, 0]
    numbers = [0] * 6
    for at in (5, 0, 1, 2, 3, 4)[:count]:
        numbers[at] = read_number(fields, shift[2 if at == 5 else at > 1])
    return numbers


def read_functions(fields, places):
    """A function (x, y, domain) -> code for each place above level 0."""
    kinds = []
    for level, _, _ in places:
        head = fields.take("B")
        kind, p, counts = head & 3, head >> 2 & 15, head >> 6
        check(kind < 3 and (kind or counts < 3) and (kind < 2 or (head == 2 and level == 1)), "a head is illegal")
        sides = [(1, 3, 6)[counts]] if kind == 0 else [3 if counts & bit else 1 for bit in (1, 2)] if kind == 1 else []
        kinds.append((kind, p, sides))
    numbers = [[read_numbers(fields, side, place[0], p) for side in sides] for place, (_, p, sides) in zip(places, kinds)]
    lines = [fields.bytes(4) if kind == 1 else None for kind, _, _ in kinds]
    check(MARKER not in lines, "a platelet's line is that of a biquadratic")
    blocks = [block_codes(fields.bytes(32)) if kind == 2 else None for kind, _, _ in kinds]

    def function(place, kind, a, line, block):
        if kind == 2:
            return lambda x, y, _domain: block[8 * y + x]
        if kind == 1:
            return lambda x, y, domain: code_of(surface(a[side_b(line, 4 << place[0], x, y)], x, y), domain)
        return lambda x, y, domain: code_of(surface(a[0], x, y), domain)

    return [function(*of) for of in zip(places, (kind for kind, _, _ in kinds), numbers, lines, blocks)]


def read_raw(fields):
    head = fields.take("B")
    b, background = head & 31, head >> 5 & 1
    check(head < 64 and b <= 16 and (not background or 1 <= b <= 15), "the head of raw codes is illegal")
    if b == 16:
        return fields.take("16H")
    least, bits = fields.take("H"), int.from_bytes(fields.bytes(2 * b), "little")
    values = [bits >> b * i & ((1 << b) - 1) for i in range(16)]
    codes = [65535 if background and value == (1 << b) - 1 else least + value for value in values]
    check(max(codes) <= 65535, "a raw code is above 65535")
    return codes


def raw_function(codes):
    return lambda x, y, _domain: codes[4 * y + x]


def parse_nodes(payload, width, height, frame_count, tree):
    """{frame: [(place, function)]}."""
    fields = Fields(payload)
    records = {}
    for frame, offset in read_record_table(fields, frame_count):
        check(offset == fields.at, "a record is elsewhere")
        if tree:
            leaves, functions = walk_tree(fields, width, height, frame == 0)
            records[frame] = [(place, raw_function(read_raw(fields))) for place in leaves]
            read_functions(fields, functions)
            fields.bytes(2 * len(functions))
        else:
            coverage, places = walk_nodes(fields, width, height)
            check(frame or not coverage, "the first record may not cover its unit")
            coarse = [place for place in places if place[0]]
            nodes = dict(zip(coarse, read_functions(fields, coarse)))
            nodes.update((place, raw_function(read_raw(fields))) for place in places if not place[0])
            records[frame] = list(nodes.items())
    fields.finish()
    return records


def paint(picture, unit_width, unit_height, nodes, domain):
    for (level, column, row), function in nodes:
        side = 4 << level
        left, top = column * side, row * side
        for y in range(min(side, unit_height - top)):
            for x in range(min(side, unit_width - left)):
                picture[(top + y) * unit_width + left + x] = function(x, y, domain)


def decode_nodes(data, chunks, width, height, window, domain, tree):
    """The pictures of a unit, each reached along its own path of fewest steps."""
    for _first, count, place in chunks:
        records = parse_nodes(fetch(data, place), width, height, count, tree)
        for target in range(count):
            picture = [0] * (width * height)
            for frame in [*range(0, target, window), target]:
                paint(picture, width, height, records.get(frame, ()), domain)
            yield struct.pack(f"<{len(picture)}H", *picture)


def decode_blocks(data, chunks, width, height):
    columns, rows = -(-width // 8), -(-height // 8)
    for _first, count, place in chunks:
        payload = fetch(data, place)
        check(len(payload) == 32 * columns * rows * count, "a payload of blocks has another size")
        blocks = [block_codes(payload[at:at + 32]) for at in range(0, len(payload), 32)]
        for frame in range(count):
            start = frame * columns * rows
            codes = (
                blocks[start + y // 8 * columns + x // 8][y % 8 * 8 + x % 8] for y in range(height) for x in range(width)
            )
            yield struct.pack(f"<{width * height}H", *codes)


# color.md 2 to 4, arithmetic.md 3, 4, blocks.md ----------------------------------------------------------------------

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


# Whole images --------------------------------------------------------------------------------------------------------

NODE_CODECS = (b"DQPN", b"DQTR", b"DB4W")
PIXEL_BYTES = {
    **{(1, codec): 2 for codec in (b"DAAB", b"DAB5", *NODE_CODECS)},
    **{(2, codec): 3 for codec in (b"MAAB", b"MAB1")},
    **{(0, codec): 3 for codec in (b"CCL8", b"CCB1", b"CCB7", b"CTR8")},
    **{(0, codec): 6 for codec in (b"CCLH", b"CCB6", b"CTRH")},
}


def decode_stream(data, stream):
    pixel = PIXEL_BYTES.get((stream.kind, stream.codec))
    check(pixel, "the codec is unknown")
    if stream.kind == 0:
        sets = read_color_header(stream)
    elif stream.codec in NODE_CODECS:
        window, domain = read_node_header(stream)
    else:
        window = read_temporal_header(stream)
    images = [bytearray(stream.width * stream.height * pixel) for _ in range(stream.count)]
    for unit, chunks in enumerate(stream.chunks):
        left, top, width, height = stream.rect(unit)
        if stream.codec in TRANSFORMS:
            pictures = decode_transform(data, chunks, width, height, TRANSFORMS[stream.codec], sets)
        elif stream.kind == 0:
            pictures = decode_cell(data, chunks, width, height, pixel // 3, stream.codec)
        elif stream.codec == b"DB4W":
            pictures = decode_blocks(data, chunks, width, height)
        elif stream.codec in NODE_CODECS:
            pictures = decode_nodes(data, chunks, width, height, window, domain, stream.codec == b"DQTR")
        else:
            pictures = decode_temporal(data, chunks, width, height, pixel, window, stream.codec)
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
