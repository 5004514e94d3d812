"""RVL of scripts/peers.c, compiled and called: it is timed beside other codecs, without Python."""

import ctypes
import pathlib
import subprocess
from typing import Any

SOURCE = pathlib.Path(__file__).with_name("peers.c")
# Bytes that C writes.
Buffer = Any


def buffer(count: int) -> Buffer:
    """Bytes that C may write, zeroed."""
    return (ctypes.c_char * max(count, 1))()


class Kernels:
    """The functions of peers.c, on bytes."""

    def __init__(self, work: str | pathlib.Path):
        library = pathlib.Path(work) / "peers.so"
        subprocess.run(["cc", "-O3", "-shared", "-fPIC", "-o", library, SOURCE], check=True)
        self.c = ctypes.CDLL(str(library))
        size, pointer = ctypes.c_size_t, ctypes.c_void_p
        self.c.rvl_encode.restype, self.c.rvl_encode.argtypes = size, [pointer, size, pointer]
        self.c.rvl_decode.restype, self.c.rvl_decode.argtypes = ctypes.c_int, [pointer, size, pointer, size]

    def rvl_encode(self, codes: bytes, out: Buffer = None) -> bytes:
        """An image of 16-bit codes, 0 for empty; `out` saves making a buffer."""
        out = out or buffer(2 * len(codes) + 16)
        return ctypes.string_at(out, self.c.rvl_encode(codes, len(codes) // 2, out))

    def rvl_decode(self, packed: bytes, pixels: int, out: Buffer = None) -> Buffer:
        """The codes again; ValueError where the bytes are not those of so many pixels."""
        out = out or buffer(2 * pixels)
        if not self.c.rvl_decode(packed, len(packed), out, pixels):
            raise ValueError(f"{len(packed)} bytes of RVL do not hold {pixels} pixels")
        return out
