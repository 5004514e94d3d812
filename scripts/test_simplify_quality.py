"""Tests of scripts/simplify-quality: python3 -m unittest discover -s scripts"""

import contextlib
import io
import json
import pathlib
import subprocess
import unittest
import unittest.mock
from typing import Any

import lightfold_runs as lf
import simplify_quality as sq
from for_tests import Folder, module_of

PNG_64_BY_48 = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x40\0\0\0\x30"
NOTHING_FITS = "simplifying\nlightfold: the budget of triangles cannot be met\n"


def report_of_simplify() -> dict[str, Any]:
    """What `lightfold simplify` could report."""
    report = dict.fromkeys(["samples", "atlas_texels", "atlas_occupancy", "overdraw_mean", "psnr_db", "released_psnr_db", "ssim",
                            "crack_pixels"], 1.0)
    return report | {"triangles": 1000, "peak_overdraw_measured": 2.5, "files": [{"bytes": 1_500_000}], "seconds": 2.0,
                     "stages": {"merge": 0.5}}


class Measuring(Folder):
    """A stub in place of runs of lightfold, which notes what it was called with."""

    def setUp(self) -> None:
        super().setUp()
        self.commands: list[list[str]] = []
        self.failing: list[str] = []

        def run_json(program: str, *command: Any) -> Any:
            words = [str(word) for word in command]
            self.commands.append(words)
            out = pathlib.Path(words[words.index("-o") + 1]) if "-o" in words else None
            if words[0] == "simplify":
                if self.failing and self.failing == words[2:2 + len(self.failing)]:
                    raise lf.Failed(words, 2, NOTHING_FITS)
                return report_of_simplify()
            if words[0] == "render" and out:
                out.mkdir()
                (out / "00_px.0003.png").write_bytes(PNG_64_BY_48)
            if words[0] == "encode" and out:
                out.write_bytes(b"12345")
            return {"color": {"psnr_db": 30.0, "ssim": 0.9, "ssimulacra2": 60.0}}

        patch = unittest.mock.patch.object(lf, "run_json", run_json)
        patch.start()
        self.addCleanup(patch.stop)

    def dataset(self, name: str, probes: int) -> pathlib.Path:
        folder = self.work / name
        folder.mkdir()
        listed = [{"name": f"{at:02}", "position": [at, 0, 0]} for at in range(probes)]
        manifest = {"name": name, "fps": 24, "frames": [3, 9], "projection": "equirect", "size": [128, 64], "probes": listed}
        (folder / "lightfield.json").write_text(json.dumps(manifest))
        (folder / "image.exr").write_bytes(b"")
        return folder

    def measured(self, given: sq.Given, more: list[str] = []) -> sq.Measured:
        work = self.work / "work"
        work.mkdir()
        return sq.measure("lightfold", given, work, more, 4)

    def test_every_way_has_a_row(self) -> None:
        found = self.measured(sq.Given("cap", self.dataset("cap", 3)), ["--atlas", "1024"])
        self.assertEqual([row.way for row in found.rows], [
            "simplify", "simplify --effort fast", "simplify --tiling uniform", "simplify --energy paper",
            "simplify --energy paper --tiling uniform", "reproject", "march", "splat", "gltfpack"])
        self.assertEqual([row.reason for row in found.rows if row.reason], ["no mesh was given"])
        self.assertEqual([row.bytes for row in found.rows], [1_500_000] * 5 + [5] * 3 + [None])
        simplified = [words for words in self.commands if words[0] == "simplify"]
        self.assertTrue(all("1024" in words for words in simplified))
        # All pictures are of the first frame, at the poses of the same images.
        compared = [words for words in self.commands if words[0] == "diff"]
        self.assertEqual(len(compared), 8)
        self.assertEqual({words[1] for words in compared}, {str(self.work / "work" / "held-out")})
        self.assertEqual({words[words.index("--frames") + 1] for words in compared}, {"3-3"})

    def test_a_dataset_is_split_at_its_middle(self) -> None:
        work = self.work / "parts"
        work.mkdir()
        names = [[name for name, _ in sq.rq.probes_of(part)] for part in sq.split(self.dataset("cap", 3), work)]
        self.assertEqual(names, [["00", "02"], ["01"]])
        self.assertTrue((work / "others" / "image.exr").is_symlink())
        with self.assertRaisesRegex(sq.rq.Refused, "it has one probe"):
            sq.split(self.dataset("one", 1), work)

    def test_what_fails_says_why(self) -> None:
        self.failing = sq.UNIFORM
        found = self.measured(sq.Given("cap", self.dataset("cap", 3)))
        [row] = [row for row in found.rows if row.way == "simplify --tiling uniform"]
        self.assertEqual((row.found, row.reason), (None, "lightfold: the budget of triangles cannot be met"))

    def test_pictures_have_the_poses_of_the_reference(self) -> None:
        (self.work / "00_px.0003.png").write_bytes(PNG_64_BY_48)
        of = {"name": "cap", "fps": 24, "projection": "equirect", "probes": [{"name": "00", "position": [0, 0, 0]}], "depth": {}}
        manifest = sq.picture_manifest(self.work, of, "3")
        self.assertEqual((manifest["projection"], manifest["size"], manifest["frames"]), ("cubemap", [64, 48], [3, 3]))
        self.assertEqual(manifest["files"]["color"] % 3, "{probe}_{face}.0003.png")
        flat = sq.picture_manifest(self.work, of | {"projection": "perspective"}, "3")
        self.assertEqual((flat["projection"], flat["files"]["color"] % 3), ("perspective", "{probe}_view.0003.png"))

    def packed(self, whole: int) -> tuple[sq.Row, list[str]]:
        """The row of a mesh of so many triangles beside a scene of 1000, and the parts that were asked for."""
        parts = []

        def run(words: list[str], **_: Any) -> subprocess.CompletedProcess[str]:
            if words[1:] == ["-v"]:
                return subprocess.CompletedProcess(words, 0, "gltfpack 1.3\n", "")
            value = lambda name: words[words.index(name) + 1]
            parts.append(value("-si"))
            count = round(whole * float(value("-si")))
            pathlib.Path(value("-r")).write_text(json.dumps({"render": {"triangleCount": count}}))
            pathlib.Path(value("-o")).write_bytes(b"123")
            return subprocess.CompletedProcess(words, 0, "", "")

        truth = sq.HeldOut("lightfold", self.dataset("held", 1), "3", self.work)
        with unittest.mock.patch.object(subprocess, "run", run), unittest.mock.patch.object(sq.shutil, "which", lambda _: "/gltfpack"):
            return sq.packed(truth, self.work / "mesh.glb", 1000, 4), parts

    def test_a_mesh_is_simplified_to_as_many_triangles(self) -> None:
        row, parts = self.packed(20000)
        self.assertEqual((row.way, row.triangles, row.bytes, parts), ("gltfpack 1.3", 1000, 3, ["1.000000", "0.050000"]))
        [capture] = [words for words in self.commands if words[0] == "capture"]
        for option, value in (("--projection", "equirect"), ("--size", "128x64"), ("--samples", "4"), ("--frames", "3-3")):
            self.assertEqual(capture[capture.index(option) + 1], value)

    def test_a_mesh_of_fewer_triangles_is_kept(self) -> None:
        row, parts = self.packed(900)
        self.assertEqual((row.triangles, parts), (900, ["1.000000"]))

    def test_a_missing_gltfpack_is_told(self) -> None:
        with unittest.mock.patch.object(sq.shutil, "which", lambda _: None):
            row = sq.packed(sq.HeldOut("lightfold", self.work, "3", self.work), self.work / "mesh.glb", 1000, 4)
        self.assertEqual((row.way, row.found, row.reason), ("gltfpack", None, "it is not installed, and npx cannot get it"))


