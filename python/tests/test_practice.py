"""The recordings that the project practises on: the package and the command say the same of each, whole."""

import os
from pathlib import Path

import pytest
from command import needs_command, run

import pitchid

PRACTICE = Path(__file__).parents[3] / "shared/data/sealed/practice"
# ten minutes for all of them: a few otherwise
CASES = sorted(PRACTICE.glob("c*"))[:: 1 if os.environ.get("PITCHID_PRACTICE") == "all" else 18]


@needs_command
def test_the_recordings_are_there():
    if not CASES:
        assert not os.environ.get("CI"), f"{PRACTICE}: no recordings"
        pytest.skip(f"{PRACTICE}: no recordings")


@needs_command
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_answer_is_the_commands(case):
    recording, model = case / "recording.csv", case / "model.toml"
    assert pitchid.diagnose(recording, model=model).to_json() == run("diagnose", recording, "--model", model, "--json", "-")
