"""Runs every snippet of the pages: each page in a folder of its own, from top to bottom.

python, sh   run; `% invisible-code-block: python` has checks that readers do not see
text         what the block before it printed; ... is anything
"""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import pathlib
import subprocess
import sys
import tempfile
from typing import Any

import matplotlib
import matplotlib.pyplot
import pytest
import scenes
from sybil import Example, Sybil
from sybil.evaluators.python import PythonEvaluator
from sybil.parsers.myst import CodeBlockParser

matplotlib.use("agg")
HERE = pathlib.Path(__file__).resolve().parent
run_python = PythonEvaluator()


def python(example: Example) -> None:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        run_python(example)
    if printed.getvalue():
        example.namespace["printed"] = printed.getvalue()


def sh(example: Example) -> None:
    path = f"{pathlib.Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-euc", str(example.parsed)],
        env={**os.environ, "PATH": path},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    example.namespace["printed"] = done.stdout


def text(example: Example) -> None:
    printed, expected = example.namespace["printed"], str(example.parsed)
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    if not doctest.OutputChecker().check_output(expected, printed, flags):
        pytest.fail(f"printed:\n{printed}\nexpected:\n{expected}")


def setup(namespace: dict[str, Any]) -> None:
    folder = tempfile.TemporaryDirectory()
    namespace.update(scenes=scenes, _folder=folder, _before=os.getcwd())
    os.chdir(folder.name)


def teardown(namespace: dict[str, Any]) -> None:
    os.chdir(namespace["_before"])
    namespace["_folder"].cleanup()
    matplotlib.pyplot.close("all")


PARSERS = [
    CodeBlockParser(name, run)
    for name, run in (("python", python), ("sh", sh), ("text", text))
]
pytest_collect_file = Sybil(
    PARSERS, pattern="*.md", setup=setup, teardown=teardown
).pytest()
