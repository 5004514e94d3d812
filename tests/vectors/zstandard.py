"""Decodes one Zstandard frame (RFC 8878), as container.md 6.2 allows it: no dictionary, no checksum, a known size."""

MAGIC = b"\x28\xb5\x2f\xfd"
MAX_WINDOW = 1 << 24
MAX_BLOCK = 1 << 17


class Damaged(Exception):
    """The frame breaks a rule."""


def check(rule, message):
    if not rule:
        raise Damaged(message)


def length_codes(ranges):
    """Base value and number of extra bits of each code."""
    table, value = [], ranges[0]
    for bits in ranges[1]:
        table.append((value, bits))
        value += 1 << bits
    return table


# RFC 8878, 3.1.1.3.2.1.1: codes of literal lengths and match lengths.
LITERAL_LENGTHS = length_codes((0, [0] * 16 + [1, 1, 1, 1, 2, 2, 3, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]))
MATCH_LENGTHS = length_codes((3, [0] * 32 + [1, 1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]))
# RFC 8878, 3.1.1.3.2.2: accuracy and default distributions.
DEFAULTS = (
    (6, [4, 3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 2, 3, 2, 1, 1, 1, 1, 1, -1, -1, -1, -1]),
    (5, [1, 1, 1, 1, 1, 1, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1]),
    (6, [1, 4, 3, 2, 2, 2, 2, 2, 2] + [1] * 37 + [-1] * 7),
)
# Most bits of accuracy and most symbols, of literal lengths, offsets and match lengths.
LIMITS = ((9, 36), (8, 32), (9, 53))


class Forward:
    """Bits from the first byte on, the lowest first."""

    def __init__(self, data):
        self.value, self.count, self.at = int.from_bytes(data, "little"), 8 * len(data), 0

    def take(self, bits):
        check(self.at + bits <= self.count, "a table ends early")
        self.at += bits
        return self.value >> (self.at - bits) & ((1 << bits) - 1)


class Backward:
    """Bits from the last byte back, below the highest bit that is set. Beyond the start they are 0."""

    def __init__(self, data):
        check(data and data[-1], "a bit stream has no end mark")
        self.value = int.from_bytes(data, "little")
        self.left = self.value.bit_length() - 1

    def take(self, bits):
        self.left -= bits
        shifted = self.value >> self.left if self.left >= 0 else self.value << -self.left
        return shifted & ((1 << bits) - 1)


def read_distribution(data, max_accuracy, max_symbols):
    """Accuracy, probabilities (-1: less than one) and the bytes that they take (RFC 8878, 4.1.1)."""
    bits = Forward(data)
    accuracy = bits.take(4) + 5
    check(accuracy <= max_accuracy, "a table is too large")
    left, counts = (1 << accuracy) + 1, []
    while left > 1:
        check(len(counts) < max_symbols, "a table has too many symbols")
        width = left.bit_length()
        low = (1 << width) - 1 - left
        value = bits.take(width - 1)
        if value >= low:
            value |= bits.take(1) << (width - 1)
            if value >= 1 << (width - 1):
                value -= low
        count = value - 1
        counts.append(count)
        left -= abs(count)
        if count == 0:
            repeat = 3
            while repeat == 3:
                repeat = bits.take(2)
                counts += [0] * repeat
    check(left == 1 and len(counts) <= max_symbols, "the counts of a table have another sum")
    return accuracy, counts, (bits.at + 7) // 8


def fse_table(accuracy, counts):
    """Symbol, bits and base of each state (RFC 8878, 4.1.1)."""
    size = 1 << accuracy
    symbols, high = [None] * size, size
    for symbol, count in enumerate(counts):
        if count == -1:
            high -= 1
            symbols[high] = symbol
    at, step = 0, (size >> 1) + (size >> 3) + 3
    for symbol, count in enumerate(counts):
        for _ in range(max(count, 0)):
            symbols[at] = symbol
            at = (at + step) % size
            while at >= high:
                at = (at + step) % size
    next_state = [1 if count == -1 else count for count in counts]
    table = []
    for symbol in symbols:
        state = next_state[symbol]
        next_state[symbol] += 1
        bits = accuracy - (state.bit_length() - 1)
        table.append((symbol, bits, (state << bits) - size))
    return accuracy, table


