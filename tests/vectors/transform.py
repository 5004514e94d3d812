"""Cells coded by a transform, for decode.py: written from formats/color.md 6 and entropy.md and from nothing else."""

import math
import os

from fields import Fields, check

# color.md 6.1 to 6.3 -------------------------------------------------------------------------------------------------

COSINES = list(map(int, """
    362 362 362 362 361 361 360 360  359 358 357 356 355 354 353 351  350 348 346 345 343 341 339 337
    334 332 330 327 325 322 319 316  314 311 307 304 301 298 294 291  287 284 280 276 272 268 264 260
    256 252 247 243 239 234 230 225  220 216 211 206 201 196 191 186  181 176 171 165 160 155 149 144
    139 133 128 122 116 111 105 99  94 88 82 76 71 65 59 53  47 41 35 30 24 18 12 6  0""".split()))
OCTAVE = (4096, 4277, 4467, 4664, 4871, 5087, 5312, 5547, 5793, 6049, 6317, 6597, 6889, 7194, 7512, 7845)
MAX_FRAMES = 96
LENGTHS = (1, 2, 3, 4, 6, 8, 12, 16, 24)
ROOTS = (4096, 2896, 2365, 2048, 1672, 1448, 1182, 1024, 836)
# By offset_set, for Y and for G and O.
OFFSETS = (
    ((0,) * 64,) * 2,
    (tuple(map(int, """
        1 3 5 7 8 9 10 10 11 12 12 13 13 14 14 15  15 15 16 16 16 17 17 17 18 18 18 18 19 19 19 19
        19 20 20 20 20 20 21 21 21 21 21 21 22 22 22 22  22 22 22 23 23 23 23 23 23 23 23 24 24 24 24 24""".split())),
     tuple(map(int, """
        2 5 8 10 12 14 15 16 18 19 20 20 21 22 23 23  24 25 25 26 26 27 27 28 28 29 29 29 30 30 30 31
        31 31 32 32 32 33 33 33 34 34 34 34 35 35 35 35  36 36 36 36 36 37 37 37 37 37 38 38 38 38 38 38""".split()))),
)


