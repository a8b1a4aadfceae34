"""The proof on a cluster is the command's, byte for byte."""

import hashlib
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("distributed")

from cluster import Cluster
from command import needs_command, run


def hashes(folder):
    files = sorted(path for path in Path(folder).rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def proof(*arguments):
    command = [sys.executable, "-m", "pitchid.prove", "--cases", "3", "--seed", "5", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


@needs_command
def test_whatever_the_number_of_workers(tmp_path):
    printed = run("prove", "--cases", 3, "--seed", 5, "--out", "proof").decode()
    expected = hashes("proof")
    assert len(expected) > 3 * 6
    Path("proof").rename("commands")
    (tmp_path / "cluster").mkdir()
    cluster = Cluster(tmp_path / "cluster")
    try:
        assert proof("--out", "proof", "--scheduler", cluster.address)[:2] == (0, printed)
    finally:
        cluster.close()
    assert hashes("proof") == expected
    # what is there already is not done again, and one worker comes to the same
    (Path("proof") / "cases/0001/beside.json").unlink()
    assert proof("--out", "proof", "--workers", "1", "--resume")[:2] == (0, printed)
    assert hashes("proof") == expected
    status, _, said = proof("--out", "proof")
    assert status == 2 and "--resume" in said
