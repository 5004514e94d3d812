"""Pictures for the eye in scripts/peers: the smoothest and the busiest place of a set at 4x, of the source, x265, libaom and
ours side by side, at the bytes of ours. Places are cells of the middle frame of a face, a margin around each.
"""

import math

import peers_frames as pf
import png_images

# Mean SSIMULACRA2 of ours: low, so that losses are in sight.
SCORE = 70
OURS, RIVALS = "lightfold, transform", ["x265 medium", "libaom, cpu-used 6"]
CELL, MARGIN, SCALE = 64, 32, 4
# Codes that a place spans, in means of squares of 8x8: what spans fewer is one colour, and shows nothing.
SPAN, SQUARE = 16, 8


def crop(film, payload, frame, left, top):
    """Rows of a crop."""
    image, side = film.images(payload)[frame], CELL + 2 * MARGIN
    rows = []
    for y in range(top, min(top + side, film.height)):
        at = 3 * (y * film.width + left)
        rows.append(image[at:at + 3 * min(side, film.width - left)])
    return rows


def detail(film, image, left, top):
    """(mean difference of neighbours in green, codes that means of squares span) of a cell."""
    rows = [image[3 * (y * film.width + left) + 1:3 * (y * film.width + left + CELL):3] for y in range(top, top + CELL)]
    beside = sum(abs(a - b) for row in rows for a, b in zip(row, row[1:]))
    below = sum(abs(a - b) for row, under in zip(rows, rows[1:]) for a, b in zip(row, under))
    squares = [sum(sum(row[x:x + SQUARE]) for row in rows[y:y + SQUARE]) / SQUARE**2
               for y in range(0, CELL, SQUARE) for x in range(0, CELL, SQUARE)]
    return (beside + below) / (2 * CELL * (CELL - 1)), max(squares) - min(squares)


def places(film):
    """Stream, frame, left and top of the smoothest and of the busiest cell, by their names."""
    found = []
    for at, payload in enumerate(film.payloads):
        frame = film.streams[at].frames // 2
        image = film.images(payload)[frame]
        for top in range(0, film.height - CELL + 1, CELL):
            for left in range(0, film.width - CELL + 1, CELL):
                busy, span = detail(film, image, left, top)
                found.append((busy, span, (at, frame, max(left - MARGIN, 0), max(top - MARGIN, 0))))
    if not found:
        raise pf.NotMeasured(f"frames of at least {CELL}x{CELL} pixels were expected")
    found.sort(key=lambda cell: cell[0])
    smooth = next((cell for cell in found if cell[1] >= SPAN), found[0])
    return {"smoothest": smooth[2], "busiest": found[-1][2]}


def scaled_bytes(codec):
    """Bytes on a scale that grows with a setting about as fast as the score does; a search comes within 2% of them."""
    return 40 * math.log10(codec.size())


def write(source, folder):
    """The pictures of a set, and a line about the bytes of each codec."""
    ours = source.ours_at(OURS, source.score, SCORE, {})
    if ours is None:
        raise pf.NotMeasured(f"no --quality has a mean score of {SCORE}")
    ours.encode()
    codecs = [source.rival_at(label, scaled_bytes, scaled_bytes(ours), {}) for label in RIVALS]
    for label, codec in zip(RIVALS, codecs):
        if codec is None:
            raise pf.NotMeasured(f"no setting of {label} has {ours.size()} bytes")
        codec.encode()
    codecs.append(ours)
    sizes = ", ".join(f"{codec.label} {codec.size() / 1000:.0f}" for codec in codecs)
    print(f"{folder}: SSIMULACRA2 {SCORE} of ours, from the left: source, {sizes} kB")
    film = source.film
    payloads = [film.payloads, *(codec.payloads() for codec in codecs)]
    folder.mkdir(parents=True, exist_ok=True)
    for name, (at, frame, left, top) in places(film).items():
        rows = zip(*(crop(film, of[at], frame, left, top) for of in payloads))
        beside = [b"".join(row) for row in rows]
        width = len(beside[0]) // 3
        stream = film.streams[at]
        file = folder / f"{name}-{stream.probe}-{stream.face}-{stream.first_frame + frame:04}.png"
        png_images.write(file, width * SCALE, png_images.enlarged(b"".join(beside), width, SCALE))
