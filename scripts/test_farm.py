"""Tests of scripts/farm: python3 -m unittest discover -s scripts

The script of one task is tested with a program of a few lines. The template is run with openjd-cli, which scripts/test installs, and
the Slurm scripts with a Slurm of one machine, both with lightfold; what is missing is said, and skipped.
"""

import filecmp
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest
from typing import Any, Sequence

from for_tests import HERE, Folder, lightfold, module_of

FARM = HERE / "farm"
# Writes down its arguments, and does as FAIL says: `2 75` ends the first two tries with exit code 75.
RECORDER = """#!/usr/bin/env bash
printf '%s\\n' "$*" >>"$CALLS"
[ "$(wc -l <"$CALLS")" -gt "${FAIL% *}" ] || exit "${FAIL#* }"
"""


def openjd() -> str | None:
    return shutil.which("openjd") or shutil.which(pathlib.Path(sys.executable).with_name("openjd"))


def program(path: pathlib.Path, text: str) -> str:
    path.write_text(text)
    path.chmod(0o755)
    return str(path)


class FarmTest(Folder):
    def run_in(self, *command: Any, **environment: str) -> subprocess.CompletedProcess[str]:
        """Runs a command in the folder."""
        return subprocess.run([str(word) for word in command], cwd=self.work, capture_output=True, text=True,
                              env=dict(os.environ, **environment))


