"""Tests of scripts/reconstruction-quality: python3 -m unittest discover -s scripts"""

import contextlib
import csv
import html.parser
import io
import itertools
import json
import math
import pathlib
import unittest
import unittest.mock
import urllib.parse
import xml.etree.ElementTree
from typing import Any, Callable

import lightfold_runs as lf
from for_tests import Folder, module_of, need_packages

need_packages()
import numpy as np  # noqa: E402

import images  # noqa: E402
import peers_frames as pf  # noqa: E402
import reconstruction_page as rp  # noqa: E402
import reconstruction_quality as rq  # noqa: E402
import reconstruction_report as rr  # noqa: E402


def value_of(words: list[str], name: str) -> str | None:
    """What stands behind an option."""
    return words[words.index(name) + 1] if name in words else None


def report_of_render(words: list[str], material: bool) -> dict[str, Any]:
    """What `lightfold render` could report."""
    probe = value_of(words, "--reference-probe")
    db = {"splat": 20.0, "reproject": 30.0, "calf": 27.0, "march": 28.0}[value_of(words, "--method") or ""]
    db += float(value_of(words, "--views") or 0) / 10 - (3 if value_of(words, "--effects") == "none" else 0)
    about = {"probe": probe, "face": "px", "frame": 0}
    image = {"psnr_db": db, "ssim": None, "hole_percent": 1.5, **about}
    exact = {"psnr_db": None, "psnr_db_is": "inf", "ssim": 0.5, "hole_percent": 0.5, **about, "face": "nx"}
    shown = {"exact": [exact, exact], "half": [image, exact]}.get(probe or "", [image, image])
    mirrors = {"psnr_db_mirrors": db - 5, "psnr_db_glass": db - 8} if material else {}
    reference = {"images": shown, "method": value_of(words, "--method"), "ghost_ratio": 1.25, **mirrors}
    return {"reference": reference, "pacing": {"render_ms": {"mean_ms": 2.0}}}


def write_pictures(words: list[str]) -> None:
    """Gray pictures; those of a method have a spot of its own."""
    output, probe = value_of(words, "-o") or "", value_of(words, "--reference-probe")
    names = [output % 0] if words[0] == "decode" else [f"{output}/{probe}_{face}.0000.png" for face in ("px", "nx")]
    pixels = np.full((96, 96, 3), 90, np.uint8)
    first, last = {"calf": (10, 20), "march": (70, 75)}.get(value_of(words, "--method") or "", (0, 0))
    pixels[first:last, 10:20] = 200
    pathlib.Path(names[0]).parent.mkdir(parents=True, exist_ok=True)
    for name in names:
        images.write_png(name, pixels)


class Stubbed(Folder):
    """A stub in place of runs of lightfold, which notes what it was called with."""

    program = "lightfold"

    def stub(self, material: bool) -> None:
        self.commands: list[list[str]] = []

        def run_json(program: str, *command: Any) -> Any:
            self.assertEqual(program, self.program)
            words = [str(word) for word in command]
            self.commands.append(words)
            if words[0] in ("render", "decode") and "-o" in words:
                write_pictures(words)
            report = report_of_render(words, material) if words[0] == "render" else {"bytes": 1, "streams": []}
            return json.loads(json.dumps(report), object_hook=lf.with_infinities)

        patch = unittest.mock.patch.object(lf, "run_json", run_json)
        patch.start()
        self.addCleanup(patch.stop)

    def measure(self, manifest: pathlib.Path, wanted: list[str], options: list[str] = []) -> list[rq.Row]:
        """Rows of a dataset."""
        return rq.measure_dataset(rq.Renderer(self.program, options), rq.Dataset(manifest, wanted), self.work)

    def dataset(self, names: list[str], height: Callable[[int], float] = lambda at: at * at) -> pathlib.Path:
        """Probes on a curve, so that none lies between two others, unless another height says so."""
        probes = [{"name": name, "position": [at, height(at), 0]} for at, name in enumerate(names)]
        (self.work / "lightfield.json").write_text(json.dumps({"probes": probes}))
        return self.work / "lightfield.json"


