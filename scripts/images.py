"""Images as arrays of numpy: PNG through Pillow, EXR through OpenEXR. Rows come first, then columns, then channels.

EXR is written by capture/exr.py.
"""

import math
import pathlib
from typing import Any

import numpy as np
import numpy.typing as npt
import PIL.Image
from OpenEXR import File as ExrFile

Array = npt.NDArray[Any]
Path = str | pathlib.Path


class NotRead(ValueError):
    """An image file that cannot be read."""


def read_png(path: Path) -> Array:
    """A PNG of 8-bit RGB or RGBA, or of 16-bit gray, which has no axis of channels."""
    try:
        with PIL.Image.open(path) as image:
            if image.format == "PNG" and image.mode in ("RGB", "RGBA", "I;16"):
                return np.asarray(image)
    except PIL.UnidentifiedImageError:
        pass
    except (OSError, SyntaxError, ValueError) as error:
        raise NotRead(f"{path}: {error}") from error
    raise NotRead(f"{path}: a PNG of 8-bit colour or 16-bit gray was expected")


def write_png(path: Path, pixels: Array, level: int = 1) -> None:
    """A PNG of 8-bit RGB, compressed at a level of zlib."""
    PIL.Image.fromarray(np.ascontiguousarray(pixels)).save(path, "PNG", compress_level=level)


def read_exr(path: Path) -> dict[str, Array]:
    """Channels of the first part of an EXR file, by name."""
    try:
        part = ExrFile(str(path), separate_channels=True).parts[0]
    except (RuntimeError, ValueError, IndexError) as error:
        raise NotRead(f"{path}: it is not an EXR file, or damaged") from error
    return {name: channel.pixels for name, channel in part.channels.items()}


def enlarged(pixels: Array, times: int) -> Array:
    """Each pixel drawn `times` times in each direction."""
    return pixels.repeat(times, axis=0).repeat(times, axis=1)


def psnr_db(squares: float, samples: int) -> float:
    """PSNR of so many 8-bit codes whose differences have this sum of squares."""
    return 10 * math.log10(255 * 255 * samples / squares) if squares else math.inf
