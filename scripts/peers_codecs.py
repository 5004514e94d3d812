"""The codecs that scripts/peers sets beside each other. Each is asked again and again to encode and to decode, in turn.

`encode()` and `decode()` answer seconds that are comparable: the start of a process does not count, input lies in memory
or in the cache of files, decoders write to nothing, and every codec may use the same number of threads.

- In this process (xz, zstd, RVL): the wall time of all streams, a stream at a time for each thread.
- ffmpeg: encoding, the time of all frames less that of the first alone; decoding, that of playing a film several times
  over less that of playing it once.
- libjxl: what cjxl and djxl report, which is without their start; an image at a time for each thread.
- one file for each stream (x265, libaom and SVT-AV1 of colour): processor time of one thread, less that of a frame of 64x64.
- lightfold: the seconds that it reports. Encoding includes reading the source's files, where others find codes ready;
  decoding is the median of passes in one process over a container in memory, after one that does not count. For
  colour, its processor time on one thread: of many passes less that of few.
"""

import concurrent.futures
import ctypes
import ctypes.util
import dataclasses
import lzma
import math
import os
import pathlib
import re
import resource
import shutil
import subprocess
import tempfile
import time
from typing import Any, Callable, Iterable, NamedTuple, Sequence, TypeVar

import numpy as np

import lightfold_runs as lf
from peers_frames import Film, NotMeasured, decoded_payloads
from peers_kernels import Kernels
from peers_measure import Given

T = TypeVar("T")

QUIET = ["ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-y"]
# Seconds that playing a film over and over should take, and how often at most.
LOOP_SECONDS, LOOPS = 0.4, 40
# Passes of lightfold in one process that count; one more goes before them.
PASSES = 3


def need(program: str, package: str) -> None:
    if not shutil.which(program):
        raise NotMeasured(f"{program} is not installed (apt-get install {package})")


def processor_time() -> float:
    """Seconds that processors spent on finished children of this process."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def seconds_of(command: Sequence[Any], clock: Callable[[], float] = time.perf_counter) -> float:
    """Time of a process, by default on the wall; its first complaint where it fails."""
    start = clock()
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    taken = clock() - start
    if done.returncode:
        # SVT-AV1 says what it is, whatever is asked for.
        lines = [line for line in done.stderr.splitlines() if line.strip() and not line.startswith("Svt[info]")]
        lines = lines or [f"exit code {done.returncode}"]
        # ffmpeg's first line is the coder's own, behind its address.
        words = re.sub(r"^\[[^]]*\] ", "", lines[0].strip())
        raise NotMeasured(f"{command[0]}: {words}")
    return taken


class Codec:
    """One row. `bound` is the largest error that it promises, in codes, or None."""

    # How many of the pixels decoding writes, in percent: whole frames.
    written = 100.0
    # Clock of the times of processes.
    clock: Callable[[], float] = staticmethod(time.perf_counter)

    def __init__(self, label: str, film: Film, bound: int | None = None):
        self.label, self.film, self.bound = label, film, bound

    def open(self) -> None:
        """NotMeasured where something is missing."""

    def encode(self) -> float | None:
        """Seconds, or None if they are less than the noise of the start of a process."""
        raise NotImplementedError

    def size(self) -> int:
        raise NotImplementedError

    def decode(self) -> float | None:
        raise NotImplementedError

    def payloads(self) -> list[bytes]:
        """Decoded payloads, as the film has them."""
        raise NotImplementedError

    def codes(self) -> list[bytes]:
        return [self.film.back(payload) for payload in self.payloads()]


class InProcess(Codec):
    """A codec of streams, called here. `pack` and `unpack` work on one stream; threads share the streams."""

    def __init__(self, label: str, film: Film, threads: int, bound: int | None = None):
        super().__init__(label, film, bound)
        self.pool = concurrent.futures.ThreadPoolExecutor(threads)
        self.packed: list[Any] = []

    def pack(self, payload: bytes) -> bytes:
        raise NotImplementedError

    def unpack(self, index: int) -> Any:
        raise NotImplementedError

    def timed(self, work: Callable[[Any], T], items: Iterable[Any]) -> tuple[float, list[T]]:
        start = time.perf_counter()
        found = list(self.pool.map(work, items))
        return time.perf_counter() - start, found

    def encode(self) -> float:
        taken, self.packed = self.timed(self.pack, self.film.payloads)
        return taken

    def size(self) -> int:
        return sum(map(len, self.packed))

    def decode(self) -> float:
        return self.timed(self.unpack, range(len(self.packed)))[0]

    def payloads(self) -> list[bytes]:
        return [bytes(payload) for payload in self.timed(self.unpack, range(len(self.packed)))[1]]


class Xz(InProcess):
    """liblzma through Python's module, as `xz -9e` does it."""

    def pack(self, payload: bytes) -> bytes:
        return lzma.compress(payload, preset=9 | lzma.PRESET_EXTREME)

    def unpack(self, index: int) -> bytes:
        return lzma.decompress(self.packed[index])