class DatasetTest(Stubbed):
    def test_each_of_few_probes_is_left_out_in_turn(self) -> None:
        self.stub(material=False)
        manifest = self.dataset(["a", "half", "exact"])
        rows = self.measure(manifest, [], ["--steps", "64"])
        out = [(row.place, row.method, row.psnr_db) for row in rows if row.table == "left out"]
        figures = {"points": 20.0, "ceiling": 30.0, "paper": 27.0, "ours": 28.0}
        exact = dict.fromkeys(figures, math.inf)
        places = {"a": figures, "half": figures, "exact": exact}
        self.assertEqual(out, [(place, *figure) for place, of in places.items() for figure in of.items()])
        own = [(row.place, row.psnr_db) for row in rows if row.table == "at a probe" and row.method == "ours"]
        self.assertEqual(own, [("a", 28.0), ("half", 28.0), ("exact", math.inf)])
        self.assertEqual([row.place for row in rows if row.table == "by views" and row.method == "ours"], [1, 2])
        self.assertFalse([row for row in rows if row.table == "effects"])
        encode, *renders = self.commands
        self.assertEqual(encode[:2], ["encode", str(manifest)])
        self.assertNotIn("--hdr", encode)
        with_all = [words for words in renders if "--exclude-probe" not in words]
        self.assertEqual(len(with_all), 3 * len(rq.METHODS))
        for words in renders:
            if words not in with_all:
                self.assertEqual(words[words.index("--exclude-probe") + 1], words[words.index("--reference-probe") + 1])
            self.assertEqual(words[words.index("--steps") + 1], "64")

    def test_mirrors_and_glass_are_rendered_with_effects_and_without(self) -> None:
        self.stub(material=True)
        rows = self.measure(self.dataset(["a", "b", "c"]), ["b", "c"])
        of_effects = [row for row in rows if row.table == "effects"]
        methods = ["points", "ceiling", "paper", "ours", "ours, without effects"]
        self.assertEqual([(row.place, row.method) for row in of_effects], [(place, method) for place in "bc" for method in methods])
        effects = {row.method: (row.psnr_db_mirrors, row.psnr_db_glass) for row in of_effects}
        self.assertEqual(effects["ours"], (23.0, 20.0))
        self.assertEqual(effects["ours, without effects"], (20.0, 17.0))
        # All methods and one without effects for each probe, all for each number of views and at three probes: nothing is rendered twice.
        _, *renders = self.commands
        self.assertEqual(len(renders), 2 * (4 + 1) + 2 * 4 + 3 * 4)

    def test_probes_between_two_others_are_poses_that_no_picture_of_the_way_has(self) -> None:
        self.stub(material=False)
        manifest = self.dataset(["a", "half", "exact", "b"], height=lambda at: 0)
        rows = self.measure(manifest, ["half"])
        poses = [(row.line, row.place, row.method) for row in rows if row.table == "by pose"]
        parts = [(0.0, "a"), (1 / 3, "half"), (2 / 3, "exact"), (1.0, "b")]
        self.assertEqual(poses, [("a to b", 1.0 * round(part, 6), method) for part, _ in parts for _, method in rq.METHODS])
        _, *renders = self.commands
        along = [words for words in renders if "half,exact" in words]
        self.assertEqual(len(along), 4 * len(rq.METHODS))
        shown = [words[words.index("--reference-probe") + 1] for words in along]
        self.assertEqual(shown, [name for _, name in parts for _ in rq.METHODS])
        report = rr.write(self.work, rr.report_of("set", rows, "a command"))
        self.assertIn("| a to b, 0.333 |", report)
        self.assertIn("take no part in the pictures of their way", report)
        xml.etree.ElementTree.parse(self.work / "by_pose.svg")
        curve = self.measure(self.dataset(["a", "half", "b"]), [])
        self.assertFalse([row for row in curve if row.table == "by pose"])
        self.assertIn("no figures by pose", rr.write(self.work, rr.report_of("set", curve, "a command")))

    def test_the_lines_of_a_dataset_are_its_longest_ways(self) -> None:
        cube = [(f"{at:02}", corner) for at, corner in enumerate(itertools.product((-1, 1), repeat=3), 1)]
        found = rq.lines_of([("00", (0, 0, 0)), *cube])
        self.assertEqual({line.name() for line in found}, {"01 to 08", "02 to 07", "03 to 06", "04 to 05"})
        self.assertTrue(all(line.between == ((0.5, "00"),) for line in found))
        # Parts of a way are no ways of their own; what lies beside it is not on it.
        row = [(str(at), (at, 0.1 if at == 2 else 0, 0)) for at in range(5)]
        [line] = rq.lines_of(row)
        self.assertEqual((line.name(), line.between), ("0 to 4", ((0.25, "1"), (0.75, "3"))))
        self.assertEqual(rq.lines_of([("a", (0, 0, 0)), ("b", (0, 0, 0)), ("c", (1, 0, 0))]), [])
        self.assertEqual(len(rq.lines_of([("00", (0, 0, 0)), *cube], most=2)), 2)

    def test_lamps_that_glass_reflects_are_kept(self) -> None:
        self.stub(material=True)
        manifest = self.dataset(["a", "b"])
        manifest.write_text(json.dumps(json.loads(manifest.read_text()) | {"material": {}}))
        self.measure(manifest, [])
        self.assertIn("--hdr", self.commands[0])

    def test_many_probes_leave_out_the_most_central_one(self) -> None:
        probes = [(str(at), (at, 0, 0)) for at in range(9)]
        self.assertEqual(rq.held_out(probes, []), ["4"])
        self.assertEqual(rq.held_out(probes, ["7", "1"]), ["7", "1"])
        self.assertEqual(rq.held_out(probes[:4], []), ["0", "1", "2", "3"])
        with self.assertRaisesRegex(rq.Refused, "no probe z"):
            rq.held_out(probes, ["z"])

    def test_what_is_no_dataset_is_refused(self) -> None:
        (self.work / "lightfield.json").write_text("[]")
        with self.assertRaisesRegex(rq.Refused, "no lightfield.json"):
            self.measure(self.work, [])
        self.dataset(["only"])
        with self.assertRaisesRegex(rq.Refused, "one probe"):
            self.measure(self.work, [])

    def test_a_command_that_fails_ends_it_with_its_words(self) -> None:
        program = self.work / "lightfold"
        program.write_text("#!/bin/sh\necho it is broken >&2\nexit 2\n")
        program.chmod(0o755)
        renderer = rq.Renderer(str(program), [])
        with self.assertRaisesRegex(SystemExit, "it is broken"):
            renderer.rows("left out", "a", rq.Case(self.work, self.work, "a"))


