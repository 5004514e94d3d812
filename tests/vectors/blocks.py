"""Blocks of texture formats, for decode.py: written from formats/blocks.md and from nothing else."""

import re

TWO = [int(word, 16) for word in """
    cccc 8888 eeee ecc8 c880 feec fec8 ec80 c800 ffec fe80 e800 ffe8 ff00 fff0 f000
    f710 008e 7100 08ce 008c 7310 3100 8cce 088c 3110 6666 366c 17e8 0ff0 718e 399c
    aaaa f0f0 5a5a 33cc 3c3c 55aa 9696 a55a 73ce 13c8 324c 3bdc 6996 c33c 9966 0660
    0272 04e4 4e40 2720 c936 936c 39c6 639c 9336 9cc6 817e e718 ccf0 0fcc 7744 ee22""".split()]
THREE = [int(word, 16) for word in """
    aa685050 6a5a5040 5a5a4200 5450a0a8 a5a50000 a0a05050 5555a0a0 5a5a5050
    aa550000 aa555500 aaaa5500 90909090 94949494 a4a4a4a4 a9a59450 2a0a4250
    a5945040 0a425054 a5a5a500 55a0a0a0 a8a85454 6a6a4040 a4a45000 1a1a0500
    0050a4a4 aaa59090 14696914 69691400 a08585a0 aa821414 50a4a450 6a5a0200
    a9a58000 5090a0a8 a8a09050 24242424 00aa5500 24924924 24499224 50a50a50
    500aa550 aaaa4444 66660000 a5a0a5a0 50a050a0 69286928 44aaaa44 66666600
    aa444444 54a854a8 95809580 96969600 a85454a8 80959580 aa141414 96960000
    aaaa1414 a05050a0 a0a5a5a0 96000000 40804080 a9a8a9a8 aaaaaa44 2a4a5254""".split()]
ANCHORS_OF_TWO = list(map(int, """
    15 15 15 15 15 15 15 15 15 15 15 15 15 15 15 15  15 2 8 2 2 8 8 15 2 8 2 2 8 8 2 2
    15 15 6 8 2 8 15 15 2 8 2 2 2 15 15 6  6 2 6 8 15 15 2 2 15 15 15 15 15 2 2 15""".split()))
ANCHORS_OF_THREE = [tuple(map(int, pair.split(","))) for pair in """
    3,15 3,8 15,8 15,3 8,15 3,15 15,3 15,8  8,15 8,15 6,15 6,15 6,15 5,15 3,15 3,8
    3,15 3,8 8,15 15,3 3,15 3,8 6,15 10,8  5,3 8,15 8,6 6,10 8,15 5,15 15,10 15,8
    8,15 15,3 3,15 5,10 6,10 10,8 8,9 15,10  15,6 3,15 15,8 5,15 15,3 15,6 15,6 15,8
    3,15 15,3 5,15 5,15 5,15 8,15 5,15 10,15  5,15 10,15 8,15 13,15 15,3 12,15 3,15 3,8""".split()]
WEIGHTS = {
    2: (0, 21, 43, 64),
    3: (0, 9, 18, 27, 37, 46, 55, 64),
    4: (0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64),
}


class Bits:
    def __init__(self, block):
        self.left = int.from_bytes(block, "little")

    def take(self, count):
        value, self.left = self.left & ((1 << count) - 1), self.left >> count
        return value


def partition_of(subsets, number):
    """Subset of each pixel, and the anchors."""
    if subsets == 1:
        return [0] * 16, (0,)
    if subsets == 2:
        return [TWO[number] >> t & 1 for t in range(16)], (0, ANCHORS_OF_TWO[number])
    return [THREE[number] >> 2 * t & 3 for t in range(16)], (0, *ANCHORS_OF_THREE[number])


def mix(a, b, weight):
    return (a * (64 - weight) + b * weight + 32) >> 6