class Zstd(InProcess):
    """libzstd, called directly."""

    def __init__(self, label: str, film: Film, threads: int, level: int, bound: int | None = None):
        super().__init__(label, film, threads, bound)
        self.level = level

    def open(self) -> None:
        name = ctypes.util.find_library("zstd")
        if not name:
            raise NotMeasured("libzstd is not installed (apt-get install libzstd1)")
        self.library = ctypes.CDLL(name)
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        for function, *kinds in (("ZSTD_compress", pointer, size, pointer, size, ctypes.c_int),
                                 ("ZSTD_decompress", pointer, size, pointer, size), ("ZSTD_compressBound", size)):
            known = getattr(self.library, function)
            known.restype, known.argtypes = size, kinds
        most = self.library.ZSTD_compressBound
        self.max_bytes = {len(payload): most(len(payload)) for payload in self.film.payloads}
        self.out = [(ctypes.c_char * len(payload))() for payload in self.film.payloads]

    def pack(self, payload: bytes) -> bytes:
        out = (ctypes.c_char * self.max_bytes[len(payload)])()
        return ctypes.string_at(out, self.library.ZSTD_compress(out, len(out), payload, len(payload), self.level))

    def unpack(self, index: int) -> Any:
        out, packed = self.out[index], self.packed[index]
        if self.library.ZSTD_decompress(out, len(out), packed, len(packed)) != len(out):
            raise NotMeasured("libzstd gave back fewer bytes")
        return out


def rotated(codes: bytes, steps: int, count: int) -> bytes:
    """16-bit codes so many steps further round among `count`."""
    return ((np.frombuffer(codes, "<u2").astype(np.uint32) + steps) % count).astype("<u2").tobytes()


class Rvl(InProcess):
    """RVL of peers.c, an image at a time; 4 bytes for each image say how long it is. The background, the largest code, becomes 0,
    which is empty for RVL."""

    def __init__(self, label: str, film: Film, threads: int, kernels: Kernels, bound: int | None = None):
        super().__init__(label, film, threads, bound)
        self.kernels = kernels
        self.type_of_payload = "<u2" if film.unit == 2 else "<u1"

    def open(self) -> None:
        film = self.film
        self.pixels = film.width * film.height
        wide = lambda image: np.frombuffer(image, self.type_of_payload).astype("<u2").tobytes()
        self.images = [[rotated(wide(image), 1, film.values) for image in film.images(payload)] for payload in film.payloads]
        self.scratch = [(ctypes.c_char * (4 * self.pixels + 16))() for _ in self.images]
        self.out = [[(ctypes.c_char * (2 * self.pixels))() for _ in images] for images in self.images]

    def encode(self) -> float:
        pack = lambda at: [self.kernels.rvl_encode(image, self.scratch[at]) for image in self.images[at]]
        taken, self.packed = self.timed(pack, range(len(self.images)))
        return taken

    def size(self) -> int:
        return sum(len(image) + 4 for images in self.packed for image in images)

    def unpack(self, index: int) -> Any:
        for packed, out in zip(self.packed[index], self.out[index]):
            self.kernels.rvl_decode(packed, self.pixels, out)
        return self.out[index]

    def payloads(self) -> list[bytes]:
        values = self.film.values
        back = lambda image: np.frombuffer(rotated(image.raw, values - 1, values), "<u2").astype(self.type_of_payload).tobytes()
        return [b"".join(map(back, images)) for images in self.timed(self.unpack, range(len(self.packed)))[1]]


