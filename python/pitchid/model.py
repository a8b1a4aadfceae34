"""Models that were found, as other packages take them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from . import _native


class StateSpace(tuple):
    """A linear model from the input to the measured outputs.

    It is the tuple ``(A, B, C, D)`` in continuous and ``(A, B, C, D, dt)`` in discrete time, so that ``scipy.signal.lsim``,
    ``scipy.signal.dlsim`` and the like take it as it is, and ``control.ss(*model)`` too. The delay of the input is beside it.

    Attributes
    ----------
    A, B, C, D : numpy.ndarray
        The matrices.
    dt : float or None
        Step in s; None in continuous time.
    delay_s : float
        By how much the input acts later than it is given, s; not in the matrices.
    states : list of str
        Names of the states.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    dt: float | None
    delay_s: float
    states: list[str]

    def __new__(cls, A, B, C, D, dt=None, delay_s=0.0, states=()):
        matrices = (A, B, C, D)
        model = super().__new__(cls, matrices if dt is None else (*matrices, dt))
        model.A, model.B, model.C, model.D = matrices
        model.dt, model.delay_s, model.states = dt, delay_s, list(states)
        return model

    def __reduce__(self):
        return StateSpace, (self.A, self.B, self.C, self.D, self.dt, self.delay_s, self.states)

    def __repr__(self) -> str:
        time = "continuous" if self.dt is None else f"dt = {self.dt} s"
        return f"<StateSpace: {len(self.A)} states, {time}, input delayed by {self.delay_s:.4g} s>"

    def to_control(self, order: int = 4) -> Any:
        """For python-control, the delay included.

        Parameters
        ----------
        order : int
            Order of the Padé approximation of the delay in continuous time; in discrete time the delay is exact.

        Returns
        -------
        control.StateSpace
        """
        import control

        outputs = ["q", "theta"][: len(self.C)]
        names = {"states": self.states, "inputs": ["u"], "outputs": outputs}
        if self.dt is not None:
            plant = control.ss(self.A, self.B, self.C, self.D, self.dt, **names)
            samples = round(self.delay_s / self.dt)
            if samples == 0:
                return plant
            late = np.eye(samples, k=-1), np.eye(samples, 1), np.eye(1, samples, samples - 1)
            return plant * control.ss(*late, np.zeros((1, 1)), self.dt)
        plant = control.ss(self.A, self.B, self.C, self.D, **names)
        if self.delay_s == 0:
            return plant
        return plant * control.ss(control.tf(*control.pade(self.delay_s, order)))

    def to_scipy(self) -> Any:
        """For scipy.signal, without the delay: shift the input by ``delay_s``.

        Returns
        -------
        scipy.signal.StateSpace
        """
        from scipy.signal import StateSpace as Scipy

        return Scipy(self.A, self.B, self.C, self.D, **({} if self.dt is None else {"dt": self.dt}))


@dataclass(frozen=True)
class Model:
    """A model of one axis, as model files have it.

    Attributes
    ----------
    toml : str
        The text of the model file: plant, effects, intervals.
    linear : StateSpace or None
        Its linear part, from the input to rate and angle; None where the data do not determine effectiveness or damping.
    """

    toml: str
    linear: StateSpace | None

    def save(self, path: str) -> None:
        """Writes the model file, as ``--out-model`` does.

        Parameters
        ----------
        path : str
            Where to.
        """
        with open(path, "w", encoding="utf-8", newline="\n") as file:
            file.write(self.toml)

    @classmethod
    def _of(cls, answer: _native.Answer) -> Model | None:
        if answer.model is None:
            return None
        linear = answer.linear()
        return cls(answer.model, None if linear is None else StateSpace(*linear))
