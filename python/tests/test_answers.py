"""Answers are the command's, and can be used as Python has it."""

import json
import pickle

import numpy as np
import pytest
from command import needs_command, run
from small import small

import pitchid


@needs_command
def test_a_diagnosis_is_the_commands_byte_for_byte(friction, model, answer):
    printed = run("diagnose", friction, "--model", model, "--json", "-")
    assert answer.to_json() == printed
    at_hand = pitchid.diagnose(pitchid.read(friction), model=model)
    assert at_hand.to_json() == printed
    assert answer.to_dict() == json.loads(printed)
    small("small.csv", 3)
    without = run("diagnose", "small.csv", "--section=I=1..8", "--section=IV=10..19", "--input", "interpolated", "--json", "-")
    options = {"sections": {"I": (1, 8), "IV": (10, 19)}, "input": "interpolated"}
    assert pitchid.diagnose("small.csv", **options).to_json() == without


@needs_command
def test_all_other_answers_are_the_commands_too(friction, model):
    assert pitchid.identify(friction, model=model).to_json() == run("identify", friction, "--model", model, "--json", "-")
    assert pitchid.show(friction).to_json() == run("show", friction, "--json", "-")
    other = pitchid.simulate(seed=8)
    other.recording.to_csv("other.csv")
    compared = pitchid.compare(friction, "other.csv", friction=True)
    assert compared.to_json() == run("compare", friction, "other.csv", "--friction", "--json", "-")
    assert compared.axes[0]["summary"]
    run("simulate", "--seed", 8, "--out", "simulation", "--json", "flown.json")
    with open("flown.json", "rb") as file:
        assert other.to_json() == file.read()
    with open("simulation", "rb") as file:
        assert pitchid.simulate(seed=8).recording.to_numpy().keys() == pitchid.read("simulation").to_numpy().keys()
    plan = {"mass": 5, "arm": 0.415, "flights": 10, "limit": 0.4}
    words = [f"--{name}={value}" for name, value in plan.items()]
    assert pitchid.plan(**plan).to_json() == run("plan", *words, "--json", "-")


@needs_command
def test_several_recordings_and_all_axes():
    names = ["first.csv", "second.csv"]
    for seed, name in enumerate(names):
        small(name, seed)
    both = run("diagnose", *names, "--json", "-")
    assert pitchid.diagnose(names).to_json() == both
    assert pitchid.diagnose([pitchid.read(name) for name in names]).to_json() == both
    first, second = (pitchid.read(name).to_numpy() for name in names)
    axes = {"t_s": first["t_s"], "u_roll_norm": first["u_rad"], "p_rad_s": first["q_rad_s"]}
    axes |= {"u_pitch_norm": second["u_rad"], "q_rad_s": second["q_rad_s"]}
    np.savetxt("axes.csv", np.stack(list(axes.values()), axis=1), delimiter=",", fmt="%.17g", header=",".join(axes), comments="")
    found = pitchid.diagnose("axes.csv", axis="all")
    assert isinstance(found, pitchid.Diagnoses) and [one.axis for one in found.axes] == ["roll", "pitch"]
    assert found.to_json() == run("diagnose", "axes.csv", "--axis", "all", "--json", "-")
    assert found.axes[0].diagnosis.verdict == found.to_dict()["axes"][0]["answer"]["verdict"]


def test_a_diagnosis_has_fields(answer):
    assert answer.verdict == "named"
    (effect,) = answer.effects
    assert effect.id == "coulomb_friction" and effect.probability > 0.9
    (size,) = effect.parameters
    assert size.unit == "N m" and size.ci95[0] < size.value < size.ci95[1]
    assert abs(size.value - 0.1) < 0.01
    assert answer.parameters["dM_du"].unit == "N m/rad"
    assert answer.fit.held_out.keys() == {"I", "II", "III", "IV"}
    assert "coulomb_friction" in str(answer)


def test_a_notebook_shows_the_report(answer):
    shown = answer._repr_html_()
    assert shown.startswith("<iframe") and "&lt;svg" in shown
    assert answer.to_html().startswith("<!DOCTYPE html>")
    assert all(svg.startswith("<svg") for svg in answer.pictures().values()) and answer.pictures()
    assert pitchid.show(pitchid.simulate().recording)._repr_html_().startswith("<iframe")


def test_an_answer_outlives_its_process(answer):
    copy = pickle.loads(pickle.dumps(answer))
    assert copy == answer and copy.to_json() == answer.to_json()
    assert copy._repr_html_() is None


def test_the_model_is_taken_by_others(answer, flown, tmp_path):
    control = pytest.importorskip("control")
    signal = pytest.importorskip("scipy.signal")
    linear = answer.model.linear
    # rate and angle of the craft, and of the mount of its sensor
    assert control.ss(*linear).nstates == len(linear.A) == 4
    t = np.arange(0, 2, 0.02)
    _, y, _ = signal.lsim(linear, np.ones_like(t), t)
    late = control.step_response(linear.to_control(order=6), t)
    # the delay of 0.06 s is beside the matrices, and in what control is given
    shifted = np.interp(t - linear.delay_s, t, y[:, 0], left=0.0)
    np.testing.assert_allclose(late.outputs[0, 0], shifted, atol=0.02 * np.abs(shifted).max())
    answer.model.save(tmp_path / "extended.toml")
    again = pitchid.simulate(model=tmp_path / "extended.toml", seed=7)
    assert [effect["id"] for effect in again.truth["effects"]] == ["coulomb_friction"]


def test_sampled_models_simulate_what_was_measured(flown):
    control = pytest.importorskip("control")
    signal = pytest.importorskip("scipy.signal")
    recording = flown.recording
    found = pitchid.identify(recording)
    assert [method.name for method in found.methods if method.name in found.state_spaces]
    rows = recording.sections["III"]
    u, q = recording["u_rad"][rows], recording["q_rad_s"][rows]
    model = found.state_spaces["PI-MOESP"]
    samples = round(model.delay_s / model.dt)
    late = np.concatenate([np.zeros(samples), u[: len(u) - samples]])
    _, simulated, _ = signal.dlsim(model, late)
    of_control = control.forced_response(model.to_control(), inputs=u).outputs.ravel()
    np.testing.assert_allclose(of_control, simulated.ravel(), atol=1e-9)
    vaf = 100 * (1 - np.var(q - of_control) / np.var(q))
    assert vaf > 60, vaf
