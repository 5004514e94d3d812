"""Runs the codecs of scripts/peers in turn, and measures what came back."""

import dataclasses
import math
import pathlib
import statistics
import sys
from typing import TYPE_CHECKING, Any, Callable

import numpy as np

from peers_frames import TOP_24, NotMeasured, Stream, type_of_codes
from peers_kernels import Kernels

if TYPE_CHECKING:
    from peers_codecs import Codec


@dataclasses.dataclass
class Given:
    """Inputs of a run."""

    binary: str
    kernels: Kernels
    work: pathlib.Path
    threads: str
    manifest: pathlib.Path


@dataclasses.dataclass
class Row:
    """Figures of one codec; those that do not apply are None."""

    dataset: str
    stream: str
    label: str
    bound: int | None = None
    bytes: int | None = None
    encode_seconds: list[float] = dataclasses.field(default_factory=list)
    decode_seconds: list[float] = dataclasses.field(default_factory=list)
    max_error_codes: float | None = None
    rms_error_codes: float | None = None
    max_error_m: float | None = None
    rms_error_m: float | None = None
    background_wrong: int | None = None
    psnr_db: float | None = None
    lowest_cell_db: float | None = None
    psnr_hvs_m_db: float | None = None
    # Means of pictures, and the 10th percentile.
    ssimulacra2: float | None = None
    ssimulacra2_p10: float | None = None
    butteraugli: float | None = None
    written_percent: float | None = None
    # Colour: what the codec was asked for, and pixels of all frames.
    asked: str = ""
    pixels: int = 0
    note: str = ""

    @property
    def encode_s(self) -> float | None:
        return statistics.median(self.encode_seconds) if self.encode_seconds else None

    @property
    def decode_s(self) -> float | None:
        return statistics.median(self.decode_seconds) if self.decode_seconds else None


@dataclasses.dataclass
class Depth:
    """Reference of depth: codes of 16 and of 24 bits, and the metres of the source where they are at hand."""

    streams: list[Stream]
    codes16: list[bytes]
    codes24: list[bytes]
    metres: list[bytes]


@dataclasses.dataclass
class Errors:
    """Errors in units of 16-bit codes and in metres, of pixels that are a surface in both; pixels that are one in one alone."""

    max_codes: float = 0.0
    squares_codes: float = 0.0
    max_m: float = 0.0
    squares_m: float = 0.0
    compared: int = 0
    background_wrong: int = 0

    def __add__(self, other: "Errors") -> "Errors":
        return Errors(max(self.max_codes, other.max_codes), self.squares_codes + other.squares_codes,
                      max(self.max_m, other.max_m), self.squares_m + other.squares_m,
                      self.compared + other.compared, self.background_wrong + other.background_wrong)

    def fields(self) -> dict[str, float]:
        """Fields of a row."""
        mean = lambda total: math.sqrt(total / self.compared) if self.compared else 0.0
        return {"max_error_codes": self.max_codes, "rms_error_codes": mean(self.squares_codes), "max_error_m": self.max_m,
                "rms_error_m": mean(self.squares_m), "background_wrong": self.background_wrong}


def compare(reference: bytes, got: bytes, near_far: tuple[float, float], source: bytes | None = None, wide: bool = False) -> Errors:
    """Errors of codes; `source` are the 32-bit metres that were coded, otherwise those of the reference are."""
    if len(reference) != len(got):
        raise ValueError(f"{len(got)} bytes came back of {len(reference)}")
    wanted, found = (np.frombuffer(codes, type_of_codes(wide)).astype(float) for codes in (reference, got))
    top = TOP_24 if wide else 65534
    surface = (wanted <= top) & (found <= top)
    background_wrong = int(((wanted > top) != (found > top)).sum())
    wanted, found = wanted[surface], found[surface]
    near_m, far_m = near_far
    span = math.log1p((far_m - near_m) / near_m)
    metres = np.frombuffer(source, "<f4").astype(float)[surface] if source else near_m * np.exp(span * wanted / top)
    codes, metres = np.abs(wanted - found) * (65534.0 / top), np.abs(near_m * np.exp(span * found / top) - metres)
    return Errors(float(codes.max(initial=0)), float((codes * codes).sum()), float(metres.max(initial=0)),
                  float((metres * metres).sum()), len(codes), background_wrong)


def depth_errors(depth: Depth, codec: "Codec") -> dict[str, float]:
    """Fields of a row: errors of the codes that come back."""
    wide = codec.film.wide
    reference = depth.codes24 if wide else depth.codes16
    found = (compare(reference[at], codes, depth.streams[at].near_far, depth.metres[at] if depth.metres else None, wide)
             for at, codes in enumerate(codec.codes()))
    return sum(found, Errors()).fields()


def add(times: list[float], seconds: float | None) -> None:
    """A time that could be measured."""
    if seconds is not None:
        times.append(seconds)


class Contest:
    """Codecs and their rows, in the order of the table."""

    def __init__(self, dataset: str, stream: str):
        self.dataset, self.stream = dataset, stream
        self.pairs: list[tuple["Codec | None", Row]] = []

    def add(self, codec: "Codec", note: str = "") -> Row:
        row = Row(self.dataset, self.stream, codec.label, codec.bound, note=note)
        self.pairs.append((codec, row))
        return row

    def missing(self, label: str, why: Any, bound: int | None = None) -> Row:
        """A row that cannot be measured."""
        row = Row(self.dataset, self.stream, label, bound, note=f"not measured: {why}")
        self.pairs.append((None, row))
        return row

    @property
    def rows(self) -> list[Row]:
        return [row for _, row in self.pairs]

    def each(self, action: Callable[["Codec", Row], None]) -> None:
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

    def encode(self, runs: int) -> None:
        """Every codec once, then every codec again: what slows the machine down hits all of them."""
        self.each(lambda codec, _: codec.open())
        for turn in range(runs):
            self.each(lambda codec, row: add(row.encode_seconds, codec.encode()))
            self.say("encode", turn, runs)

    def check(self, errors: Callable[["Codec"], dict[str, float]]) -> None:
        """Sizes, and the fields that `errors` finds of a codec."""
        def one(codec: "Codec", row: Row) -> None:
            row.bytes = codec.size()
            for name, value in errors(codec).items():
                setattr(row, name, value)
        self.each(one)

    def decode(self, runs: int) -> None:
        """In turn, as encoding; the first turn does not count."""
        for turn in range(runs + 1):
            def once(codec: "Codec", row: Row) -> None:
                taken = codec.decode()
                row.written_percent = codec.written
                if turn:
                    add(row.decode_seconds, taken)
            self.each(once)
            self.say("decode", turn, runs + 1)

    def say(self, what: str, turn: int, turns: int) -> None:
        self.note(f"{what} {turn + 1} of {turns}")

    def note(self, words: str) -> None:
        print(f"{self.dataset} {self.stream}: {words}", file=sys.stderr)
