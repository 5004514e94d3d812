"""Colour in scripts/peers: bytes at a mean SSIMULACRA2, and at a promise for every frame of every cell.

Codecs with a setting of quality are asked again and again until the mean score of the first, the middle and the last frame of
each stream is met. HAP, which stores each frame as BC1 (hap) or as BC3 of YCoCg (hap_q), and lossless codecs have none.
"""

import collections
import dataclasses
import pathlib
from typing import Any, Callable, Sequence

import lightfold_runs as lf
import peers_codecs as pc
import peers_frames as pf
from peers_codecs import Dial
from peers_measure import Contest, Given, Row

SCORES, PROMISES = [70, 80, 90], [40, 50]
# How near a search comes, in points of the score, and what it may try for each.
NEAR, TRIES = 0.5, 8
CELLS, TRANSFORM = ["--color-codec", "cells"], ["--color-codec", "transform"]
BLOCKS = ["--color-block", "bc7", "--lzma2"]
# Ours with a setting of quality: the options, and the one that is searched.
OURS: dict[str, tuple[list[str], Dial]] = {
    "lightfold, transform": ([*TRANSFORM, "--quality"], Dial(79, 1.0, 0, 100)),
    "lightfold, bc7 + LZMA2": ([*BLOCKS, "--psnr-final", "20", "--psnr"], Dial(38, 2.0, 20, 70)),
}


# A figure by a setting.
Measure = Callable[[float], float]


def search(measure: Measure, wanted: float, dial: Dial, known: dict[float, float]) -> float | None:
    """The setting at which `measure`, which grows with it, is nearest to what is wanted and not more than NEAR below; None
    where there is none.

    `known` has what was measured with this dial before, and gets what is measured now.
    """
    for _ in range(TRIES):
        found = reaching(wanted, known)
        at = dial.following(wanted, known)
        if found is not None and known[found] <= wanted + NEAR or at in known:
            return found
        known[at] = measure(at)
    return reaching(wanted, known)


def reaching(wanted: float, known: dict[float, float]) -> float | None:
    """The setting with the lowest value that is enough."""
    return min((at for at, found in known.items() if found >= wanted - NEAR), key=lambda at: known[at], default=None)


# A figure of a codec that has encoded.
Value = Callable[[pc.Codec], float]


class Source:
    """Frames of a set's colour as 8 bits: the lossless container, its manifest, and the film that other codecs get."""

    def __init__(self, given: Given):
        self.given, self.container, folder = given, given.work / "source.lfold", given.work / "source"
        # Fields of codecs at settings that a search has measured.
        self.known: dict[tuple[str, str], dict[str, float]] = {}
        lf.run_json(given.binary, "encode", given.manifest, "--stream", "color", "--clip", *CELLS, "--psnr", "200", "-o", self.container,
                    "--json")
        streams, width, height = pf.streams_of(lf.run_json(given.binary, "inspect", self.container, "--json"))
        lf.run_json(given.binary, "decode", self.container, "--format", "png", "-o", folder, "--json")
        self.manifest = (folder / "lightfield.json").read_text()
        payloads = pf.read_dataset(folder, streams)
        self.film = pf.Film("color", width, height, "rgb24", 3, streams, payloads)

    def quality(self, codec: pc.Codec) -> dict[str, float]:
        """Fields of a row."""
        setting = str(codec.options if isinstance(codec, pc.Lightfold) else getattr(codec, "quality", None))
        key = (codec.label, setting)
        if key not in self.known:
            if isinstance(codec, pc.Lightfold):
                other = codec.file
            else:
                other = self.given.work / "shown"
                pf.write_dataset(other, self.manifest, self.film, codec.payloads())
            self.known[key] = self.fields(other)
        return self.known[key]

    def fields(self, other: pathlib.Path) -> dict[str, float]:
        report = lf.run_json(self.given.binary, "diff", self.container, other, "--allow-clipping", "--ssimulacra2", "--json",
                             may_differ=True)
        found = report["color"]
        names = {"psnr_db": "psnr_db", "lowest_cell_db": "min_cell_psnr_db", "psnr_hvs_m_db": "psnr_hvs_m_db",
                 "ssimulacra2": "ssimulacra2", "ssimulacra2_p10": "ssimulacra2_p10", "butteraugli": "butteraugli_3norm"}
        if found["ssimulacra2"] is None:
            raise pf.NotMeasured("no frame has a score")
        return {name: float(found[key]) for name, key in names.items()}

    def score(self, codec: pc.Codec) -> float:
        return self.quality(codec)["ssimulacra2"]

    def ours(self, label: str, options: Sequence[Any]) -> pc.OneThread:
        return pc.OneThread(label, self.film, self.given, options)

    def rival_at(self, label: str, value: Value, wanted: float, known: dict[float, float]) -> pc.PerStream | None:
        """A coder of ffmpeg where `value` of it is what is wanted; None where no setting has it."""
        codec = pc.PerStream(label, self.film, self.given.work)
        codec.open()
        codec.at_once = int(self.given.threads)

        def measure(quality: float) -> float:
            codec.quality = quality
            codec.encode()
            return value(codec)
        found = search(measure, wanted, codec.coder.dial, known)
        codec.at_once = 1
        if found is None:
            return None
        codec.quality = found
        return codec

    def ours_at(self, label: str, value: Value, wanted: float, known: dict[float, float]) -> pc.OneThread | None:
        """Ours where `value` of it is what is wanted; None where no setting has it."""
        options, dial = OURS[label]

        def measure(setting: float) -> float:
            codec = pc.LightfoldColor(label, self.film, self.given, [*options, setting])
            codec.encode()
            return value(codec)
        at = search(measure, wanted, dial, known)
        return None if at is None else self.ours(label, [*options, at])


