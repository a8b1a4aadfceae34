"""The command, to hold the package against it."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

COMMAND = os.environ.get("PITCHID") or shutil.which("pitchid") or Path(__file__).parents[2] / "target/release/pitchid"

if os.environ.get("CI") and not Path(COMMAND).exists():
    pytest.fail(f"{COMMAND}: not there; build it with cargo build --release --bin pitchid")

needs_command = pytest.mark.skipif(not Path(COMMAND).exists(), reason="cargo build --release --bin pitchid first")


def run(*arguments, folder=None):
    """Runs it, and returns what it printed."""
    done = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout
