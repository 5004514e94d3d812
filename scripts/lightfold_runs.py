"""What the scripts beside this file share: finding the program and the footage, running, timing, writing tables."""

import datetime
import json
import os
import pathlib
import platform
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SETS = ["sponza", "sponza9", "sponza1k", "glass", "object", "equirect"]


def build():
    """Builds the release binary and answers its path; LIGHTFOLD names another one instead."""
    named = os.environ.get("LIGHTFOLD")
    if named:
        if not shutil.which(named):
            raise Failed([named], 127, f"LIGHTFOLD: {named} is no program")
        return named
    subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=ROOT, check=True)
    return str(pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "lightfold")


def data_folder():
    """Where the data sets are: LIGHTFOLD_DATA, else ../shared/data."""
    return pathlib.Path(os.environ.get("LIGHTFOLD_DATA", ROOT.parent / "shared" / "data"))


class Failed(SystemExit):
    """A command that ended with an exit code that was not expected."""

    def __init__(self, command, code, words):
        self.words = words
        super().__init__(f"{' '.join(map(str, command))}: exit code {code}\n{words}")

    def sentence(self):
        """The last line of what it said."""
        lines = [line for line in self.words.splitlines() if line.strip()]
        return lines[-1].strip() if lines else str(self.code)


def footage(binary, work):
    """(name, manifest) of every data set at hand: those under LIGHTFOLD_DATA or ../shared/data, else the demo."""
    data = data_folder()
    found = [(name, data / name / "lightfield.json") for name in SETS if (data / name / "lightfield.json").is_file()]
    if found:
        return found
    print(f"{data} holds none of the measured data sets; the demo's scene takes their place", file=sys.stderr)
    demo = pathlib.Path(work) / "demo"
    subprocess.run([binary, "demo", "-o", str(demo), "--quiet"], check=True, stdout=subprocess.DEVNULL)
    return [("demo", next(demo.rglob("lightfield.json")))]


def with_infinities(report):
    """An object of a report: a number that is null beside a key `…_is` is infinite."""
    infinite = {key.removesuffix("_is"): float(word) for key, word in report.items() if word in ("inf", "-inf") and key.endswith("_is")}
    return report | {key: value for key, value in infinite.items() if key in report}


def run_json(*command, may_differ=False):
    """Runs a command that reports JSON. `may_differ` accepts exit code 1, as `diff` gives it."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode not in ([0, 1] if may_differ else [0]):
        raise Failed(command, done.returncode, done.stderr)
    try:
        return json.loads(done.stdout, object_hook=with_infinities)
    except ValueError as error:
        raise Failed(command, done.returncode, f"{command[0]} {command[1]}: JSON was expected, {error}") from error


def sweep(binary, subject, folder, knobs, more):
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


def peak_memory_mb(command):
    """Peak resident memory of one run, in MB."""
    process = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{' '.join(map(str, command))}: exit code {process.returncode}")
    return usage.ru_maxrss / 1000


def megabytes(count):
    return f"{count / 1e6:.2f}"


def table(head, rows):
    """A Markdown table; the first column is left-aligned, the others right."""
    lines = ["| " + " | ".join(head) + " |", "| --- |" + " ---: |" * (len(head) - 1)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


def now():
    """The date and time in UTC, as recorded rows have it."""
    return datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


def busy(load):
    """Is a load average so high that times which are taken then are void? Half a process for each processor may run."""
    return load > 0.5 * os.cpu_count()


def machine():
    """One line about the machine, for the foot of a table."""
    model = platform.machine()
    try:
        text = pathlib.Path("/proc/cpuinfo").read_text()
        model = re.search(r"model name\s*:\s*(.*)", text).group(1)
    except (OSError, AttributeError):
        pass
    return f"{model}, {len(os.sched_getaffinity(0))} threads"


def write_between(marker, text, path=ROOT / "BENCHMARKS.md"):
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
