"""Measurements of scripts/simplify-quality: simplified scenes beside other ways to the same images, which were held out."""

import dataclasses
import json
import pathlib
import shutil
import subprocess
from typing import Any, Callable

import lightfold_runs as lf
import reconstruction_quality as rq

FAST, UNIFORM = ["--effort", "fast"], ["--tiling", "uniform"]
# Options of `simplify` whose scenes stand beside the one by default settings.
VARIANTS = [FAST, UNIFORM, ["--energy", "paper"], ["--energy", "paper", "--tiling", "uniform"]]
METHODS = ("reproject", "march", "splat")
# What npx gets where there is no program of that name.
GLTFPACK = "gltfpack@1.3.0"
# Projections of a manifest as options of `capture` name them.
PROJECTIONS = {"cubemap": "cube"}


@dataclasses.dataclass(frozen=True)
class Given:
    """A set: what is simplified, the dataset that is held out where it is another, and the mesh from which both were captured."""

    name: str
    path: pathlib.Path
    held_out: pathlib.Path | None = None
    mesh: pathlib.Path | None = None


@dataclasses.dataclass
class Row:
    """A way to the images that were held out."""

    way: str
    # What `diff` reports of colour; none where there are no pictures, for a reason.
    found: dict[str, Any] | None = None
    bytes: int | None = None
    triangles: int | None = None
    peak_overdraw: float | None = None
    reason: str = ""


@dataclasses.dataclass
class Measured:
    """A set: the report of `simplify` by default settings, and all ways, which is the first."""

    name: str
    simplified: dict[str, Any]
    rows: list[Row]


def way_of(options: list[str]) -> str:
    return " ".join(["simplify", *options])


def split(manifest: pathlib.Path, work: pathlib.Path) -> tuple[pathlib.Path, pathlib.Path]:
    """Datasets of all probes but the most central one, and of that one alone, which share the files of `manifest`."""
    path = lf.manifest_path(manifest)
    probes = rq.probes_of(path)
    if len(probes) < 2:
        raise rq.Refused(f"{path}: it has one probe; one to hold out and others to simplify were expected")
    central = rq.most_central(probes)
    whole = json.loads(path.read_text())
    folders = []
    for name, is_held_out in (("others", False), ("held-out", True)):
        folder = work / name
        folder.mkdir()
        for entry in path.resolve().parent.iterdir():
            if entry.name != path.name:
                (folder / entry.name).symlink_to(entry)
        of = {**whole, "probes": [probe for probe in whole["probes"] if (probe["name"] == central) == is_held_out]}
        (folder / path.name).write_text(json.dumps(of))
        folders.append(folder)
    return folders[0], folders[1]


def png_size(path: pathlib.Path) -> list[int]:
    """Width and height of a PNG file."""
    head = path.read_bytes()[16:24]
    return [int.from_bytes(head[:4], "big"), int.from_bytes(head[4:], "big")]


def picture_manifest(folder: pathlib.Path, of: dict[str, Any], frame: str) -> dict[str, Any]:
    """The manifest of a folder of pictures that `render --reference` wrote, by the manifest of the reference. Panoramas are compared
    by faces of cubes."""
    perspective = of["projection"] == "perspective"
    pattern = "{probe}_view.%04d.png" if perspective else "{probe}_{face}.%04d.png"
    return {
        "lightfield": 1,
        "name": of["name"],
        "fps": of["fps"],
        "frames": [int(frame), int(frame)],
        "projection": "perspective" if perspective else "cubemap",
        "size": png_size(next(folder.glob("*.png"))),
        "color": {"space": "srgb"},
        # Translucent pixels are over black, as `render` compares them.
        "files": {"color": pattern, "alpha": pattern},
        "probes": of["probes"],
    }


