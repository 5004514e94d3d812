"""Pictures for the eye in scripts/peers: the smoothest and the busiest place of a set at 4x, of the source, x265, libaom and
ours side by side, at the bytes of ours. Places are cells of the middle frame of a face, a margin around each.
"""

import math
import pathlib

import numpy as np

import images
import peers_codecs as pc
import peers_frames as pf
from images import Array
from peers_color import Source

# Mean SSIMULACRA2 of ours: low, so that losses are in sight.
SCORE = 70
OURS, RIVALS = "lightfold, transform", ["x265 medium", "libaom, cpu-used 6"]
CELL, MARGIN, SCALE = 64, 32, 4
# Codes that a place spans, in means of squares of 8x8: what spans fewer is one colour, and shows nothing.
SPAN, SQUARE = 16, 8


def crop(pixels: Array, left: int, top: int) -> Array:
    """A place and its margin."""
    side = CELL + 2 * MARGIN
    return pixels[top:top + side, left:left + side]


def detail(cell: Array) -> tuple[float, float]:
    """(mean difference of neighbours in green, codes that means of squares span) of a cell."""
    green = cell[..., 1].astype(int)
    differences = sum(int(np.abs(np.diff(green, axis=axis)).sum()) for axis in (0, 1))
    squares = green.reshape(CELL // SQUARE, SQUARE, CELL // SQUARE, SQUARE).mean(axis=(1, 3))
    return differences / (2 * CELL * (CELL - 1)), float(np.ptp(squares))


def places(film: pf.Film) -> dict[str, tuple[int, int, int, int]]:
    """Stream, frame, left and top of the smoothest and of the busiest cell, by their names."""
    found = []
    for at, payload in enumerate(film.payloads):
        frame = film.streams[at].frames // 2
        pixels = film.pixels(payload, frame)
        for top in range(0, film.height - CELL + 1, CELL):
            for left in range(0, film.width - CELL + 1, CELL):
                busy, span = detail(pixels[top:top + CELL, left:left + CELL])
                found.append((busy, span, (at, frame, max(left - MARGIN, 0), max(top - MARGIN, 0))))
    if not found:
        raise pf.NotMeasured(f"frames of at least {CELL}x{CELL} pixels were expected")
    found.sort(key=lambda cell: cell[0])
    smooth = next((cell for cell in found if cell[1] >= SPAN), found[0])
    return {"smoothest": smooth[2], "busiest": found[-1][2]}


def scaled_bytes(codec: pc.Codec) -> float:
    """Bytes on a scale that grows with a setting about as fast as the score does; a search comes within 2% of them."""
    return 40 * math.log10(codec.size())


def write(source: Source, folder: pathlib.Path) -> None:
    """The pictures of a set, and a line about the bytes of each codec."""
    ours = source.ours_at(OURS, source.score, SCORE, {})
    if ours is None:
        raise pf.NotMeasured(f"no --quality has a mean score of {SCORE}")
    ours.encode()
    codecs: list[pc.Codec] = []
    for label in RIVALS:
        codec = source.rival_at(label, scaled_bytes, scaled_bytes(ours), {})
        if codec is None:
            raise pf.NotMeasured(f"no setting of {label} has {ours.size()} bytes")
        codec.encode()
        codecs.append(codec)
    codecs.append(ours)
    sizes = ", ".join(f"{codec.label} {codec.size() / 1000:.0f}" for codec in codecs)
    print(f"{folder}: SSIMULACRA2 {SCORE} of ours, from the left: source, {sizes} kB")
    film = source.film
    payloads = [film.payloads, *(codec.payloads() for codec in codecs)]
    folder.mkdir(parents=True, exist_ok=True)
    for name, (at, frame, left, top) in places(film).items():
        beside = np.concatenate([crop(film.pixels(of[at], frame), left, top) for of in payloads], axis=1)
        stream = film.streams[at]
        file = folder / f"{name}-{stream.probe}-{stream.face}-{stream.first_frame + frame:04}.png"
        images.write_png(file, images.enlarged(beside, SCALE))