def basis(points, k, n):
    if k == 0:
        return 256
    t = (2 * n + 1) * k * (96 // points) % 384
    a = t if t <= 192 else 384 - t
    return COSINES[a] if a <= 96 else -COSINES[192 - a]


BASES = {points: [[basis(points, k, n) for n in range(points)] for k in range(points)] for points in (*LENGTHS, 32)}


def wrap(value):
    """A number as 32 bits with a sign hold it."""
    return (value + (1 << 31) & 0xFFFFFFFF) - (1 << 31)


class Domain:
    def __init__(self, size):
        self.key_bits, self.middle, self.fraction = (8, 128, 6) if size == 1 else (16, 48128, 0)
        self.shown = (0, 255) if size == 1 else (0x0400, 0xFBFF)
        # Bits of the fraction of the channels of pixels where offset_set is 1.
        self.fine = 4 if size == 1 else 0


def predict(slope, luma):
    return wrap(slope * luma + 8) >> 4


def keys_of(channels, slopes, domain, fraction):
    luma, green, orange = channels
    green = wrap(green + predict(slopes[0], luma))
    orange = wrap(orange + predict(slopes[1], luma))
    m = wrap(luma + (domain.middle << fraction) - (green >> 1))
    b = wrap(m - (orange >> 1))
    least, most = domain.shown
    half = 1 << fraction >> 1
    return [max(least, min(most, wrap(key + half) >> fraction)) for key in (b + orange, green + m, b)]


def channels_of(keys, slopes, domain):
    r, g, b = keys
    orange = r - b
    m = b + (orange >> 1)
    green = g - m
    luma = m + (green >> 1) - domain.middle
    return [wrap(value) for value in (luma, green - predict(slopes[0], luma), orange - predict(slopes[1], luma))]


def step_of(index, length, domain):
    mantissa = OCTAVE[index % 16] * ROOTS[length] + 2048 >> 12
    shift = 11 - domain.fraction
    return max((mantissa << index // 16) + (1 << shift - 1) >> shift, 1)


class Steps:
    """Steps of the levels of a region."""

    def __init__(self, luma_step, chroma_step, offset_set, delta, domain):
        self.bases = [base + 4 * delta for base in (luma_step, chroma_step + 3, chroma_step + 8)]
        self.offsets = (OFFSETS[offset_set][0], *[OFFSETS[offset_set][1]] * 2)
        self.domain, self.pixel_fraction = domain, domain.fine if offset_set else 0

    def of(self, c, size, length):
        """By the sum of both frequencies."""
        indices = [self.bases[c] + self.offsets[c][(2 * f + 1 << 3 - size) >> 1] for f in range((8 << size) - 1)]
        return [step_of(max(0, min(255, index)), length, self.domain) for index in indices]


def coefficient(level, step):
    return wrap(level * step + 4) >> 3


# color.md 6.6, 6.7, 7 ------------------------------------------------------------------------------------------------

# Contexts, symbols and distributions of each family.
FAMILIES = {
    "NODE": (40, 4, 8), "PLANES": (324, 16, 12), "CODED": (96, 2, 8), "LAST": (384, 11, 12), "LAST_BITS": (22, 4, 3),
    "LEVELS": (1296, 16, 32), "PALETTE_SIZE": (4, 16, 4), "PALETTE_COLOR": (1, 16, 1), "ROW": (2, 2, 2),
    "PIXEL": (16, 3, 16), "LATER_FRAME": (2, 2, 2), "LATER_ROW": (2, 2, 2), "LATER_PIXEL": (16, 4, 16),
}
ALPHABETS = [symbols for _, symbols, count in FAMILIES.values() for _ in range(count)]
BUILT_IN = 10


def slots_of(frequencies):
    """The owner of each slot, with its frequency and its place in it."""
    check(sum(frequencies) == 4096, "frequencies have another sum")
    return [(symbol, count, place) for symbol, count in enumerate(frequencies) for place in range(count)]


def read_tables():
    """The first context of each family, the distribution of each context, and the built-in sets."""
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../formats/color-tables.txt")
    with open(path, encoding="utf-8") as file:
        numbers = iter([int(word) for line in file for word in line.split("#")[0].split()])
    first, of_context, distributions = {}, [], 0
    for name, (contexts, _, count) in FAMILIES.items():
        first[name] = len(of_context)
        of_context += [distributions + next(numbers) for _ in range(contexts)]
        assert all(distributions <= at < distributions + count for at in of_context[first[name]:])
        distributions += count
    sets = [[slots_of([next(numbers) for _ in range(symbols)]) for symbols in ALPHABETS] for _ in range(BUILT_IN)]
    assert next(numbers, None) is None
    return first, of_context, sets


FIRST, DISTRIBUTION, SETS = read_tables()


def read_distribution(fields, symbols):
    frequencies, left = [], 4096
    for _ in range(symbols - 1):
        frequencies.append(fields.varint())
        left -= frequencies[-1]
        check(left >= 0, "the frequencies of a distribution sum to more than 4096")
    return slots_of([*frequencies, left])


def read_sets(fields):
    """The built-in sets, and those of a codec header."""
    count = fields.take("B")
    check(count <= 8, "there are too many table sets")
    return SETS + [[read_distribution(fields, symbols) for symbols in ALPHABETS] for _ in range(count)]


class Substream:
    def __init__(self, data, tables):
        self.tables, self.bytes = tables, len(data)
        if len(data) < 4:
            self.x, self.words = (1 << 16) + int.from_bytes(data, "little"), Fields(b"")
        else:
            self.words = Fields(data)
            self.x = self.words.take("I")
            check(self.x >= 1 << 16, "a substream starts with an illegal state")

    def renormalise(self):
        if self.x < 1 << 16:
            self.x = self.x << 16 | self.words.take("H")

    def symbol(self, family, context=0):
        return self.owner(self.tables[DISTRIBUTION[FIRST[family] + context]])

    def owner(self, slots):
        symbol, frequency, place = slots[self.x % 4096]
        self.x = frequency * (self.x >> 12) + place
        self.renormalise()
        return symbol

    def bits(self, count):
        if count > 12:
            return self.bits(count - 12) << 12 | self.bits(12)
        value = self.x & (1 << count) - 1
        self.x >>= count
        self.renormalise()
        return value

    def number(self, family, context):
        symbol = self.symbol(family, context)
        if symbol < 12:
            return symbol
        if symbol < 15:
            return (1 << symbol - 11) + 10 + self.bits(symbol - 11)
        e = min(self.bits(5), 22)
        return (1 << e) + 25 + self.bits(e)

    def finish(self):
        self.words.finish()
        check(self.x == 1 << 16, "a substream does not end with its last symbol")


# color.md 6.4 to 6.6 -------------------------------------------------------------------------------------------------

def scan(side):
    positions = [(x, y) for y in range(side) for x in range(side)]
    return sorted(positions, key=lambda at: (at[0] + at[1], at[1] if (at[0] + at[1]) % 2 else at[0]))


SCANS = [scan(4 << size) for size in range(4)]
POSITION_CLASSES = (0, 1, 2, 2, 3, 3, 3, 4, 4, 4, 4, 4)
SUM_CLASSES = (0, 1, 2, 3, 4, 5, 5, 6, 6, 6, 6)


def read_last(stream, chroma, size, kind, class_before):
    e = stream.symbol("LAST", 12 * (16 * chroma + 4 * size + kind) + class_before)
    if e == 0:
        return 0
    a = min(e, 2)
    h = stream.symbol("LAST_BITS", 11 * chroma + e) % (1 << a)
    return min((1 << e) + (h << e - a) + stream.bits(e - a) - 1, (4 << size) ** 2 - 1)


def read_levels(stream, size, frames):
    """{(plane, x, y): level} of each channel."""
    channels, before, first_planes, first_class = [], 0, {}, 0
    for c in range(3):
        chroma, levels = min(c, 1), {}
        planes = min(stream.number("PLANES", 27 * (4 * c + size) + 3 * LENGTHS.index(frames) + before), frames)
        before = min(planes, 2) if planes else before
        flag, others, class_before = 0, dict(first_planes), first_class
        for k in range(planes):
            kind = 3 if frames == 1 else min(k, 2)
            flag = 1 if k == planes - 1 else stream.symbol("CODED", 32 * c + 8 * kind + 2 * size + flag)
            known = {}
            if flag:
                last = read_last(stream, chroma, size, kind, class_before)
                for at in range(last, -1, -1):
                    x, y = SCANS[size][at]
                    p = POSITION_CLASSES[x + y] if x + y < 12 else 5
                    o = min(others.get((x, y), 0), 2)
                    r = 24 * chroma + 6 * kind + p
                    if at == last:
                        magnitude = 1 + stream.number("LEVELS", 3 * r + o)
                    else:
                        around = ((x + 1, y), (x + 2, y), (x, y + 1), (x + 1, y + 1), (x, y + 2))
                        s = sum(known.get(position, 0) for position in around)
                        q = SUM_CLASSES[s] if s < 11 else 7
                        magnitude = stream.number("LEVELS", 144 + 24 * r + 3 * q + o)
                    if magnitude:
                        levels[k, x, y] = -magnitude if stream.bits(1) else magnitude
                        known[x, y] = min(magnitude, 15)
            class_before = (last + 1).bit_length() if flag else 0
            if k == 0:
                first_class = max(first_class, class_before)
                for at, magnitude in known.items():
                    first_planes[at] = max(first_planes.get(at, 0), magnitude)
            others = known
        channels.append(levels)
    return channels


class Region:
    def __init__(self, stream, steps, slopes, colors, domain, width, height, frames):
        self.stream, self.steps, self.slopes, self.domain = stream, steps, slopes, domain
        self.means = [[[0] * 8 for _ in range(8)] for _ in range(3)]
        self.cache = list(colors)
        self.pictures = [[[None] * width for _ in range(height)] for _ in range(frames)]
        # Leaves, and colours of palettes.
        self.items, self.max_items = 0, 64 + 8 * stream.bytes
        size = next(size for size in range(4) if 4 << size >= max(width, height))
        self.node(0, 0, 0, size, frames)
        stream.finish()

    def node(self, left, top, first, size, frames):
        kind = self.stream.symbol("NODE", 10 * size + (LENGTHS.index(frames) if frames in LENGTHS else 9))
        half = 2 << size
        if kind == 0:
            check(frames in LENGTHS, "a block has no legal length")
            self.transform(left, top, first, size, frames)
        elif kind == 1:
            check(size > 0, "a block of 4x4 pixels is split")
            for y in (top, top + half):
                for x in (left, left + half):
                    self.node(x, y, first, size - 1, frames)
        elif kind == 2:
            check(frames > 1, "a block of one frame is split")
            for part in (1, 1, 1) if frames == 3 else (-(-frames // 2), frames // 2):
                self.node(left, top, first, size, part)
                first += part
        else:
            self.palette(left, top, first, size, frames)

    def count(self, items):
        self.items += items
        check(self.items <= self.max_items, "a region has more leaves and colours than its substream allows")

    def predicted(self, c, left, top, first, size, step):
        q, means, x, y = 1 << size, self.means[c], left // 4, top // 4
        if first > 0:
            m = wrap(sum(means[y + j][x + i] for j in range(q) for i in range(q))) >> 2 * size
        else:
            before = sum(means[y + j][x - 1] for j in range(q)) if x else 0
            above = sum(means[y - 1][x + i] for i in range(q)) if y else 0
            m = wrap(before + above) >> size + (x > 0 and y > 0)
        return wrap(wrap(m * 32 << size) + (step >> 1)) // step

    def transform(self, left, top, first, size, frames):
        self.count(1)
        side, length, columns = 4 << size, LENGTHS.index(frames), []
        picture = self.pictures[0]
        visible = [max(0, min(side, whole - corner)) for whole, corner in ((len(picture[0]), left), (len(picture), top))]
        time, space = BASES[frames], BASES[4 << size]
        for c, levels in enumerate(read_levels(self.stream, size, frames)):
            steps = self.steps.of(c, size, length)
            predicted = self.predicted(c, left, top, first, size, steps[0])
            levels[0, 0, 0] = wrap(levels.get((0, 0, 0), 0) + predicted)
            coefficients = {at: coefficient(level, steps[at[1] + at[2]]) for at, level in levels.items()}
            end = sum(value * time[k][frames - 1] for (k, x, y), value in coefficients.items() if x == y == 0)
            mean = (wrap(end + 128) >> 8) >> 2 + size
            for y in range(top // 4, top // 4 + (1 << size)):
                self.means[c][y][left // 4:left // 4 + (1 << size)] = [mean] * (1 << size)
            columns.append([self.inverse(coefficients, time, space, n, size, visible) for n in range(frames)])
        for n in range(frames):
            luma, green, orange = (column[n] for column in columns)
            self.show(left, top, first + n, side, lambda x, y: keys_of(
                (luma[y][x], green[y][x], orange[y][x]), self.slopes, self.domain, self.steps.pixel_fraction))

    def inverse(self, coefficients, time, space, n, size, visible):
        """The rows of a channel in one frame, as far as they lie in the cell."""
        (width, height), sums = visible, {}
        for (k, x, y), value in coefficients.items():
            sums[x, y] = sums.get((x, y), 0) + value * time[k][n]
        # Columns of vertical frequencies, those that have any.
        columns = {}
        for (x, y), total in sums.items():
            columns.setdefault(x, []).append((y, wrap(total + 128) >> 8))
        halves = {
            x: [wrap(sum(u * space[y][j] for y, u in column) + 128) >> 8 for j in range(height)]
            for x, column in columns.items()
        }
        shift = 10 + size + self.domain.fraction - self.steps.pixel_fraction
        return [
            [wrap(sum(half[j] * space[x][i] for x, half in halves.items()) + (1 << shift - 1)) >> shift for i in range(width)]
            for j in range(height)
        ]

    def show(self, left, top, frame, side, keys_at):
        picture = self.pictures[frame]
        for y in range(min(side, len(picture) - top)):
            for x in range(min(side, len(picture[0]) - left)):
                picture[top + y][left + x] = keys_at(x, y)

    # color.md 6.8

    def palette(self, left, top, first, size, frames):
        stream, side = self.stream, 4 << size
        colors = []
        for _ in range(1 + stream.symbol("PALETTE_SIZE", size)):
            p = stream.symbol("PALETTE_COLOR")
            if p == 15:
                colors.append(tuple(stream.bits(self.domain.key_bits) for _ in range(3)))
            else:
                colors.append(self.cache[p] if p < len(self.cache) else (0, 0, 0))
        self.count(1 + len(colors))
        for color in reversed(colors):
            if color in self.cache:
                self.cache.remove(color)
            self.cache = [color, *self.cache][:15]
        pictures = [[[0] * side for _ in range(side)] for _ in range(frames)]
        if len(colors) > 1:
            self.read_indices(pictures, side, int(math.log2(len(colors) - 1)) + 1)
        check(all(index < len(colors) for picture in pictures for row in picture for index in row),
              "an index is beyond its palette")
        for n, picture in enumerate(pictures):
            self.show(left, top, first + n, side, lambda x, y: colors[picture[y][x]])
        for y in range(0, side, 4):
            for x in range(0, side, 4):
                square = [colors[pictures[-1][y + j][x + i]] for j in range(4) for i in range(4)]
                keys = [sum(keys) + 8 >> 4 for keys in zip(*square)]
                for c, value in enumerate(channels_of(keys, self.slopes, self.domain)):
                    self.means[c][(top + y) // 4][(left + x) // 4] = wrap(value << self.domain.fraction)

    def read_indices(self, pictures, side, index_bits):
        stream, flag = self.stream, 0
        for y, row in enumerate(pictures[0]):
            flag = stream.symbol("ROW", flag) if y else 0
            if flag:
                row[:] = pictures[0][y - 1]
                continue
            for x in range(side):
                self.first_pixel(pictures[0], x, y, side, index_bits)
        frame_flag = 0
        for before, picture in zip(pictures, pictures[1:]):
            frame_flag = stream.symbol("LATER_FRAME", frame_flag)
            if frame_flag:
                picture[:] = [list(row) for row in before]
                continue
            flag = 0
            for y in range(side):
                flag = stream.symbol("LATER_ROW", flag)
                if flag:
                    picture[y][:] = before[y]
                    continue
                for x in range(side):
                    self.later_pixel(picture, before, x, y, index_bits)

    def first_pixel(self, picture, x, y, side, index_bits):
        above = picture[y - 1][x] if y else None
        left = picture[y][x - 1] if x else above if y else 0
        above = left if above is None else above
        above_left = picture[y - 1][x - 1] if x and y else above
        above_right = picture[y - 1][x + 1] if y and x + 1 < side else above
        c = (left == above) + 2 * (above_left == left) + 4 * (above_left == above) + 8 * (above_right == above)
        picture[y][x] = self.index(self.stream.symbol("PIXEL", c), (left, above), index_bits)

    def later_pixel(self, picture, before, x, y, index_bits):
        held = before[y][x]
        above = picture[y - 1][x] if y else None
        left = picture[y][x - 1] if x else above if y else held
        above = left if above is None else above
        left_changed = x > 0 and picture[y][x - 1] != before[y][x - 1]
        above_changed = y > 0 and picture[y - 1][x] != before[y - 1][x]
        c = left_changed + 2 * above_changed + 4 * (left == held) + 8 * (above == held)
        picture[y][x] = self.index(self.stream.symbol("LATER_PIXEL", c), (held, left, above), index_bits)

    def index(self, symbol, candidates, index_bits):
        distinct = list(dict.fromkeys(candidates))
        return distinct[symbol] if symbol < len(distinct) else self.stream.bits(index_bits)


def decode(payload, width, height, frames, size, sets):
    """The keys of each frame, row by row; `size` is that of a sample."""
    domain, fields = Domain(size), Fields(payload)
    table_set, luma_step, chroma_step, *slopes, choices = fields.take("BBBbbB")
    check(table_set < len(sets), "the table set is unknown")
    offset_set, color_count = choices >> 4 & 7, choices & 15
    check(offset_set < len(OFFSETS), "the set of offsets is unknown")
    colors = [fields.take("3B" if size == 1 else "3H") for _ in range(color_count)]
    regions = [
        (x, y, min(32, width - x), min(32, height - y)) for y in range(0, height, 32) for x in range(0, width, 32)
    ]
    deltas = [0] * len(regions)
    if choices & 128:
        packed = fields.bytes((len(regions) + 1) // 2)
        deltas = [(packed[at // 2] >> 4 * (at % 2) & 15) - 8 for at in range(len(regions))]
    lengths = [fields.varint() for _ in regions[1:]]
    substreams = [fields.bytes(length) for length in lengths]
    substreams.append(fields.bytes(len(fields.data) - fields.at))
    pictures = [[0] * (3 * width * height) for _ in range(frames)]
    for (left, top, w, h), delta, data in zip(regions, deltas, substreams):
        stream = Substream(data, sets[table_set])
        steps = Steps(luma_step, chroma_step, offset_set, delta, domain)
        region = Region(stream, steps, slopes, colors, domain, w, h, frames)
        for picture, rows in zip(pictures, region.pictures):
            for y, row in enumerate(rows):
                start = 3 * ((top + y) * width + left)
                picture[start:start + 3 * w] = [key for keys in row for key in keys]
    return pictures