class OneTask(FarmTest):
    def setUp(self) -> None:
        super().setUp()
        self.program = program(self.work / "recorder", RECORDER)
        # What tasks before have written: a task whose inputs are missing may be tried again.
        for film, names in [("film.lfold", ["scan-1-of-2.json", "scan-2-of-2.json", "scan-of-12.json", "scan-of-1.json", "scan-of-4.json",
                                            "shard-1-of-2.lfold", "shard-2-of-2.lfold"]),
                            ("sets/room.lfold", ["shard-1-of-1.lfold"])]:
            parts = self.work / f"{film}.parts"
            parts.mkdir(parents=True)
            for name in names:
                (parts / name).touch()

    def task(self, *words: str, fail: str = "0 0", **environment: str) -> tuple[int, list[str]]:
        """(exit code, what the program was called with) of one task."""
        calls = self.work / "calls"
        calls.unlink(missing_ok=True)
        done = self.run_in("bash", FARM / "task", *words, LIGHTFOLD=self.program, CALLS=str(calls), FAIL=fail,
                           LIGHTFOLD_RETRY_SECONDS="0", **environment)
        return done.returncode, calls.read_text().splitlines() if calls.exists() else []

    def test_command_lines(self) -> None:
        parts = "film.lfold.parts"
        for words, expected in [
            (["scan", "room", "film.lfold", "2/3"],
             f"scan room --shard 2/3 -o {parts}/scan-2-of-3.json --progress none"),
            (["merge-scans", "room", "film.lfold", "2"],
             f"scan --merge {parts}/scan-1-of-2.json {parts}/scan-2-of-2.json -o {parts}/scan-of-2.json --progress none"),
            (["encode", "room", "film.lfold", "10/12", "--psnr", "45"],
             f"encode room --scan {parts}/scan-of-12.json --shard 10/12 -o {parts}/shard-10-of-12.lfold --resume --psnr 45 "
             "--progress none"),
            (["merge", "room", "film.lfold", "2"],
             f"pack {parts}/shard-1-of-2.lfold {parts}/shard-2-of-2.lfold -o film.lfold --progress none"),
        ]:
            self.assertEqual(self.task(*words), (0, [expected]))

    def test_inputs_that_are_missing_may_be_tried_again(self) -> None:
        for words in [["merge-scans", "room", "film.lfold", "3"], ["encode", "room", "film.lfold", "1/5"], ["merge", "room", "film.lfold", "3"]]:
            self.assertEqual(self.task(*words, LIGHTFOLD_RETRIES="0"), (75, []), words)

    def test_an_empty_output_is_beside_the_dataset(self) -> None:
        for dataset in ["sets/room", "sets/room/", "sets/room/lightfield.json"]:
            _, calls = self.task("merge", dataset, "", "1")
            self.assertEqual(calls, ["pack sets/room.lfold.parts/shard-1-of-1.lfold -o sets/room.lfold --progress none"])

    def test_options_of_one_line(self) -> None:
        recorder = program(self.work / "words", '#!/usr/bin/env bash\nprintf "<%s>" "$@"\n')
        done = self.run_in("bash", FARM / "task", "encode", "room", "film.lfold", "1/1", "--psnr", "45", LIGHTFOLD=recorder,
                           LIGHTFOLD_OPTIONS="--depth-channel 'a depth' --stream=\"depth\"", LIGHTFOLD_PROGRESS="openjd",
                           LIGHTFOLD_THREADS="2")
        self.assertTrue(done.stdout.endswith(
            "<--psnr><45><--depth-channel><a depth><--stream=depth><--progress><openjd><--threads><2>"), done.stdout)

    def test_scans_get_the_options_of_encodes(self) -> None:
        _, calls = self.task("scan", "room", "film.lfold", "1/1", "--near=2", "--psnr", "45", LIGHTFOLD_OPTIONS="--lzma2")
        self.assertEqual(calls, ["scan room --shard 1/1 -o film.lfold.parts/scan-1-of-1.json --near=2 --psnr 45 --lzma2 "
                                 "--progress none"])

    def test_what_is_refused(self) -> None:
        for words in [[], ["encode"], ["encode", "room", "", "0/3"], ["encode", "room", "", "4/3"], ["encode", "room", "", "3"],
                      ["merge", "room", "", "1/3"], ["scanner", "room", "", "1/3"], ["merge", "room", "", "many"]]:
            self.assertEqual(self.task(*words), (2, []), words)

    def test_exit_code_75_alone_is_tried_again(self) -> None:
        words = ["encode", "room", "film.lfold", "3/4"]
        for fail, retries, code, tries in [("2 75", "3", 0, 3), ("2 75", "1", 75, 2), ("2 75", "0", 75, 1), ("2 2", "3", 2, 1),
                                           ("2 1", "3", 1, 1), ("2 130", "3", 130, 1)]:
            found, calls = self.task(*words, fail=fail, LIGHTFOLD_RETRIES=retries)
            self.assertEqual((found, len(calls)), (code, tries), fail)

    def test_sigterm_reaches_the_program(self) -> None:
        program(self.work / "waiting", "#!/usr/bin/env python3\nimport signal, sys\n"
                "signal.signal(signal.SIGTERM, lambda *_: sys.exit(130))\nprint('ready', flush=True)\nsignal.pause()\n")
        running = subprocess.Popen(["bash", FARM / "task", "encode", "room", "film.lfold", "1/1"], cwd=self.work, text=True,
                                   stdout=subprocess.PIPE, env=dict(os.environ, LIGHTFOLD="./waiting", LIGHTFOLD_RETRIES="3"))
        assert running.stdout
        self.assertEqual(running.stdout.readline(), "ready\n")
        begin = time.monotonic()
        running.send_signal(signal.SIGTERM)
        running.communicate(timeout=20)
        self.assertEqual(running.returncode, 130)
        self.assertLess(time.monotonic() - begin, 10)


