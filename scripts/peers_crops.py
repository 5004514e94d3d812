"""Pictures for the eye in scripts/peers: crops of the source, x265, BC7 and ours, side by side, at the bytes of ours.

Crops lie around the cells where ours is worst, one of each face, with a cell's border in sight on every side.
"""

import math
import sys

import peers_frames as pf
from peers_color import BLOCKS, TRANSFORM

MEANS = [38.5, 40.0]
CELL, MARGIN, SCALE, PICTURES = 64, 32, 4, 6


def crop(film, payload, frame, left, top):
    """Rows of a crop, every pixel SCALE times as wide; and how often each row is shown."""
    image, side = film.images(payload)[frame], CELL + 2 * MARGIN
    rows = []
    for y in range(top, min(top + side, film.height)):
        at = 3 * (y * film.width + left)
        row = image[at:at + 3 * min(side, film.width - left)]
        rows.append(b"".join(row[x:x + 3] * SCALE for x in range(0, len(row), 3)))
    return rows


def worst_cells(source, container):
    """(stream's place, frame, left, top) of the worst cell of each of the worst faces."""
    found = source.differences(container)["streams"]
    cells = [(float(stream["min_cell_psnr_db"]), at, stream["min_cell_psnr_at"]) for at, stream in enumerate(found)]
    for _, at, place in sorted(cells, key=lambda cell: cell[:2])[:PICTURES]:
        first = source.film.streams[at].first_frame
        yield at, place["frame"] - first, max(place["x"] - MARGIN, 0), max(place["y"] - MARGIN, 0)


def write(source, folder):
    """The pictures of a set, and a line about the bytes of each codec."""
    folder.mkdir(parents=True, exist_ok=True)
    film = source.film
    decibels = lambda codec: 10 * math.log10(codec.size())
    for mean in MEANS:
        ours = source.ours_at("lightfold, transform", TRANSFORM, mean)
        ours.encode()
        x265 = source.rival_at("x265 medium", decibels, decibels(ours))
        blocks = source.ours("bc7", [*BLOCKS, "--psnr-final", "20", "--psnr", "20"])
        shown = [film.payloads]
        for codec in (x265, blocks, ours):
            codec.encode()
            shown.append(codec.payloads())
        sizes = [f"{name} {codec.size() / 1000:.0f}" for name, codec in (("x265", x265), ("BC7", blocks), ("ours", ours))]
        print(f"{folder}: {mean} dB, from the left: source, {', '.join(sizes)} kB", file=sys.stderr)
        for at, frame, left, top in worst_cells(source, ours.file):
            stream = film.streams[at]
            beside = zip(*(crop(film, payloads[at], frame, left, top) for payloads in shown))
            rows = [b"".join(row) for row in beside]
            name = f"{mean:g}-{stream.probe}-{stream.face}-{stream.first_frame + frame:04}.png"
            pf.write_png(folder / name, len(rows[0]) // 3, b"".join(row * SCALE for row in rows))
