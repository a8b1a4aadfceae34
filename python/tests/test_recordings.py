"""Recordings from and to arrays and tables."""

import signal
import threading
import time

import numpy as np
import pytest

import pitchid
from pitchid import Recording


def test_arrays_and_files_are_the_same_recording(flown, friction, model, answer):
    recording = flown.recording
    columns = dict(recording.to_numpy())
    columns["section"], columns["supervised"] = recording.labels(), recording.supervised
    made = Recording.from_arrays(columns, name=str(friction))
    assert made.sections == recording.sections and made.notes == pitchid.read(friction).notes
    assert pitchid.diagnose(made, model=model).to_json() == answer.to_json()


def test_tables_of_pandas_go_there_and_back(flown):
    pandas = pytest.importorskip("pandas")
    table = flown.recording.to_pandas()
    assert len(table) == len(flown.recording) and table["q_rad_s"].dtype == np.float64
    again = Recording.from_pandas(table)
    assert again.to_pandas().equals(table)
    timed = table.drop(columns="t_s").set_index(pandas.Timestamp("2026-01-01") + pandas.to_timedelta(table["t_s"], unit="s"))
    assert Recording.from_pandas(timed).step == pytest.approx(0.02)


def test_columns_are_views_that_nobody_can_change(flown):
    q = flown.recording["q_rad_s"]
    assert np.shares_memory(q, flown.recording["q_rad_s"])
    with pytest.raises(ValueError, match="read-only"):
        q[0] = 1.0
    kept = Recording.from_arrays({"t_s": np.arange(100) * 0.02, "u_rad": np.sin(np.arange(100.0)), "q_rad_s": np.ones(100)})[
        "u_rad"
    ]
    assert kept[1] == np.sin(1.0), "the array keeps what it shows"


def test_an_hour_passes_without_more_copies_than_needed():
    psutil = pytest.importorskip("psutil")
    rows = 3600 * 50
    columns = {name: np.random.default_rng(1).normal(size=rows) for name in ["u_rad", "q_rad_s", "theta_rad"]}
    columns = {"t_s": np.arange(rows) * 0.02, **columns}
    size = sum(column.nbytes for column in columns.values())
    process = psutil.Process()
    before = process.memory_info().rss
    recording = Recording.from_arrays(columns)
    grown = process.memory_info().rss - before
    # the engine's own columns, one more while the clock is looked at, and what the allocator keeps
    assert grown < 2.5 * size, f"{grown / size:.2f} times the columns"
    before = process.memory_info().rss
    views = recording.to_numpy()
    assert sum(view.nbytes for view in views.values()) == size
    assert process.memory_info().rss - before < 0.05 * size


def test_errors_say_where_and_what_to_do(tmp_path):
    (tmp_path / "bad.csv").write_text("t_s,u_rad,q_rad_s\n0,1,2\n0.02,abc,3\n")
    with pytest.raises(pitchid.PitchidError) as caught:
        pitchid.read("bad.csv")
    error = caught.value
    assert (error.file, error.line, error.column) == ("bad.csv", 3, "u_rad")
    assert "finite number" in error.remedy and 'found "abc"' in str(error)
    for wrong, says in [
        (lambda: pitchid.read("nowhere.csv"), "no such file"),
        (lambda: pitchid.read("bad.csv", axis="up"), "'up'"),
        (lambda: pitchid.simulate(effects=["no_such"]), "no_such"),
        (lambda: pitchid.diagnose(pitchid.simulate().recording, model="no.toml"), "no.toml"),
        (lambda: Recording.from_arrays({"t_s": [0.0, 0.1], "q_rad_s": [1.0, 2.0]}), "input"),
        (lambda: Recording.from_arrays({"t_s": [0.0, 0.1], "u_rad": [1.0]}), "1 values"),
    ]:
        with pytest.raises(pitchid.PitchidError, match=says) as caught:
            wrong()
        assert caught.value.remedy
    with pytest.raises(TypeError, match="axis"):
        pitchid.diagnose(pitchid.simulate().recording, axis="roll")


def test_others_run_while_it_works(friction, model):
    counted, done = [], threading.Event()

    def count():
        while not done.is_set():
            counted.append(time.perf_counter())
            time.sleep(0.002)

    thread = threading.Thread(target=count)
    thread.start()
    pitchid.diagnose(friction, model=model)
    done.set()
    thread.join()
    assert max(np.diff(counted)) < 0.3, "somebody held the interpreter"


def test_control_c_ends_it(friction):
    # a process in the background of a shell is started with Ctrl-C ignored
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    begun = time.perf_counter()
    threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            # many times as much as 0.3 s
            pitchid.plan(mass=5, arm=0.415, flights=2000)
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.perf_counter() - begun < 2
    # and the work itself ends with its next step: nothing is left that takes the processor
    time.sleep(3)
    used = time.process_time()
    time.sleep(1)
    assert time.process_time() - used < 0.2