class Template(FarmTest):
    """encode.openjd.yaml through openjd-cli, with lightfold."""

    def setUp(self) -> None:
        super().setUp()
        if not openjd():
            self.skipTest("openjd is missing: pip install -c scripts/requirements.txt openjd-cli")

    def capture(self, *options: str) -> str:
        binary = lightfold()
        if not binary:
            self.skipTest("lightfold is not built")
        positions = ["--position=-0.3,1.5,0", "--position=0.3,1.5,0"]
        for command in [["capture", "interior", *positions, "--size", "32", "--frames", "0-3", "-o", "room"],
                        ["encode", "room", "-o", "one.lfold", "--clip", *options]]:
            done = self.run_in(binary, *command, "--quiet")
            self.assertEqual(done.returncode, 0, done.stderr)
        return binary

    def openjd_run(self, *parameters: str, options: Sequence[str] = (), failing: str = "") -> subprocess.CompletedProcess[str]:
        """Runs the template and one encode; `failing` is a case of a shell that stands before the program of the template."""
        binary = self.capture(*options)
        if failing:
            binary = program(self.work / "failing", f"#!/usr/bin/env bash\necho \"$*\" >>{self.work}/calls\ncase \"$*\" in\n"
                             f"{failing}\nesac\nexec {binary} \"$@\"\n")
        words = [word for parameter in (*parameters, f"Options={' '.join(['--clip', *options])}") for word in ("-p", parameter)]
        return self.run_in(openjd(), "run", FARM / "encode.openjd.yaml", *words, "-p", f"Lightfold={binary}")

    def calls(self, words: str) -> int:
        return sum(words in line for line in (self.work / "calls").read_text().splitlines())

    def same_bytes(self, path: str) -> None:
        self.assertTrue(filecmp.cmp(self.work / "one.lfold", self.work / path, shallow=False), "other bytes than one encode")

    def test_it_is_a_valid_template(self) -> None:
        done = self.run_in(openjd(), "check", FARM / "encode.openjd.yaml")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_all_steps_write_the_bytes_of_one_encode(self) -> None:
        done = self.openjd_run("Dataset=room", "Shards=3")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.same_bytes("room.lfold")
        # Shards to scan and to encode, and two steps that join.
        self.assertIn("Chunks run: 8", done.stdout)
        self.assertIn("openjd_progress: 100", done.stdout)

    def test_one_of_eight_shards_fails_once_and_is_tried_again(self) -> None:
        mark = self.work / "failed"
        done = self.openjd_run("Dataset=room", "Output=film.lfold", "Shards=8", "Retries=1", "RetrySeconds=0",
                               options=["--depth-codec", "quadtree", "--psnr", "45"],
                               failing=f"*encode*\"--shard 3/8\"*) [ -e {mark} ] || {{ touch {mark}; exit 75; }} ;;")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.same_bytes("film.lfold")
        for shard in range(1, 9):
            self.assertEqual(self.calls(f"scan-of-8.json --shard {shard}/8"), 2 if shard == 3 else 1)

    def test_bad_input_ends_the_job_at_once(self) -> None:
        done = self.openjd_run("Dataset=room", "Output=film.lfold", "Shards=2", "RetrySeconds=0",
                               failing="*encode*\"--shard 2/2\"*) exit 2 ;;")
        self.assertNotEqual(done.returncode, 0)
        self.assertFalse((self.work / "film.lfold").exists())
        self.assertEqual(self.calls("scan-of-2.json --shard 2/2"), 1)
        self.assertEqual(self.calls("pack"), 0)


class Slurm(FarmTest):
    def test_arrays_that_requeue(self) -> None:
        binary = lightfold()
        if not binary:
            self.skipTest("lightfold is not built")
        done = self.run_in("bash", FARM / "test-slurm", LIGHTFOLD=binary)
        if done.returncode == 3:
            self.skipTest(done.stdout.strip())
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(done.stdout.count("passed: "), 2)

    def test_usage(self) -> None:
        for words in [[], ["room", "--shards", "0"], ["room", "--shards"], ["room", "--fast"], ["room", "other"], ["nowhere"]]:
            done = self.run_in("bash", FARM / "slurm" / "submit", *words)
            self.assertEqual(done.returncode, 2, words)
            self.assertTrue(done.stderr)


class Farm:
    """A farm where nothing goes wrong."""
    streams, size, frames, shards = 2, 1000, 50, 10
    server_gbit = machine_gbit = 80.0
    disk_mb, start_seconds, retry_seconds = 1000.0, 0.0, 60.0
    slow_share, slow_factor, failures = 0.0, 3.0, 0.0

    def __init__(self, **other: Any):
        self.__dict__.update(other)