class Played(Codec):
    """A codec whose program decodes a film several times in one process, so that its start can be left out."""

    loops = 0

    def played(self, times: int) -> float:
        """Seconds of decoding so many times."""
        raise NotImplementedError

    def decode(self) -> float | None:
        if not self.loops:
            once = max(self.played(3) - self.played(1), 1e-3) / 2
            self.loops = min(max(round(LOOP_SECONDS / once), 2), LOOPS)
        taken = (self.played(1 + self.loops) - self.played(1)) / self.loops
        return taken if taken > 0 else None


def raw_source(film: Film, file: pathlib.Path, size: str = "") -> list[Any]:
    """Options of ffmpeg that read frames of a film as they are, or of another size."""
    size = size or f"{film.width}x{film.height}"
    return ["-f", "rawvideo", "-pix_fmt", film.pixel_format, "-s", size, "-r", "25", "-i", file]


class Ffmpeg(Played):
    """A coder of ffmpeg; all streams are one film, and each begins with a frame that needs no other."""

    def __init__(self, label: str, film: Film, given: Given, coder: Sequence[str], bound: int | None = None):
        super().__init__(label, film, bound)
        self.threads, self.coder, self.work = given.threads, coder, given.work
        name = re.sub(r"\W+", "-", f"{film.name}-{label}")
        self.file, self.first = self.work / f"{name}.mkv", self.work / f"{name}-first.mkv"

    def open(self) -> None:
        need("ffmpeg", "ffmpeg")

    def encoding(self, target: pathlib.Path, *more: str) -> list[Any]:
        return [*QUIET, *raw_source(self.film, self.film.raw(self.work)), *self.coder, "-threads", self.threads, *more, target]

    def encode(self) -> float | None:
        first = seconds_of(self.encoding(self.first, "-frames:v", "1"), self.clock)
        whole = seconds_of(self.encoding(self.file), self.clock)
        # One frame's share is given back: the first was encoded too.
        taken = (whole - first) * self.film.frames / max(self.film.frames - 1, 1)
        return taken if taken > 0 else None

    def size(self) -> int:
        return os.path.getsize(self.file)

    def played(self, times: int) -> float:
        loop = ["-stream_loop", str(times - 1)] if times > 1 else []
        return seconds_of([*QUIET, "-threads", self.threads, *loop, "-i", self.file, "-f", "null", "-"], self.clock)

    def payloads(self) -> list[bytes]:
        back = self.file.with_suffix(".back")
        # Full chroma and exact rounding, where colours are converted.
        scale = ["-sws_flags", "accurate_rnd+full_chroma_int+full_chroma_inp"]
        seconds_of([*QUIET, "-i", self.file, *scale, "-f", "rawvideo", "-pix_fmt", self.film.pixel_format, back])
        data = back.read_bytes()
        back.unlink()
        return self.film.split(data)


def key_frames(film: Film) -> list[str]:
    """Options that begin every stream with a key frame; times lie a little before a frame, where rounding does no harm."""
    starts, at = [], 0
    for stream in film.streams:
        starts.append(f"{max(at - 0.25, 0) / 25:.4f}")
        at += stream.frames
    return ["-force_key_frames", ",".join(starts)]


