"""Prints which one-bit changes of Zstandard frames zstandard.py accepts: the lines of README.md, for each file of the command line."""

import os
import sys
import zlib

import zstandard


def main():
    for path in sys.argv[1:]:
        with open(path, "rb") as file:
            stored = file.read()
        raw_bytes = os.path.getsize(os.path.splitext(path)[0] + ".raw")
        for at in range(len(stored)):
            for bit in range(8):
                changed = bytearray(stored)
                changed[at] ^= 1 << bit
                try:
                    raw = zstandard.decompress(bytes(changed), raw_bytes)
                except zstandard.Damaged:
                    continue
                print(f"{at} {bit} {zlib.crc32(raw):08x}")


main()
