"""A fleet on a real scheduler with workers that are processes of their own."""

import json
import os
import subprocess
import sys
import time

import numpy as np
import pytest
from small import small

pytest.importorskip("distributed")

from cluster import Cluster, kill_a_worker

import pitchid
from pitchid import fleet

SMALL = int(os.environ.get("PITCHID_FLEET", "24"))
"""Recordings of the robustness test."""


@pytest.fixture(scope="session")
def logs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    for k in range(SMALL):
        place = folder / "quad" / f"craft-{k % 5}"
        place.mkdir(parents=True, exist_ok=True)
        small(place / f"flight-{k:04}.csv", k)
    return folder


@pytest.fixture
def cluster(tmp_path):
    cluster = Cluster(tmp_path)
    yield cluster
    cluster.close()


def test_what_a_row_says_is_the_answer(friction, model, answer):
    run = fleet.diagnose(friction, out="one.parquet", model=model, workers=1)
    (row,) = run.table().to_pylist()
    assert (run.total, run.done, run.failed) == (1, 1, 0)
    assert row["answer"].encode() == answer.to_json() and fleet.answer(row) == answer
    assert row["verdict"] == "named" and [effect["id"] for effect in row["effects"]] == ["coulomb_friction"]
    of = {(one["of"], one["name"]): one for one in row["parameters"]}
    assert of["coulomb_friction", "Mc"]["low"] < of["coulomb_friction", "Mc"]["value"]
    assert ("", "dM_du") in of and ("", "Mc") not in of
    assert row["vaf_after_percent"] > row["vaf_before_percent"] and row["version"] == pitchid.__version__


