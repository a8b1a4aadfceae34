"""Identification and diagnosis of the pitch axis of rotorcraft, from recordings.

>>> import pitchid
>>> answer = pitchid.diagnose("flight.csv", model="simulation.toml")     # doctest: +SKIP
>>> answer.verdict, answer.effects[0].id                                 # doctest: +SKIP
('named', 'coulomb_friction')

Every answer holds the JSON of the command ``pitchid``, byte for byte (``to_json``, ``to_dict``), prints as the command
does, and shows its report in a notebook. Many recordings at once: :mod:`pitchid.fleet`.
"""

from ._errors import PitchidError
from ._native import __version__
from .answers import (
    Change,
    Comparison,
    Diagnoses,
    Diagnosis,
    Effect,
    Estimate,
    Identification,
    Method,
    Plan,
    Shown,
    Simulation,
)
from .model import Model, StateSpace
from .questions import compare, diagnose, identify, plan, show, simulate
from .recording import Recording, read

__all__ = [
    "Change",
    "Comparison",
    "Diagnoses",
    "Diagnosis",
    "Effect",
    "Estimate",
    "Identification",
    "Method",
    "Model",
    "PitchidError",
    "Plan",
    "Recording",
    "Shown",
    "Simulation",
    "StateSpace",
    "__version__",
    "compare",
    "diagnose",
    "identify",
    "plan",
    "read",
    "show",
    "simulate",
]
