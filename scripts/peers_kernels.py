"""scripts/peers.c, compiled and called: what is too slow for Python, and what is timed without it."""

import ctypes
import pathlib
import subprocess

SOURCE = pathlib.Path(__file__).with_name("peers.c")
SIZE = ctypes.c_size_t
REAL = ctypes.c_double
# name, type of the result, types of the arguments; None is a pointer.
SIGNATURES = [
    ("rvl_encode", SIZE, [None, SIZE, None]),
    ("rvl_decode", ctypes.c_int, [None, SIZE, None, SIZE]),
    ("rotate", None, [None, SIZE, ctypes.c_uint32, ctypes.c_int, None]),
    ("swizzle", None, [None, ctypes.c_int, SIZE, None]),
    ("unswizzle", None, [None, ctypes.c_int, SIZE, None]),
    ("codes24", None, [None, None, SIZE, REAL, REAL, None]),
    ("compare", None, [None, None, ctypes.c_int, SIZE, REAL, REAL, None, None]),
    ("png_rows", ctypes.c_int, [None, SIZE, SIZE, SIZE, None]),
    ("exr_unpredict", None, [None, SIZE, None]),
]


def buffer(count):
    """Bytes that C may write, zeroed."""
    return (ctypes.c_char * max(count, 1))()


class Kernels:
    """The functions of peers.c, on bytes."""

    def __init__(self, work):
        library = pathlib.Path(work) / "peers.so"
        command = ["cc", "-O3", "-shared", "-fPIC", "-o", library, SOURCE, "-lm"]
        subprocess.run(command, check=True)
        self.c = ctypes.CDLL(str(library))
        for name, result, arguments in SIGNATURES:
            function = getattr(self.c, name)
            function.restype = result
            function.argtypes = [kind or ctypes.c_void_p for kind in arguments]

    def _made(self, count, call):
        out = buffer(count)
        call(out)
        return out.raw[:count]

    def rvl_encode(self, codes, out=None):
        """An image of 16-bit codes, 0 for empty; `out` saves making a buffer."""
        out = out or buffer(2 * len(codes) + 16)
        return ctypes.string_at(out, self.c.rvl_encode(codes, len(codes) // 2, out))

    def rvl_decode(self, packed, pixels, out=None):
        """The codes again; ValueError where the bytes are not those of so many pixels."""
        out = out or buffer(2 * pixels)
        if not self.c.rvl_decode(packed, len(packed), out, pixels):
            raise ValueError(f"{len(packed)} bytes of RVL do not hold {pixels} pixels")
        return out

    def rotate(self, codes, count, back=False):
        """Codes one further round among `count`, so that the largest becomes 0; or back."""
        return self._made(len(codes), lambda out: self.c.rotate(codes, len(codes) // 2, count, back, out))

    def swizzle(self, codes, wide=False):
        """Planes of green, blue and red of one image."""
        pixels = len(codes) // (4 if wide else 2)
        return self._made(3 * pixels, lambda out: self.c.swizzle(codes, wide, pixels, out))

    def unswizzle(self, planes, wide=False):
        """Codes of one image."""
        pixels = len(planes) // 3
        return self._made(pixels * (4 if wide else 2), lambda out: self.c.unswizzle(planes, wide, pixels, out))

    def codes24(self, metres, codes, near_m, far_m):
        """24-bit codes in 32 bits, of 32-bit floats; 16-bit `codes` tell where the background is."""
        pixels = len(codes) // 2
        if len(metres) != 4 * pixels:
            raise ValueError(f"{len(metres)} bytes of metres for {pixels} pixels")
        return self._made(4 * pixels, lambda out: self.c.codes24(metres, codes, pixels, near_m, far_m, out))

    def compare(self, reference, got, near_far, source=None, wide=False):
        """(largest error in codes, sum of squares, the same two in metres, pixels compared, background that differs)."""
        if len(reference) != len(got):
            raise ValueError(f"{len(got)} bytes came back of {len(reference)}")
        out = (REAL * 6)()
        self.c.compare(reference, got, wide, len(reference) // (4 if wide else 2), *near_far, source, out)
        return tuple(out)

    def png_rows(self, filtered, rows, row_bytes, step):
        """Rows of a PNG without their filters."""
        if len(filtered) != rows * (row_bytes + 1):
            raise ValueError("a PNG holds more or fewer rows than it says")
        out = buffer(rows * row_bytes)
        if not self.c.png_rows(filtered, rows, row_bytes, step, out):
            raise ValueError("a PNG names an unknown filter")
        return out.raw[:rows * row_bytes]

    def exr_unpredict(self, data):
        """Bytes of a block of an EXR file, inflated before."""
        scratch = ctypes.create_string_buffer(data, max(len(data), 1))
        return self._made(len(data), lambda out: self.c.exr_unpredict(scratch, len(data), out))
