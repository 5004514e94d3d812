"""Fields of files, and refusals, for decode.py (container.md 1)."""

import math
import struct


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

    def varint(self, most=(1 << 32) - 1):
        value = 0
        for place in range(5):
            byte = self.take("B")
            value |= (byte & 0x7f) << 7 * place
            if byte < 0x80:
                check(byte or place == 0, "a varint is not in its shortest form")
                check(value <= most, "a varint is too large")
                return value
        raise Refused("a varint of more than five bytes")

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
