"""Tests of what scripts/view-glb refuses, and of its exit codes: python3 -m unittest discover -s scripts"""

import json
import os
import shutil
import struct
import subprocess
import unittest
from typing import Any

from for_tests import HERE, Folder

SCRIPT = HERE / "view-glb"


def run(*arguments: Any, path: str | None = None) -> subprocess.CompletedProcess[str]:
    environment = dict(os.environ, PATH=path or os.environ["PATH"])
    return subprocess.run(["/usr/bin/env", "bash", SCRIPT, *arguments], capture_output=True, text=True, env=environment)


class Refusals(Folder):
    def setUp(self) -> None:
        super().setUp()
        self.scene = self.work / "scene.glb"
        text = json.dumps({"asset": {"version": "2.0"}, "extras": {}}).encode()
        text += b" " * (-len(text) % 4)
        self.scene.write_bytes(b"glTF" + struct.pack("<III", 2, 20 + len(text), len(text)) + b"JSON" + text)

    def test_usage(self) -> None:
        cases: list[tuple[list[Any], str]] = [
            ([], "scripts/view-glb scene.glb"),
            (["nowhere.glb"], "nowhere.glb: no such file"),
            ([self.scene, "other.glb"], "other.glb: one scene was expected"),
            ([self.scene, "--size", "big"], "--size big: 1 to 9999 pixels"),
            ([self.scene, "--size"], "--size: a value was expected"),
            ([self.scene, "--fast"], "--fast: no such option"),
        ]
        for arguments, words in cases:
            found = run(*arguments)
            self.assertEqual(found.returncode, 2, arguments)
            self.assertIn(words, found.stderr)

    def test_without_node_nothing_is_run(self) -> None:
        tools = self.work / "bin"
        tools.mkdir()
        for tool in ["bash", "basename", "cat", "dirname", "mkdir", "realpath"]:
            (tools / tool).symlink_to(shutil.which(tool) or tool)
        found = run(self.scene, "--out", str(self.work), path=str(tools))
        self.assertEqual(found.returncode, 3, found.stderr)
        self.assertIn("NOT RUN: node and npm are missing", found.stderr)

    @unittest.skipUnless(shutil.which("node"), "node is missing")
    def test_other_files_are_refused(self) -> None:
        program: list[Any] = ["node", SCRIPT.with_name("view_glb.mjs"), str(self.work)]
        other = self.work / "text"
        other.write_text("no GLB at all, but a text")
        for path, words in [(self.scene, "extras name no viewing region"), (other, "not binary glTF")]:
            found = subprocess.run([*program, path, str(self.work), "64", ""], capture_output=True, text=True)
            self.assertEqual(found.returncode, 2)
            self.assertIn(words, found.stderr)


if __name__ == "__main__":
    unittest.main()
