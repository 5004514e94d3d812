"""How scripts/reconstruction-quality shows what it measured: tables as Markdown and CSV, and charts as SVG."""

import csv
import dataclasses
import io
import math
import xml.sax.saxutils

import lightfold_runs as lf

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


def decibels(value):
    return "" if value is None else "exact" if math.isinf(value) else f"{value:.2f}"


def place_in_words(place, line=None):
    text = f"{place:.3f}" if isinstance(place, float) else str(place)
    return f"{line}, {text}" if line else text


def tables(rows):
    """(title, head, lines of cells) of each table that has rows."""
    found = []
    for name, title in TITLES.items():
        of_table = [row for row in rows if row.table == name]
        if not of_table:
            continue
        methods = list(dict.fromkeys(row.method for row in of_table))
        places = list(dict.fromkeys((row.place, row.line) for row in of_table))
        cell = {((row.place, row.line), row.method): row for row in of_table}
        if name == "effects":
            head = ["place", "method", "all dB", "mirrors dB", "glass dB"]
            lines = [[row.place, row.method, decibels(row.psnr_db), decibels(row.psnr_db_mirrors),
                      decibels(row.psnr_db_glass)] for row in of_table]
        else:
            head = [PLACES[name], *(f"{method} dB" for method in methods), *(f"{method} SSIM" for method in methods),
                    *(f"{method} holes %" for method in methods)]
            with_ghosts = name in WITH_GHOSTS and any(row.ghost_ratio is not None for row in of_table)
            head += [f"{method} ghosts" for method in methods if with_ghosts]
            ghosts = lambda row: "" if row.ghost_ratio is None else f"{row.ghost_ratio:.2f}"
            ssim = lambda row: "" if row.ssim is None else f"{row.ssim:.4f}"
            lines = [
                [place_in_words(*place), *(decibels(cell[place, method].psnr_db) for method in methods),
                 *(ssim(cell[place, method]) for method in methods),
                 *(f"{cell[place, method].hole_percent:.2f}" for method in methods),
                 *(ghosts(cell[place, method]) for method in methods if with_ghosts)]
                for place in places
            ]
        found.append((title, head, lines))
    return found


def to_csv(rows):
    """All figures, a line for each row."""
    text = io.StringIO()
    names = list(dataclasses.asdict(rows[0])) if rows else []
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: "" if value is None else value for name, value in dataclasses.asdict(row).items()})
    return text.getvalue()


def mean_over_lines(rows, field):
    """(place, method, value) of a chart: where poses lie on several lines, their mean by part of the way."""
    found = {}
    for row in rows:
        value = getattr(row, field)
        if value is not None and math.isfinite(value):
            found.setdefault((row.place, row.method), []).append(value)
    return [(place, method, sum(values) / len(values)) for (place, method), values in found.items()]


def ticks(least, most, about=6):
    """Round numbers between two, both of which lie within."""
    step = 10 ** math.floor(math.log10(max(most - least, 1e-9) / about))
    step *= next(factor for factor in (1, 2, 5, 10) if (most - least) / (step * factor) <= about)
    first, last = math.floor(least / step), math.ceil(most / step)
    return [at * step for at in range(first, max(last, first + 1) + 1)]