class TableTest(Folder):
    script = module_of("simplify-quality")

    def measured(self, psnr_db: dict[str, float], ssim: dict[str, float]) -> sq.Measured:
        ways = [sq.way_of(own) for own in [[], sq.FAST, sq.UNIFORM]] + ["march"]
        rows = [sq.Row(way, {"psnr_db": psnr_db.get(way, 30.0), "ssim": ssim[way], "ssimulacra2": 60.04}, 1_500_000, 12345, 2.5)
                for way in ways if way in ssim]
        return sq.Measured("cap", report_of_simplify(), [*rows, sq.Row("gltfpack", reason="no mesh was given")])

    def test_verdicts_allow_for_the_tolerance(self) -> None:
        ssim = {"simplify": 0.9, "simplify --effort fast": 0.9004, "simplify --tiling uniform": 0.8, "march": 0.9}
        self.assertEqual(self.script.verdict(self.measured({"march": 31.25}, ssim)),
                         "- cap: SSIM of normal >= fast >= uniform (to 0.0005) holds: 0.9000, 0.9004, 0.8000. "
                         "Default within 1.5 dB of `march` holds: 1.25 dB below.")
        worse = self.script.verdict(self.measured({"march": 31.75}, ssim | {"simplify --tiling uniform": 0.901}))
        self.assertIn("does not hold (fast below uniform): 0.9000, 0.9004, 0.9010.", worse)
        self.assertIn("`march` does not hold: 1.75 dB below.", worse)
        better = self.script.verdict(self.measured({"march": 29.0}, ssim))
        self.assertIn("`march` holds: 1.00 dB above.", better)
        del ssim["simplify --tiling uniform"]
        self.assertIn("was not measured: 0.9000, 0.9004, none.", self.script.verdict(self.measured({}, ssim)))

    def test_rows_without_figures_have_words(self) -> None:
        ssim = {"simplify": 0.9, "simplify --effort fast": 0.9, "simplify --tiling uniform": 0.9, "march": 0.9}
        text = self.script.pages([self.measured({}, ssim)], [])
        self.assertIn("| cap | simplify | 30.00 | 0.9000 | 60.0 | 1.50 | 12,345 | 2.50 |", text)
        self.assertIn("| cap | gltfpack: no mesh was given |  |  |  |  |  |  |", text)

    def refused(self, *words: Any) -> str:
        with self.assertRaises(SystemExit), contextlib.redirect_stderr(io.StringIO()) as told:
            self.script.arguments([str(word) for word in words])
        return told.getvalue()

    def test_sets_and_meshes(self) -> None:
        mesh = self.work / "mesh.glb"
        mesh.touch()
        options, more = self.script.arguments(["a/cap=held", "b/lightfield.json", "--mesh", f"cap={mesh}", "--", "--atlas", "1024"])
        path = pathlib.Path
        self.assertEqual(options.sets, [sq.Given("cap", path("a/cap"), path("held"), mesh), sq.Given("b", path("b/lightfield.json"))])
        self.assertEqual(more, ["--atlas", "1024"])
        self.assertIn("--mesh other: there is no such set; there are cap", self.refused("cap", "--mesh", f"other={mesh}"))
        self.assertIn("there is no such file", self.refused("cap", "--mesh", f"cap={self.work / 'none.glb'}"))
        self.assertIn("--effort=fast: its values are compared anyway", self.refused("cap", "--", "--effort=fast"))


if __name__ == "__main__":
    unittest.main()
