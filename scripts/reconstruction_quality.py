"""Measurements of scripts/reconstruction-quality: pictures rendered where the truth is known, by several methods."""

import dataclasses
import itertools
import json
import math
import pathlib
from typing import Any, Iterable, Sequence

import lightfold_runs as lf

Position = tuple[float, ...]
Probe = tuple[str, Position]
# The middle, and how far from it along each axis, in metres.
Region = tuple[Position, Position]
METHODS = [("splat", "points"), ("reproject", "ceiling"), ("calf", "paper"), ("march", "ours")]
# Probes of a dataset or scene that are rendered from their own positions.
MAX_OWN = 9
# Where probes of scenes that come with the program, or with the data, stand: the middle, and how far from it, in metres.
REGIONS: dict[str, Region] = {
    "courtyard": ((0.0, 1.5, 0.0), (0.3, 0.2, 0.3)),
    "interior": ((0.0, 1.5, 0.3), (0.3, 0.2, 0.3)),
    "mirrors": ((0.0, 1.6, 1.1), (0.3, 0.15, 0.2)),
    "cornell": ((0.0, 1.3, 0.75), (0.3, 0.15, 0.15)),
    "fence": ((0.0, 1.5, 0.0), (0.4, 0.2, 0.4)),
    "object": ((0.0, 0.2, 1.4), (0.5, 0.3, 0.2)),
    "sponza.glb": ((-0.6, 1.7, -0.4), (0.5, 0.5, 0.5)),
}
# Scenes with mirrors or glass.
SCENES_WITH_MIRRORS = ("mirrors",)
# Glass reflects a few parts of a hundred of lamps that 8 bits store as white.
KEEP_LAMPS = ["--hdr"]


# Largest distance from the straight line between two probes at which another lies on it, in parts of its length.
BESIDE = 0.01
# Lines of a dataset that are measured.
MAX_LINES = 4


class Refused(SystemExit):
    """Input that cannot be measured."""


@dataclasses.dataclass(frozen=True)
class Case:
    """A container, and the images of one probe that pictures are compared with."""

    container: pathlib.Path
    reference: pathlib.Path
    probe: str
    # Probes of the container that do not take part.
    without: tuple[str, ...] = ()
    frames: str = "0"


@dataclasses.dataclass
class Row:
    """Figures of one method in one place of one table."""

    table: str
    place: Any
    method: str
    psnr_db: float
    ssim: float | None
    hole_percent: float | None
    psnr_db_mirrors: float | None = None
    psnr_db_glass: float | None = None
    render_ms: float | None = None
    # Error near silhouettes of probes over that elsewhere.
    ghost_ratio: float | None = None
    # The two probes that a pose lies between.
    line: str | None = None


def number(value: Any) -> float | None:
    """A number of a report, if there is one."""
    return None if value is None else float(value)


def mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def mean_psnr(values: Iterable[float]) -> float:
    """Mean over images, as papers have it, without those that are exact; infinite where all are."""
    return mean(value for value in values if math.isfinite(value)) or math.inf


def row_of(table: str, place: Any, method: str, report: dict[str, Any]) -> Row:
    """The figures of a report of `render`."""
    reference = report["reference"]
    images = reference["images"]
    return Row(
        table, place, method,
        mean_psnr(float(image["psnr_db"]) for image in images),
        mean(number(image["ssim"]) for image in images),
        mean(number(image["hole_percent"]) for image in images),
        number(reference.get("psnr_db_mirrors")),
        number(reference.get("psnr_db_glass")),
        number(report.get("pacing", {}).get("render_ms", {}).get("mean_ms")),
        number(reference.get("ghost_ratio")),
    )


@dataclasses.dataclass(frozen=True)
class Pose:
    """A case whose pictures are kept in files, and what `render` reported of each method."""

    title: str
    case: Case
    reports: dict[str, Any]
    folder: pathlib.Path

    def picture(self, label: str, image: dict[str, Any]) -> pathlib.Path:
        """The file of an image that is in a report."""
        return pictures_of(self.folder, self.case, label) / f"{image['probe']}_{image['face']}.{image['frame']:04}.png"


