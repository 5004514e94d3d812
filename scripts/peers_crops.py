"""Pictures for the eye in scripts/peers: crops of the source, x265, BC7 and ours, side by side, at the bytes of ours.

BC7 is shown at its fewest bytes where it does not come down to those of ours.

Crops lie around the cells where ours is worst, one of each face, with a cell's border in sight on every side.
"""

import math
import os

import peers_frames as pf
import png_images
from peers_color import BLOCKS, PSNR, QP, TRANSFORM

MEANS = [38.5, 40.0]
CELL, MARGIN, SCALE, PICTURES = 64, 32, 4, 6


def crop(film, payload, frame, left, top):
    """Rows of a crop."""
    image, side = film.images(payload)[frame], CELL + 2 * MARGIN
    rows = []
    for y in range(top, min(top + side, film.height)):
        at = 3 * (y * film.width + left)
        rows.append(image[at:at + 3 * min(side, film.width - left)])
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
    for mean in MEANS:
        ours = source.ours_at("transform", TRANSFORM, QP, source.mean_psnr, mean)
        if ours is None:
            raise pf.NotMeasured(f"no --color-qp has a mean of {mean} dB")
        ours.encode()
        wanted = 10 * math.log10(ours.size())
        x265 = source.rival_at("x265 medium", lambda codec: 10 * math.log10(codec.size()), wanted)
        size_db = lambda file: 10 * math.log10(os.path.getsize(file))
        blocks = source.ours_at("bc7", [*BLOCKS, "--psnr-final", "20"], PSNR, size_db, wanted)
        shown = [film.payloads]
        sizes = []
        for name, codec in (("x265", x265), ("BC7", blocks), ("ours", ours)):
            if codec is None:
                raise pf.NotMeasured(f"no setting of {name} has {ours.size()} bytes")
            codec.encode()
            shown.append(codec.payloads())
            sizes.append(f"{name} {codec.size() / 1000:.0f}")
        print(f"{folder}: {mean} dB, from the left: source, {', '.join(sizes)} kB")
        for at, frame, left, top in worst_cells(source, ours.file):
            stream = film.streams[at]
            rows = zip(*(crop(film, payloads[at], frame, left, top) for payloads in shown))
            beside = [b"".join(row) for row in rows]
            width = len(beside[0]) // 3
            name = f"{mean:g}-{stream.probe}-{stream.face}-{stream.first_frame + frame:04}.png"
            png_images.write(folder / name, width * SCALE, png_images.enlarged(b"".join(beside), width, SCALE))