def huffman_table(weights):
    """Longest code and, for each value of so many bits, symbol and length (RFC 8878, 4.2.1)."""
    check(max(weights) <= 11, "a weight of a Huffman table is too large")
    total = sum(1 << weight - 1 for weight in weights if weight)
    check(total, "a Huffman table is empty")
    longest = total.bit_length()
    rest = (1 << longest) - total
    check(rest & (rest - 1) == 0 and longest <= 11, "a Huffman table is illegal")
    weights = weights + [rest.bit_length()]
    check(1 in weights, "no code of a Huffman table has its longest length")
    table = []
    for weight in range(1, longest + 1):
        for symbol, of_symbol in enumerate(weights):
            if of_symbol == weight:
                table += [(symbol, longest + 1 - weight)] * (1 << weight - 1)
    check(len(table) == 1 << longest, "a Huffman table has another sum")
    return longest, table


def read_huffman(data):
    """A Huffman table and the bytes that it takes."""
    check(data, "a Huffman table is missing")
    head = data[0]
    if head >= 128:
        count = head - 127
        size = (count + 1) // 2
        check(1 + size <= len(data), "a Huffman table ends early")
        nibbles = [half for byte in data[1:1 + size] for half in (byte >> 4, byte & 15)]
        return huffman_table(nibbles[:count]), 1 + size
    check(1 + head <= len(data), "a Huffman table ends early")
    packed = data[1:1 + head]
    accuracy, counts, used = read_distribution(packed, 6, 256)
    _, table = fse_table(accuracy, counts)
    bits, weights = Backward(packed[used:]), []
    states = [bits.take(accuracy), bits.take(accuracy)]
    check(bits.left >= 0, "the weights of a Huffman table end early")
    turn = 0
    while True:
        symbol, width, base = table[states[turn]]
        weights.append(symbol)
        check(len(weights) < 255, "a Huffman table has too many weights")
        states[turn] = base + bits.take(width)
        turn = 1 - turn
        if bits.left < 0:
            weights.append(table[states[turn]][0])
            break
    return huffman_table(weights), 1 + head


def huffman_stream(data, count, huffman):
    longest, table = huffman
    bits, out = Backward(data), bytearray()
    for _ in range(count):
        value = bits.take(longest)
        symbol, length = table[value]
        bits.left += longest - length
        out.append(symbol)
    check(bits.left == 0, "a stream of literals has another length")
    return out


