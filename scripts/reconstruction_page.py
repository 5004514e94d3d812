"""The page of scripts/reconstruction-quality: tables and charts of its reports, and pictures side by side, before and after.

Before is the algorithm of the paper, after is ours. Crops of a pose are chosen from windows of its pictures that a silhouette of
the truth crosses, by the sum of squared errors: in turn the one that is worst before and the one that is worst after, of those
that overlap none chosen before.
"""

import dataclasses
import html
import itertools
import math
import pathlib
import re
import urllib.parse
from typing import Any, Iterable, Iterator, Sequence

import numpy as np

import images
import lightfold_runs as lf
import peers_frames as pf
import reconstruction_quality as rq
import reconstruction_report as rr
from images import Array

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

def read_png(path: images.Path) -> Array:
    """RGB that is black where alpha is 0, or codes of 16 bits."""
    try:
        pixels = images.read_png(path)
    except images.NotRead as error:
        raise rq.Refused(str(error)) from error
    return without_alpha(pixels) if pixels.shape[2:] == (4,) else pixels


def without_alpha(pixels: Array) -> Array:
    return pixels[..., :3] * (pixels[..., 3:] > 0)


def error_picture(truth: Array, shown: Array, windows: Iterable["Window"]) -> Array:
    """The largest difference of the codes of each pixel, in gray; windows are framed."""
    largest = np.abs(truth.astype(int) - shown).max(axis=2, keepdims=True)
    drawn = np.minimum(largest * 255 // WHITE_CODES, 255).astype(np.uint8).repeat(3, axis=2)
    for window in windows:
        square = window.of(drawn)
        square[[0, -1]] = FRAME
        square[:, [0, -1]] = FRAME
    return drawn


# ---- the truth

class Truths:
    """Pictures and depth of probes of datasets, from a container that keeps them without loss."""

    def __init__(self, binary: lf.Binary, work: pathlib.Path):
        self.binary, self.work = binary, work
        self.containers: dict[tuple[pathlib.Path, int], tuple[pathlib.Path, dict[tuple[str, str], tuple[float, float]]]] = {}

    def container(self, case: rq.Case, frame: int) -> tuple[pathlib.Path, dict[tuple[str, str], tuple[float, float]]]:
        """(container, ranges of depth by probe and face) of the dataset of a case."""
        if (case.reference, frame) not in self.containers:
            path = self.work / f"truth_{len(self.containers)}.lfold"
            lf.run_json(self.binary, "encode", case.reference, "--frames", frame, *LOSSLESS, "-o", path, "--json")
            streams = lf.run_json(self.binary, "inspect", path, "--json")["streams"]
            ranges = {(of["probe"], of.get("face") or "view"): (of["near_m"], of["far_m"]) for of in streams if "near_m" in of}
            self.containers[case.reference, frame] = path, ranges
        return self.containers[case.reference, frame]

    def of(self, case: rq.Case, image: dict[str, Any]) -> tuple[Array, Array | None]:
        """RGB and silhouettes of an image that is in a report."""
        path, ranges = self.container(case, image["frame"])
        near_far = ranges.get((image["probe"], image["face"]))
        edges = silhouettes(self.decoded(path, "depth", image), near_far) if near_far else None
        return self.decoded(path, "color", image), edges

    def decoded(self, path: pathlib.Path, kind: str, image: dict[str, Any]) -> Array:
        """Pixels of one stream of an image."""
        probe, face, frame = image["probe"], image["face"], image["frame"]
        pick = ["--stream", kind, "--probe", probe, *([] if face == "view" else ["--face", face])]
        files = path.with_suffix("") / f"{probe}_{face}_{kind}.%04d.png"
        lf.run_json(self.binary, "decode", path, *pick, "--format", "png", "-o", files, "--json")
        return read_png(str(files) % frame)


def silhouettes(codes: Array, near_far: tuple[float, float]) -> Array:
    """1 for each pixel beside which there is another surface, by the codes of depth, else 0."""
    near_m, far_m = near_far
    most = DIFFERENCE * (pf.BACKGROUND - 1) / max(math.log(far_m / near_m), 1e-9)
    found = np.zeros(codes.shape, int)
    # Beside each other, and with rows for columns below each other.
    for of, edges in ((codes.astype(int), found), (codes.astype(int).T, found.T)):
        first, second = of[:, :-1], of[:, 1:]
        background = (first == pf.BACKGROUND) | (second == pf.BACKGROUND)
        differ = np.where(background, first != second, np.abs(first - second) > most)
        edges[:, :-1] |= differ
        edges[:, 1:] |= differ
    return found


# ---- the choice of crops

@dataclasses.dataclass(frozen=True)
class Window:
    """A square of a face; `errors` are sums of squared differences of codes by method, and `edge` is its pixels at silhouettes."""

    face: str
    left: int
    top: int
    side: int
    errors: dict[str, int]
    edge: int

    def of(self, pixels: Array) -> Array:
        """The part of a picture that it shows."""
        return pixels[self.top:self.top + self.side, self.left:self.left + self.side]

    def overlaps(self, other: "Window") -> bool:
        return self.face == other.face and max(abs(self.left - other.left), abs(self.top - other.top)) < self.side

    def psnr_db(self, label: str) -> float:
        return images.psnr_db(self.errors[label], 3 * self.side**2)


def squares(a: Array, b: Array) -> Array:
    """The sum of squared differences of each pixel's codes."""
    return ((a.astype(int) - b)**2).sum(axis=2)


class Sums:
    """Sums of values of pixels over squares."""

    def __init__(self, values: Array):
        self.above_left = np.pad(values.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))

    def within(self, left: int, top: int, side: int) -> int:
        above, below = self.above_left[top], self.above_left[top + side]
        return int(below[left + side] - below[left] - above[left + side] + above[left])