class SceneTest(Stubbed):
    def test_a_scene_is_captured_from_corners_and_on_the_way_between_two(self) -> None:
        self.stub(material=True)
        module = module_of("reconstruction-quality")
        output = self.work / "out"
        with unittest.mock.patch.object(lf, "build", lambda: self.program), contextlib.redirect_stdout(io.StringIO()) as told, \
                contextlib.redirect_stderr(io.StringIO()):
            module.main(["mirrors", "--size", "32", "--poses", "5", "-o", str(output), "--", "--refine", "4"])
        commands = self.commands
        self.assertEqual([words[0] for words in commands[:3]], ["capture", "capture", "encode"])
        self.assertIn("--hdr", commands[2])
        cameras = json.loads((output / "mirrors" / "probes.json").read_text())["cameras"]
        self.assertEqual(len(cameras), 8)
        poses = json.loads((output / "mirrors" / "poses.json").read_text())["cameras"]
        poses, free = poses[:5], poses[5:]
        self.assertEqual(len(free), 6)
        middle, reach = rq.REGIONS["mirrors"]
        for pose in free:
            self.assertTrue(all(abs(at - of) < far for at, of, far in zip(pose["position"], middle, reach)))
        self.assertEqual((poses[0]["position"], poses[-1]["position"]), (cameras[0]["position"], cameras[-1]["position"]))
        for found, wanted in zip(poses[2]["position"], rq.REGIONS["mirrors"][0]):
            self.assertAlmostEqual(found, wanted)
        self.assertTrue(all(words[-2:] == ["--refine", "4"] or "--refine" in words for words in commands[3:]))
        report = told.getvalue()
        for title in ("Midway", "From where a probe stands", "Six poses", "By pose", "By the number", "With and without effects"):
            self.assertIn(title, report)
        self.assertIn("ours ghosts |", report)
        self.assertIn(" 1.25 |", report)
        rows = list(csv.DictReader(io.StringIO((output / "mirrors" / "figures.csv").read_text())))
        self.assertEqual({row["table"] for row in rows}, {"midway", "at a probe", "free poses", "by pose", "by views", "effects"})
        for name in ("by_views.svg", "by_pose.svg"):
            xml.etree.ElementTree.parse(output / "mirrors" / name)

    def test_a_scene_of_ones_own_needs_a_place_for_its_probes(self) -> None:
        module = module_of("reconstruction-quality")
        with self.assertRaisesRegex(rq.Refused, "--centre"):
            module.main(["room.glb"])
        options = module.arguments(["a/room.glb", "--centre", "1,2,3"])
        self.assertEqual(module.scene_of("a/room.glb", options).region, ((1, 2, 3), (0.3, 0.3, 0.3)))
        self.assertEqual(module.scene_of("x/sponza.glb", module.arguments(["a"])).region, rq.REGIONS["sponza.glb"])
        with contextlib.redirect_stderr(io.StringIO()), self.assertRaises(SystemExit):
            module.arguments(["a", "--poses", "4"])