def pictures_of(folder: pathlib.Path, case: Case, label: str) -> pathlib.Path:
    return folder / "pictures" / f"{case.probe}_{label}"


class Renderer:
    """Runs `lightfold render` on cases, each once; `options` are given to all of them."""

    def __init__(self, binary: lf.Binary, options: list[str]):
        self.binary, self.options = binary, options
        self.known: dict[Any, Any] = {}
        self.poses: list[Pose] = []

    def report(self, case: Case, method: str, *more: Any, out: Sequence[Any] = ("--null",)) -> Any:
        """The report of `render`; pictures go to `out` if this is the first time that it is asked for."""
        words: list[Any] = [self.binary, "render", case.container, "--reference", case.reference, "--reference-probe", case.probe]
        if case.without:
            words += ["--exclude-probe", ",".join(case.without)]
        words += ["--frames", case.frames, "--method", method, "--stats", "--json", *self.options, *more]
        if (case, method, more) not in self.known:
            self.known[case, method, more] = lf.run_json(*words, *out)
        return self.known[case, method, more]

    def draw(self, title: str, case: Case, folder: pathlib.Path) -> None:
        """Keeps pictures and error maps of a pose, before its rows are asked for."""
        reports = {}
        for method, label in METHODS:
            out = ["-o", pictures_of(folder, case, label), "--error-map", folder / "errors" / f"{case.probe}_{label}"]
            reports[label] = self.report(case, method, out=out)
        self.poses.append(Pose(title, case, reports, folder))

    def rows(self, table: str, place: Any, case: Case, *more: Any) -> list[Row]:
        """A row for each method."""
        return [row_of(table, place, label, self.report(case, method, *more)) for method, label in METHODS]


def counts_of_views(probes: int) -> list[int]:
    """Numbers of active views: all of few, and fewer and fewer of many."""
    steps = itertools.chain(range(1, 9), (12, 16, 24, 32, 48, 64))
    return [count for count in steps if count < probes] + [probes]


def probes_of(manifest: str | pathlib.Path) -> list[Probe]:
    """(name, position) of the probes of a dataset."""
    path = lf.manifest_path(manifest)
    try:
        probes = json.loads(path.read_text())["probes"]
        return [(probe["name"], tuple(probe["position"])) for probe in probes]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise Refused(f"{path}: this is no lightfield.json: {error}") from error


def held_out(probes: Sequence[Probe], wanted: list[str]) -> list[str]:
    """Names of the probes that are left out in turn: those that are wanted, all of up to four, else the most central."""
    names = [name for name, _ in probes]
    for name in wanted:
        if name not in names:
            raise Refused(f"there is no probe {name}; there are {', '.join(names)}")
    if wanted or len(names) <= 4:
        return wanted or names
    return [most_central(probes)]


def most_central(probes: Sequence[Probe]) -> str:
    """The name of the probe that is nearest to the middle of all."""
    middle = [sum(position[axis] for _, position in probes) / len(probes) for axis in range(3)]
    return min(probes, key=lambda probe: math.dist(probe[1], middle))[0]


@dataclasses.dataclass(frozen=True)
class Line:
    """Probes of a dataset that lie between two others, on the straight way from one to the other."""

    first: str
    last: str
    # (part of the way, name), from the first to the last.
    between: tuple[tuple[float, str], ...]

    def name(self) -> str:
        return f"{self.first} to {self.last}"


