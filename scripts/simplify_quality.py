"""Measurements of scripts/simplify-quality: simplified scenes beside light fields that are rendered, and times of stages."""

import dataclasses
import json
import pathlib
from typing import Any

import lightfold_runs as lf
import reconstruction_quality as rq

# Name, dataset, and the one that is held out where it is another.
Given = tuple[str, pathlib.Path, pathlib.Path | None]
METHODS = ("reproject", "march", "splat")
STAGES = ("merge", "candidates", "selection", "silhouettes", "shading", "atlas", "gaps", "export", "evaluate")


@dataclasses.dataclass
class Measured:
    """A set: the report of `simplify`, and of `render` by method for the same held-out images."""

    name: str
    simplified: dict[str, Any]
    rendered: dict[str, Any]


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


def measure(binary: lf.Binary, name: str, sets: tuple[pathlib.Path, pathlib.Path], work: pathlib.Path, options: list[str]) -> Measured:
    """Simplifies the first of two datasets and renders it by all methods at the poses of the second."""
    others, held_out = sets
    simplified = lf.run_json(binary, "simplify", others, "--held-out", held_out, *options, "-o", work / "scene.glb", "--json")
    container = work / "field.lfold"
    frame = str(json.loads(lf.manifest_path(others).read_text())["frames"][0])
    lf.run_json(binary, "encode", others, "--frames", frame, "--clip", "-o", container, "--json")
    render = [binary, "render", container, "--reference", held_out, "--frames", frame, "--null", "--json"]
    rendered = {method: lf.run_json(*render, "--method", method)["reference"] for method in METHODS}
    return Measured(name, simplified, rendered)


def decibels(value: float | None) -> str:
    return "" if value is None else f"{float(value):.2f}"


def scenes(measured: list[Measured]) -> str:
    """Seurat table 1."""
    rows = []
    for of in measured:
        report = of.simplified
        rows.append([
            of.name,
            f"{report['samples'] / 1e6:.2f}",
            f"{report['triangles'] / 1e3:.1f}",
            f"{report['atlas_texels'] / 1e6:.2f}",
            f"{100 * report['atlas_occupancy']:.1f}",
            f"{report['overdraw_mean']:.2f}",
            f"{report['peak_overdraw_measured']:.2f}",
            lf.megabytes(report["files"][0]["bytes"]),
            decibels(report["psnr_db"]),
            decibels(report["released_psnr_db"]),
            f"{report['ssim']:.4f}",
            report["crack_pixels"],
            f"{report['seconds']:.1f}",
        ])
    head = ["set", "samples (M)", "triangles (k)", "texels (M)", "used %", "overdraw", "peak", "MB", "PSNR dB",
            "as released dB", "SSIM", "cracks", "seconds"]
    return lf.table(head, rows)


def held_out(measured: list[Measured]) -> str:
    """Simplified scenes beside other ways to the same images, none of which knows them."""
    rows = []
    for of in measured:
        methods = [("simplify", of.simplified["held_out"]), *of.rendered.items()]
        rows += [[of.name, name, decibels(found["psnr_db"]), decibels(found.get("psnr_hvs_m_db")), f"{found['ssim']:.4f}"]
                 for name, found in methods]
    return lf.table(["set", "by", "PSNR dB", "PSNR-HVS-M dB", "SSIM"], rows)


def stages(measured: list[Measured]) -> str:
    """Seurat table 2."""
    timed = [stage for stage in STAGES if any(stage in of.simplified["stages"] for of in measured)]
    rows = []
    for of in measured:
        seconds, total = of.simplified["stages"], of.simplified["seconds"]
        cell = lambda value: f"{value:.1f} ({100 * value / total:.0f}%)"
        known = [seconds.get(stage, 0.0) for stage in timed]
        rows.append([of.name, *map(cell, known), cell(max(total - sum(known), 0.0)), f"{total:.1f}"])
    return lf.table(["set", *timed, "other", "seconds"], rows)


def pages(binary: lf.Binary, work: str, sets: list[Given], options: list[str]) -> str:
    """All tables of sets, which are names with pairs of datasets or with one that is split; as Markdown."""
    measured = []
    for at, (name, given, held) in enumerate(sets):
        folder = pathlib.Path(work) / str(at)
        folder.mkdir()
        pair = (given, held) if held else split(given, folder)
        measured.append(measure(binary, name, pair, folder, options))
    with_options = f" with `{' '.join(options)}`" if options else " by default settings"
    return (
        f"{scenes(measured)}\n\nSimplified{with_options}; PSNR and SSIM are over all images of the capture, holes black. \"As "
        "released\" is what the evaluator of the released program would have printed for the same pictures: without pixels that are "
        f"not opaque, and 24.07 dB more.\n\n{held_out(measured)}\n\nImages that were held out: of a dataset that is split, those of its "
        "most central probe. `reproject` knows the true distances of each pixel; splatting, marching and reprojecting use the light "
        f"field of all other probes.\n\n{stages(measured)}\n\nSeconds of each stage. Made by `scripts/simplify-quality` ({lf.machine()})."
    )
