"""Answers: what the command's JSON says, as dataclasses that a notebook shows as the report."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Optional, Union

import msgspec

from .model import Model, StateSpace
from .recording import Recording

if TYPE_CHECKING:
    from ._native import Answer as Native

Number = Optional[float]
"""A number; None where it is not finite."""


class Answer:
    """What all answers have: the JSON of the command, its words, its report."""

    # without annotations, as these are no fields
    _json = b""
    _native = None

    @classmethod
    def from_json(cls, text: bytes | str) -> Any:
        """Reads an answer that the command, or :meth:`to_json`, has written.

        Parameters
        ----------
        text : bytes or str
            The JSON.

        Returns
        -------
        Answer
            Without report and pictures, which are not in the JSON.
        """
        text = text.encode() if isinstance(text, str) else text
        answer = msgspec.json.decode(text, type=cls)
        answer._json, answer._native = text, None
        return answer

    @classmethod
    def _of(cls, native: Native) -> Any:
        answer = cls.from_json(native.json)
        answer._native = native
        return answer

    def __reduce__(self):
        # the report stays where it was made
        return type(self).from_json, (self._json,)

    def to_json(self) -> bytes:
        """The answer as the command writes it with ``--json``, byte for byte."""
        return self._json

    def to_dict(self) -> Any:
        """The JSON as Python has it."""
        return json.loads(self._json)

    def __str__(self) -> str:
        return self._native.text if self._native else self._json.decode()

    def to_html(self) -> str | None:
        """The report: one page that needs nothing else; None of an answer that has none."""
        return self._native.html() if self._native else None

    def pictures(self) -> dict[str, str]:
        """The pictures of the report as SVG, by name."""
        return dict(self._native.pictures()) if self._native else {}

    def _repr_html_(self) -> str | None:
        page = self.to_html()
        if page:
            # a frame keeps the styles of page and notebook apart
            return (
                f'<iframe srcdoc="{html.escape(page)}" style="width: 100%; height: 40rem; border: 0; resize: vertical"></iframe>'
            )
        if not self._native:
            return None
        return f"<pre>{html.escape(str(self))}</pre>" + "".join(self.pictures().values())


@dataclass
class Estimate:
    """A number with its unit (``1`` for a pure number) and its 95 % interval, whose ends are None where there is none."""

    name: str
    unit: str
    value: Number
    ci95: tuple[Number, Number]


@dataclass
class WithError:
    """A figure with its standard error."""

    value: Number
    standard_error: Number


@dataclass
class Alternative:
    """A candidate that the data cannot rule out, with its probability."""

    id: str
    probability: float


@dataclass
class Evidence:
    """What speaks for a term: the model with it against the model without it."""

    log_evidence: Number
    p_value: Number
    vaf_gain_points: WithError
    held_out_log_likelihood: WithError


@dataclass
class Effect:
    """One effect that was added to the model.

    Attributes
    ----------
    id : str
        Id of the catalogue, or ``unlisted``.
    probability : float
        That this term is in the model, over all models visited.
    share : float
        Of what the fullest model gains, the part that is lost without this term.
    """

    id: str
    locus: str
    equation: str
    parameters: list[Estimate]
    by_part: dict[str, list[WithError]]
    probability: Number
    share: Number
    alternatives: list[Alternative]
    evidence: Evidence


@dataclass
class ModelFit:
    """How one model fits."""

    vaf_percent: dict[str, Number]
    horizon_vaf_percent: dict[str, dict[str, WithError]]
    parameters: list[Estimate]


@dataclass
class Fit:
    """Baseline against extended model; ``held_out`` by models that never saw the section.

    Attributes
    ----------
    predicted : str or None
        How far ahead the terms tell the motion held out: ``far``, ``near`` or ``little``; ``None`` where none was held out.
    """

    baseline: ModelFit
    extended: ModelFit
    held_out: dict[str, dict[str, Any]]
    predicted: str | None
    chosen_in: dict[str, tuple[int, int]]
    ceiling_vaf_percent: dict[str, Number]


@dataclass
class Question:
    """A question of a careful person, and what the data say."""

    question: str
    answer: str


@dataclass
class DataCheck:
    """What could make model and data differ without missing physics: ``ruled_out``, ``found`` or ``cannot_tell``."""

    cause: str
    state: str
    words: str


@dataclass
class Diagnosis(Answer):
    """What the model leaves out.

    Attributes
    ----------
    verdict : str
        ``no_mismatch``, ``named``, ``ambiguous``, ``unlisted``, ``not_excited`` or ``check_data``.
    summary : str
        One to three sentences.
    effects : list of Effect
        The terms that were added, largest share first.
    model : Model or None
        The model with what was missing.
    """

    schema: str
    verdict: str
    summary: str
    questions: list[Question]
    effects: list[Effect]
    in_model: list[dict[str, Any]]
    remainder: Optional[dict[str, Any]]
    location: Optional[dict[str, Any]]
    fit: Fit
    next_experiment: Optional[dict[str, Any]]
    data_checks: list[DataCheck]
    per_unit_inertia: bool
    notes: list[str]
    balance: Optional[dict[str, Any]] = None

    @property
    def model(self) -> Model | None:
        return Model._of(self._native) if self._native else None

    @property
    def parameters(self) -> dict[str, Estimate]:
        """The parameters that are told, by name: of the model with what was missing, or of the baseline where nothing is.

        Empty where the data cannot tell or are to be put right first.
        """
        told = self.fit.extended if self.effects else self.fit.baseline
        return {estimate.name: estimate for estimate in told.parameters}


@dataclass
class OfAxis:
    """The diagnosis of one axis."""

    axis: str
    answer: dict[str, Any]

    @property
    def diagnosis(self) -> Diagnosis:
        """The answer by its fields."""
        return Diagnosis.from_json(json.dumps(self.answer))


@dataclass
class Diagnoses(Answer):
    """What the models of all axes leave out, and what they share."""

    schema: str
    shared: Optional[dict[str, Any]]
    axes: list[OfAxis]


@dataclass
class Method:
    """One method of identification: VAF by section, per cent."""

    name: str
    detail: str
    vaf_percent: dict[str, Number]
    remark: str
    tests: dict[str, dict[str, Any]] = field(repr=False)


@dataclass
class Identification(Answer):
    """The dynamics, by every method side by side.

    Attributes
    ----------
    methods : list of Method
        Each judged on sections that it has not seen.
    parameters : list of Estimate
        Of the grey box.
    model : Model or None
        The grey box.
    state_spaces : dict of str to StateSpace
        Sampled models of the methods that find one.
    cautions : list of str
        What speaks against a controller that rests on the grey box's values; empty where nothing does.
    """

    schema: str
    methods: list[Method]
    ceiling_vaf_percent: dict[str, Number]
    parameters: list[Estimate]
    parameters_coloured: list[Estimate]
    correlation: list[list[Number]] = field(repr=False)
    identifiability: Optional[dict[str, Any]] = field(repr=False)
    delay: Optional[dict[str, Any]] = field(repr=False)
    subspace: Optional[dict[str, Any]] = field(repr=False)
    hinf: Optional[dict[str, Any]] = field(repr=False)
    response: list[dict[str, Any]] = field(repr=False)
    training: list[str]
    held_out: list[str]
    cautions: list[str]
    notes: list[str]

    @property
    def model(self) -> Model | None:
        return Model._of(self._native) if self._native else None

    @property
    def state_spaces(self) -> dict[str, StateSpace]:
        if not self._native:
            return {}
        return {name: StateSpace(*linear) for name, linear in self._native.methods()}


@dataclass
class Change:
    """What became of one quantity."""

    quantity: str
    before: Estimate
    after: Estimate
    difference: Estimate
    verdict: str
    probability: Number


@dataclass
class Comparison(Answer):
    """What changed on a craft between two recordings.

    Attributes
    ----------
    axes : list of dict
        For each axis ``axis``, ``summary``, ``changes`` and what else the JSON has.
    """

    schema: str
    before: str
    after: str
    axes: list[dict[str, Any]]


@dataclass
class Plan(Answer):
    """An experiment before it is flown; see docs/plan.md for its fields."""

    tests: list[dict[str, Any]]
    accuracy: list[dict[str, Any]]
    notes: list[str]


@dataclass
class Shown(Answer):
    """What a log or a recording holds.

    Attributes
    ----------
    holds : list of dict
        One for each flight of a log, or axis of a recording, as the JSON has them.
    """

    holds: list[dict[str, Any]]

    @classmethod
    def from_json(cls, text: bytes | str) -> Shown:
        text = text.encode() if isinstance(text, str) else text
        answer = cls(json.loads(text))
        answer._json, answer._native = text, None
        return answer


@dataclass
class Simulation(Answer):
    """A flight on the simulated test-bed.

    Attributes
    ----------
    recording : Recording
        What a rig would have logged.
    truth : dict
        What was really there.
    outcome : str
        How it ended.
    """

    schema: str
    campaign: int
    amplitude_rad: float
    seed: int
    seconds: float
    samples: int
    overridden_percent: float
    outcome: str
    recording: ClassVar[Recording]
    truth: ClassVar[dict[str, Any]]


Diagnosed = Union[Diagnosis, Diagnoses]
