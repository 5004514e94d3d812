"""Colour in scripts/peers: HAP, x265 and ffv1 of 8-bit frames, and ours at the PSNR that was measured of them.

HAP stores each frame as BC1 (hap) or as BC3 of YCoCg (hap_q), with Snappy behind it, and has no setting of quality. So
the others are measured first, and then lightfold is asked for colour of at least their PSNR: the lowest --psnr is searched
with which the whole set reaches it, for cells as they are and for blocks.
"""

import math

import lightfold_runs as lf
import peers_codecs as pc
import peers_frames as pf
from peers_measure import Contest, psnr

# Steps of --psnr that are tried, in dB, from the lowest to the highest.
STEP, LOWEST, HIGHEST = 0.25, 20.0, 60.0
OURS = [
    ("cells", []),
    ("cells, bc7", ["--color-block", "bc7", "--psnr-final", "20"]),
    ("cells, bc1", ["--color-block", "bc1", "--psnr-final", "20"]),
]


def rivals(given, film):
    """Codecs of ffmpeg."""
    made = [(kind, ["-pix_fmt", "rgba", "-c:v", "hap", "-format", kind]) for kind in ("hap", "hap_q")]
    made.append(("x265 crf 18", ["-pix_fmt", "yuv444p", *pc.x265(film, given.threads, "crf=18")]))
    found = [pc.Ffmpeg(label, film, given.threads, given.work, coder) for label, coder in made]
    return [*found, pc.Ffv1("ffv1 8 bits", film, given.threads, given.work, ["-pix_fmt", "bgr0"])]


class Search:
    """PSNR of the whole set by options and step of --psnr; what was tried once is kept."""

    def __init__(self, given, source):
        self.given, self.source, self.known = given, source, {}

    def reached(self, options, step):
        key = (*options, step)
        if key not in self.known:
            given, container = self.given, self.given.work / "search.lfold"
            lf.run_json(given.binary, "encode", given.manifest, "--stream", "color", "--psnr", asked(step), *options,
                        "-o", container, "--json")
            found = lf.run_json(given.binary, "diff", self.source, container, "--ssim", "none", "--json", may_differ=True)
            self.known[key] = float(found["color"]["psnr_db"])
        return self.known[key]

    def lowest(self, options, wanted):
        """The lowest step that reaches `wanted` dB, or None."""
        low, high = 0, round((HIGHEST - LOWEST) / STEP)
        if self.reached(options, high) < wanted:
            return None
        while low < high:
            middle = (low + high) // 2
            if self.reached(options, middle) >= wanted:
                high = middle
            else:
                low = middle + 1
        return low


def asked(step):
    return LOWEST + step * STEP


def add_ours(contest, given, film, search, target):
    """Ours at the PSNR of one of the others."""
    label, wanted = target
    if math.isinf(wanted):
        for more in ([], ["--lzma2"]):
            words = ["--psnr", "200", *more]
            contest.add(pc.Lightfold(f"lightfold {' '.join(words)}, for {label}", film, given, "color", words))
        return
    for name, options in OURS:
        step = search.lowest(options, wanted)
        if step is None:
            contest.missing(f"lightfold {name}, for {label}", "its blocks do not reach the PSNR at any setting")
            continue
        for more in ([], ["--lzma2"]):
            words = [*options, "--psnr", asked(step), *more]
            contest.add(pc.Lightfold(" ".join([f"lightfold {name}, for {label}", *more]), film, given, "color", words))


def measure(given, name, runs):
    """The rows of a set's colour."""
    source = given.work / "color.lfold"
    lf.run_json(given.binary, "encode", given.manifest, "--stream", "color", "--psnr", "200", "-o", source, "--json")
    streams, width, height = pf.streams_of(lf.run_json(given.binary, "inspect", source, "--json"))
    payloads = pf.decoded_payloads(given.binary, given.kernels, source, "color", streams, given.work)
    film = pf.Film("color", width, height, "rgb24", 3, streams, payloads)
    errors = lambda codec: {"psnr_db": psnr(given.kernels, film.payloads, codec.payloads())}
    first = Contest(name, "color")
    for codec in rivals(given, film):
        first.add(codec)
    first.encode(1)
    first.check(errors)
    search = Search(given, source)
    contest = Contest(name, "color")
    for more in ([], ["--lzma2"]):
        contest.add(pc.Lightfold(" ".join(["lightfold, defaults", *more]), film, given, "color", more))
    for codec, row in first.pairs:
        if codec is None:
            contest.missing(row.label, row.note.removeprefix("not measured: "))
            continue
        contest.add(codec)
        add_ours(contest, given, film, search, (row.label, row.psnr_db))
    contest.encode(runs[0])
    contest.check(errors)
    contest.decode(runs[1])
    return contest.rows
