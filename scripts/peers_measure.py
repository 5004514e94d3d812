"""Runs the codecs of scripts/peers in turn, and measures what came back."""

import dataclasses
import math
import statistics
import sys

from peers_frames import NotMeasured


@dataclasses.dataclass
class Given:
    """What a run is given."""

    binary: str
    kernels: object
    work: object
    threads: str
    manifest: object = None


@dataclasses.dataclass
class Row:
    """What was found of one codec; figures that do not apply are None."""

    dataset: str
    stream: str
    label: str
    bound: object = None
    bytes: object = None
    encode_seconds: list = dataclasses.field(default_factory=list)
    decode_seconds: list = dataclasses.field(default_factory=list)
    max_error_codes: object = None
    rms_error_codes: object = None
    max_error_m: object = None
    rms_error_m: object = None
    background_wrong: object = None
    psnr_db: object = None
    lowest_cell_db: object = None
    psnr_hvs_m_db: object = None
    # Means of pictures, and the 10th percentile.
    ssimulacra2: object = None
    ssimulacra2_p10: object = None
    butteraugli: object = None
    written_percent: object = None
    # Colour: what the codec was asked for, and pixels of all frames.
    asked: str = ""
    pixels: int = 0
    note: str = ""

    @property
    def encode_s(self):
        return statistics.median(self.encode_seconds) if self.encode_seconds else None

    @property
    def decode_s(self):
        return statistics.median(self.decode_seconds) if self.decode_seconds else None


@dataclasses.dataclass
class Depth:
    """What depth is compared with: codes of 16 and of 24 bits, and the metres of the source where they are at hand."""

    streams: list
    codes16: list
    codes24: list
    metres: list


def depth_errors(kernels, depth, codec):
    """Fields of a row: errors of the codes that come back."""
    wide = codec.film.wide
    reference = depth.codes24 if wide else depth.codes16
    largest, squares, largest_m, squares_m, compared, background = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for at, codes in enumerate(codec.codes()):
        source = depth.metres[at] if depth.metres else None
        found = kernels.compare(reference[at], codes, depth.streams[at].near_far, source, wide)
        largest, largest_m = max(largest, found[0]), max(largest_m, found[2])
        squares, squares_m = squares + found[1], squares_m + found[3]
        compared, background = compared + found[4], background + found[5]
    mean = lambda total: math.sqrt(total / compared) if compared else 0.0
    return {"max_error_codes": largest, "rms_error_codes": mean(squares), "max_error_m": largest_m,
            "rms_error_m": mean(squares_m), "background_wrong": int(background)}


def add(times, seconds):
    """A time that could be measured."""
    if seconds is not None:
        times.append(seconds)



class Contest:
    """Codecs and their rows, in the order of the table."""

    def __init__(self, dataset, stream):
        self.dataset, self.stream, self.pairs = dataset, stream, []

    def add(self, codec, note=""):
        row = Row(self.dataset, self.stream, codec.label, codec.bound, note=note)
        self.pairs.append((codec, row))
        return row

    def missing(self, label, why, bound=None):
        """A row that cannot be measured."""
        row = Row(self.dataset, self.stream, label, bound, note=f"not measured: {why}")
        self.pairs.append((None, row))
        return row

    @property
    def rows(self):
        return [row for _, row in self.pairs]

    def each(self, action):
        """Does something with every codec that still works; one that fails says why in its row."""
        for at, (codec, row) in enumerate(self.pairs):
            if codec is None:
                continue
            try:
                action(codec, row)
            except NotMeasured as error:
                row.note = f"not measured: {error}"
                row.encode_seconds, row.decode_seconds, row.bytes = [], [], None
                self.pairs[at] = (None, row)

    def encode(self, runs):
        """Every codec once, then every codec again: what slows the machine down hits all of them."""
        self.each(lambda codec, _: codec.open())
        for turn in range(runs):
            self.each(lambda codec, row: add(row.encode_seconds, codec.encode()))
            self.say("encode", turn, runs)

    def check(self, errors):
        """Sizes, and the fields that `errors` finds of a codec."""
        def one(codec, row):
            row.bytes = codec.size()
            for name, value in errors(codec).items():
                setattr(row, name, value)
        self.each(one)

    def decode(self, runs):
        """In turn, as encoding; the first turn does not count."""
        for turn in range(runs + 1):
            def once(codec, row):
                taken = codec.decode()
                row.written_percent = codec.written
                if turn:
                    add(row.decode_seconds, taken)
            self.each(once)
            self.say("decode", turn, runs + 1)

    def say(self, what, turn, turns):
        self.note(f"{what} {turn + 1} of {turns}")

    def note(self, words):
        print(f"{self.dataset} {self.stream}: {words}", file=sys.stderr)
