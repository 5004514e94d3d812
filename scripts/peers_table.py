"""Rows of scripts/peers as Markdown and CSV."""

import statistics
from typing import Any

import lightfold_runs as lf
from peers_measure import Row

FOOT = """\
E: the error bound of a codec, in 16-bit log codes; –: no bound. Ratios are to lightfold of the same
E, of rows without one to `--max-error 0`. Steps: codes in steps of 2E + 1, which keep the bound, and the background as it is;
making and undoing steps or channels is not timed. Worst and RMS: what was measured after decoding, of pixels that are a
surface before and after; metres are against the 32-bit depth of the source where its files are EXR of distances, so that
16-bit codes without loss show what 16 bits cost, else against the codes. Background wrong: pixels that lost or gained a
surface. Times are medians, codecs take turns, starts of processes are left out, decoders write to nothing; lightfold reads
the source's files to encode, the others get codes. All decode from memory or from cached files; lightfold, like xz, zstd and
RVL, again and again in one process, where the first pass does not count. No time: too short to be told from the start of
ffmpeg. Written: lightfold keeps the frame before and
writes pixels that change alone, the others write whole frames, and a time is that of as many pixels as each writes.
To show one tile of a frame, lightfold reads that tile, libjxl, PNG and RVL an image, the others a face from its first frame
on."""
COLOR_FOOT = """\
Every figure is measured after decoding, against the same 8 bits, by `lightfold diff --ssimulacra2`: mean SSIMULACRA2, its 10th
percentile, mean butteraugli (3-norm; less is better) and PSNR-HVS-M of the first, the middle and the last frame of each face,
where sides below 256 pixels are mirrored; PSNR of all frames; the lowest PSNR of a cell of 64² in any frame. A number asked is a
mean SSIMULACRA2, met within 0.5 by a search for the setting; what does not come down to it is shown at its fewest bytes. HAP
has no setting. x265, libaom and SVT-AV1 code one raw file for each face, 4:4:4 unless noted. Ours counts whole files: rows and
tables. Times are of one thread, by processor time without the start of processes; codecs take turns, and medians are shown. AV1 is
decoded by dav1d, HEVC by ffmpeg, ours by `decode --null`. Encoding is with the setting found, without the search;
lightfold reads the source's files, the others get codes. No time: too short to be told from the start of ffmpeg. To show one
cell of a frame, lightfold reads that cell, HAP a frame, the others a face from its first frame on."""

CSV_HEAD = [
    "date", "machine", "set", "stream", "bound", "codec", "bytes", "encode_s", "encode_low_s", "encode_high_s", "decode_s",
    "decode_low_s", "decode_high_s", "max_error_codes", "rms_error_codes", "max_error_m", "rms_error_m", "background_wrong",
    "psnr_db", "lowest_cell_db", "psnr_hvs_m_db", "ssimulacra2", "ssimulacra2_p10", "butteraugli", "written_percent", "asked",
    "pixels", "note",
]


def shown(value: float | None, form: str) -> str:
    """A figure, or nothing where there is none."""
    return "" if value is None else form.format(value)


def short_time(seconds: float | None) -> str:
    """Seconds of encoding; what is below the noise of ffmpeg's start is no figure."""
    return "" if seconds is None else "< 0.01" if seconds < 0.005 else f"{seconds:.2f}"


def milliseconds(seconds: float | None) -> str:
    return "" if seconds is None else f"{1000 * seconds:.1f}"


def ratio(value: float | None, first: float | None) -> str:
    return "" if value is None or not first else f"{value / first:.2f}"


def error(value: float | None) -> str:
    """An error in codes or metres: 0 where there is none at all."""
    return "" if value is None else "0" if value == 0 else f"{value:.2g}" if value < 1 else f"{value:.4g}"


def firsts(rows: list[Row]) -> list[Row | None]:
    """For each depth row, ours that it is compared with."""
    ours = {row.bound: row for row in reversed(rows) if row.label.startswith("lightfold --max-error")}
    return [ours.get(row.bound, ours.get(0)) for row in rows]


