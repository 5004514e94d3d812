"""Common parts of the scripts beside this file: finding packages, the program and the footage, running, timing, writing tables."""

import argparse
import datetime
import json
import os
import pathlib
import platform
import re
import shutil
import subprocess
import sys
from typing import Any, Iterable, Sequence

ROOT = pathlib.Path(__file__).resolve().parent.parent
SETS = ["sponza", "sponza9", "sponza1k", "glass", "object", "equirect"]


Binary = str | pathlib.Path


def need_packages() -> None:
    """Runs the script again with the Python that need.bash sets up, where this one has no numpy, Pillow or OpenEXR."""
    try:
        import images  # noqa: F401
        return
    except ImportError as error:
        reason = error
    install = '. "$0" && need_python numpy OpenEXR pillow && echo "$python"'
    done = subprocess.run(["bash", "-c", install, ROOT / "scripts" / "need.bash"], stdout=subprocess.PIPE, text=True)
    python = done.stdout.strip()
    if done.returncode or python == sys.executable:
        print(f"numpy, Pillow and OpenEXR are needed: python3 -m pip install -c scripts/requirements.txt numpy pillow OpenEXR ({reason})",
              file=sys.stderr)
        sys.exit(2)
    os.execv(python, [python, *sys.orig_argv[1:]])


def build() -> str:
    """Builds the release binary and returns its path; LIGHTFOLD names another one instead."""
    named = os.environ.get("LIGHTFOLD")
    if named:
        if not shutil.which(named):
            raise Failed([named], 127, f"LIGHTFOLD: {named} is no program")
        return named
    subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=ROOT, check=True)
    return str(pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "lightfold")


def data_folder() -> pathlib.Path:
    """Where the data sets are: LIGHTFOLD_DATA, else ../shared/data."""
    return pathlib.Path(os.environ.get("LIGHTFOLD_DATA", ROOT.parent / "shared" / "data"))


class Failed(SystemExit):
    """A command that ended with an exit code that was not expected."""

    def __init__(self, command: Sequence[Any], code: int, words: str):
        self.words = words
        super().__init__(f"{' '.join(map(str, command))}: exit code {code}\n{words}")

    def sentence(self) -> str:
        """The last line of what it said."""
        lines = [line for line in self.words.splitlines() if line.strip()]
        return lines[-1].strip() if lines else str(self.code)


def footage(binary: Binary, work: str | pathlib.Path) -> list[tuple[str, pathlib.Path]]:
    """(name, manifest) of every data set at hand: those under LIGHTFOLD_DATA or ../shared/data, else the demo."""
    data = data_folder()
    found = [(name, data / name / "lightfield.json") for name in SETS if (data / name / "lightfield.json").is_file()]
    if found:
        return found
    print(f"{data} holds none of the measured data sets; the demo's scene takes their place", file=sys.stderr)
    demo = pathlib.Path(work) / "demo"
    subprocess.run([binary, "demo", "-o", str(demo), "--quiet"], check=True, stdout=subprocess.DEVNULL)
    return [("demo", next(demo.rglob("lightfield.json")))]


def with_infinities(report: dict[str, Any]) -> dict[str, Any]:
    """An object of a report: a number that is null beside a key `…_is` is infinite."""
    infinite = {key.removesuffix("_is"): float(word) for key, word in report.items() if word in ("inf", "-inf") and key.endswith("_is")}
    return report | {key: value for key, value in infinite.items() if key in report}


