#!/usr/bin/env python3
"""Decodes .lfold containers, written from the documents in formats/ and from nothing else.

Prints `stream frame crc32` for each frame of each stream, the CRC-32 being that of the image in the form that
arithmetic.md 1 gives it. For a container that breaks a rule of the documents it says so on standard error, and ends with
exit code 2.

Usage: decode.py FILE.lfold...
"""

import sys
import zlib

from boxes import decode_temporal, read_temporal_header
from cells import TRANSFORMS, decode_cell, decode_transform, read_color_header
from container import NODE_CODECS, PIXEL_BYTES, read_foot, read_head, read_index
from fields import Refused, check
from nodes import decode_blocks, decode_nodes, read_node_header
from predictive import decode_alpha, decode_predictive, read_alpha_header, read_predictive_header


def decode_stream(data, stream):
    pixel = PIXEL_BYTES.get((stream.kind, stream.codec))
    check(pixel, "the codec is unknown")
    if stream.kind == 0:
        sets = read_color_header(stream)
    elif stream.codec == b"DPRD":
        predictive = read_predictive_header(stream)
    elif stream.codec == b"APRD":
        predictive = read_alpha_header(stream)
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
        elif stream.codec == b"DPRD":
            pictures = decode_predictive(data, chunks, (left, top, width, height), stream.width, predictive)
        elif stream.codec == b"APRD":
            pictures = decode_alpha(data, chunks, (left, top, width, height), stream.width, predictive)
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