def windows_of(face: str, errors: dict[str, Array], edges: Array | None) -> Iterator[Window]:
    """Windows of a face: `errors` are values of pixels by method, `edges` are its silhouettes or None where they are unknown."""
    height, width = next(iter(errors.values())).shape
    side = min(SIDE, width, height)
    sums = {label: Sums(values) for label, values in errors.items()}
    edge = None if edges is None else Sums(edges)
    for top, left in itertools.product(range(0, height - side + 1, STEP), range(0, width - side + 1, STEP)):
        square = left, top, side
        of_methods = {label: of.within(*square) for label, of in sums.items()}
        yield Window(face, *square, of_methods, edge.within(*square) if edge else side)


def choose(windows: list[Window], count: int) -> list[tuple[str, Window]]:
    """(method whose error is the largest there, window), in turn before and after. A silhouette crosses a window that has as
    many of its pixels as its side is long; where none is crossed, all windows take part."""
    crossed = [window for window in windows if window.edge >= window.side] or windows
    ranked = {label: sorted(crossed, key=lambda window: -window.errors[label]) for label in (BEFORE, AFTER)}
    chosen: list[tuple[str, Window]] = []
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

    pictures: dict[str, Array]
    psnr_db: dict[str, float | None]
    windows: list[Window]


def faces_of(pose: rq.Pose, truths: Truths) -> dict[str, Face]:
    """The images of the first frame of a pose, by the name of the face."""
    reported = {label: pose.reports[label]["reference"]["images"] for label in COMPARED}
    first = min(image["frame"] for image in reported[AFTER])
    found = {}
    for at, image in enumerate(reported[AFTER]):
        if image["frame"] != first:
            continue
        truth, edges = truths.of(pose.case, image)
        pictures = {"truth": truth}
        for label in COMPARED:
            path = pose.picture(label, image)
            pictures[label] = read_png(path)
            if pictures[label].shape != truth.shape:
                (high, wide, _), (height, width, _) = truth.shape, pictures[label].shape
                raise rq.Refused(f"{path}: {wide} x {high} pixels were expected, as the truth has, not {width} x {height}")
        errors = {label: squares(truth, pictures[label]) for label in COMPARED}
        psnr_db = {label: rq.number(reported[label][at]["psnr_db"]) for label in COMPARED}
        found[image["face"]] = Face(pictures, psnr_db, list(windows_of(image["face"], errors, edges)))
    return found


