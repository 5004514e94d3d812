"""Colour in scripts/peers: bytes at a mean PSNR, and at a promise for every frame of every cell.

Codecs with a setting of quality are asked again and again until the mean PSNR of all frames is met. HAP, which stores each
frame as BC1 (hap) or as BC3 of YCoCg (hap_q), and lossless codecs have none.
"""

import math
from typing import NamedTuple

import lightfold_runs as lf
import peers_codecs as pc
import peers_frames as pf
from peers_measure import Contest, psnr

MEANS, PROMISES = [38.5, 41.5, 45.0], [40, 50]
# How near a search comes, in dB, and its tries.
NEAR, TRIES = 0.1, 10
CELLS, TRANSFORM = ["--color-codec", "cells"], ["--color-codec", "transform"]
BLOCKS = ["--color-block", "bc7", "--lzma2"]


class Setting(NamedTuple):
    """An option of ours that mean PSNR grows with, in dB for each 1, or falls with."""
    option: str
    start: float
    slope: float
    limits: tuple

    def arguments(self, value):
        return [self.option, value if self.slope > 0 else round(value)]


PSNR, QP = Setting("--psnr", 38, 1.0, (20, 70)), Setting("--color-qp", 100, -0.3, (0, 240))


def search(measure, start, slope, limits):
    """The setting at which `measure`, which grows with it, is nearest to 0 and not below -NEAR; None where there is none.

    `slope` is a guess of the growth; then it is known from two sides.
    """
    low, high, known, at = *limits, {}, start
    while len(known) < TRIES and at not in known:
        found = known[at] = measure(at)
        if abs(found) <= NEAR:
            return at
        if found < 0:
            low = max(low, at)
        else:
            high = min(high, at)
        if low < high and low in known and high in known:
            share = -known[low] / (known[high] - known[low]) if math.isfinite(known[high]) else 0.5
            at = round(low + (high - low) * min(max(share, 0.1), 0.9), 3)
        else:
            at = round(min(max(at - found / slope, low), high), 3)
    reaching = {setting: above for setting, above in known.items() if above >= -NEAR}
    return min(reaching, key=reaching.get) if reaching else None


class Source:
    """Frames of a set's colour as 8 bits: the lossless container, its manifest, and the film that other codecs get."""

    def __init__(self, given):
        self.given, self.container, folder = given, given.work / "source.lfold", given.work / "source"
        lf.run_json(given.binary, "encode", given.manifest, "--stream", "color", "--clip", *CELLS, "--psnr", "200", "-o", self.container,
                    "--json")
        streams, width, height = pf.streams_of(lf.run_json(given.binary, "inspect", self.container, "--json"))
        lf.run_json(given.binary, "decode", self.container, "--format", "png", "-o", folder, "--json")
        self.manifest = (folder / "lightfield.json").read_text()
        payloads = pf.read_dataset(given.kernels, folder, streams)
        self.film = pf.Film("color", width, height, "rgb24", 3, streams, payloads)

    def differences(self, other, ssim="none"):
        return lf.run_json(self.given.binary, "diff", self.container, other, "--allow-clipping", "--ssim", ssim, "--json",
                           may_differ=True)

    def quality(self, codec):
        """Fields of a row."""
        if isinstance(codec, pc.Lightfold):
            other = codec.file
        else:
            other = self.given.work / "shown"
            pf.write_dataset(other, self.manifest, self.film, codec.payloads())
        found = self.differences(other, "every")["color"]
        return {"psnr_db": float(found["psnr_db"]), "lowest_cell_db": float(found["min_cell_psnr_db"]), "ssim": found["ssim"],
                "psnr_hvs_m_db": float(found["psnr_hvs_m_db"])}

    def ours(self, label, options):
        return pc.OneThread(label, self.film, self.given, "color", options)

    def encoded(self, options):
        """A container by these options, for a search."""
        container = self.given.work / "search.lfold"
        lf.run_json(self.given.binary, "encode", self.given.manifest, "--stream", "color", "--clip", *options,
                    "-o", container, "--json")
        return container

    def mean_psnr(self, container):
        return float(self.differences(container)["color"]["psnr_db"])

    def rival_at(self, label, value, wanted):
        """A coder of ffmpeg where `value` of it, in dB, is what is wanted; None where no setting has it."""
        codec = pc.PerStream(label, self.film, self.given.work)
        codec.open()

        def above(quality):
            codec.quality = quality
            codec.encode()
            return value(codec) - wanted
        coder = codec.coder
        codec.quality = search(above, coder.start, coder.slope, (coder.lowest, coder.highest))
        return None if codec.quality is None else codec

    def ours_at(self, label, options, setting, value, wanted):
        """Ours where `value` of the container, in dB, is what is wanted; None where nothing that is set has it."""
        sign = math.copysign(1, setting.slope)
        above = lambda at: value(self.encoded([*options, *setting.arguments(sign * at)])) - wanted
        at = search(above, sign * setting.start, abs(setting.slope), sorted(sign * limit for limit in setting.limits))
        return None if at is None else self.ours(label, [*options, *setting.arguments(sign * at)])


