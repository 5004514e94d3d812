"""Reports of scripts/reconstruction-quality: tables as Markdown and CSV, and charts as SVG."""

import csv
import dataclasses
import io
import math
import pathlib
import xml.sax.saxutils
from typing import Any

import lightfold_runs as lf
from reconstruction_quality import Row

# (title, head, lines of cells)
Table = tuple[str, list[str], list[list[Any]]]

TITLES = {
    "left out": "A probe that is left out, rendered from the others",
    "midway": "Midway between probes",
    "at a probe": "From where a probe stands that takes part",
    "free poses": "Six poses between the probes, off the straight ways between them",
    "by pose": "By pose on the way from one probe to another (0 and 1 are probes; CALF figure 11)",
    "by views": "By the number of active views (CALF figure 9)",
    "effects": "With and without effects, inside mirrors and glass (CALF figure 12)",
}
PLACES = {
    "left out": "probe", "midway": "probes", "at a probe": "probe", "free poses": "pose", "by pose": "way", "by views": "views",
    "effects": "place",
}
# Tables that show the error near silhouettes of probes over that elsewhere.
WITH_GHOSTS = ("left out", "midway", "free poses")
COLORS = {"points": "#b25d00", "ceiling": "#767676", "paper": "#a02060", "ours": "#0067b1", "ours, without effects": "#8a4fae"}
OTHER_COLORS = ("#0067b1", "#b25d00", "#8a4fae", "#767676")
DASHES = {"points": "2 3", "ceiling": "8 4", "paper": "6 2", "ours": "", "ours, without effects": "10 3 2 3"}

ABOUT = (
    "PSNR is of 8-bit codes, the mean over images that are not exact, and inside mirrors or glass that of all their "
    "pixels together; holes count as black. Points: every texel drawn as a point of one pixel. Paper: the algorithm of "
    "CALF, `--method calf`. Ceiling: true distances instead of marching, one point of each pixel, the weights of the "
    "paper; marching can be better all the same, in mirrors and glass, and where few views know a surface. Ghosts: RMS "
    "error within 3 pixels of projected silhouettes of probes, over that of all other pixels.")


def decibels(value: float | None) -> str:
    return "" if value is None else "exact" if math.isinf(value) else f"{value:.2f}"


def place_in_words(place: Any, line: str | None = None) -> str:
    text = f"{place:.3f}" if isinstance(place, float) else str(place)
    return f"{line}, {text}" if line else text


def tables(rows: list[Row]) -> list[Table]:
    """Each table that has rows."""
    found: list[Table] = []
    for name, title in TITLES.items():
        of_table = [row for row in rows if row.table == name]
        if not of_table:
            continue
        if name == "effects":
            head = ["place", "method", "all dB", "mirrors dB", "glass dB"]
            lines: list[list[Any]] = [[row.place, row.method, decibels(row.psnr_db), decibels(row.psnr_db_mirrors),
                                       decibels(row.psnr_db_glass)] for row in of_table]
        else:
            head, lines = by_place(name, of_table)
        found.append((title, head, lines))
    return found


def by_place(name: str, rows: list[Row]) -> tuple[list[str], list[list[Any]]]:
    """Head and lines of a table with all methods side by side."""
    methods = list(dict.fromkeys(row.method for row in rows))
    cell = {((row.place, row.line), row.method): row for row in rows}
    shown = lambda value, form: "" if value is None else format(value, form)
    columns = [("dB", lambda row: decibels(row.psnr_db)), ("SSIM", lambda row: shown(row.ssim, ".4f")),
               ("holes %", lambda row: shown(row.hole_percent, ".2f"))]
    if name in WITH_GHOSTS and any(row.ghost_ratio is not None for row in rows):
        columns.append(("ghosts", lambda row: shown(row.ghost_ratio, ".2f")))
    head = [PLACES[name], *(f"{method} {measure}" for measure, _ in columns for method in methods)]
    places = dict.fromkeys((row.place, row.line) for row in rows)
    lines = [[place_in_words(*place), *(show(cell[place, method]) for _, show in columns for method in methods)] for place in places]
    return head, lines


def to_csv(rows: list[Row]) -> str:
    """All figures, a line for each row."""
    text = io.StringIO()
    names = list(dataclasses.asdict(rows[0])) if rows else []
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if value is None else value for name, value in dataclasses.asdict(row).items()})
    return text.getvalue()


def mean_over_lines(rows: list[Row], field: str) -> list[tuple[float, str, float]]:
    """(place, method, value) of a chart: where poses lie on several lines, their mean by part of the way."""
    found: dict[tuple[float, str], list[float]] = {}
    for row in rows:
        value = getattr(row, field)
        if value is not None and math.isfinite(value):
            found.setdefault((row.place, row.method), []).append(value)
    return [(place, method, sum(values) / len(values)) for (place, method), values in found.items()]


def ticks(least: float, most: float, about: int = 6) -> list[float]:
    """Round numbers between two, both of which lie within."""
    step: float = 10 ** math.floor(math.log10(max(most - least, 1e-9) / about))
    step *= next(factor for factor in (1, 2, 5, 10) if (most - least) / (step * factor) <= about)
    first, last = math.floor(least / step), math.ceil(most / step)
    return [at * step for at in range(first, max(last, first + 1) + 1)]


# Size and margins of a chart, in pixels.
WIDE, HIGH, LEFT, RIGHT, TOP, BOTTOM = 760, 460, 64, 150, 40, 52


def text(x: float, y: float, words: str, more: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}"{more}>{xml.sax.saxutils.escape(words)}</text>'