class Ffv1(Ffmpeg):
    """Range coder and the larger contexts, which are smaller here. ffv1 knows key frames at even distances alone."""

    def __init__(self, label: str, film: Film, given: Given, options: Sequence[str] = (), bound: int | None = None):
        self.lengths = {stream.frames for stream in film.streams}
        apart = ["-g", str(min(self.lengths))]
        super().__init__(label, film, given, [*options, "-c:v", "ffv1", "-level", "3", "-coder", "1", "-context", "1", *apart], bound)

    def open(self) -> None:
        super().open()
        if len(self.lengths) > 1:
            raise NotMeasured(f"ffv1 begins each stream with a key frame where all have one length, not {min(self.lengths)} "
                              f"to {max(self.lengths)} frames")


def x265(film: Film, threads: str, setting: str) -> list[str]:
    """Key frames that are forced stand nearer than x265 likes: they reset what is referred to only if they must."""
    return ["-c:v", "libx265", "-preset", "medium", *key_frames(film), "-forced-idr", "1",
            "-x265-params", f"{setting}:pools={threads}:log-level=error"]


class Dial(NamedTuple):
    """A setting of quality, larger is better: where a search starts, and roughly what one more is worth in what is searched for."""

    start: float
    slope: float
    lowest: float
    highest: float

    def following(self, wanted: float, known: dict[float, float]) -> float:
        """The setting to try next: between the known ones below and above what is wanted, else beyond the nearest."""
        below = max((at for at, found in known.items() if found < wanted), default=None)
        above = min((at for at, found in known.items() if found >= wanted), default=None)
        if not known:
            at = self.start
        elif below is not None and above is not None and below < above:
            share = (wanted - known[below]) / (known[above] - known[below])
            at = below + (above - below) * min(max(share, 0.1), 0.9)
        else:
            nearest = min(known, key=lambda tried: abs(known[tried] - wanted))
            at = nearest + (wanted - known[nearest]) / self.slope
        return round(min(max(at, self.lowest), self.highest), 3)


@dataclasses.dataclass
class Coder:
    """A coder of ffmpeg with its setting of quality."""

    suffix: str
    decoder: str
    # By quality, and a share of 0 to 1 that is another one for each stream.
    options: Callable[[float, float], list[str]]
    dial: Dial
    pixels: str = "yuv444p"


def x265_of(preset: str) -> Callable[[float, float], list[str]]:
    def options(quality: float, _: float) -> list[str]:
        alone = f"crf={51 - quality:.3f}:pools=none:frame-threads=1:info=0:log-level=error"
        return ["-c:v", "libx265", "-preset", preset, "-x265-params", alone]
    return options


def whole_crf(quality: float, share: float) -> str:
    """AV1 takes whole steps alone: what lies between is one step for some streams and the next for the others."""
    return str(63 - math.floor(quality + share))


def libaom(quality: float, share: float) -> list[str]:
    crf = whole_crf(quality, share)
    return ["-c:v", "libaom-av1", "-cpu-used", "6", "-crf", crf, "-b:v", "0", "-threads", "1", "-row-mt", "0"]


def svt_av1(quality: float, share: float) -> list[str]:
    return ["-c:v", "libsvtav1", "-preset", "6", "-crf", whole_crf(quality, share), "-svtav1-params", "lp=1"]


CODERS = {
    "x265 medium": Coder(".hevc", "hevc", x265_of("medium"), Dial(35, 2.0, 0, 51)),
    "x265 slow": Coder(".hevc", "hevc", x265_of("slow"), Dial(35, 2.0, 0, 51)),
    "libaom, cpu-used 6": Coder(".obu", "libdav1d", libaom, Dial(42, 1.0, 0, 63)),
    # It codes nothing but 4:2:0.
    "SVT-AV1, preset 6, 4:2:0": Coder(".obu", "libdav1d", svt_av1, Dial(42, 1.0, 0, 62), "yuv420p"),
}
# Rec. 709, as players expect it, with full chroma and exact rounding.
TO_YUV = "scale=out_color_matrix=bt709:flags=accurate_rnd+full_chroma_int+full_chroma_inp,format="
TO_RGB = "scale=in_color_matrix=bt709:flags=accurate_rnd+full_chroma_int+full_chroma_inp,format=rgb24"


