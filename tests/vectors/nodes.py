"""Nodes of a quadtree and plain blocks, for decode.py: written from formats/depth.md 7 to 12, formats/arithmetic.md 6 and 7,
and from nothing else."""

import struct

from boxes import read_depth_fields, read_record_table
from container import fetch
from fields import Fields, check

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
