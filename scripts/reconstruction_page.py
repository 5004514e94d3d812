"""The page of scripts/reconstruction-quality: tables and charts of its reports, and pictures side by side, before and after.

Before is the algorithm of the paper, after is ours. Crops of a pose are chosen from windows of its pictures that a silhouette of
the truth crosses, by the sum of squared errors: in turn the one that is worst before and the one that is worst after, of those
that overlap none chosen before.
"""

import array
import dataclasses
import html
import itertools
import math
import pathlib
import re
import sys
import urllib.parse

import lightfold_runs as lf
import peers_frames as pf
import png_images
import reconstruction_quality as rq
import reconstruction_report as rr

# Labels of methods, and what the page calls them.
BEFORE, AFTER = "paper", "ours"
COMPARED = {"paper": "paper (before)", "ours": "ours (after)", "points": "points"}
# Pixels of a side of a crop, from one window to the next, and that a pixel of a crop becomes.
SIDE, STEP, SCALE = 40, 8, 4
# Crops of a pose.
CROPS = 6
# Pictures of fewer pixels a side are enlarged.
WHOLE = 256
# Two pixels side by side are of two surfaces if the logarithms of their distances differ by more than this, as in `render`.
DIFFERENCE = 0.1
# In pictures of errors this difference of codes, and more, is white.
WHITE_CODES = 64
FRAME = (255, 150, 0)
ABOUT = (
    "Before is the algorithm of the CALF paper, `--method calf`; after is what `lightfold render` shows by default. A crop is "
    f"a window of {SIDE} x {SIDE} pixels, drawn {SCALE} times as large, with the PSNR of its 8-bit codes. Windows are chosen "
    f"among those that silhouettes cross: at least {SIDE} pixels lie beside one whose true distance differs by 10 %. In turn "
    f"the one with the largest sum of squared errors before is taken, and the one with the largest after, of all faces of a "
    f"pose and of those that overlap none taken before; {CROPS} in all. Pictures of errors show the largest difference of a "
    f"pixel's codes, white at {WHITE_CODES} of 255 and more; crops are framed there.")
# Without loss, so that pictures are those that `render` compares with.
LOSSLESS = ["--color-codec", "cells", "--psnr", "100", "--max-error", "0", "--clip"]

STYLE = """
:root{color-scheme:light dark}
body{font:16px/1.5 'DejaVu Sans',Verdana,sans-serif;max-width:1320px;margin:0 auto;padding:24px}
.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums;margin:8px 0 24px}
caption{text-align:left;font-weight:bold;padding:4px 0}th,td{padding:3px 8px;text-align:right;border-bottom:1px solid #8886}
th[scope=row]{text-align:left;font-weight:normal}.pictures :is(th,td){text-align:left;vertical-align:top}
img{display:block;image-rendering:pixelated}figure{margin:16px 0}svg{max-width:100%;height:auto}
code{font:13px 'DejaVu Sans Mono',Consolas,monospace;overflow-wrap:anywhere}
"""


# ---- pictures

def read_png(path):
    """(width, height, samples) of a PNG of 8-bit RGB or RGBA, as RGB that is black where alpha is 0, or of 16-bit gray."""
    try:
        width, height, step, samples = png_images.read(path)
    except png_images.NotRead as error:
        raise rq.Refused(str(error)) from error
    if step == 2:
        codes = array.array("H", samples)
        if sys.byteorder == "big":
            codes.byteswap()
        return width, height, codes
    return width, height, without_alpha(samples) if step == 4 else samples