class Simulation(FarmTest):
    def setUp(self) -> None:
        super().setUp()
        self.model = module_of("farm/simulate")
        # 0.1 s a megapixel of scanning, 1 s of encoding; 10 bytes read and 0.1 written for a pixel.
        self.path = self.work / "times.csv"
        row = lambda stage, shard, of, megapixels, read, written, seconds: dict(zip(self.model.HEAD, [
            "2026-01-01T00:00:00Z", "a machine", "abc", "room", stage, shard, of, megapixels, read, written, seconds, ""]))
        self.model.write_rows(self.path, [row("scan", 1, 2, 10, 4e7, 100, 1.0), row("scan", 2, 2, 10, 4e7, 100, 1.0)])
        self.model.write_rows(self.path, [row("encode", 1, 2, 20, 2e8, 2e6, 20.0), row("encode", 2, 2, 20, 2e8, 2e6, 20.0),
                                          row("merge", 1, 1, 40, 4e6, 4e6, 0.04)])
        self.stages, _ = self.model.recorded(self.path)

    def run_farm(self, machines: int, seed: Any = 1, **other: Any) -> Any:
        return self.model.simulate(self.stages, Farm(**other), machines, seed)

    def test_time_is_that_of_the_processors(self) -> None:
        # 100 megapixels, half of them scanned.
        for machines, scan, encode in [(1, 5.0, 100.0), (5, 1.0, 20.0), (10, 0.5, 10.0), (99, 0.5, 10.0), (4, 1.5, 30.0)]:
            (found_scan, found_encode, _), work = self.run_farm(machines)
            self.assertAlmostEqual(found_scan, scan)
            self.assertAlmostEqual(found_encode, encode)
            self.assertAlmostEqual(work, 105.0 + 0.1)

    def test_merging_is_one_copy(self) -> None:
        # 10 MB, read and written at 1000 MB/s; joining took 1 ms a megapixel, which is longer.
        (_, _, merge), _ = self.run_farm(1)
        self.assertAlmostEqual(merge, 0.1)
        (_, _, merge), _ = self.run_farm(1, disk_mb=10.0)
        self.assertAlmostEqual(merge, 2.0)

    def test_a_slow_file_server_bounds_the_time(self) -> None:
        # 1 GB of images at 10 MB/s.
        (_, encode, _), _ = self.run_farm(10, server_gbit=0.08)
        self.assertAlmostEqual(encode, 100.0)
        self.assertEqual(self.model.limit(self.stages, Farm(server_gbit=0.08), 10), "file server")
        self.assertEqual(self.model.limit(self.stages, Farm(), 2), "processors")

    def test_failures_and_slow_tasks_cost_time_and_a_seed_repeats_them(self) -> None:
        (plain_scan, plain_encode, _), _ = self.run_farm(2)
        for other in ({"failures": 0.5}, {"slow_share": 0.5}, {"start_seconds": 5.0}):
            (scan, encode, _), _ = self.run_farm(2, **other)
            self.assertGreater(scan + encode, plain_scan + plain_encode, other)
            self.assertEqual(self.run_farm(2, **other), self.run_farm(2, **other))
        self.assertNotEqual(self.run_farm(2, 1, failures=0.5), self.run_farm(2, 2, failures=0.5))

    def test_a_failed_task_waits_and_is_run_again(self) -> None:
        class Chance:
            draws = iter([0.9, 0.1, 0.5, 0.9, 0.9])

            def random(self) -> float:
                return next(self.draws)

        end, work = self.model.schedule(1, [10.0], Farm(failures=0.2), Chance())
        self.assertAlmostEqual(end, 5.0 + 60.0 + 10.0)
        self.assertAlmostEqual(work, 15.0)

    def test_a_table_is_printed_from_what_is_recorded(self) -> None:
        for times in [self.path, self.model.TIMES]:
            done = self.run_in(FARM / "simulate", "--times", times, "--machines", "1,7")
            self.assertEqual(done.returncode, 0, done.stderr)
            rows = [line.split(" | ")[0] for line in done.stdout.splitlines() if line.startswith("| ")]
            self.assertEqual(rows, ["| machines", "| ---", "| 1", "| 7"])

    def test_a_stage_that_is_not_recorded_is_named(self) -> None:
        self.path.write_text("".join(line for line in self.path.read_text().splitlines(True) if ",merge," not in line))
        done = self.run_in(FARM / "simulate", "--times", self.path)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("no row of merge", done.stderr)


if __name__ == "__main__":
    unittest.main()