@dataclasses.dataclass
class Axes:
    """Ticks of a chart, from the first to the last place and beyond all values."""

    places: list[float]
    up: list[float]

    def x(self, place: float) -> float:
        return LEFT + (WIDE - LEFT - RIGHT) * (place - self.places[0]) / (self.places[-1] - self.places[0])

    def y(self, value: float) -> float:
        return HIGH - BOTTOM - (HIGH - TOP - BOTTOM) * (value - self.up[0]) / (self.up[-1] - self.up[0])

    def grid(self) -> list[str]:
        # There is no half of a view.
        whole = all(float(place).is_integer() for place in self.places)
        across = [at for at in ticks(self.places[0], self.places[-1])
                  if self.places[0] <= at <= self.places[-1] and (float(at).is_integer() or not whole)]
        parts = []
        for at in self.up:
            y = self.y(at)
            parts.append(f'<line x1="{LEFT}" x2="{WIDE - RIGHT}" y1="{y:.1f}" y2="{y:.1f}" stroke="#d9d9d9"/>')
            parts.append(text(LEFT - 8, y + 4, f"{at:g}", ' text-anchor="end"'))
        return parts + [text(self.x(at), HIGH - BOTTOM + 18, f"{at:g}", ' text-anchor="middle"') for at in across or self.places]

    def curve(self, at: int, method: str, points: list[tuple[float, float]]) -> list[str]:
        """The line of a method and its name in the legend, where it is number `at`."""
        color, dash = COLORS.get(method, OTHER_COLORS[at % len(OTHER_COLORS)]), DASHES.get(method, "")
        stroke = f'stroke="{color}" stroke-width="2" stroke-dasharray="{dash}"/>'
        way = " ".join(f"{self.x(place):.1f},{self.y(value):.1f}" for place, value in points)
        circles = [f'<circle cx="{self.x(place):.1f}" cy="{self.y(value):.1f}" r="3" fill="{color}"/>' for place, value in points]
        y = TOP + 18 * at + 8
        return [f'<polyline points="{way}" fill="none" {stroke}', *circles,
                f'<line x1="{WIDE - RIGHT + 12}" x2="{WIDE - RIGHT + 42}" y1="{y}" y2="{y}" {stroke}',
                text(WIDE - RIGHT + 48, y + 4, method)]


def chart(title: str, label: str, rows: list[Row], measure: tuple[str, str] = ("psnr_db", "PSNR (dB)")) -> str | None:
    """A measure (a field and its name) of each method by place, as the text of an SVG file; none where there are fewer than two
    places."""
    field, name = measure
    spots = mean_over_lines(rows, field)
    places = sorted({place for place, _, _ in spots})
    if len(places) < 2:
        return None
    axes = Axes(places, ticks(min(value for _, _, value in spots), max(value for _, _, value in spots)))
    middle = (TOP + HIGH - BOTTOM) / 2
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDE}" height="{HIGH}" viewBox="0 0 {WIDE} {HIGH}" '
        'font-family="DejaVu Sans, sans-serif" font-size="12">',
        f'<rect width="{WIDE}" height="{HIGH}" fill="white"/>',
        text(LEFT, 24, title, ' font-size="14"'),
        *axes.grid(),
        text((LEFT + WIDE - RIGHT) / 2, HIGH - 12, label, ' text-anchor="middle"'),
        text(14, middle, name, f' text-anchor="middle" transform="rotate(-90 14 {middle:.1f})"'),
    ]
    for at, method in enumerate(dict.fromkeys(of for _, of, _ in spots)):
        parts += axes.curve(at, method, sorted((place, value) for place, of, value in spots if of == method))
    return "\n".join([*parts, "</svg>", ""])


def of_lines(rows: list[Row]) -> list[str]:
    """A paragraph about the poses of a dataset; none for a scene."""
    if any(row.line for row in rows):
        return ["Poses are probes that lie on the straight way between two others, as the truth is known at probes only. Those "
                "between the two take no part in the pictures of their way; the two themselves do. A chart has the mean of "
                "several ways."]
    if any(row.table == "left out" for row in rows):
        return ["No probe lies on the straight way between two others, so that there are no figures by pose."]
    return []


@dataclasses.dataclass
class Report:
    """Contents of the report of an input, as Markdown and on a page."""

    name: str
    command: str
    rows: list[Row]
    # Paragraphs; `words` are code.
    about: list[str]
    tables: list[Table]
    # (file, title, text of an SVG)
    charts: list[tuple[str, str, str]]


def report_of(name: str, rows: list[Row], command: str) -> Report:
    charts = []
    for table, file, label in (("by views", "by_views.svg", "active views"), ("by pose", "by_pose.svg", "way between two probes")):
        title = f"{name}: PSNR by {label}"
        drawn = chart(title, label, [row for row in rows if row.table == table])
        if drawn:
            charts.append((file, title, drawn))
    return Report(name, command, rows, [ABOUT, *of_lines(rows)], tables(rows), charts)


def write(folder: pathlib.Path, report: Report) -> str:
    """Writes report.md, figures.csv and charts; returns the Markdown."""
    for file, _, drawn in report.charts:
        (folder / file).write_text(drawn)
    (folder / "figures.csv").write_text(to_csv(report.rows))
    sections = [f"## {title}\n\n{lf.table(head, lines)}\n" for title, head, lines in report.tables]
    about = " ".join([*report.about, "Pictures are in pictures/, and where their errors lie in errors/.\n"])
    shown = "".join(f"![{title}]({file})\n" for file, title, _ in report.charts)
    page = "\n".join([f"# {report.name}\n", f"`{report.command}`\n", about, *sections, shown])
    (folder / "report.md").write_text(page)
    return page