def add(contest: Contest, label: str, asked: str, find: Callable[[], pc.Codec | None]) -> None:
    """Adds the row of a codec that `find` returns, or one with the reason why there is none."""
    try:
        codec = find()
        row = contest.add(codec) if codec else contest.missing(label, "no setting has this score")
    except pf.NotMeasured as error:
        row = contest.missing(label, error)
    except lf.Failed as error:
        row = contest.missing(label, error.sentence())
    row.asked = asked


def one_thread(kind: type[pc.Ffmpeg], label: str, source: Source, coder: list[str]) -> pc.Ffmpeg:
    """A coder of ffmpeg for the whole film, by processor time."""
    codec = kind(label, source.film, dataclasses.replace(source.given, threads="1"), coder)
    codec.clock = pc.processor_time
    return codec


def at_scores(contest: Contest, source: Source) -> None:
    """Codecs with a setting of quality at each score, the others as they are."""
    for label, coder in (("hap", ["hap", "-format", "hap"]), ("hap_q", ["hap", "-format", "hap_q"])):
        add(contest, label, "–", lambda: one_thread(pc.Ffmpeg, label, source, ["-pix_fmt", "rgba", "-c:v", *coder]))
    known: dict[str, dict[float, float]] = collections.defaultdict(dict)
    for wanted in SCORES:
        for label in [*pc.CODERS, *OURS]:
            find = source.rival_at if label in pc.CODERS else source.ours_at
            add(contest, label, f"{wanted}", lambda: find(label, source.score, wanted, known[label]))
            contest.note(f"{label} at {wanted} {contest.rows[-1].note}".rstrip())
    add(contest, "ffv1", "lossless", lambda: one_thread(pc.Ffv1, "ffv1", source, ["-pix_fmt", "bgr0"]))
    for label, more in (("lightfold, cells + zstd", "--zstd"), ("lightfold, cells + LZMA2", "--lzma2")):
        add(contest, label, "lossless", lambda: source.ours(label, [*CELLS, "--psnr", "200", more]))


def at_promises(contest: Contest, source: Source) -> None:
    """Ours at each PSNR that every frame of every cell keeps."""
    for least in PROMISES:
        for label, options in (
            ("lightfold, bc7 + LZMA2", [*BLOCKS, "--psnr-final", least]), ("lightfold, cells + zstd", [*CELLS, "--zstd"]),
            ("lightfold, transform", TRANSFORM),
        ):
            add(contest, label, f"every cell {least}", lambda: source.ours(label, [*options, "--psnr", least]))


def measure(source: Source, name: str, runs: tuple[int, int]) -> list[Row]:
    """The rows of a set's colour."""
    contest = Contest(name, "color")
    at_scores(contest, source)
    at_promises(contest, source)
    contest.encode(runs[0])
    contest.check(source.quality)
    contest.decode(runs[1])
    for row in contest.rows:
        row.pixels = sum(map(len, source.film.payloads)) // 3
    return contest.rows