def chart(title, label, rows, measure=("psnr_db", "PSNR (dB)")):
    """A measure (a field and its name) of each method by place, as the text of an SVG file; none where there are fewer than two
    places."""
    field, name = measure
    spots = mean_over_lines(rows, field)
    places = sorted({place for place, _, _ in spots})
    if len(places) < 2:
        return None
    wide, high, left, right, top, bottom = 760, 460, 64, 150, 40, 52
    across = ticks(places[0], places[-1])
    # There is no half of a view.
    whole = all(float(place).is_integer() for place in places)
    across = [at for at in across if places[0] <= at <= places[-1] and (float(at).is_integer() or not whole)] or places
    up = ticks(min(value for _, _, value in spots), max(value for _, _, value in spots))
    x = lambda at: left + (wide - left - right) * (at - places[0]) / (places[-1] - places[0])
    y = lambda at: high - bottom - (high - top - bottom) * (at - up[0]) / (up[-1] - up[0])
    escape = xml.sax.saxutils.escape
    text = lambda at_x, at_y, words, more="": f'<text x="{at_x:.1f}" y="{at_y:.1f}"{more}>{escape(words)}</text>'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{high}" viewBox="0 0 {wide} {high}" '
        'font-family="DejaVu Sans, sans-serif" font-size="12">',
        f'<rect width="{wide}" height="{high}" fill="white"/>',
        text(left, 24, title, ' font-size="14"'),
    ]
    for at in up:
        parts.append(f'<line x1="{left}" x2="{wide - right}" y1="{y(at):.1f}" y2="{y(at):.1f}" stroke="#d9d9d9"/>')
        parts.append(text(left - 8, y(at) + 4, f"{at:g}", ' text-anchor="end"'))
    for at in across:
        parts.append(text(x(at), high - bottom + 18, f"{at:g}", ' text-anchor="middle"'))
    parts.append(text((left + wide - right) / 2, high - 12, label, ' text-anchor="middle"'))
    parts.append(text(14, (top + high - bottom) / 2, name,
                      f' text-anchor="middle" transform="rotate(-90 14 {(top + high - bottom) / 2:.1f})"'))
    for at, method in enumerate(dict.fromkeys(of for _, of, _ in spots)):
        points = sorted((place, value) for place, of, value in spots if of == method)
        color, dash = COLORS.get(method, OTHER_COLORS[at % len(OTHER_COLORS)]), DASHES.get(method, "")
        way = " ".join(f"{x(place):.1f},{y(value):.1f}" for place, value in points)
        parts.append(f'<polyline points="{way}" fill="none" stroke="{color}" stroke-width="2" stroke-dasharray="{dash}"/>')
        parts += [f'<circle cx="{x(place):.1f}" cy="{y(value):.1f}" r="3" fill="{color}"/>' for place, value in points]
        beside = top + 18 * at + 8
        parts.append(f'<line x1="{wide - right + 12}" x2="{wide - right + 42}" y1="{beside}" y2="{beside}" '
                     f'stroke="{color}" stroke-width="2" stroke-dasharray="{dash}"/>')
        parts.append(text(wide - right + 48, beside + 4, method))
    return "\n".join([*parts, "</svg>", ""])


def of_lines(rows):
    """What poses of a dataset are, in a paragraph; nothing is said of a scene."""
    if any(row.line for row in rows):
        return ["Poses are probes that lie on the straight way between two others, as the truth is known at probes only. Those "
                "between the two take no part in the pictures of their way; the two themselves do. A chart has the mean of "
                "several ways."]
    if any(row.table == "left out" for row in rows):
        return ["No probe lies on the straight way between two others, so that there are no figures by pose."]
    return []


@dataclasses.dataclass
class Report:
    """What is shown of an input, as Markdown and on a page."""

    name: str
    command: str
    rows: list
    # Paragraphs; `words` are code.
    about: list
    # (title, head, lines of cells)
    tables: list
    # (file, title, text of an SVG)
    charts: list


def report_of(name, rows, command):
    charts = []
    for table, file, label in (("by views", "by_views.svg", "active views"), ("by pose", "by_pose.svg", "way between two probes")):
        title = f"{name}: PSNR by {label}"
        drawn = chart(title, label, [row for row in rows if row.table == table])
        if drawn:
            charts.append((file, title, drawn))
    return Report(name, command, rows, [ABOUT, *of_lines(rows)], tables(rows), charts)


def write(folder, report):
    """report.md, figures.csv and charts; answers the Markdown."""
    for file, _, drawn in report.charts:
        (folder / file).write_text(drawn)
    (folder / "figures.csv").write_text(to_csv(report.rows))
    sections = [f"## {title}\n\n{lf.table(head, lines)}\n" for title, head, lines in report.tables]
    about = " ".join([*report.about, "Pictures are in pictures/, and where their errors lie in errors/.\n"])
    shown = "".join(f"![{title}]({file})\n" for file, title, _ in report.charts)
    text = "\n".join([f"# {report.name}\n", f"`{report.command}`\n", about, *sections, shown])
    (folder / "report.md").write_text(text)
    return text
