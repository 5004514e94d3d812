"""Depth and alpha by predictive coding, for decode.py: written from formats/depth.md 15 and 16 and from nothing else."""

import os

from boxes import read_depth_fields
from container import fetch
from fields import Fields, check
from nodes import log_of, wrap
from transform import Substream, read_distribution, slots_of

# Contexts, symbols and distributions of each family (depth.md 15.7).
FAMILIES = {
    "FRAME": (2, 2, 2), "MODE": (363, 10, 40), "SMALL_MODE": (32, 7, 16), "CHANGE": (12, 15, 12), "PIXEL": (810, 12, 96),
    "ESCAPE": (36, 16, 20), "CANDIDATE": (3, 16, 3),
}
ESCAPE_BITS = (0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 7, 9, 16)
ESCAPE_MIN = (3, 4, 5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 321, 833)
CANDIDATE_BITS = (0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 5, 6, 7, 8, 9, 16)
CANDIDATE_MIN = (0, 1, 2, 3, 5, 7, 11, 15, 23, 31, 47, 79, 143, 271, 527, 1039)
CHANGE_BITS = (0, 0, 1, 1, 2, 6, 14)
CHANGE_MIN = (1, 2, 3, 5, 7, 11, 75)
WEIGHTS = ((128, 85, 64), (171, 128, 102), (192, 154, 128))
GAINS = (256, 128, 85)
RIGHT_GROUPS = (1, 1, 0, 1, 1, 2, 2, 3, 4)
MIDDLE = 32768 * 256
# Value, slopes, class, confidence, magnitude.
BACKGROUND = (0, 0, 0, 8, 0, 0)
V, GX, GY, K, N, M = range(6)


def read_tables():
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../formats/depth-tables.txt")
    with open(path, encoding="utf-8") as file:
        numbers = iter([int(word) for line in file for word in line.split("#")[0].split()])
    first, of_context, distributions, alphabets = {}, [], 0, []
    for name, (contexts, symbols, count) in FAMILIES.items():
        first[name] = len(of_context)
        of_context += [distributions + next(numbers) for _ in range(contexts)]
        distributions += count
        alphabets += [symbols] * count
    sets = [[slots_of([next(numbers) for _ in range(symbols)]) for symbols in alphabets] for _ in range(9)]
    assert next(numbers, None) is None
    return first, of_context, alphabets, sets


FIRST, DISTRIBUTION, ALPHABETS, SETS = read_tables()


def read_predictive_header(stream):
    """Bound, projection, octave, table sets and levels."""
    check(stream.unit_width <= 1024 and stream.unit_height <= 1024, "the units are too large")
    fields = Fields(stream.header)
    read_depth_fields(fields)
    bound, epsilon, interval, projection, has_levels, own_sets, octave = fields.take("HHIHBBI")
    check(own_sets <= 8, "there are too many table sets")
    check(bound <= 65534 and interval >= 1 and projection <= 2, "a header is illegal")
    check(512 <= octave <= 131071 if projection else octave == 0, "the octave is illegal")
    check(projection < 2 or stream.width == stream.height, "a cube face is not square")
    own = [[read_distribution(fields, symbols) for symbols in ALPHABETS] for _ in range(own_sets)]
    levels = []
    if has_levels:
        check(has_levels == 1 and bound == 0 and epsilon == 0 and projection == 0, "levels are illegal here")
        count = fields.take("H")
        check(1 <= count <= 4096, "a number of levels is illegal")
        levels = [fields.take("H") for _ in range(count)]
        check(all(one < next for one, next in zip(levels, levels[1:] + [65535])), "levels do not ascend")
    fields.finish()
    return bound, projection, octave, SETS + own, levels


def read_alpha_header(stream):
    """The same of a stream of alpha, without what it cannot have."""
    check(stream.unit_width <= 1024 and stream.unit_height <= 1024, "the units are too large")
    fields = Fields(stream.header)
    check(fields.take("I") >= 1, "a keyframe interval is illegal")
    fields.finish()
    return 0, 0, 0, SETS, []


class Symbols(Substream):
    """entropy.md 3 with the contexts of depth.md 15.7."""

    def symbol(self, family, context=0):
        return self.owner(self.tables[DISTRIBUTION[FIRST[family] + context]])