def lines_of(probes: Sequence[Probe], most: int = MAX_LINES) -> list[Line]:
    """Lines with the most probes between their ends, then the longest; a part of a longer line is none of its own."""
    found = []
    for (first, start), (last, end) in itertools.combinations(probes, 2):
        length = math.dist(start, end)
        between = []
        for name, position in probes:
            if name in (first, last) or length == 0:
                continue
            part = sum((at - a) * (b - a) for at, a, b in zip(position, start, end)) / length**2
            beside = math.dist(position, [a + part * (b - a) for a, b in zip(start, end)])
            if 0 < part < 1 and beside <= BESIDE * length:
                between.append((round(part, 6), name))
        if between:
            found.append((len(between), length, Line(first, last, tuple(sorted(between)))))
    found.sort(key=lambda entry: entry[:2], reverse=True)
    chosen: list[Line] = []
    for _, _, line in found:
        on = lambda other: {other.first, other.last, *(name for _, name in other.between)}
        if not any(on(line) <= on(other) for other in chosen):
            chosen.append(line)
    return chosen[:most]


def corners(region: Region) -> list[Position]:
    """Eight positions around the middle of a region."""
    middle, reach = region
    signs = itertools.product((-1, 1), repeat=3)
    return [tuple(at + sign * far for at, sign, far in zip(middle, corner, reach)) for corner in signs]


def line(start: Position, end: Position, poses: int) -> list[tuple[float, Position]]:
    """(part of the way, position) of poses from one point to another, both included."""
    parts = [at / (poses - 1) for at in range(poses)]
    return [(part, tuple(a + part * (b - a) for a, b in zip(start, end))) for part in parts]


def write_cameras(path: pathlib.Path, named: Iterable[Probe]) -> None:
    """A file of cameras of (name, position)."""
    cameras = [{"name": name, "position": list(position)} for name, position in named]
    path.write_text(json.dumps({"lightfold_cameras": 1, "cameras": cameras}))


@dataclasses.dataclass
class Dataset:
    """A dataset to measure: probes to leave out, or none to choose them, and frames."""

    manifest: pathlib.Path
    wanted: list[str]
    frames: str = "0"


def measure_dataset(renderer: Renderer, dataset: Dataset, work: pathlib.Path) -> list[Row]:
    """Leaves one probe out at a time."""
    manifest, frames = dataset.manifest, dataset.frames
    probes = probes_of(manifest)
    if len(probes) < 2:
        raise Refused(f"{manifest}: it has one probe; one to leave out and one to render from were expected")
    left_out = held_out(probes, dataset.wanted)
    container = work / "field.lfold"
    lamps = KEEP_LAMPS if "material" in json.loads(lf.manifest_path(manifest).read_text()) else ["--clip"]
    lf.run_json(renderer.binary, "encode", manifest, "--frames", frames, *lamps, "-o", container, "--json")
    rows = []
    for probe in left_out:
        case = Case(container, manifest, probe, (probe,), frames)
        renderer.draw(f"Probe {probe}, left out", case, work)
        of_probe = renderer.rows("left out", probe, case)
        rows += of_probe + with_and_without_effects(renderer, probe, case, of_probe)
    everywhere = Case(container, manifest, left_out[0], frames=frames)
    rows += by_views(renderer, dataclasses.replace(everywhere, without=(left_out[0],)), len(probes) - 1)
    rows += at_probes(renderer, everywhere, [name for name, _ in probes])
    for line in lines_of(probes):
        rows += along(renderer, everywhere, line)
    return rows


def at_probes(renderer: Renderer, case: Case, names: list[str]) -> list[Row]:
    """Rows of pictures from where probes stand, all of which take part: a picture becomes what the probe recorded."""
    return [row for name in names[:MAX_OWN] for row in renderer.rows("at a probe", name, dataclasses.replace(case, probe=name))]


def free_positions(region: Region) -> list[Position]:
    """Six positions within a region, off the straight ways between its corners."""
    middle, reach = region
    parts = itertools.permutations((-0.6, 0.2, 0.7))
    return [tuple(at + part * far for at, part, far in zip(middle, three, reach)) for three in parts]


def along(renderer: Renderer, case: Case, line: Line) -> list[Row]:
    """Rows by pose on a line of a dataset (CALF figure 11). The truth is known at probes only: those between the ends are
    poses and take no part in any picture; the ends take part, as they do where a scene is captured for this."""
    without = tuple(name for _, name in line.between)
    rows = []
    for part, name in ((0.0, line.first), *line.between, (1.0, line.last)):
        rows += renderer.rows("by pose", part, dataclasses.replace(case, probe=name, without=without))
    return [dataclasses.replace(row, line=line.name()) for row in rows]