class Pictures:
    """Writes the pictures of an input into a folder beside the page, and returns the HTML that shows them."""

    def __init__(self, page: pathlib.Path, name: str):
        self.folder, self.name = page / name, name
        self.folder.mkdir(parents=True, exist_ok=True)

    def cell(self, place: tuple[str, str], what: str, rgb: Array, psnr_db: float | None) -> str:
        """An image and its PSNR: `place` is (start of the file's name, words)."""
        stem, words = place
        file = f"{stem}_{re.sub('[^a-z]+', '_', what).strip('_')}.png"
        images.write_png(self.folder / file, rgb)
        address, (height, width, _) = urllib.parse.quote(f"{self.name}/{file}"), rgb.shape
        alt = html.escape(f"{what}: {words}")
        shown = f'<img src="{address}" alt="{alt}" width="{width}" height="{height}" loading="lazy">'
        under = "" if psnr_db is None else rr.decibels(psnr_db) + (" dB" if math.isfinite(psnr_db) else "")
        return shown + under

    def crops(self, pose: rq.Pose, faces: dict[str, Face], chosen: list[tuple[str, Window]]) -> str:
        """A row for each crop."""
        lines = []
        for label, window in chosen:
            face = faces[window.face]
            draw = lambda of: images.enlarged(window.of(face.pictures[of]), SCALE)
            shown: dict[str, tuple[Array, float | None]] = {"truth": (draw("truth"), None)}
            shown |= {name: (draw(of), window.psnr_db(of)) for of, name in COMPARED.items()}
            stem = f"{pose.case.probe}_{window.face}_{window.left}_{window.top}"
            place = stem, f"crop of face {window.face} at column {window.left}, row {window.top}"
            first = f"{window.face}, {window.left}, {window.top}<br>worst of {COMPARED[label]}"
            lines.append([first, *(self.cell(place, what, *of) for what, of in shown.items())])
        return table(f"{pose.title}: crops", ["face, column, row", "truth", *COMPARED.values()], lines, "pictures")

    def whole(self, pose: rq.Pose, faces: dict[str, Face], chosen: list[tuple[str, Window]]) -> str:
        """A row for each face that crops are of."""
        compared = {COMPARED[of]: of for of in (BEFORE, AFTER)}
        lines = []
        for name, face in faces.items():
            windows = [window for _, window in chosen if window.face == name]
            if not windows:
                continue
            truth = face.pictures["truth"]
            shown: dict[str, tuple[Array, float | None]] = {"truth": (truth, None)}
            shown |= {method: (face.pictures[of], face.psnr_db[of]) for method, of in compared.items()}
            shown |= {f"error of {method}": (error_picture(truth, face.pictures[of], windows), None) for method, of in compared.items()}
            place = f"{pose.case.probe}_{name}", f"face {name}"
            times = max(1, WHOLE // truth.shape[1])
            lines.append([name, *(self.cell(place, what, images.enlarged(rgb, times), db) for what, (rgb, db) in shown.items())])
        return table(f"{pose.title}: whole pictures", ["face", "truth", *compared, *(f"error of {method}" for method in compared)], lines, "pictures")

    def of(self, pose: rq.Pose, truths: Truths) -> str:
        """Crops and whole pictures of a pose."""
        faces = faces_of(pose, truths)
        chosen = choose([window for face in faces.values() for window in face.windows], CROPS)
        title = f"<h4>{html.escape(pose.title)}</h4>"
        if not chosen:
            return f"{title}\n<p>All pictures are exact.</p>"
        return "\n".join([title, self.crops(pose, faces, chosen), self.whole(pose, faces, chosen)])


# ---- HTML

def paragraph(text: str) -> str:
    """A paragraph; `words` are code."""
    return "<p>" + re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(text)) + "</p>"


def table(title: str, head: Iterable[str], lines: Iterable[Sequence[str]], kind: str = "figures") -> str:
    """A table of cells that are HTML; the first of a line is its header."""
    name = html.escape(title)
    columns = "".join(f'<th scope="col">{html.escape(cell)}</th>' for cell in head)
    row = lambda first, *others: f'<tr><th scope="row">{first}</th>' + "".join(f"<td>{cell}</td>" for cell in others) + "</tr>"
    rows = "\n".join(row(*line) for line in lines)
    return (f'<div class="scroll" role="region" aria-label="{name}" tabindex="0">\n<table class="{kind}">\n'
            f"<caption>{name}</caption>\n<thead><tr>{columns}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table>\n</div>")


def section(page: pathlib.Path, report: rr.Report, poses: list[rq.Pose], truths: Truths) -> str:
    """The part of a page about one input; its pictures are written beside the page."""
    pictures = Pictures(page, report.name)
    escaped = lambda lines: [[html.escape(str(cell)) for cell in line] for line in lines]
    figures = [table(title, head, escaped(lines)) for title, head, lines in report.tables]
    charts = [f'<figure role="img" aria-label="{html.escape(title)}">\n{drawn}</figure>' for _, title, drawn in report.charts]
    parts = [f"<section>\n<h2>{html.escape(report.name)}</h2>", paragraph(f"`{report.command}`"), "<h3>Pictures</h3>"]
    parts += [pictures.of(pose, truths) for pose in poses]
    return "\n".join([*parts, "<h3>Figures</h3>", *map(paragraph, report.about), *figures, *charts, "</section>"])


def write(page: pathlib.Path, sections: list[str]) -> None:
    """index.html, without scripts and without anything from a network."""
    title = "Pictures rendered from light fields, before and after"
    parts = ['<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
             '<meta name="viewport" content="width=device-width, initial-scale=1">',
             f"<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>", paragraph(ABOUT)]
    (page / "index.html").write_text("\n".join([*parts, *sections, "</main>\n</body>\n</html>\n"]), encoding="utf-8")