class ReportTest(unittest.TestCase):
    def rows(self, places: list[int]) -> list[rq.Row]:
        return [rq.Row("by views", place, method, 20.0 + place, None, 1.0) for place in places for method in ("points", "ours")]

    def test_views_are_tried_one_by_one_and_then_fewer(self) -> None:
        self.assertEqual(rq.counts_of_views(1), [1])
        self.assertEqual(rq.counts_of_views(8), list(range(1, 9)))
        self.assertEqual(rq.counts_of_views(20), [*range(1, 9), 12, 16, 20])

    def test_ticks_are_round_and_enclose_what_is_shown(self) -> None:
        for least, most in ((0, 1), (20.03, 20.9), (1, 8), (-3, 250), (5, 5)):
            found = rr.ticks(least, most)
            self.assertTrue(found[0] <= least and found[-1] >= most and 2 <= len(found) <= 9, found)

    def test_charts_are_well_formed_and_hold_every_point(self) -> None:
        drawn = rr.chart("PSNR <by> views & more", "views", self.rows([1, 2, 4]))
        root = xml.etree.ElementTree.fromstring(drawn or "")
        circles = [(float(e.get("cx", "")), float(e.get("cy", ""))) for e in root.iter() if e.tag.endswith("circle")]
        self.assertEqual(len(circles), 6)
        self.assertTrue(all(0 < x < 760 and 0 < y < 460 for x, y in circles))
        self.assertIsNone(rr.chart("one place", "views", self.rows([1])))
        exact = [rq.Row("by pose", 0.0, "ours", math.inf, None, 0.0), rq.Row("by pose", 1.0, "ours", 30.0, None, 0.0)]
        self.assertIsNone(rr.chart("an exact picture has no place", "way", exact))

    def test_several_ways_have_one_curve(self) -> None:
        rows = [rq.Row("by pose", part, "ours", db, None, 0.0, line=line)
                for line, db in (("a to b", 20.0), ("c to d", 30.0)) for part in (0.0, 0.5, 1.0)]
        self.assertEqual([value for _, _, value in rr.mean_over_lines(rows, "psnr_db")], [25.0] * 3)
        root = xml.etree.ElementTree.fromstring(rr.chart("title", "way", rows) or "")
        self.assertEqual(len([e for e in root.iter() if e.tag.endswith("circle")]), 3)
        [(_, _, lines)] = rr.tables(rows)
        self.assertEqual(len(lines), 6)

    def test_tables_have_all_methods_side_by_side(self) -> None:
        [(title, head, lines)] = rr.tables(self.rows([1, 2]))
        self.assertIn("figure 9", title)
        self.assertEqual(head, ["views", "points dB", "ours dB", "points SSIM", "ours SSIM", "points holes %", "ours holes %"])
        self.assertEqual(lines[0], ["1", "21.00", "21.00", "", "", "1.00", "1.00"])
        self.assertEqual(rr.to_csv(self.rows([1])).splitlines()[1], "by views,1,points,21.0,,1.0,,,,,")