def shown_of_scene(named: dict[str, float], free: list[str]) -> list[tuple[str, str, str]]:
    """(title, folder of the reference, name) of the poses of a scene whose pictures are kept; `named` are those on the way."""
    near, middle = list(named)[1], list(named)[len(named) // 2]
    return [
        ("Probe 00, which takes part", "probes", "00"),
        (f"Near probe 00, at {named[near]:g} of the way", "poses", near),
        ("Midway between probes", "poses", middle),
        *((f"{name}, off the straight ways", "poses", name) for name in (free[0], free[-1])),
    ]


@dataclasses.dataclass
class Scene:
    """A scene to measure: where probes stand, the side of a face, samples of a pixel, and poses on the way between two probes."""

    name: str
    region: Region
    size: int
    samples: int
    poses: int


def capture_scene(binary: lf.Binary, scene: Scene, cameras: dict[str, Iterable[Probe]], work: pathlib.Path) -> None:
    """Captures datasets of cameras by their names."""
    options = ["--frames", "0", "--size", scene.size, "--samples", scene.samples, "--aov", "depth,material"]
    for name, probes in cameras.items():
        file = work / f"{name}.json"
        write_cameras(file, probes)
        lf.run_json(binary, "capture", scene.name, "--cameras", file, *options, "-o", work / name, "--json")


def measure_scene(renderer: Renderer, scene: Scene, work: pathlib.Path) -> list[Row]:
    """Captures a scene from eight corners and from poses on the way between two of them."""
    around = {f"{at:02}": position for at, position in enumerate(corners(scene.region))}
    poses = line(around["00"], around["07"], scene.poses)
    named = {f"pose_{at:02}": part for at, (part, _) in enumerate(poses)}
    free = {f"free_{at}": position for at, position in enumerate(free_positions(scene.region))}
    positions = [*zip(named, (position for _, position in poses)), *free.items()]
    capture_scene(renderer.binary, scene, {"probes": around.items(), "poses": positions}, work)
    container = work / "field.lfold"
    lamps = KEEP_LAMPS if scene.name in SCENES_WITH_MIRRORS else ["--clip"]
    lf.run_json(renderer.binary, "encode", work / "probes", *lamps, "-o", container, "--json")
    rows = []
    for title, reference, name in shown_of_scene(named, list(free)):
        renderer.draw(title, Case(container, work / reference, name), work)
    for name, part in named.items():
        rows += renderer.rows("by pose", part, Case(container, work / "poses", name))
    for name in free:
        rows += renderer.rows("free poses", name, Case(container, work / "poses", name))
    rows += at_probes(renderer, Case(container, work / "probes", ""), list(around))
    middle = Case(container, work / "poses", list(named)[scene.poses // 2])
    both = renderer.rows("midway", "all", middle)
    rows += both + with_and_without_effects(renderer, "midway", middle, both)
    return rows + by_views(renderer, middle, len(around))


def by_views(renderer: Renderer, case: Case, probes: int) -> list[Row]:
    """Rows by the number of active views, the nearest first (CALF figure 9)."""
    return [row for count in counts_of_views(probes) for row in renderer.rows("by views", count, case, "--views", count)]


def with_and_without_effects(renderer: Renderer, place: str, case: Case, known: list[Row]) -> list[Row]:
    """Rows with mirrors and glass, and with views blended there (CALF figure 12); none where there are neither.

    `known` are the rows of the case with effects, one for each method.
    """
    if all(row.psnr_db_mirrors is None and row.psnr_db_glass is None for row in known):
        return []
    blended = renderer.report(case, "march", "--effects", "none")
    rows = [dataclasses.replace(row, table="effects", place=place) for row in known]
    return rows + [row_of("effects", place, "ours, without effects", blended)]