class Frame:
    def __init__(self, data):
        self.data, self.at, self.out = data, 0, bytearray()
        self.huffman, self.tables, self.repeats = None, [None] * 3, [1, 4, 8]

    def bytes(self, count):
        check(self.at + count <= len(self.data), "the frame ends early")
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self, count):
        return int.from_bytes(self.bytes(count), "little")

    def decode(self, raw_bytes):
        check(self.bytes(4) == MAGIC, "the magic number is other")
        descriptor = self.number(1)
        check(descriptor & 0x1f == 0, "a dictionary, a checksum or reserved bits")
        single = descriptor >> 5 & 1
        self.window = raw_bytes
        if not single:
            byte = self.number(1)
            base = 1 << 10 + (byte >> 3)
            self.window = base + base // 8 * (byte & 7)
        check(self.window <= MAX_WINDOW, "the window is too large")
        size = descriptor >> 6
        check(size or single, "the content size is missing")
        content = self.number(1 << size) + (256 if size == 1 else 0)
        check(content == raw_bytes, "the content size is other")
        last = 0
        while not last:
            head = self.number(3)
            last, kind, size = head & 1, head >> 1 & 3, head >> 3
            most = min(MAX_BLOCK, self.window)
            check(kind < 3 and size <= most, "a block is illegal")
            start = len(self.out)
            if kind == 0:
                self.out += self.bytes(size)
            elif kind == 1:
                self.out += self.bytes(1) * size
            else:
                self.block(self.bytes(size))
            check(len(self.out) - start <= most, "a block has more bytes than it may")
            check(len(self.out) <= raw_bytes, "the content is longer")
        check(self.at == len(self.data), "bytes are left over")
        check(len(self.out) == raw_bytes, "the content is shorter")
        return bytes(self.out)

    def block(self, data):
        literals, used = self.literals(data)
        self.sequences(data[used:], literals)

    def literals(self, data):
        check(data, "a block is empty")
        kind, form = data[0] & 3, data[0] >> 2 & 3
        if kind < 2:
            head, shift = ((1, 3), (2, 4), (1, 3), (3, 4))[form]
            check(head <= len(data), "literals end early")
            count = int.from_bytes(data[:head], "little") >> shift
            check(count <= MAX_BLOCK and head + (1 if kind else count) <= len(data), "literals end early")
            return (data[head:head + count], head + count) if kind == 0 else (data[head:head + 1] * count, head + 1)
        head, width = ((3, 10), (3, 10), (4, 14), (5, 18))[form]
        check(head <= len(data), "literals end early")
        sizes = int.from_bytes(data[:head], "little") >> 4
        count, size = sizes & (1 << width) - 1, sizes >> width
        check(count <= MAX_BLOCK and head + size <= len(data), "literals end early")
        body, used = data[head:head + size], 0
        if kind == 2:
            self.huffman, used = read_huffman(body)
        check(self.huffman, "a Huffman table is missing")
        body = body[used:]
        check(count >= (6 if form else 1), "too few literals for their streams")
        if form == 0:
            return huffman_stream(body, count, self.huffman), head + size
        check(len(body) >= 6, "literals end early")
        jumps = [int.from_bytes(body[at:at + 2], "little") for at in (0, 2, 4)]
        part, at, out = (count + 3) // 4, 6, bytearray()
        check(6 + sum(jumps) <= len(body), "literals end early")
        for number in range(4):
            end = at + jumps[number] if number < 3 else len(body)
            out += huffman_stream(body[at:end], part if number < 3 else count - 3 * part, self.huffman)
            at = end
        return out, head + size

    def sequences(self, data, literals):
        check(data, "sequences are missing")
        count, at = data[0], 1
        if count >= 128:
            check(len(data) >= (3 if count == 255 else 2), "sequences end early")
            count, at = (data[1] + (data[2] << 8) + 0x7f00, 3) if count == 255 else ((count - 128 << 8) + data[1], 2)
        if count == 0:
            check(at == len(data), "bytes follow the sequences")
            self.out += literals
            return
        check(at < len(data) and data[at] & 3 == 0, "the modes of sequences are illegal")
        modes, at = data[at], at + 1
        for number in range(3):
            mode = modes >> 6 - 2 * number & 3
            if mode == 0:
                self.tables[number] = fse_table(*DEFAULTS[number])
            elif mode == 1:
                check(at < len(data) and data[at] < LIMITS[number][1], "the code of a table is illegal")
                self.tables[number] = 0, [(data[at], 0, 0)]
                at += 1
            elif mode == 2:
                accuracy, counts, used = read_distribution(data[at:], *LIMITS[number])
                self.tables[number] = fse_table(accuracy, counts)
                at += used
            check(self.tables[number], "a table is missing")
        bits = Backward(data[at:])
        states = [bits.take(accuracy) for accuracy, _ in self.tables]
        place = 0
        for number in range(count):
            rows = [table[state] for (_, table), state in zip(self.tables, states)]
            offset_code = rows[1][0]
            offset = (1 << offset_code) + bits.take(offset_code)
            base, extra = MATCH_LENGTHS[rows[2][0]]
            match = base + bits.take(extra)
            base, extra = LITERAL_LENGTHS[rows[0][0]]
            length = base + bits.take(extra)
            if number + 1 < count:
                for which in (0, 2, 1):
                    _, width, base = rows[which]
                    states[which] = base + bits.take(width)
            check(bits.left >= 0, "the sequences end early")
            check(place + length <= len(literals), "the literals end early")
            self.out += literals[place:place + length]
            place += length
            self.copy(self.offset(offset, length), match)
        check(bits.left == 0, "the sequences have another length")
        self.out += literals[place:]

    def offset(self, value, length):
        """RFC 8878, 3.1.1.5."""
        repeats = self.repeats
        if value > 3:
            self.repeats = [value - 3] + repeats[:2]
            return value - 3
        which = value - 1 + (length == 0)
        chosen = repeats[0] - 1 if which == 3 else repeats[which]
        check(chosen > 0, "an offset is 0")
        if which:
            self.repeats = [chosen, repeats[0], repeats[2] if which == 1 else repeats[1]]
        return chosen

    def copy(self, offset, count):
        check(offset <= min(len(self.out), self.window), "a match reaches too far back")
        check(len(self.out) + count <= MAX_WINDOW * 64, "the content is longer")
        start = len(self.out) - offset
        for at in range(start, start + count):
            self.out.append(self.out[at])


def decompress(stored, raw_bytes):
    """The payload of a chunk; raises Damaged where container.md 6.2 or RFC 8878 forbids it."""
    return Frame(stored).decode(raw_bytes)