def depth_table(rows: list[Row]) -> str:
    head = ["set", "E", "codec", "MB", "MB, ratio", "encode s", "decode ms", "time, ratio", "written %", "worst codes",
            "RMS codes", "worst m", "RMS m", "background wrong"]
    lines: list[list[Any]] = []
    for row, first in zip(rows, firsts(rows)):
        first = first or Row("", "", "")
        bound = "–" if row.bound is None else row.bound
        if row.note.startswith("not measured"):
            lines.append([row.dataset, bound, row.label, row.note, *[""] * (len(head) - 4)])
            continue
        lines.append([
            row.dataset, bound, row.label, lf.megabytes(row.bytes or 0), ratio(row.bytes, first.bytes),
            short_time(row.encode_s), milliseconds(row.decode_s), ratio(row.decode_s, first.decode_s),
            shown(row.written_percent, "{:.1f}"), error(row.max_error_codes), error(row.rms_error_codes),
            error(row.max_error_m), error(row.rms_error_m), row.background_wrong,
        ])
    return lf.table(head, lines)


def speed(row: Row, seconds: float | None) -> str:
    """Megapixels a second."""
    return shown(seconds and row.pixels / seconds / 1e6, "{:.3g}")


def color_table(rows: list[Row]) -> str:
    """Rows at a score, then those at a promise, as tables of their own."""
    promises = [row for row in rows if row.asked.startswith("every cell")]
    means = [row for row in rows if row not in promises]
    return "\n\n".join(colors(part) for part in (means, promises) if part)


def colors(rows: list[Row]) -> str:
    head = ["set", "asked", "codec", "kB", "SSIMULACRA2", "10th percentile", "butteraugli", "PSNR-HVS-M dB", "PSNR dB",
            "lowest cell dB", "encode Mpixel/s", "decode Mpixel/s"]
    lines = []
    for row in rows:
        first = [row.dataset, row.asked, row.label]
        if row.note.startswith("not measured"):
            lines.append([*first, row.note, *[""] * (len(head) - 4)])
            continue
        lines.append([
            *first, f"{(row.bytes or 0) / 1000:.0f}", shown(row.ssimulacra2, "{:.2f}"), shown(row.ssimulacra2_p10, "{:.2f}"),
            shown(row.butteraugli, "{:.3f}"), shown(row.psnr_hvs_m_db, "{:.2f}"), shown(row.psnr_db, "{:.2f}"),
            shown(row.lowest_cell_db, "{:.2f}"), speed(row, row.encode_s), speed(row, row.decode_s),
        ])
    return lf.table(head, lines)


def markdown(rows: list[Row], machine: str, stream: str) -> str:
    """The tables of a stream with what their columns mean."""
    table, foot = {"depth": (depth_table, FOOT), "color": (color_table, COLOR_FOOT)}[stream]
    parts = []
    of_stream = [row for row in rows if row.stream == stream]
    for at, name in enumerate(dict.fromkeys(row.dataset for row in of_stream)):
        made = table([row for row in of_stream if row.dataset == name])
        # Sets after the first are folded: a page with all of it open is hard to read.
        folded = [f"<details><summary>{name}, {stream}</summary>", made, "</details>"]
        parts += folded if at else [made]
    made_by = f"Made by `scripts/peers --{stream}` ({machine})."
    return "\n\n".join([*parts, foot.replace("\n", " "), made_by])


def spread(times: list[float]) -> list[float | None]:
    return [statistics.median(times), min(times), max(times)] if times else [None] * 3


def csv_rows(rows: list[Row], machine: str, date: str) -> list[list[Any]]:
    """The head and a line for each row; figures in full, nothing where there is none."""
    lines = [CSV_HEAD]
    for row in rows:
        values = [
            date, machine, row.dataset, row.stream, row.bound, row.label, row.bytes, *spread(row.encode_seconds),
            *spread(row.decode_seconds), row.max_error_codes, row.rms_error_codes, row.max_error_m, row.rms_error_m,
            row.background_wrong, row.psnr_db, row.lowest_cell_db, row.psnr_hvs_m_db, row.ssimulacra2, row.ssimulacra2_p10,
            row.butteraugli, row.written_percent, row.asked, row.pixels, row.note,
        ]
        lines.append(["" if value is None else f"{value:.6g}" if isinstance(value, float) else value for value in values])
    return lines
