"""Common parts of tests of scripts: a folder for each, the program, and scripts as modules."""

import importlib.machinery
import importlib.util
import os
import pathlib
import shutil
import sys
import tempfile
import types
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", HERE.parent / "target"))


def need_packages() -> None:
    """Skips the tests of a module where a package is missing."""
    try:
        import images  # noqa: F401
    except ImportError as error:
        reason = f"numpy, Pillow and OpenEXR are needed: {error}"
        print(f"\nNOT RUN: {reason}", file=sys.stderr)
        raise unittest.SkipTest(reason) from error


def lightfold() -> str | None:
    """The program of LIGHTFOLD, or the one that was built last in the target folder."""
    named = os.environ.get("LIGHTFOLD")
    if named:
        return shutil.which(named)
    built = [path for path in (TARGET / kind / "lightfold" for kind in ("debug", "release")) if path.is_file()]
    return str(max(built, key=lambda path: path.stat().st_mtime)) if built else None


def module_of(name: str) -> types.ModuleType:
    """A script without an ending as a module."""
    loader = importlib.machinery.SourceFileLoader(pathlib.Path(name).name.replace("-", "_"), str(HERE / name))
    spec = importlib.util.spec_from_loader(loader.name, loader)
    assert spec
    module = importlib.util.module_from_spec(spec)
    with unittest.mock.patch.object(sys, "dont_write_bytecode", True):
        loader.exec_module(module)
    return module


class Folder(unittest.TestCase):
    """Tests that have a folder each."""

    def setUp(self) -> None:
        work = tempfile.TemporaryDirectory()
        self.addCleanup(work.cleanup)
        self.work = pathlib.Path(work.name)