def run_json(*command: Any, may_differ: bool = False) -> Any:
    """Runs a command that reports JSON. `may_differ` accepts exit code 1, as `diff` gives it."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode not in ([0, 1] if may_differ else [0]):
        raise Failed(command, done.returncode, done.stderr)
    try:
        return json.loads(done.stdout, object_hook=with_infinities)
    except ValueError as error:
        raise Failed(command, done.returncode, f"{command[0]} {command[1]}: JSON was expected, {error}") from error


def sweep(binary: Binary, subject: Any, folder: pathlib.Path, knobs: list[str], more: list[str]) -> Any:
    """Measures a grid of knobs, such as `area=1,2`, into a folder; prints what was found. `more` are options of all points."""
    # Knobs that are swept cannot be fixed as well.
    names = {f"--{knob.split('=')[0]}" for knob in knobs}
    fixed = [word for at, word in enumerate(more)
             if word.split("=")[0] not in names and not (at > 0 and more[at - 1] in names)]
    words = [part for knob in knobs for part in ("--sweep", knob)]
    report = run_json(binary, "tradeoff", subject, *words, "--repeats", "1", "--overwrite", "-o", folder, "--json", "--", *fixed)
    for finding in report["findings"]:
        if finding["verdict"] != "not measured":
            print(f"{folder.name}: {finding['verdict']}: {finding['sentence']} {finding['rests_on']}")
    for point in report["failed"]:
        print(f"{folder.name}: {point['error']}", file=sys.stderr)
    return report


def peak_memory_mb(command: Sequence[Any]) -> float:
    """Peak resident memory of one run, in MB."""
    process = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{' '.join(map(str, command))}: exit code {process.returncode}")
    return usage.ru_maxrss / 1000


def parser(about: str | None, name: str | None = None) -> argparse.ArgumentParser:
    """A parser whose description is printed as it is written."""
    return argparse.ArgumentParser(prog=name, description=about, formatter_class=argparse.RawDescriptionHelpFormatter)


def split_words(words: list[str]) -> tuple[list[str], list[str]]:
    """Words before `--` and behind it."""
    at = words.index("--") if "--" in words else len(words)
    return words[:at], words[at + 1:]


def manifest_path(manifest: str | pathlib.Path) -> pathlib.Path:
    """The file of a dataset that is named by it or by its folder."""
    path = pathlib.Path(manifest)
    return path / "lightfield.json" if path.is_dir() else path


def megabytes(count: float) -> str:
    return f"{count / 1e6:.2f}"


def table(head: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """A Markdown table; the first column is left-aligned, the others right."""
    head = list(head)
    line = lambda cells: f"| {' | '.join(map(str, cells))} |"
    return "\n".join([line(head), "| --- |" + " ---: |" * (len(head) - 1), *map(line, rows)])


def now() -> str:
    """The date and time in UTC, as recorded rows have it."""
    return datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


def busy(load: float) -> bool:
    """True if times that are taken at a load average are void: more than half a process for each processor."""
    return load > 0.5 * (os.cpu_count() or 1)


def commit() -> str:
    """The short name of the commit."""
    return subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip()


def machine() -> str:
    """One line about the machine, for the foot of a table."""
    model = platform.machine()
    try:
        text = pathlib.Path("/proc/cpuinfo").read_text()
        found = re.search(r"model name\s*:\s*(.*)", text)
        model = found[1] if found else model
    except OSError:
        pass
    return f"{model}, {len(os.sched_getaffinity(0))} threads"


def write_between(marker: str, text: str, path: pathlib.Path = ROOT / "BENCHMARKS.md") -> None:
    """Puts `text` between `<!-- table:MARKER -->` and `<!-- end:MARKER -->` of a file. Of most tables BENCHMARKS.md has excerpts
    and no markers: then nothing is written."""
    page = path.read_text()
    begin, end = f"<!-- table:{marker} -->", f"<!-- end:{marker} -->"
    if begin not in page and path.resolve() == ROOT / "BENCHMARKS.md":
        print(f"{path.name} has no {begin}: nothing is written", file=sys.stderr)
        return
    if begin not in page or end not in page:
        sys.exit(f"{path} has no {begin} and {end}")
    head, rest = page.split(begin, 1)
    _, tail = rest.split(end, 1)
    path.write_text(f"{head}{begin}\n{text}\n{end}{tail}")
