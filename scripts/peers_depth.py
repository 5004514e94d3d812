"""Depth in scripts/peers: which codecs meet, on which mapping of the codes."""

import lightfold_runs as lf
import peers_codecs as pc
import peers_frames as pf
from peers_measure import Contest, Depth, Given, Row, depth_errors

# x265's constant rate factors on the mapping of CALF 7.1: high quality, and a usual one.
CRF = [10, 18]


def reference(given: Given) -> tuple[pf.Film, pf.Film | None, Depth, str]:
    """(film of 16-bit codes, film of 24-bit codes or None, Depth, why there are no 24 bits)."""
    container = given.work / "reference.lfold"
    encode = [given.binary, "encode", given.manifest, "--stream", "depth", "--depth-codec", "aabb", "-o", container, "--json"]
    lf.run_json(*encode)
    check = lf.run_json(given.binary, "diff", given.manifest, container, "--stream", "depth", "--json", may_differ=True)
    if check["depth"]["max_error_codes"]:
        raise pf.BadInput(f"{given.manifest}: boxes were expected to be lossless, and are {check['depth']} from the source")
    streams, width, height = pf.streams_of(lf.run_json(given.binary, "inspect", container, "--json"))
    codes = pf.decoded_payloads(given.binary, container, "depth", streams, given.work)
    film = pf.Film("codes", width, height, "gray16le", 2, streams, codes)
    try:
        metres = pf.source_metres(given.manifest, streams, (width, height))
    except pf.NotMeasured as error:
        return film, None, Depth(streams, codes, [], []), str(error)
    triples = zip(metres, codes, streams)
    finer = [pf.codes24(source, coarse, stream.near_far) for source, coarse, stream in triples]
    wide = pf.Film("codes24", width, height, "", 4, streams, finer, wide=True)
    return film, wide, Depth(streams, codes, finer, metres), ""


def ours(contest: Contest, given: Given, film: pf.Film, bound: int) -> None:
    for options in ([], ["--depth-codec", "quadtree"], ["--depth-codec", "quadtree", "--lzma2"]):
        options = ["--max-error", str(bound), *options]
        contest.add(pc.Lightfold(" ".join(["lightfold", *options]), film, given, options, bound))


def lossless(contest: Contest, given: Given, film: pf.Film) -> None:
    """Rows of the 16-bit codes as they are."""
    ours(contest, given, film, 0)
    for more in ([], ["--lzma2"]):
        label = " ".join(["lightfold --depth-codec aabb", *more])
        contest.add(pc.Lightfold(label, film, given, ["--depth-codec", "aabb", *more], 0))
    threads = given.threads
    contest.add(pc.Ffv1("ffv1 gray16le", film, given, bound=0))
    colors = pf.swizzled(film)
    contest.add(pc.Ffmpeg("x265 lossless, 16 bits as RGB", colors, given, pc.x265(colors, threads, "lossless=1"), 0))
    contest.add(pc.Jxl("libjxl -d 0", film, int(threads), given.work))
    contest.add(pc.Ffmpeg("PNG-16", film, given, ["-c:v", "png", "-pred", "mixed", "-pix_fmt", "gray16be"], 0))
    contest.add(pc.Xz("xz -9e", film, int(threads), 0))
    for level in (19, 3):
        contest.add(pc.Zstd(f"zstd -{level}", film, int(threads), level, 0))
    contest.add(pc.Rvl("RVL", film, int(threads), given.kernels, 0))


def in_24_bits(contest: Contest, given: Given, wide: pf.Film | None, why: str) -> None:
    """Rows of the mapping that CALF's table 2 has: 24-bit codes as RGB.

    By YUV: the way in which players and coders of graphics processors store RGB, which is said to be lossless and rounds.
    """
    if wide is None:
        contest.missing("x265, 24 bits as RGB", why)
        return
    settings: list[tuple[str, list[str], str]] = [
        ("lossless, 24 bits as RGB", [], "lossless=1"),
        ("lossless, 24 bits as RGB by YUV", ["-pix_fmt", "yuv444p"], "lossless=1"),
    ]
    settings += [(f"crf {crf}, 24 bits as RGB", [], f"crf={crf}") for crf in CRF]
    colors = pf.swizzled(wide)
    for name, more, setting in settings:
        coder = [*more, *pc.x265(colors, given.threads, setting)]
        contest.add(pc.Ffmpeg(f"x265 {name}", colors, given, coder))


def bounded(contest: Contest, given: Given, film: pf.Film, bound: int) -> None:
    """Rows within a bound: ours, and codes in steps that are as wide as it allows."""
    ours(contest, given, film, bound)
    steps = pf.stepped(film, bound)
    threads = given.threads
    contest.add(pc.Xz("steps, xz -9e", steps, int(threads), bound))
    for level in (19, 3):
        contest.add(pc.Zstd(f"steps, zstd -{level}", steps, int(threads), level, bound))
    contest.add(pc.Ffv1("steps, ffv1", steps, given, bound=bound))
    label = "steps, x265 lossless"
    if steps.pixel_format == "gray16le":
        contest.missing(label, f"{steps.values} steps do not fit 12 bits", bound)
    else:
        coder = pc.x265(steps, threads, "lossless=1")
        contest.add(pc.Ffmpeg(f"{label} {steps.pixel_format.removesuffix('le')}", steps, given, coder, bound))
    contest.add(pc.Rvl("steps, RVL", steps, int(threads), given.kernels, bound))


def measure(given: Given, name: str, bounds: list[int], runs: tuple[int, int]) -> list[Row]:
    """The rows of a set's depth."""
    film, wide, depth, why = reference(given)
    contest = Contest(name, "depth")
    lossless(contest, given, film)
    for bound in bounds:
        if bound:
            bounded(contest, given, film, bound)
    in_24_bits(contest, given, wide, why)
    contest.encode(runs[0])
    contest.check(lambda codec: depth_errors(depth, codec))
    contest.decode(runs[1])
    return contest.rows
