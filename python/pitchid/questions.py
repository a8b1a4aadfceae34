"""The questions: what the subcommands of ``pitchid`` answer, as functions."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from typing import Any, Union

import msgspec

from . import _native, _words
from ._words import Path, Span, option
from .answers import Comparison, Diagnosed, Diagnoses, Diagnosis, Identification, Plan, Shown, Simulation
from .recording import Recording, read

Source = Union[Path, Recording]
Effects = Union[Iterable[str], Mapping[str, Mapping[str, float]]]


class _Schema(msgspec.Struct):
    schema: str


def _at_hand(source: Source | Iterable[Source]) -> list[Recording] | None:
    """The recordings, where these are recordings and not files."""
    all_ = [source] if isinstance(source, (str, os.PathLike, Recording)) else list(source)
    recordings = [one for one in all_ if isinstance(one, Recording)]
    if recordings and len(recordings) < len(all_):
        raise TypeError("either files or recordings, not both; pitchid.read makes a recording of a file")
    if len({one.axis for one in recordings}) > 1:
        raise ValueError("recordings of several axes; one question is about one axis")
    return recordings or None


def _path(model: Path | None) -> str | None:
    return None if model is None else os.fspath(model)


def _refuse(options: Mapping[str, Any]) -> None:
    given = sorted(name for name, value in options.items() if value not in (None, True))
    if given:
        raise TypeError(f"{', '.join(given)}: of files; a recording at hand was read already")


def diagnose(source: Source | Iterable[Source], *, model: Path | None = None, **reading: Any) -> Diagnosed:
    """Says what physics the model of these recordings leaves out, and what adding it gains.

    Parameters
    ----------
    source : path, Recording, or several of either
        One vehicle; several are one data set.
    model : path, optional
        The simulation in use today, a model file. Without it, the grey-box model with moments per unit inertia.
    **reading
        How files are read: the options of :func:`read`. With ``axis="all"`` every axis of a flight log is asked, and first
        what they share.

    Returns
    -------
    Diagnosis, or Diagnoses with ``axis="all"``

    Raises
    ------
    PitchidError
        Input that cannot be used.

    Examples
    --------
    >>> flown = simulate(effects=["coulomb_friction"])
    >>> answer = diagnose(flown.recording)                                  # doctest: +SKIP
    >>> answer.verdict                                                      # doctest: +SKIP
    'named'
    """
    recordings = _at_hand(source)
    if recordings:
        _refuse(reading)
        return Diagnosis._of(_native.diagnose([one._native for one in recordings], _path(model)))
    words = _words.reading(model=model, **reading) + _words.files(_words.paths(source))
    answer = _native.diagnose_files(words)
    # all axes may be asked by pitchid.toml too
    schema = msgspec.json.decode(answer.json, type=_Schema).schema
    return (Diagnoses if schema == "pitchid.diagnoses/1" else Diagnosis)._of(answer)


def identify(source: Source | Iterable[Source], *, model: Path | None = None, **reading: Any) -> Identification:
    """Identifies the dynamics by every method, and judges each on data that it has not seen.

    Parameters
    ----------
    source : path, Recording, or several of either
        One vehicle; several are one data set.
    model : path, optional
        The simulation in use today: inertia, and where the fits start.
    **reading
        How files are read: the options of :func:`read`.

    Returns
    -------
    Identification

    Raises
    ------
    PitchidError
        Input that cannot be used.
    """
    recordings = _at_hand(source)
    if recordings:
        _refuse(reading)
        return Identification._of(_native.identify([one._native for one in recordings], _path(model)))
    words = _words.reading(model=model, **reading) + _words.files(_words.paths(source))
    return Identification._of(_native.identify_files(words))


def compare(
    before: Source,
    after: Source,
    *,
    model: Path | None = None,
    friction: bool = False,
    axis: str | None = None,
    columns: Mapping[str, str] | None = None,
    input: str | None = None,
    time: tuple[Span, Span] | None = None,
    flight: tuple[int, int] | None = None,
    vehicle_file: bool = True,
) -> Comparison:
    """Says what changed on a craft between two recordings of it.

    Parameters
    ----------
    before, after : path or Recording
        Two files, or two recordings.
    model : path, optional
        The simulation in use: gives the inertia, so that moments are in N m.
    friction : bool
        Whether to compare dry friction too.
    axis : str, optional
        ``roll``, ``pitch``, ``yaw`` or ``all``; all without it.
    columns, input, vehicle_file
        As :func:`read`, of files.
    time : two of (float, float), optional
        The part of each to use, s.
    flight : (int, int), optional
        Which flight of each log.

    Returns
    -------
    Comparison

    Raises
    ------
    PitchidError
        Input that cannot be used.
    """
    recordings = _at_hand([before, after])
    if recordings:
        _refuse({"axis": axis, "columns": columns, "input": input, "time": time, "flight": flight})
        first, second = (one._native for one in recordings)
        return Comparison._of(_native.compare(first, second, _path(model), friction))
    words = _words.reading(model=model, axis=axis, columns=columns, input=input, vehicle_file=vehicle_file)
    words += ["--friction"] if friction else []
    words += [f"--time={_words.span(part)}" for part in time or ()]
    words += [f"--flight={number}" for number in flight or ()]
    return Comparison._of(_native.compare_files(words + _words.files(_words.paths([before, after]))))


def _effect(name: str, parameters: Mapping[str, float]) -> str:
    values = ",".join(f"{key}={value!r}" for key, value in parameters.items())
    return f"{name}:{values}" if values else name


def _effects(effects: Effects) -> list[str]:
    return [_effect(*of) for of in effects.items()] if isinstance(effects, Mapping) else list(effects)


def plan(
    *,
    model: Path | None = None,
    axis: str | None = None,
    mass: float | None = None,
    arm: float | None = None,
    rivals: Effects = (),
    diagnosis: Path | None = None,
    limit: float | None = None,
    amplitude: float | None = None,
    supervised: float | None = None,
    time: float | None = None,
    accuracy: float | None = None,
    background: str | None = None,
    air: str | None = None,
    flights: int | None = None,
    seed: int | None = None,
    vehicle_file: bool = True,
) -> Plan:
    """Plans the experiment before it is flown: amplitude, dwell, length and order, and what to expect of it.

    Parameters
    ----------
    model : path, optional
        What is known of the craft; or ``mass`` (kg) and ``arm`` (m, of the rotors' hubs from the pitch axis).
    axis : str, optional
        Of a model file of several.
    rivals : two effects, optional
        To be told apart: ``["servo_lag", "gyro_lag"]``, or with sizes ``{"servo_lag": {"T": 0.05}, "gyro_lag": {}}``.
    diagnosis : path, optional
        The JSON of a diagnosis that ended with rivals.
    limit : float, optional
        Angle that must not be passed, rad.
    amplitude : float, optional
        Largest amplitude of the excitation, rad.
    supervised : float, optional
        Share of the excitation that the supervisor may take, %.
    time : float, optional
        Longest test, s.
    accuracy : float, optional
        Half the 95 % interval of dM/du that is wanted, %.
    background, air : str, optional
        How strong the air is (``clean``, ``lab``, ``paper``), and of which kind.
    flights, seed : int, optional
        Flights by which each test is foretold; seed of everything drawn.
    vehicle_file : bool
        Whether ``pitchid.toml`` counts.

    Returns
    -------
    Plan

    Raises
    ------
    PitchidError
        No excitation keeps the limits, or input that cannot be used.
    """
    given = {
        "--model": _path(model),
        "--axis": axis,
        "--mass": mass,
        "--arm": arm,
        "--diagnosis": _path(diagnosis),
        "--limit": limit,
        "--amplitude": amplitude,
        "--supervised": supervised,
        "--time": time,
        "--accuracy": accuracy,
        "--background": background,
        "--air": air,
        "--flights": flights,
        "--seed": seed,
    }
    words = [word for name, value in given.items() for word in option(name, value)]
    two = _effects(rivals)
    words += ["--rivals", *two] if two else []
    return Plan._of(_native.plan(words + ([] if vehicle_file else ["--no-vehicle-file"])))


def show(
    source: Source | Iterable[Path],
    *,
    axis: str | None = None,
    flight: int | None = None,
    time: Span | None = None,
) -> Shown:
    """Says what a flight log or a recording holds: whether it can serve, where something moves, what to set if not.

    Parameters
    ----------
    source : path, several paths, or Recording
        What to look at.
    axis : str, optional
        Only this axis.
    flight : int, optional
        Only this flight of a log that holds several.
    time : (float, float), optional
        Only this part, s.

    Returns
    -------
    Shown

    Raises
    ------
    PitchidError
        Input that cannot be used.
    """
    if isinstance(source, Recording):
        _refuse({"axis": axis, "flight": flight, "time": time})
        return Shown._of(_native.show(source._native))
    words = option("--axis", axis) + option("--flight", flight)
    words += option("--time", None if time is None else _words.span(time))
    return Shown._of(_native.show_files(words + _words.files(_words.paths(source))))


def simulate(
    *,
    effects: Effects = (),
    campaign: int | None = None,
    amplitude: float | None = None,
    seed: int | None = None,
    background: str | None = None,
    air: str | None = None,
    model: Path | None = None,
    name: str = "simulation",
) -> Simulation:
    """Flies a whole test on a simulated vehicle; the same arguments give the same recording.

    Parameters
    ----------
    effects : effects, optional
        Physics to conceal: ``["coulomb_friction"]`` at a usual size, ``["coulomb_friction:Mc=0.1"]`` or
        ``{"coulomb_friction": {"Mc": 0.1}}``.
    campaign : int, optional
        Dwell of the PRBS, 1 to 4.
    amplitude : float, optional
        Amplitude of the PRBS, rad.
    seed : int, optional
        Seed of everything random.
    background, air : str, optional
        How much of the motion nothing causes (``clean``, ``lab``, ``paper``), and of which kind.
    model : path, optional
        Flies plant and effects of this model file.
    name : str
        What messages call the recording, as the path behind ``--out``.

    Returns
    -------
    Simulation

    Raises
    ------
    PitchidError
        No such effect or parameter, or a model that cannot be flown.

    Examples
    --------
    >>> simulate(seed=3).outcome
    'finished'
    """
    given = {
        "--campaign": campaign,
        "--amplitude": amplitude,
        "--seed": seed,
        "--background": background,
        "--air": air,
        "--model": _path(model),
    }
    words = [word for option_, value in given.items() for word in option(option_, value)]
    words += [f"--effect={effect}" for effect in _effects(effects)]
    native, truth, csv = _native.simulate([*words, f"--out={name}"])
    flown = Simulation._of(native)
    flown.truth, flown.recording = json.loads(truth), Recording(_native.recording_of_csv(name, csv))
    return flown


__all__ = ["compare", "diagnose", "identify", "plan", "read", "show", "simulate"]