@dataclasses.dataclass(frozen=True)
class HeldOut:
    """Images of a dataset with which all ways are compared, and a folder for their pictures."""

    binary: lf.Binary
    dataset: pathlib.Path
    frame: str
    work: pathlib.Path

    def manifest(self) -> dict[str, Any]:
        return json.loads(lf.manifest_path(self.dataset).read_text())

    def compared(self, pictures: pathlib.Path) -> dict[str, Any]:
        """What `diff` finds in colour between these images and a dataset of the same poses."""
        frames = ["--frames", f"{self.frame}-{self.frame}"]
        report = lf.run_json(self.binary, "diff", self.dataset, pictures, "--stream", "color", *frames, "--ssim", "every",
                             "--ssimulacra2", "--allow-clipping", "--json")
        return report["color"]

    def rendered(self, subject: pathlib.Path, name: str, *options: str) -> dict[str, Any]:
        """A scene or container that `render` draws."""
        folder = self.work / f"pictures {name}"
        where = ["--reference", self.dataset, "--frames", self.frame, "-o", folder]
        lf.run_json(self.binary, "render", subject, *where, *options, "--json")
        (folder / "lightfield.json").write_text(json.dumps(picture_manifest(folder, self.manifest(), self.frame)))
        return self.compared(folder)

    def captured(self, scene: pathlib.Path, samples: int) -> dict[str, Any]:
        """A mesh that `capture` draws as the images were."""
        folder, of = self.work / "captured", self.manifest()
        projection, (width, height) = of["projection"], of["size"]
        lf.run_json(self.binary, "capture", scene, "--cameras", self.dataset, "--projection", PROJECTIONS.get(projection, projection),
                    "--size", f"{width}x{height}", "--samples", samples, "--frames", f"{self.frame}-{self.frame}", "--aov", "none",
                    "-o", folder, "--json")
        return self.compared(folder)


def simplify(truth: HeldOut, others: pathlib.Path, own: list[str], more: list[str]) -> tuple[dict[str, Any], Row]:
    """The report of `simplify` with options of its own and more, and the row of the scene."""
    way = way_of(own)
    scene = truth.work / f"{way}.glb"
    report = lf.run_json(truth.binary, "simplify", others, *own, *more, "-o", scene, "--json")
    found = truth.rendered(scene, way)
    return report, Row(way, found, report["files"][0]["bytes"], report["triangles"], report["peak_overdraw_measured"])


def light_field(truth: HeldOut, others: pathlib.Path) -> list[Row]:
    """Rows of the light field by all methods."""
    container = truth.work / "field.lfold"
    lf.run_json(truth.binary, "encode", others, "--frames", truth.frame, "--clip", "-o", container, "--json")
    size = container.stat().st_size
    return [Row(method, truth.rendered(container, method, "--method", method), size) for method in METHODS]


def gltfpack() -> tuple[list[str], str] | None:
    """The command of gltfpack, and its name with its version; none where it is not installed and npx cannot get it."""
    for command in (["gltfpack"], ["npx", "--yes", GLTFPACK]):
        if shutil.which(command[0]):
            done = subprocess.run([*command, "-v"], capture_output=True, text=True)
            if done.returncode == 0:
                return command, done.stdout.strip()
    return None


def pack(command: list[str], mesh: pathlib.Path, output: pathlib.Path, ratio: float) -> int:
    """Keeps this part of the triangles of a mesh, and all of its textures; returns how many there are then."""
    counts = output.with_suffix(".json")
    words = [*command, "-i", mesh, "-o", output, "-si", f"{ratio:.6f}", "-sa", "-noq", "-r", counts]
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode:
        raise lf.Failed(words, done.returncode, done.stdout + done.stderr)
    return json.loads(counts.read_text())["render"]["triangleCount"]


def packed(truth: HeldOut, mesh: pathlib.Path, triangles: int, samples: int) -> Row:
    """The mesh with as many triangles as a scene, or as it is where it has fewer."""
    tool = gltfpack()
    if tool is None:
        return Row("gltfpack", reason="it is not installed, and npx cannot get it")
    command, name = tool
    scene = truth.work / "packed.glb"
    kept = pack(command, mesh, scene, 1)
    if kept > triangles:
        kept = pack(command, mesh, scene, triangles / kept)
    return Row(name, truth.captured(scene, samples), scene.stat().st_size, kept)


def row_or_reason(way: str, made: Callable[[], Row]) -> Row:
    """A row, or why there is none."""
    try:
        return made()
    except lf.Failed as error:
        return Row(way, reason=error.sentence())


def measure(binary: lf.Binary, given: Given, work: pathlib.Path, more: list[str], samples: int) -> Measured:
    """All ways to the images of a set that were held out; `more` are options of every `simplify`."""
    others, dataset = (given.path, given.held_out) if given.held_out else split(given.path, work)
    truth = HeldOut(binary, dataset, str(json.loads(lf.manifest_path(others).read_text())["frames"][0]), work)
    report, first = simplify(truth, others, [], more)
    rows = [first, *(row_or_reason(way_of(own), lambda: simplify(truth, others, own, more)[1]) for own in VARIANTS)]
    rows += light_field(truth, others)
    mesh = given.mesh
    if mesh is None:
        rows.append(Row("gltfpack", reason="no mesh was given"))
    else:
        rows.append(row_or_reason("gltfpack", lambda: packed(truth, mesh, report["triangles"], samples)))
    return Measured(given.name, report, rows)
