"""The examples of the docstrings, and what the typed stubs promise."""

import ast
import doctest
from pathlib import Path

import pytest

import pitchid
import pitchid.questions
import pitchid.recording
from pitchid import _native


@pytest.mark.parametrize("module", [pitchid.questions, pitchid.recording])
def test_examples_hold(module):
    found = doctest.testmod(module)
    assert found.attempted > 0 and found.failed == 0


def test_the_stubs_name_what_is_there():
    stubs = ast.parse(Path(pitchid.__file__).with_name("_native.pyi").read_text())
    told = {node.name: node for node in stubs.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    there = {name for name in dir(_native) if not name.startswith("_")}
    assert set(told) == there
    for name, node in told.items():
        if isinstance(node, ast.ClassDef):
            methods = {one.name for one in node.body if isinstance(one, ast.FunctionDef) and one.name != "__init__"}
            own = {one for one in vars(getattr(_native, name)) if not one.startswith("__") or one == "__len__"}
            assert methods == own, name


def test_every_question_is_documented():
    for name in pitchid.__all__:
        of = getattr(pitchid, name)
        assert name == "__version__" or of.__doc__, name
        if callable(of) and not isinstance(of, type):
            assert "Parameters\n" in of.__doc__ and "Returns\n" in of.__doc__, name