def test_nothing_is_lost_or_twice_when_workers_are_killed(cluster, logs):
    client, generator = cluster.client(), np.random.default_rng(16)
    run = fleet.diagnose(str(logs / "**/*.csv"), client, out="fleet.parquet", limit_s=120)
    killed = []
    # ten moments spread over the rows
    moments = sorted(generator.choice(np.arange(1, SMALL - 1), size=10, replace=False).tolist())
    rows = []
    for row in run:
        rows.append(row)
        if moments and len(rows) >= moments[0]:
            moments.pop(0)
            delay = generator.uniform(0, 0.2)
            time.sleep(delay)
            killed.append(kill_a_worker(client, generator))
    assert len(set(killed)) == 10, "ten different processes"
    paths = [row["path"] for row in rows]
    assert len(paths) == len(set(paths)) == SMALL == run.done
    table = fleet.read_table("fleet.parquet").to_pylist()
    assert sorted(paths) == [row["path"] for row in table]
    assert all(row["status"] == "answered" for row in table), [row["error"] for row in table if row["error"]]
    sample = table[:: max(1, SMALL // 4)]
    assert all(pitchid.diagnose(row["path"]).to_json() == row["answer"].encode() for row in sample)
    again = fleet.diagnose(str(logs / "**/*.csv"), client, out="fleet.parquet")
    assert list(again) == [] and again.done == SMALL
    client.close()


def test_a_lost_scheduler_leaves_what_was_done_and_the_rest_is_done_later(cluster, logs, tmp_path, monkeypatch):
    monkeypatch.setattr("pitchid.fleet.run.LOST_S", 3.0)
    client = cluster.client()
    run = fleet.diagnose(str(logs / "**/*.csv"), client, out="fleet.parquet")
    rows = []
    with pytest.raises(pitchid.PitchidError, match="scheduler was lost"):
        for row in run:
            rows.append(row)
            if len(rows) == 5:
                cluster.kill_scheduler()
    kept = fleet.read_table("fleet.parquet").to_pylist()
    assert {row["path"] for row in rows} == {row["path"] for row in kept}
    assert 5 <= len(kept) < SMALL and not os.path.exists("fleet.parquet"), "in parts still"
    client.close()
    (tmp_path / "second").mkdir()
    second = Cluster(tmp_path / "second")
    try:
        resumed = fleet.diagnose(str(logs / "**/*.csv"), second.address, out="fleet.parquet")
        new = [row["path"] for row in resumed]
    finally:
        second.close()
    assert not set(new) & {row["path"] for row in kept} and len(new) + len(kept) == SMALL
    assert fleet.read_table("fleet.parquet").num_rows == SMALL and not os.path.exists("fleet.parquet.parts")


def test_files_that_are_corrupt_or_hang_are_rows(logs, tmp_path):
    (tmp_path / "corrupt.csv").write_text("t_s,u_rad,q_rad_s\n0,1,2\n0.02,abc,3\n")
    (tmp_path / "empty.csv").write_bytes(b"")
    (tmp_path / "gone.csv").symlink_to(tmp_path / "nowhere")
    small(tmp_path / "good.csv", 1)
    # whoever opens a pipe that nobody writes to waits for ever
    os.mkfifo(tmp_path / "hangs.csv")
    run = fleet.diagnose(str(tmp_path / "*.csv"), out="out.parquet", limit_s=10, workers=1)
    rows = {os.path.basename(row["path"]): row for row in run.table().to_pylist()}
    assert run.failed == 4 and len(rows) == 5 and rows["good.csv"]["status"] == "answered"
    assert (rows["corrupt.csv"]["line"], rows["corrupt.csv"]["column"]) == (3, "u_rad")
    assert "abc" in rows["corrupt.csv"]["error"] and rows["corrupt.csv"]["remedy"]
    assert "not done after 10 s" in rows["hangs.csv"]["error"]
    assert "No such file" in rows["gone.csv"]["error"]
    assert rows["empty.csv"]["error"]


def test_a_diagnosis_that_takes_too_long_is_ended(friction, model):
    asked = {"out": "out.parquet", "model": model, "workers": 1}
    (row,) = fleet.diagnose(friction, limit_s=0.5, **asked).table().to_pylist()
    assert row["status"] == "failed" and "not done after 0.5 s" in row["error"]
    # what is in the table is not run again, unless it is asked for
    assert list(fleet.diagnose(friction, **asked)) == []
    (row,) = fleet.diagnose(friction, **asked, retry=True).table().to_pylist()
    assert row["status"] == "answered"


def test_other_arguments_and_other_bytes_are_run_again(logs, tmp_path):
    first = tmp_path / "first.csv"
    small(first, 1)
    assert len(list(fleet.diagnose(first, out="out.parquet", workers=1))) == 1
    assert list(fleet.diagnose(first, out="out.parquet", workers=1)) == []
    (row,) = fleet.diagnose(first, out="out.parquet", workers=1, input="interpolated")
    assert json.loads(row["arguments"])["options"] == {"input": "interpolated"}
    small(first, 2)
    assert len(list(fleet.diagnose(first, out="out.parquet", workers=1, input="interpolated"))) == 1
    assert fleet.read_table("out.parquet").num_rows == 1
    held = fleet.diagnose(first, out="held.parquet")
    with pytest.raises(pitchid.PitchidError, match="another run"):
        fleet.diagnose(first, out="held.parquet")
    with pytest.raises(pitchid.PitchidError, match="no files"):
        fleet.diagnose("nothing/*.csv", out="held.parquet")
    del held


def test_the_shell_does_it_too(logs):
    command = [sys.executable, "-m", "pitchid.fleet", str(logs / "quad/craft-0/*.csv"), "--out", "out.parquet"]
    done = subprocess.run([*command, "--workers", "1", "--report", "page.html"], capture_output=True, text=True)
    count = len(list((logs / "quad/craft-0").iterdir()))
    assert done.returncode == 0, done.stderr
    assert f"diagnosing: {count} of {count}" in done.stderr
    assert done.stdout == f"{count} recordings, 0 failed: out.parquet\n"
    with open("page.html") as page:
        assert "fewer than 4 craft" in page.read()
    lost = subprocess.run([*command, "--scheduler", "tcp://127.0.0.1:1"], capture_output=True, text=True)
    assert lost.returncode == 2 and "no scheduler answers" in lost.stderr and "Traceback" not in lost.stderr
