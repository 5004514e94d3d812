"""Head, foot, index and chunks, for decode.py: written from formats/container.md 3 to 7 and from nothing else."""

import lzma
import math
import re
import unicodedata
import zlib

import zstandard
from fields import Fields, Refused, check

PROBE_NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9._-]*")
MAX_SIZE = 16384
MAX_FRAME = 1 << 31
MAX_CHUNK_BYTES = 1 << 30
# Payload bytes for each stored byte, by storage.
EXPANSION = (1, 16384, 32768)
NODE_CODECS = (b"DQPN", b"DQTR", b"DB4W")
PIXEL_BYTES = {
    **{(1, codec): 2 for codec in (b"DAAB", b"DAB5", b"DPRD", *NODE_CODECS)},
    **{(2, codec): 3 for codec in (b"MAAB", b"MAB1")},
    (3, b"APRD"): 1,
    **{(0, codec): 3 for codec in (b"CCL8", b"CCB1", b"CCB7", b"CTR8")},
    **{(0, codec): 6 for codec in (b"CCLH", b"CCB6", b"CTRH")},
}


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


def read_probe(fields, frames):
    flags, name = fields.take("B"), fields.string()
    check(flags < 8, "a probe's flags are unknown")
    check(PROBE_NAME.fullmatch(name), "a probe's name is illegal")
    fields.take("3d")
    if flags & 1:
        fields.take("4d")
    if flags & 2:
        frames = fields.varint(), fields.varint()
        check(frames[0] <= frames[1] < MAX_FRAME, "a probe's frames are illegal")
    if flags & 4:
        fields.take("4d")
    return name, frames


class Stream:
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

    def check(self, probe_count):
        check(self.kind <= 3 and self.face <= 6 and self.probe < probe_count, "kind, face or probe is illegal")
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


def read_index(index, end):
    fields = Fields(index)
    probe_count, stream_count, chunk_count = (fields.varint() for _ in range(3))
    order = fields.take("B")
    check(order <= 1, "the order of the chunk table is unknown")
    read_dataset(fields)
    fields.fits(probe_count, 27)
    probes, frames = [], (0, 0)
    for _ in range(probe_count):
        name, frames = read_probe(fields, frames)
        probes.append(name)
    fields.fits(stream_count, 2)
    streams = []
    for _ in range(stream_count):
        streams.append(Stream(fields, streams, probe_count))
    fields.fits(chunk_count, 1)
    rows = read_rows(fields, streams, chunk_count, order, end)
    read_attributes(fields)
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


def read_attributes(fields):
    before = ""
    while fields.at < len(fields.data):
        name = fields.string()
        check(re.fullmatch("[a-z0-9_.]{1,64}", name), "an attribute's name is illegal")
        check(name > before, "attributes do not ascend by name")
        before = name
        value = Fields(fields.bytes(fields.varint()))
        VALUES.get(name, lambda value: value.bytes(len(value.data)))(value)
        value.finish()


# container.md 6.5 ----------------------------------------------------------------------------------------------------

def read_chromaticities(fields):
    numbers = fields.take("8f")
    check(all(map(math.isfinite, numbers)) and all(numbers[1::2]), "chromaticities are illegal")
    red, green, blue, white = ((x / y, 1, (1 - x - y) / y) for x, y in zip(numbers[::2], numbers[1::2]))
    check(determinant(red, green, blue), "primaries span no colors")
    parts = determinant(white, green, blue), determinant(red, white, blue), determinant(red, green, white)
    check(all(parts), "primaries and white span no colors")


def determinant(a, b, c):
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))


def read_probe_name(fields):
    name = fields.string()
    check(PROBE_NAME.fullmatch(name), "a probe's name is illegal")
    return name


def read_missing_frames(fields):
    def row():
        place = read_probe_name(fields), *fields.take("BBI")
        check(place[1] <= 3 and place[2] <= 6, "a missing frame of an unknown kind or face")
        held = fields.take("I")
        check(place[3] < MAX_FRAME and (held < MAX_FRAME or held == 0xFFFFFFFF), "a frame's number is illegal")
        return place
    read_ascending(fields, row)


def read_poses(fields):
    def row():
        place = read_probe_name(fields), fields.take("I")
        check(place[1] < MAX_FRAME, "a frame's number is illegal")
        fields.take("7d")
        return place
    read_ascending(fields, row)


def read_view(fields):
    numbers = fields.take("7d")
    check(all(map(math.isfinite, numbers)) and numbers[:3] != numbers[3:6], "eye and look_at are not two points")
    check(0 < numbers[6] < 180, "a field of view is illegal")


def read_ascending(fields, row):
    before = None
    while fields.at < len(fields.data):
        place = row()
        check(before is None or before < place, "rows do not ascend")
        before = place


VALUES = {
    "color.chromaticities": read_chromaticities,
    "color.clipped_pixels": lambda value: value.take("Q"),
    "frames.missing": read_missing_frames,
    "probes.poses": read_poses,
    "view": read_view,
}


def check_place(place, end):
    offset, stored, raw, _crc, storage = place
    check(16 <= offset and offset + stored <= end, "a chunk's place is illegal")
    check(raw <= MAX_CHUNK_BYTES, "a chunk is too large")
    check(raw <= stored * EXPANSION[storage] if storage else raw == stored, "a chunk's sizes are illegal")
    return place


def read_rows(fields, streams, chunk_count, order, end):
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