def add(contest, label, asked, find):
    """The row of a codec that `find` answers, or one that says why there is none."""
    try:
        codec = find()
        row = contest.add(codec) if codec else contest.missing(label, "no setting has this PSNR")
    except pf.NotMeasured as error:
        row = contest.missing(label, error)
    except lf.Failed as error:
        row = contest.missing(label, error.sentence())
    row.asked = asked


def one_thread(kind, label, source, coder):
    """A coder of ffmpeg for the whole film, by processor time."""
    codec = kind(label, source.film, "1", source.given.work, coder)
    codec.clock = pc.processor_time
    return codec


def at_means(contest, source):
    """Codecs with a setting of quality at each mean PSNR, the others as they are."""
    film, given = source.film, source.given
    for label, coder in (("hap", ["hap", "-format", "hap"]), ("hap_q", ["hap", "-format", "hap_q"])):
        add(contest, label, "–", lambda: one_thread(pc.Ffmpeg, label, source, ["-pix_fmt", "rgba", "-c:v", *coder]))
    mean = lambda codec: psnr(given.kernels, film.payloads, codec.payloads())
    for wanted in MEANS:
        for label in pc.CODERS:
            add(contest, label, f"{wanted}", lambda: source.rival_at(label, mean, wanted))
        for label, options, setting in (("bc7 + LZMA2", [*BLOCKS, "--psnr-final", "20"], PSNR), ("transform", TRANSFORM, QP)):
            label = f"lightfold, {label}"
            add(contest, label, f"{wanted}", lambda: source.ours_at(label, options, setting, source.mean_psnr, wanted))
    add(contest, "ffv1", "lossless", lambda: one_thread(pc.Ffv1, "ffv1", source, ["-pix_fmt", "bgr0"]))
    for label, more in (("lightfold, cells + zstd", "--zstd"), ("lightfold, cells + LZMA2", "--lzma2")):
        add(contest, label, "lossless", lambda: source.ours(label, [*CELLS, "--psnr", "200", more]))


def at_promises(contest, source):
    """Ours at each PSNR that every frame of every cell keeps."""
    for least in PROMISES:
        for label, options in (
            ("lightfold, bc7 + LZMA2", [*BLOCKS, "--psnr-final", least]), ("lightfold, cells + zstd", [*CELLS, "--zstd"]),
            ("lightfold, transform", TRANSFORM),
        ):
            add(contest, label, f"every cell {least}", lambda: source.ours(label, [*options, "--psnr", least]))


def measure(source, name, runs):
    """The rows of a set's colour."""
    contest = Contest(name, "color")
    at_means(contest, source)
    at_promises(contest, source)
    contest.encode(runs[0])
    contest.check(source.quality)
    contest.decode(runs[1])
    for row in contest.rows:
        row.pixels = sum(map(len, source.film.payloads)) // 3
    return contest.rows