class PerStream(Played):
    """A coder of ffmpeg in a raw file for each stream."""

    clock = staticmethod(processor_time)

    def __init__(self, label: str, film: Film, work: pathlib.Path):
        super().__init__(label, film)
        self.coder, self.quality = CODERS[label], CODERS[label].dial.start
        # Files that are coded at once: more than one where no time is taken.
        self.at_once = 1
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=work))
        self.files = [self.folder / f"{at:06}{self.coder.suffix}" for at in range(len(film.payloads))]

    def open(self) -> None:
        need("ffmpeg", "ffmpeg")
        encoder = self.coder.options(0, 0)[1]
        known = subprocess.run([*QUIET, "-h", f"encoder={encoder}"], stdin=subprocess.DEVNULL, capture_output=True, text=True)
        if "is not recognized" in known.stdout + known.stderr:
            raise NotMeasured(f"this ffmpeg has no {encoder}")
        self.sources: list[pathlib.Path] = []
        for at, payload in enumerate(self.film.payloads):
            self.sources.append(self.film.raw(self.folder.parent).with_suffix(f".{at:06}"))
            if not self.sources[at].exists():
                self.sources[at].write_bytes(payload)

    def coding(self, at: int, target: pathlib.Path, *more: str, size: str = "") -> list[Any]:
        """The command that codes a stream."""
        source = raw_source(self.film, self.sources[at], size)
        # Shares spread evenly, and are not those of neighbouring faces.
        share = (at * 0.618) % 1
        return [*QUIET, *source, "-vf", TO_YUV + self.coder.pixels, *self.coder.options(self.quality, share), *more, target]

    def encode(self) -> float | None:
        small = self.coding(0, self.folder / f"start{self.coder.suffix}", "-frames:v", "1", size="64x64")
        start = seconds_of(small, self.clock)
        taken = sum(self.each(lambda at: seconds_of(self.coding(at, self.files[at]), self.clock)))
        return taken - start * len(self.files) if taken > start * len(self.files) else None

    def size(self) -> int:
        return sum(map(os.path.getsize, self.files))

    def played(self, times: int) -> float:
        film = self.folder / f"film{self.coder.suffix}"
        film.write_bytes(b"".join(file.read_bytes() for file in self.files) * times)
        source = ["-threads", "1", "-c:v", self.coder.decoder, "-i", film]
        return seconds_of([*QUIET, *source, "-fps_mode", "passthrough", "-f", "null", "-"], self.clock)

    def each(self, work: Callable[[int], T]) -> list[T]:
        """Results of `work` for the index of every file."""
        with concurrent.futures.ThreadPoolExecutor(self.at_once) as pool:
            return list(pool.map(work, range(len(self.files))))

    def payloads(self) -> list[bytes]:
        def decoded(at: int) -> bytes:
            back = self.folder / f"{at:06}.back"
            decoder = ["-threads", "1", "-c:v", self.coder.decoder, "-i", self.files[at]]
            seconds_of([*QUIET, *decoder, "-fps_mode", "passthrough", "-vf", TO_RGB, "-f", "rawvideo", back])
            return back.read_bytes()
        return self.film.split(b"".join(self.each(decoded)))


def swapped(image: bytes) -> bytes:
    """16-bit samples in the other order of their bytes."""
    return np.frombuffer(image, "<u2").byteswap().tobytes()