class Elements(html.parser.HTMLParser):
    """(tag, attributes, text up to the next tag) of a page; tags that are not closed in turn raise."""

    def __init__(self, text: str):
        super().__init__()
        self.found: list[tuple[str, dict[str, Any], list[str]]] = []
        self.open: list[str] = []
        self.feed(text)
        assert not self.open, self.open

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attributes), []))
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attributes), []))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, tag

    def handle_data(self, data: str) -> None:
        if self.found:
            self.found[-1][2].append(data)

    def of(self, tag: str) -> list[tuple[dict[str, Any], str]]:
        return [(attributes, "".join(text).strip()) for name, attributes, text in self.found if name == tag]


class PageTest(Stubbed):
    def run_script(self, *words: Any) -> None:
        with unittest.mock.patch.object(lf, "build", lambda: self.program), \
                contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            module_of("reconstruction-quality").main([*map(str, words), "-o", str(self.work / "reports")])

    def test_a_page_shows_figures_and_crops_of_every_input(self) -> None:
        self.stub(material=False)
        manifest = self.dataset(["a <&>", "b"])
        page = self.work / "page"
        self.run_script("mirrors", manifest, "--poses", "3", "--page", page)
        text = (page / "index.html").read_text()
        elements = Elements(text)
        [(attributes, _)] = elements.of("html")
        self.assertEqual(attributes["lang"], "en")
        self.assertEqual([name for _, name in elements.of("h2")], ["mirrors", self.work.name])
        poses = [name for _, name in elements.of("h4")]
        self.assertEqual([name.split(",")[0] for name in poses[-2:]], ["Probe a <&>", "Probe b"])
        self.assertEqual(len(poses), 5 + 2)
        # Figures of the report, and what the crops compare.
        self.assertIn("<td>28.10</td>", text)
        self.assertIn("figure 9", text)
        heads = [name for attributes, name in elements.of("th") if attributes["scope"] == "col"]
        for name in ("truth", "paper (before)", "ours (after)", "points", "ours ghosts"):
            self.assertIn(name, heads)
        rows = [name for attributes, name in elements.of("th") if attributes["scope"] == "row"]
        self.assertEqual(rows.count("px, 0, 0"), len(poses))
        # Nothing comes from elsewhere, and nothing is missing.
        self.assertFalse({"script", "link", "iframe", "image", "use"} & {tag for tag, _, _ in elements.found})
        self.assertNotRegex(text, r"url\(|@import|(src|href)=.(https?:)?//")
        images = elements.of("img")
        self.assertTrue(images and all(attributes["alt"] for attributes, _ in images))
        files = {urllib.parse.unquote(attributes["src"]) for attributes, _ in images}
        self.assertEqual(files, {str(file.relative_to(page)) for file in page.rglob("*.png")})
        crop = next(attributes for attributes, _ in images if "crop" in attributes["alt"])
        self.assertEqual(rp.read_png(page / urllib.parse.unquote(crop["src"])).shape, (rp.SIDE * rp.SCALE, rp.SIDE * rp.SCALE, 3))

    def test_a_page_is_the_same_each_time(self) -> None:
        self.stub(material=False)
        words = [self.dataset(["a", "b"]), "--page", self.work / "page"]
        contents = lambda: {file: file.read_bytes() for file in (self.work / "page").rglob("*.*")}
        self.run_script(*words)
        first = contents()
        self.run_script(*words)
        self.assertEqual(contents(), first)

    def test_what_cannot_be_shown_is_told(self) -> None:
        self.stub(material=False)
        manifest = self.dataset(["a", "b"])
        with self.assertRaises(SystemExit), contextlib.redirect_stderr(io.StringIO()) as told:
            module_of("reconstruction-quality").main([str(manifest), "--page", str(manifest)])
        self.assertIn("--page: the folder cannot be made", told.getvalue())
        with self.assertRaisesRegex(rq.Refused, "different names"):
            self.run_script(manifest, self.work, "--page", self.work / "page")
        image = {"probe": "a", "face": "px", "frame": 0, "psnr_db": 1}
        reports = dict.fromkeys(rp.COMPARED, {"reference": {"images": [image]}})
        pose = rq.Pose("a pose", rq.Case(self.work, self.work, "a"), reports, self.work)
        for label in rp.COMPARED:
            file = pose.picture(label, image)
            file.parent.mkdir(parents=True)
            images.write_png(file, np.zeros((8, 8, 3), np.uint8))
        with self.assertRaisesRegex(rq.Refused, "96 x 96 pixels were expected, as the truth has, not 8 x 8"):
            rp.faces_of(pose, rp.Truths(self.program, self.work))

    def test_pictures_that_cannot_be_read_are_told(self) -> None:
        pixels = np.array([[[1, 2, 3, 255], [4, 5, 6, 0]]], np.uint8)
        self.assertEqual(rp.without_alpha(pixels).tolist(), [[[1, 2, 3], [0, 0, 0]]])
        (self.work / "no.png").write_bytes(b"no picture")
        with self.assertRaisesRegex(rq.Refused, "no.png: a PNG of 8-bit colour or 16-bit gray was expected"):
            rp.read_png(self.work / "no.png")
        images.write_png(self.work / "cut.png", np.random.default_rng(1).integers(0, 256, (64, 64, 3), np.uint8))
        cut = (self.work / "cut.png").read_bytes()
        (self.work / "cut.png").write_bytes(cut[:len(cut) // 2])
        with self.assertRaisesRegex(rq.Refused, "cut.png: .*truncated"):
            rp.read_png(self.work / "cut.png")

    def test_silhouettes_are_where_distances_differ(self) -> None:
        # From 1 m to 100 m; 10 % are 1357 codes.
        codes = np.array([[0, 1000, 3000, 3000], [0, 1000, 3000, pf.BACKGROUND]], np.uint16)
        self.assertEqual(rp.silhouettes(codes, (1.0, 100.0)).tolist(), [[0, 1, 1, 1], [0, 1, 1, 1]])
        self.assertFalse(rp.silhouettes(np.full((2, 2), pf.BACKGROUND, np.uint16), (1.0, 100.0)).any())

    def test_crops_are_the_worst_windows_at_silhouettes(self) -> None:
        side = 128

        def spot(left: int, top: int, value: int) -> images.Array:
            errors = np.zeros((side, side), int)
            errors[top:top + 4, left:left + 4] = value
            return errors

        # Ours is better at the first spot, and worse at the second; the third has no silhouette.
        away = spot(100, 100, 10**6)
        errors = {"paper": spot(20, 20, 900) + spot(24, 90, 10) + away, "ours": spot(20, 20, 5) + spot(24, 90, 50) + away}
        edges = np.zeros((side, side), int)
        edges[:, 24] = 1
        windows = list(rp.windows_of("px", errors, edges))
        (first, at_first), (second, at_second) = rp.choose(windows, 2)
        self.assertEqual((first, second), ("paper", "ours"))
        covers = lambda window, x, y: 0 <= x - window.left <= rp.SIDE - 4 and 0 <= y - window.top <= rp.SIDE - 4
        self.assertTrue(covers(at_first, 20, 20) and covers(at_second, 24, 90))
        self.assertAlmostEqual(at_second.psnr_db("ours"), 10 * math.log10(255**2 * 3 * rp.SIDE**2 / (16 * 50)))
        many = [window for _, window in rp.choose(windows, 6)]
        self.assertFalse([pair for pair in itertools.combinations(many, 2) if pair[0].overlaps(pair[1])])
        # Where silhouettes are unknown, the worst windows of all are shown.
        [(_, worst)] = rp.choose(list(rp.windows_of("px", errors, None)), 1)
        self.assertTrue(covers(worst, 100, 100))
        exact = dict.fromkeys(errors, np.zeros((side, side), int))
        self.assertEqual(rp.choose(list(rp.windows_of("px", exact, None)), 6), [])


if __name__ == "__main__":
    unittest.main()
