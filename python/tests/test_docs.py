"""Examples of the documentation run, and the type stub has what the module has."""

import ast
import contextlib
import doctest
import inspect
import io
import json
import os
import re
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import film
import lightfold

PYTHON = Path(__file__).resolve().parent.parent
README = (PYTHON / "README.md").read_text()
STUB = ast.parse((PYTHON / "lightfold/__init__.pyi").read_text())
CLASSES = [lightfold.Container, lightfold.Stream, lightfold.Probe]


def docstrings():
    """Names of all that is public, and their docstrings."""
    yield "lightfold", inspect.getdoc(lightfold)
    for thing in [lightfold.open, lightfold.encode, lightfold.Error, *CLASSES]:
        yield thing.__name__, inspect.getdoc(thing)
    for kind in CLASSES:
        for name in public(kind):
            yield f"{kind.__name__}.{name}", inspect.getdoc(inspect.getattr_static(kind, name))


def public(kind):
    return sorted(name for name in vars(kind) if not name.startswith("_"))


def examples(text, name):
    globs = {"lightfold": lightfold, "np": np}
    return doctest.DocTestParser().get_doctest(text, globs, name, None, 0)


def readme():
    return "\n".join(re.findall(r"```pycon\n(.*?)```", README, re.DOTALL))


class Examples(unittest.TestCase):
    def setUp(self):
        before = os.getcwd()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, before)
        os.chdir(folder.name)
        film.write("film.lfold")

    def run_examples(self, test):
        runner = doctest.DocTestRunner(optionflags=doctest.IGNORE_EXCEPTION_DETAIL)
        said = []
        results = runner.run(test, out=said.append)
        self.assertEqual(results.failed, 0, "".join(said))
        return results.attempted

    def test_docstrings(self):
        attempted = 0
        for name, text in docstrings():
            with self.subTest(name):
                self.assertTrue(text, f"{name} has no docstring")
                attempted += self.run_examples(examples(text, name))
        self.assertGreater(attempted, 20)

    def test_readme(self):
        self.assertGreater(self.run_examples(examples(readme(), "README.md")), 15)

    def test_the_readme_shows_what_docstrings_show(self):
        sources = {example.source for _, text in docstrings() for example in examples(text, "docstring").examples}
        shared = [example for example in examples(readme(), "README.md").examples if example.source in sources]
        self.assertGreater(len(shared), 10)


class Notebook(unittest.TestCase):
    def test_it_runs_with_charts_that_nobody_sees(self):
        notebook = json.loads((PYTHON / "examples" / "error_map.ipynb").read_text())
        cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
        self.assertTrue(all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells))
        axes = np.empty((2, 2), object)
        axes.flat = [mock.Mock() for _ in range(4)]
        pyplot = mock.Mock(subplots=mock.Mock(return_value=(mock.Mock(), axes)))
        modules = {"matplotlib": mock.Mock(pyplot=pyplot), "matplotlib.pyplot": pyplot}
        said = io.StringIO()
        with mock.patch.dict("sys.modules", modules), contextlib.redirect_stdout(said):
            scope = {}
            for cell in cells:
                exec("".join(cell["source"]), scope)
        self.assertIn("max_error=100: at most 0.16", said.getvalue())
        self.assertEqual([axis.imshow.call_count for axis in axes.flat], [1] * 4)


class Stub(unittest.TestCase):
    def test_names(self):
        listed = {node.name: node for node in STUB.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        self.assertEqual(set(listed), {"Container", "Error", "Probe", "Stream", "encode", "open"})
        for kind in CLASSES:
            methods = [node for node in listed[kind.__name__].body if isinstance(node, ast.FunctionDef)]
            self.assertEqual(sorted(node.name for node in methods if node.name != "__new__"), public(kind))
            for node in methods:
                if not node.decorator_list:
                    self.check_parameters(node, kind if node.name == "__new__" else getattr(kind, node.name))
        self.check_parameters(listed["open"], lightfold.open)

    def check_parameters(self, node, function):
        stated = [argument.arg for argument in node.args.args if argument.arg != "cls"]
        self.assertEqual(list(inspect.signature(function).parameters), stated, node.name)

    def test_settings(self):
        node = next(node for node in STUB.body if getattr(node, "name", None) == "encode")
        with self.assertRaisesRegex(TypeError, "no argument 'x'; it has (.*)") as caught:
            lightfold.encode("never.lfold", x=1)
        known = str(caught.exception).split("it has ")[1].split(", ")
        self.assertEqual([argument.arg for argument in node.args.kwonlyargs], known)

    def test_settings_that_messages_name_are_arguments(self):
        node = next(node for node in STUB.body if getattr(node, "name", None) == "encode")
        known = {argument.arg for argument in node.args.kwonlyargs}
        # Of files and of the command line alone; work from memory is not resumed, and is no shard.
        known |= {"clip", "color_space", "color_tables", "depth_tables", "frames", "resume", "shard", "shard_by", "shard_frames",
                  "shard_probe", "shard_stream"}
        sources = PYTHON.parent / "src"
        if not sources.is_dir():
            self.skipTest("not in a clone")
        named = set()
        for path in [path for folder in ("footage/encode", "codec/streams", "codec/container") for path in sources.glob(f"{folder}/*.rs")]:
            for line in path.read_text().splitlines():
                if not line.lstrip().startswith("//"):
                    named |= set(re.findall(r"`([a-z][a-z0-9_]*)`", line))
        self.assertGreater(len(named), 20)
        self.assertEqual(named - known - {"stream"}, set())

    def test_marker_of_types(self):
        folder = Path(lightfold.__file__).parent
        for name in ["py.typed", "__init__.pyi"]:
            self.assertTrue((folder / name).is_file(), name)


if __name__ == "__main__":
    unittest.main()