class Jxl(Codec):
    """libjxl's own programs on 16-bit gray images; they report their speed without their start."""

    def __init__(self, label: str, film: Film, threads: int, work: pathlib.Path):
        super().__init__(label, film, 0)
        self.folder = work / "jxl"
        self.pool = concurrent.futures.ThreadPoolExecutor(threads)
        self.threads = threads

    def open(self) -> None:
        for program in ("cjxl", "djxl"):
            need(program, "libjxl-tools")
        self.folder.mkdir(exist_ok=True)
        head = f"P5\n{self.film.width} {self.film.height}\n65535\n".encode()
        self.files: list[pathlib.Path] = []
        for payload in self.film.payloads:
            for image in self.film.images(payload):
                path = self.folder / f"{len(self.files):06}.pgm"
                path.write_bytes(head + swapped(image))
                self.files.append(path)

    def spent(self, program: str, *more: str) -> float:
        """Seconds of all images, `threads` at once by one thread each."""
        def one(path: pathlib.Path) -> float:
            coded = path.with_suffix(".jxl")
            inputs = [path, coded] if program == "cjxl" else [coded]
            command = [program, *inputs, *more, "--num_threads", "0" if program == "cjxl" else "1"]
            done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
            speed = re.search(r"([\d.]+) MP/s \[", done.stderr)
            if done.returncode or not speed or float(speed[1]) == 0:
                raise NotMeasured(f"{program} names no speed: {done.stderr.strip()[-200:]}")
            return self.film.width * self.film.height / (1e6 * float(speed[1]))
        return sum(self.pool.map(one, self.files)) / self.threads

    def encode(self) -> float:
        return self.spent("cjxl", "-d", "0", "--num_reps", "2")

    def size(self) -> int:
        return sum(os.path.getsize(path.with_suffix(".jxl")) for path in self.files)

    def decode(self) -> float:
        return self.spent("djxl", "--num_reps", "3")

    def payloads(self) -> list[bytes]:
        back, images = self.folder / "back.pgm", []
        for path in self.files:
            seconds_of(["djxl", path.with_suffix(".jxl"), back, "--quiet"])
            images.append(swapped(back.read_bytes()[-self.film.frame_bytes:]))
        return self.film.split(b"".join(images))


class Lightfold(Codec):
    """The program of this repository, from the source's files."""

    # The kind of stream.
    kind = "depth"

    def __init__(self, label: str, film: Film, given: Given, options: Sequence[Any], bound: int | None = None):
        super().__init__(label, film, bound)
        self.given, self.options = given, [str(option) for option in options]
        self.file = given.work / (re.sub(r"\W+", "-", f"{self.kind}-{label}") + ".lfold")

    def encoding(self, threads: str, *more: str) -> list[Any]:
        return [self.given.binary, "encode", self.given.manifest, "--stream", self.kind, "--clip", *self.options,
                "--threads", threads, "-o", self.file, *more]

    def encode(self) -> float:
        return float(lf.run_json(*self.encoding(self.given.threads, "--json"))["seconds"])

    def size(self) -> int:
        return os.path.getsize(self.file)

    def decode(self) -> float | None:
        command = [self.given.binary, "decode", self.file, "--null", "--repeat", PASSES, "--threads", self.given.threads]
        report = lf.run_json(*command, "--json")
        self.written = 100 * report["updated_pixels"] / report["pixels"]
        return float(report["seconds"])

    def payloads(self) -> list[bytes]:
        return decoded_payloads(self.given.binary, self.file, self.kind, self.film.streams, self.given.work)


class LightfoldColor(Lightfold):
    kind = "color"


class OneThread(Played, LightfoldColor):
    """Ours on one thread, by processor time."""

    clock = staticmethod(processor_time)

    def __init__(self, label: str, film: Film, given: Given, options: Sequence[Any]):
        super().__init__(label, film, given, options)
        self.file = pathlib.Path(tempfile.mkdtemp(dir=given.work)) / "ours.lfold"

    def encode(self) -> float:
        return seconds_of(self.encoding("1", "-q"), self.clock)

    def played(self, times: int) -> float:
        return seconds_of([self.given.binary, "decode", self.file, "--null", "--threads", "1", "--repeat", times, "-q"],
                          self.clock)