def without_alpha(samples):
    rgb = bytearray(len(samples) // 4 * 3)
    for channel in range(3):
        rgb[channel::3] = bytes(value if alpha else 0 for value, alpha in zip(samples[channel::4], samples[3::4]))
    return rgb


def cropped(picture, width, window):
    starts = (3 * (y * width + window.left) for y in range(window.top, window.top + window.side))
    return b"".join(picture[start:start + 3 * window.side] for start in starts)


def error_picture(truth, shown, width, windows):
    """The largest difference of the codes of each pixel, in gray; windows are framed."""
    gain = [min(255, code * 255 // WHITE_CODES) for code in range(256)]
    largest = [gain[max(map(abs, of))] for of in zip(*[iter(a - b for a, b in zip(truth, shown))] * 3)]
    drawn = bytearray(value for value in largest for _ in range(3))
    for window in windows:
        last = window.side - 1
        for x, y in itertools.product(range(window.side), repeat=2):
            if x in (0, last) or y in (0, last):
                at = 3 * ((window.top + y) * width + window.left + x)
                drawn[at:at + 3] = bytes(FRAME)
    return drawn


# ---- the truth

class Truths:
    """Pictures and depth of probes of datasets, from a container that keeps them without loss."""

    def __init__(self, binary, work):
        self.binary, self.work = binary, work
        self.containers = {}

    def container(self, case, frame):
        """(container, ranges of depth by probe and face) of the dataset of a case."""
        if (case.reference, frame) not in self.containers:
            path = self.work / f"truth_{len(self.containers)}.lfold"
            lf.run_json(self.binary, "encode", case.reference, "--frames", frame, *LOSSLESS, "-o", path, "--json")
            streams = lf.run_json(self.binary, "inspect", path, "--json")["streams"]
            ranges = {(of["probe"], of.get("face") or "view"): (of["near_m"], of["far_m"]) for of in streams if "near_m" in of}
            self.containers[case.reference, frame] = path, ranges
        return self.containers[case.reference, frame]

    def of(self, case, image):
        """(width, height, RGB, silhouettes) of an image that is in a report."""
        path, ranges = self.container(case, image["frame"])
        width, height, rgb = self.decoded(path, "color", image)
        near_far = ranges.get((image["probe"], image["face"]))
        edges = silhouettes(self.decoded(path, "depth", image)[2], width, near_far) if near_far else None
        return width, height, rgb, edges

    def decoded(self, path, kind, image):
        """What a PNG of one stream holds."""
        probe, face, frame = image["probe"], image["face"], image["frame"]
        pick = ["--stream", kind, "--probe", probe, *([] if face == "view" else ["--face", face])]
        files = path.with_suffix("") / f"{probe}_{face}_{kind}.%04d.png"
        lf.run_json(self.binary, "decode", path, *pick, "--format", "png", "-o", files, "--json")
        return read_png(str(files) % frame)


def silhouettes(codes, width, near_far):
    """1 for each pixel beside which there is another surface, by the codes of depth, else 0."""
    near_m, far_m = near_far
    most = DIFFERENCE * (pf.BACKGROUND - 1) / max(math.log(far_m / near_m), 1e-9)
    differ = lambda a, b: abs(a - b) > most if pf.BACKGROUND not in (a, b) else a != b
    found = bytearray(len(codes))
    for step in (1, width):
        for at in range(len(codes) - step):
            if (step > 1 or (at + 1) % width) and differ(codes[at], codes[at + step]):
                found[at] = found[at + step] = 1
    return found


# ---- the choice of crops

@dataclasses.dataclass(frozen=True)
class Window:
    """A square of a face; `errors` are sums of squared differences of codes by method, and `edge` is its pixels at silhouettes."""

    face: str
    left: int
    top: int
    side: int
    errors: dict
    edge: int

    def overlaps(self, other):
        return self.face == other.face and max(abs(self.left - other.left), abs(self.top - other.top)) < self.side

    def psnr_db(self, label):
        return png_images.psnr_db(self.errors[label], 3 * self.side**2)


def squares(a, b):
    """The sum of squared differences of each pixel's codes."""
    each = [(x - y) * (x - y) for x, y in zip(a, b)]
    return [sum(of) for of in zip(each[0::3], each[1::3], each[2::3])]


class Sums:
    """Sums of values of pixels over squares."""

    def __init__(self, values, width):
        self.rows = [[0] * (width + 1)]
        for start in range(0, len(values), width):
            row = itertools.accumulate(values[start:start + width], initial=0)
            self.rows.append([a + b for a, b in zip(self.rows[-1], row)])

    def within(self, left, top, side):
        above, below = self.rows[top], self.rows[top + side]
        return below[left + side] - below[left] - above[left + side] + above[left]


def windows_of(face, errors, edges, size):
    """Windows of a face: `errors` are values of pixels by method, `edges` are its silhouettes or None where they are unknown."""
    width, height = size
    side = min(SIDE, width, height)
    sums = {label: Sums(values, width) for label, values in errors.items()}
    edge = edges and Sums(edges, width)
    for top, left in itertools.product(range(0, height - side + 1, STEP), range(0, width - side + 1, STEP)):
        square = left, top, side
        of_methods = {label: of.within(*square) for label, of in sums.items()}
        yield Window(face, *square, of_methods, edge.within(*square) if edge else side)


def choose(windows, count):
    """(method whose error is the largest there, window), in turn before and after. A silhouette crosses a window that has as
    many of its pixels as its side is long; where none is crossed, all windows take part."""
    crossed = [window for window in windows if window.edge >= window.side] or windows
    ranked = {label: sorted(crossed, key=lambda window: -window.errors[label]) for label in (BEFORE, AFTER)}
    chosen = []
    for _, label in zip(range(count), itertools.cycle(ranked)):
        free = (window for window in ranked[label] if not any(window.overlaps(other) for _, other in chosen))
        window = next(free, None)
        if window and window.errors[label]:
            chosen.append((label, window))
    return chosen


# ---- a pose

@dataclasses.dataclass
class Face:
    """An image of a pose: RGB of the truth and of each method, and windows that crops are chosen from."""

    width: int
    pictures: dict
    psnr_db: dict
    windows: list


def faces_of(pose, truths):
    """The images of the first frame of a pose, by the name of the face."""
    images = {label: pose.reports[label]["reference"]["images"] for label in COMPARED}
    first = min(image["frame"] for image in images[AFTER])
    found = {}
    for at, image in enumerate(images[AFTER]):
        if image["frame"] != first:
            continue
        width, height, truth, edges = truths.of(pose.case, image)
        pictures = {"truth": truth}
        for label in COMPARED:
            path = pose.picture(label, image)
            *size, pictures[label] = read_png(path)
            if size != [width, height]:
                raise rq.Refused(f"{path}: {width} x {height} pixels were expected, as the truth has, not {size[0]} x {size[1]}")
        errors = {label: squares(truth, pictures[label]) for label in COMPARED}
        psnr_db = {label: rq.number(images[label][at]["psnr_db"]) for label in COMPARED}
        windows = list(windows_of(image["face"], errors, edges, (width, height)))
        found[image["face"]] = Face(width, pictures, psnr_db, windows)
    return found


class Pictures:
    """Writes the pictures of an input into a folder beside the page, and answers what shows them."""

    def __init__(self, page, name):
        self.folder, self.name = page / name, name
        self.folder.mkdir(parents=True, exist_ok=True)

    def cell(self, place, what, picture, width):
        """An image and its PSNR: `place` is (start of the file's name, words), `picture` is (RGB, dB or None)."""
        (stem, words), (rgb, psnr_db) = place, picture
        file = f"{stem}_{re.sub('[^a-z]+', '_', what).strip('_')}.png"
        png_images.write(self.folder / file, width, rgb)
        address, height = urllib.parse.quote(f"{self.name}/{file}"), len(rgb) // (3 * width)
        alt = html.escape(f"{what}: {words}")
        shown = f'<img src="{address}" alt="{alt}" width="{width}" height="{height}" loading="lazy">'
        under = "" if psnr_db is None else rr.decibels(psnr_db) + (" dB" if math.isfinite(psnr_db) else "")
        return shown + under

    def crops(self, pose, faces, chosen):
        """A row for each crop."""
        lines = []
        for label, window in chosen:
            face = faces[window.face]
            draw = lambda of: png_images.enlarged(cropped(face.pictures[of], face.width, window), window.side, SCALE)
            shown = {"truth": (draw("truth"), None)}
            shown |= {name: (draw(of), window.psnr_db(of)) for of, name in COMPARED.items()}
            stem = f"{pose.case.probe}_{window.face}_{window.left}_{window.top}"
            place = stem, f"crop of face {window.face} at column {window.left}, row {window.top}"
            first = f"{window.face}, {window.left}, {window.top}<br>worst of {COMPARED[label]}"
            lines.append([first, *(self.cell(place, what, of, window.side * SCALE) for what, of in shown.items())])
        return table(f"{pose.title}: crops", ["face, column, row", *shown], lines, "pictures")

    def whole(self, pose, faces, chosen):
        """A row for each face that crops are of."""
        lines = []
        for name, face in faces.items():
            windows = [window for _, window in chosen if window.face == name]
            if not windows:
                continue
            times = max(1, WHOLE // face.width)
            errors = {of: error_picture(face.pictures["truth"], face.pictures[of], face.width, windows) for of in (BEFORE, AFTER)}
            shown = {"truth": (face.pictures["truth"], None)}
            shown |= {COMPARED[of]: (face.pictures[of], face.psnr_db[of]) for of in errors}
            shown |= {f"error of {COMPARED[of]}": (error, None) for of, error in errors.items()}
            place = f"{pose.case.probe}_{name}", f"face {name}"
            drawn = lambda rgb: png_images.enlarged(rgb, face.width, times)
            draw = lambda what, rgb, db: self.cell(place, what, (drawn(rgb), db), face.width * times)
            lines.append([name, *(draw(what, *of) for what, of in shown.items())])
        return table(f"{pose.title}: whole pictures", ["face", *shown], lines, "pictures")

    def of(self, pose, truths):
        """Crops and whole pictures of a pose."""
        faces = faces_of(pose, truths)
        chosen = choose([window for face in faces.values() for window in face.windows], CROPS)
        title = f"<h4>{html.escape(pose.title)}</h4>"
        if not chosen:
            return f"{title}\n<p>All pictures are exact.</p>"
        return "\n".join([title, self.crops(pose, faces, chosen), self.whole(pose, faces, chosen)])


# ---- HTML

def paragraph(text):
    """A paragraph; `words` are code."""
    return "<p>" + re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(text)) + "</p>"


def table(title, head, lines, kind="figures"):
    """A table of cells that are HTML; the first of a line is its header."""
    name = html.escape(title)
    columns = "".join(f'<th scope="col">{html.escape(cell)}</th>' for cell in head)
    row = lambda first, *others: f'<tr><th scope="row">{first}</th>' + "".join(f"<td>{cell}</td>" for cell in others) + "</tr>"
    rows = "\n".join(row(*line) for line in lines)
    return (f'<div class="scroll" role="region" aria-label="{name}" tabindex="0">\n<table class="{kind}">\n'
            f"<caption>{name}</caption>\n<thead><tr>{columns}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table>\n</div>")


def section(page, report, poses, truths):
    """The part of a page about one input; its pictures are written beside the page."""
    pictures = Pictures(page, report.name)
    escaped = lambda lines: [[html.escape(str(cell)) for cell in line] for line in lines]
    figures = [table(title, head, escaped(lines)) for title, head, lines in report.tables]
    charts = [f'<figure role="img" aria-label="{html.escape(title)}">\n{drawn}</figure>' for _, title, drawn in report.charts]
    parts = [f"<section>\n<h2>{html.escape(report.name)}</h2>", paragraph(f"`{report.command}`"), "<h3>Pictures</h3>"]
    parts += [pictures.of(pose, truths) for pose in poses]
    return "\n".join([*parts, "<h3>Figures</h3>", *map(paragraph, report.about), *figures, *charts, "</section>"])


def write(page, sections):
    """index.html, without scripts and without anything from a network."""
    title = "Pictures rendered from light fields, before and after"
    parts = ['<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
             '<meta name="viewport" content="width=device-width, initial-scale=1">',
             f"<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>", paragraph(ABOUT)]
    (page / "index.html").write_text("\n".join([*parts, *sections, "</main>\n</body>\n</html>\n"]), encoding="utf-8")