def quotient(a, b):
    """Rounded toward zero."""
    return abs(a) // b * (1 if a >= 0 else -1)


def within(d, t):
    return (d + t) & 0xFFFFFFFF <= 2 * t


def clamp(x, least, most):
    return max(least, min(most, x))


def steep(g):
    return clamp(g, -(1 << 20), 1 << 20)


class Unit:
    def __init__(self, rect, side, header):
        left, top, self.w, self.h = rect
        self.bound, projection, octave, _sets, self.levels = header
        self.step, self.same, self.apart = (2 * self.bound + 1) * 256, (3 * self.bound + 2) * 256, (2 * self.bound + 1) * 640
        self.K = octave * 2955 >> 11
        self.R = (1 << 22) // self.K if self.K else 0
        self.q = [0] * (self.w * self.h)
        if projection == 2:
            square = [(2 * x + 1 - side) ** 2 for x in range(side)]
            logs = [[(log_of(side * side + square[top + y] + square[left + x]) - log_of(side * side)) >> 10
                     for x in range(self.w)] for y in range(self.h)]
            self.q = [log * octave >> 7 for row in logs for log in row]
        self.pixels = {(x, y): BACKGROUND for x in range(-1, self.w + 1) for y in range(-1, self.h)}
        self.columns = (self.w + 7) // 8
        blocks = self.columns * ((self.h + 7) // 8)
        self.content, self.plane, self.mode = [2] * blocks, [None] * blocks, [10] * blocks
        self.later = 0

    def picture(self):
        codes = []
        for y in range(self.h):
            for x in range(self.w):
                pixel = self.pixels[x, y]
                code = clamp(wrap(pixel[V] + self.q[y * self.w + x] + 128) >> 8, 0, 65534)
                if self.levels:
                    code = self.levels[min(code, len(self.levels) - 1)]
                codes.append(65535 if pixel[K] == 8 else code)
        return b"".join(code.to_bytes(2, "little") for code in codes)

    def frame(self, stream):
        if stream.symbol("FRAME", self.later):
            for at in range(len(self.content)):
                self.block(stream, at)
        self.later = 1

    def block(self, stream, at):
        column, row = at % self.columns, at // self.columns
        x, y = 8 * column, 8 * row
        a = self.mode[at - 1] if column else 10
        b = self.mode[at - self.columns] if row else 10
        past = 0 if not self.later else 1 if self.content[at] in (0, 3) else 2
        mode = self.mode[at] = stream.symbol("MODE", (11 * a + b) * 3 + past)
        if mode == 1:
            return
        if mode == 0:
            self.read_pixels(stream, x, y, 8)
        elif mode == 2:
            for place in self.places(x, y, 8):
                self.pixels[place] = BACKGROUND
        elif mode == 3:
            for qx, qy in ((x, y), (x + 4, y), (x, y + 4), (x + 4, y + 4)):
                if qx < self.w and qy < self.h:
                    self.quarter(stream, qx, qy)
        else:
            sources = (lambda: self.from_left(at, x, y), lambda: self.from_above(at, x, y))
            plane = self.source(sources, (mode - 4) % 3)
            if mode >= 7:
                plane = self.change(stream, plane, 0)
            self.fill(plane, x, y, 8)
            self.plane[at] = plane
        self.content[at] = mode

    def quarter(self, stream, x, y):
        right, bottom = min(x + 4, self.w) - 1, min(y + 4, self.h) - 1
        e = self.edge(self.pixels[x - 1, y], self.pixels[x - 1, bottom])
        f = self.edge(self.pixels[x, y - 1], self.pixels[right, y - 1])
        mode = stream.symbol("SMALL_MODE", (4 * e + f) * 2 + self.later)
        if mode == 0:
            return self.read_pixels(stream, x, y, 4)
        sources = (
            lambda: self.from_pixel(x - 1, min(y + 2, self.h - 1), 5, -1) if x else (MIDDLE, 0, 0),
            lambda: self.from_pixel(min(x + 2, self.w - 1), y - 1, -1, 5) if y else (MIDDLE, 0, 0),
        )
        plane = self.source(sources, (mode - 1) % 3)
        if mode > 3:
            plane = self.change(stream, plane, 1)
        return self.fill(plane, x, y, 4)

    @staticmethod
    def edge(one, other):
        if 8 in (one[K], other[K]):
            return 2
        if one[K] == other[K] == 2:
            return 0 if one[N] == other[N] == 2 else 1
        return 3

    @staticmethod
    def source(sources, which):
        if which < 2:
            return sources[which]()
        return tuple(wrap(a + b) >> 1 for a, b in zip(sources[0](), sources[1]()))

    def from_left(self, at, x, y):
        if x == 0:
            return MIDDLE, 0, 0
        if self.content[at - 1] >= 4:
            return self.moved(self.plane[at - 1], 16, 0)
        return self.from_pixel(x - 1, min(y + 4, self.h - 1), 9, -1)

    def from_above(self, at, x, y):
        if y == 0:
            return MIDDLE, 0, 0
        if self.content[at - self.columns] >= 4:
            return self.moved(self.plane[at - self.columns], 0, 16)
        return self.from_pixel(min(x + 4, self.w - 1), y - 1, -1, 9)

    def from_pixel(self, x, y, dx, dy):
        pixel = self.pixels[x, y]
        if pixel[K] == 8:
            return MIDDLE, 0, 0
        return self.moved((pixel[V], steep(pixel[GX]), steep(pixel[GY])), dx, dy)

    def moved(self, plane, dx, dy):
        v, gx, gy = plane
        d = (gx * dx + gy * dy) >> 1
        if self.K == 0:
            return wrap(v + d), gx, gy
        if abs(d) > 128 * self.K:
            return plane
        r = quotient(16 * d, self.K)
        t = r * r >> 12
        v = wrap(v + d + ((d >> 6) * r >> 7) + quotient((d >> 6) * t, 192))
        return (v, *(steep(g + ((g >> 2) * (r + t) >> 10)) for g in (gx, gy)))

    def change(self, stream, plane, small):
        numbers, before = [], 0
        for number in range(3):
            symbol = stream.symbol("CHANGE", 6 * small + 2 * number + (before != 0))
            before = 0
            if symbol:
                kind = symbol - 1 >> 1
                before = CHANGE_MIN[kind] + stream.bits(CHANGE_BITS[kind])
                before = -before if symbol % 2 else before
            numbers.append(before)
        v, gx, gy = plane
        unit = max((64 if small else 32) * self.bound, 16)
        v = wrap(v + wrap(numbers[0] * max(128 * self.bound, 256)))
        return v, steep(wrap(gx + wrap(numbers[1] * unit))), steep(wrap(gy + wrap(numbers[2] * unit)))

    def places(self, x, y, side):
        return [(i, j) for j in range(y, min(y + side, self.h)) for i in range(x, min(x + side, self.w))]

    def fill(self, plane, x, y, side):
        v, gx, gy = plane
        for i, j in self.places(x, y, side):
            h = gx * (2 * (i - x) + 1 - side) + gy * (2 * (j - y) + 1 - side)
            u = clamp(h >> 7, -32767, 32767)
            self.pixels[i, j] = wrap(v + (h >> 1) + ((u * u >> 12) * self.R >> 7)), gx, gy, 2, 2, 0

    def read_pixels(self, stream, x, y, side):
        for place in self.places(x, y, side):
            self.pixels[place] = self.pixel(stream, *place)

    def pixel(self, stream, x, y):
        at = self.pixels
        left, above, before = at[x - 1, y], at[x, y - 1], at[x, y]
        corner, right = at[x - 1, y - 1], at[x + 1, y - 1]
        context = ((9 * left[K] + above[K]) * 5 + RIGHT_GROUPS[right[K]]) * 2 + self.later
        symbol = stream.symbol("PIXEL", context)
        if symbol == 5:
            return before if before[K] == 8 else (*before[:K], 7, before[N], before[M])
        if symbol == 6:
            return BACKGROUND
        q = self.q[y * self.w + x]

        def inside(value):
            return clamp(wrap(value), -q, 65534 * 256 - q)

        carried = {
            "W": (left, left[V] + left[GX]), "N": (above, above[V] + above[GY]),
            "NE": (right, right[V] - right[GX] + right[GY]), "NW": (corner, corner[V] + corner[GX] + corner[GY]),
        }
        c, slopes, n, origin = self.predict(carried, before, inside, q)
        if symbol in (7, 8, 9):
            return self.other_surface(stream, symbol - 7, carried, c, inside)
        if symbol >= 10:
            most, least = max(left[M], above[M]), min(left[M], above[M])
            i = min(11, most.bit_length() + (right[M] > most)) if most else 0
            o = 2 if 2 * least > most else 1 if 8 * least > most else 0
            kind = stream.symbol("ESCAPE", 3 * i + o)
            r = ESCAPE_MIN[kind] + stream.bits(ESCAPE_BITS[kind])
            r = r if symbol == 10 else -r
            value = wrap(c + r * self.step)
            if self.bound >= 50 or abs(r) >= 64:
                return value, 0, 0, 5, 0, min(abs(r), 255)
            return (value, *self.corrected(slopes, n, origin, r), 5, min(n + 1, 2), min(abs(r), 255))
        r = (0, 1, -1, 2, -2)[symbol]
        return (wrap(c + r * self.step), *self.corrected(slopes, n, origin, r), r + 2, min(n + 1, 2), abs(r))

    def corrected(self, slopes, n, origin, r):
        d = wrap(GAINS[n] * r * (2 * self.bound + 1))
        gx, gy = slopes
        if origin == "both":
            return wrap(gx + (d >> 1)), wrap(gy + (d >> 1))
        return (wrap(gx + d), gy) if origin == "W" else (gx, wrap(gy + d))

    def predict(self, carried, before, inside, q):
        (left, from_left), (above, from_above) = carried["W"], carried["N"]
        corner = carried["NW"][0]
        if left[K] != 8 and above[K] != 8:
            d = wrap(from_left - from_above)
            if within(d, self.same):
                w = WEIGHTS[left[N]][above[N]]
                slopes = [wrap(b + (wrap((wrap(a - b) >> 4) * w) >> 4)) for a, b in zip(left[GX:K], above[GX:K])]
                return inside(from_above + (wrap((d >> 4) * w) >> 4)), slopes, max(left[N], above[N]), "both"
            if (corner[K] != 8 and within(corner[V] + corner[GY] - left[V], self.same)
                    and not within(corner[V] + corner[GX] - above[V], self.same)):
                return inside(from_above), above[GX:K], above[N], "N"
            return inside(from_left), left[GX:K], left[N], "W"
        for name, origin in (("W", "W"), ("N", "N"), ("NE", "both"), ("NW", "both")):
            pixel, value = carried[name]
            if pixel[K] != 8:
                return inside(value), pixel[GX:K], pixel[N], origin
        if before[K] != 8:
            return inside(before[V]), before[GX:K], before[N], "both"
        return MIDDLE - q, (0, 0), 0, "both"

    def other_surface(self, stream, entry, carried, c, inside):
        found = []
        for name in ("W", "N", "NE", "NW"):
            pixel, value = carried[name]
            x = inside(value)
            if pixel[K] != 8 and not within(x - c, self.apart) and len(found) < 3:
                if not any(within(x - y, self.apart // 2) for y, _ in found):
                    found.append((x, pixel))
        kind = stream.symbol("CANDIDATE", entry)
        r = CANDIDATE_MIN[kind] + stream.bits(CANDIDATE_BITS[kind])
        r = -r if r and stream.bits(1) else r
        x, pixel = found[entry] if entry < len(found) else (c, carried["W"][0])
        return wrap(x + r * self.step), pixel[GX], pixel[GY], 6, pixel[N], min(abs(r), 255)


def decode_predictive(data, chunks, rect, side, header):
    for _first, count, place in chunks:
        payload = fetch(data, place)
        check(payload and payload[0] < len(header[3]), "a table set is unknown")
        check(count <= 4096, "a chunk has too many frames")
        stream, unit = Symbols(payload[1:], header[3][payload[0]]), Unit(rect, side, header)
        pictures = []
        for _ in range(count):
            unit.frame(stream)
            pictures.append(unit.picture())
        stream.finish()
        yield from pictures


def decode_alpha(data, chunks, rect, side, header):
    for picture in decode_predictive(data, chunks, rect, side, header):
        codes = [int.from_bytes(picture[at:at + 2], "little") for at in range(0, len(picture), 2)]
        yield bytes(min(code, 255) for code in codes)