def bc1(block):
    bits = Bits(block)
    ends = [bits.take(16), bits.take(16)]
    a, b = ([c >> 11 << 3 | c >> 13, (c >> 5 & 63) << 2 | c >> 9 & 3, (c & 31) << 3 | c >> 2 & 7] for c in ends)
    if ends[0] > ends[1]:
        more = [[(2 * x + y + 1) // 3 for x, y in zip(a, b)], [(x + 2 * y + 1) // 3 for x, y in zip(a, b)]]
    else:
        more = [[(x + y + 1) >> 1 for x, y in zip(a, b)], [0, 0, 0]]
    palette = [bytes(color) for color in (a, b, *more)]
    return [palette[bits.take(2)] for _ in range(16)]


def bc4(block):
    bits = Bits(block)
    e0, e1 = bits.take(8), bits.take(8)
    if e0 > e1:
        palette = [e0, e1] + [((8 - i) * e0 + (i - 1) * e1 + 3) // 7 for i in range(2, 8)]
    else:
        palette = [e0, e1] + [((6 - i) * e0 + (i - 1) * e1 + 2) // 5 for i in range(2, 6)] + [0, 255]
    return [palette[bits.take(3)] for _ in range(16)]


def bc5(block):
    return list(zip(bc4(block[:8]), bc4(block[8:])))


BC6H = {}
for row in """
    0 10 5,5,5 gy4 by4 bz4 rw0-9 gw0-9 bw0-9 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
    1 7 6,6,6 gy5 gz4-5 rw0-6 bz0-1 by4 gw0-6 by5 bz2 gy4 bw0-6 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4
    2 11 5,4,4 rw0-9 gw0-9 bw0-9 rx0-4 rw10 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
    6 11 4,5,4 rw0-9 gw0-9 bw0-9 rx0-3 rw10 gz4 gy0-3 gx0-4 gw10 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-3 bz0 bz2 rz0-3 gy4 bz3 d0-4
    10 11 4,4,5 rw0-9 gw0-9 bw0-9 rx0-3 rw10 by4 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-4 bw10 by0-3 ry0-3 bz1-2 rz0-3 bz4 bz3 d0-4
    14 9 5,5,5 rw0-8 by4 gw0-8 gy4 bw0-8 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
    18 8 6,5,5 rw0-7 gz4 by4 gw0-7 bz2 gy4 bw0-7 bz3-4 rx0-5 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-5 rz0-5 d0-4
    22 8 5,6,5 rw0-7 bz0 by4 gw0-7 gy5 gy4 bw0-7 gz5 bz4 rx0-4 gz4 gy0-3 gx0-5 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
    26 8 5,5,6 rw0-7 bz1 by4 gw0-7 by5 gy4 bw0-7 bz5 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-5 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
    30 6 0,0,0 rw0-5 gz4 bz0-1 by4 gw0-5 gy5 by5 bz2 gy4 bw0-5 gz5 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4
    3 10 0,0,0 rw0-9 gw0-9 bw0-9 rx0-9 gx0-9 bx0-9
    7 11 9,9,9 rw0-9 gw0-9 bw0-9 rx0-8 rw10 gx0-8 gw10 bx0-8 bw10
    11 12 8,8,8 rw0-9 gw0-9 bw0-9 rx0-7 rw11-10 gx0-7 gw11-10 bx0-7 bw11-10
    15 16 4,4,4 rw0-9 gw0-9 bw0-9 rx0-3 rw15-10 gx0-3 gw15-10 bx0-3 bw15-10""".strip().splitlines():
    code, precision, differences, *layout = row.split()
    places = []
    for entry in layout:
        name, first, last = re.fullmatch(r"([a-z]+)(\d+)(?:-(\d+))?", entry).groups()
        first, last = int(first), int(last or first)
        places += [(name, bit) for bit in (range(first, last + 1) if first <= last else range(first, last - 1, -1))]
    BC6H[int(code)] = int(precision), list(map(int, differences.split(","))), places


def bc6h(block):
    bits = Bits(block)
    code = bits.take(2)
    if code > 1:
        code |= bits.take(3) << 2
    if code not in BC6H:
        return [(0, 0, 0)] * 16
    precision, differences, places = BC6H[code]
    numbers = {}
    for name, bit in places:
        numbers[name] = numbers.get(name, 0) | bits.take(1) << bit
    subsets = 2 if "d" in numbers else 1

    def endpoint(channel, end):
        v, d = numbers[channel + end], differences["rgb".index(channel)]
        if d and end != "w":
            v = (numbers[channel + "w"] + v - (v >> (d - 1) << d)) % (1 << precision)
        if precision == 16 or v == 0:
            return v
        return 65535 if v == (1 << precision) - 1 else (v * 65536 + 32768) >> precision

    ends = [[endpoint(channel, end) for channel in "rgb"] for end in "wxyz"[:2 * subsets]]
    subset, anchors = partition_of(subsets, numbers.get("d", 0))
    count = 3 if subsets == 2 else 4
    pixels = []
    for t in range(16):
        weight = WEIGHTS[count][bits.take(count - (t in anchors))]
        a, b = ends[2 * subset[t]:2 * subset[t] + 2]
        pixels.append(tuple(mix(x, y, weight) * 31 >> 6 for x, y in zip(a, b)))
    return pixels


# Subsets, bits of partition, rotation and selection, C, A, lowest bits for each endpoint or subset, N, M.
BC7 = [
    (3, 4, 0, 0, 4, 0, "endpoint", 3, 0),
    (2, 6, 0, 0, 6, 0, "subset", 3, 0),
    (3, 6, 0, 0, 5, 0, "none", 2, 0),
    (2, 6, 0, 0, 7, 0, "endpoint", 2, 0),
    (1, 0, 2, 1, 5, 6, "none", 2, 3),
    (1, 0, 2, 0, 7, 8, "none", 2, 2),
    (1, 0, 0, 0, 7, 7, "endpoint", 4, 0),
    (2, 6, 0, 0, 5, 5, "endpoint", 2, 0),
]


def bc7(block):
    """Red, green and blue; alpha is dropped."""
    if block[0] == 0:
        return [bytes(3)] * 16
    bits, mode = Bits(block), 0
    while not bits.take(1):
        mode += 1
    subsets, partition_bits, rotation_bits, selection_bits, c, a, lowest, n, m = BC7[mode]
    subset, anchors = partition_of(subsets, bits.take(partition_bits))
    rotation, selection = bits.take(rotation_bits), bits.take(selection_bits)
    channels = [[bits.take(count) for _ in range(2 * subsets)] for count in (c, c, c, a)]
    low = [bits.take(1) for _ in range({"none": 0, "subset": subsets, "endpoint": 2 * subsets}[lowest])]
    low = [bit for bit in low for _ in (0, 1)] if lowest == "subset" else low
    for channel, count in zip(channels, (c, c, c, a)):
        for at in range(2 * subsets) if count else ():
            v, width = (channel[at] << 1 | low[at], count + 1) if low else (channel[at], count)
            channel[at] = v << (8 - width) | v >> (2 * width - 8)
        if not count:
            channel[:] = [255] * (2 * subsets)
    first = [WEIGHTS[n][bits.take(n - (t in anchors))] for t in range(16)]
    second = [WEIGHTS[m][bits.take(m - (t == 0))] for t in range(16)] if m else first
    of_color, of_alpha = (second, first) if selection else (first, second)
    pixels = []
    for t in range(16):
        at = 2 * subset[t]
        weights = (of_color[t],) * 3 + (of_alpha[t],)
        pixel = [mix(channel[at], channel[at + 1], weight) for channel, weight in zip(channels, weights)]
        if rotation:
            pixel[rotation - 1], pixel[3] = pixel[3], pixel[rotation - 1]
        pixels.append(bytes(pixel[:3]))
    return pixels


def image(blocks, size, decode, width, height):
    """The pixels of an image, row by row (blocks.md 2); `size` is that of a block in bytes."""
    columns = -(-width // 4)
    decoded = [decode(blocks[at:at + size]) for at in range(0, len(blocks), size)]
    return [decoded[y // 4 * columns + x // 4][y % 4 * 4 + x % 4] for y in range(height) for x in range(width)]


def image_bytes(size, width, height):
    return -(-width // 4) * -(-height // 4) * size
