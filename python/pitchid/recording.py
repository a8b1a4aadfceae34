"""Recordings, from files and from arrays."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native, _words
from ._words import Path, Span

if TYPE_CHECKING:
    import pandas


class Recording:
    """A recording of one axis on a uniform clock, in SI units.

    Made by :func:`read`, :meth:`from_arrays` or :meth:`from_pandas`. Its columns are read-only views of the memory that the
    engine works on: nothing is copied.

    Attributes
    ----------
    name : str
        What messages call it.
    axis : str
        The axis: ``roll``, ``pitch`` or ``yaw``. The columns are named as those of pitch whatever the axis.
    step : float
        Step of the clock, s.
    input_unit : str
        Unit of the input; ``1`` for a normalised command.
    sections : dict of str to slice
        Rows of each section.
    notes : list of str
        What was done to the data and what looks wrong.
    columns : list of str
        Names of the columns of numbers, as in :func:`__getitem__`.
    """

    def __init__(self, native: _native.Recording) -> None:
        self._native = native

    @property
    def name(self) -> str:
        return self._native.name

    @property
    def axis(self) -> str:
        return self._native.axis

    @property
    def step(self) -> float:
        return self._native.step

    @property
    def input_unit(self) -> str:
        return self._native.input_unit

    @property
    def sections(self) -> dict[str, slice]:
        return {name: slice(first, end) for name, first, end in self._native.sections}

    @property
    def notes(self) -> list[str]:
        return self._native.notes

    @property
    def columns(self) -> list[str]:
        return self._native.columns

    def __len__(self) -> int:
        return len(self._native)

    def __getitem__(self, column: str) -> np.ndarray:
        """A column, such as ``recording["q_rad_s"]``, as a read-only array without a copy."""
        values = self._native.column(column)
        if values is None:
            raise KeyError(f"{column}; there are {', '.join(self.columns)}")
        return values

    def __repr__(self) -> str:
        seconds = len(self) * self.step
        return f"<Recording {self.name}: {self.axis}, {seconds:.1f} s, {len(self)} samples, {', '.join(self.columns)}>"

    @property
    def supervised(self) -> np.ndarray:
        """Where the supervisor overrode the excitation."""
        return np.asarray(self._native.supervised, dtype=bool)

    @property
    def unmeasured(self) -> np.ndarray:
        """Where neither rate nor angle was measured: the row was filled, or repeats an older reading."""
        return np.asarray(self._native.unmeasured, dtype=bool)

    def labels(self) -> np.ndarray:
        """The section of each row, ``-`` between them."""
        labels = np.full(len(self), "-", dtype=object)
        for name, rows in self.sections.items():
            labels[rows] = name
        return labels

    def to_numpy(self) -> dict[str, np.ndarray]:
        """All columns of numbers, by name.

        Returns
        -------
        dict of str to numpy.ndarray
            Read-only views, no copies.
        """
        return {name: self[name] for name in self.columns}

    def to_pandas(self) -> pandas.DataFrame:
        """A table with a row for each sample: the columns, ``section`` where there are any, ``supervised`` and ``unmeasured``
        where they are ever set.

        Returns
        -------
        pandas.DataFrame
        """
        import pandas

        table: dict[str, Any] = dict(self.to_numpy())
        if list(self.sections) != ["all"]:
            table["section"] = pandas.Categorical(self.labels())
        if self.supervised.any():
            table["supervised"] = self.supervised
        if self.unmeasured.any():
            table["unmeasured"] = self.unmeasured
        return pandas.DataFrame(table)

    def to_csv(self, path: Path) -> None:
        """Writes the format that the command reads.

        Parameters
        ----------
        path : path
            Where to.
        """
        with open(path, "wb") as file:
            file.write(self._native.csv())

    @classmethod
    def from_arrays(
        cls,
        columns: Mapping[str, Any],
        *,
        name: str = "recording",
        axis: str = "pitch",
        sections: Mapping[str, Span] | None = None,
        splits: Iterable[float] = (),
        input: str = "held",
    ) -> Recording:
        """Makes a recording of arrays.

        Parameters
        ----------
        columns : mapping of str to array
            The columns by their names in the format: ``t_s``, an input (``u_rad``, ``u_norm``, ...), ``q_rad_s`` and/or
            ``theta_rad``; beside them any other of the format, ``section`` as texts, ``supervised`` and ``unmeasured`` as 0 or
            1. NaN says that nothing was measured. Arrays of float64 are copied once, into the engine.
        name : str
            What messages call it.
        axis : str
            ``roll``, ``pitch`` or ``yaw``: whose columns these are.
        sections : mapping of str to (float, float), optional
            Sections by time, s.
        splits : iterable of float
            Times at which a new section begins, s.
        input : str
            ``held`` (a command) or ``interpolated`` (it was measured).

        Returns
        -------
        Recording

        Raises
        ------
        PitchidError
            Columns that are missing, of different lengths, or hold what is no measurement.

        Examples
        --------
        >>> t = np.arange(0, 60, 0.02)
        >>> Recording.from_arrays({"t_s": t, "u_rad": 0.01 * np.sin(t**2), "q_rad_s": np.cos(t)}).step
        0.02
        """
        numbers, labels = [], None
        for column, values in columns.items():
            if column == "section":
                names, rows = np.unique(np.asarray(values).astype(str), return_inverse=True)
                labels = names.tolist(), rows.astype(np.uint32)
            else:
                numbers.append((column, np.asarray(values, dtype=np.float64)))
        parts = _words.sections(sections), [float(at) for at in splits]
        return cls(_native.recording_of(name, axis, numbers, labels, parts[1], parts[0], input))

    @classmethod
    def from_pandas(cls, table: pandas.DataFrame, **options: Any) -> Recording:
        """Makes a recording of a table, its columns named as in :meth:`from_arrays`.

        Parameters
        ----------
        table : pandas.DataFrame
            A row for each sample. Without a column ``t_s``, the index is the time in s, or a time stamp.
        **options
            As :meth:`from_arrays`.

        Returns
        -------
        Recording
        """
        import pandas

        columns = {str(column): table[column].to_numpy() for column in table.columns}
        if "t_s" not in columns:
            index = table.index
            if isinstance(index, pandas.DatetimeIndex):
                time = (index - index[0]) / pandas.Timedelta(seconds=1)
            else:
                time = index
            columns = {"t_s": time.to_numpy(dtype=np.float64), **columns}
        return cls.from_arrays(columns, **options)


def read(
    path: Path,
    *,
    axis: str | None = None,
    columns: Mapping[str, str] | None = None,
    sections: Mapping[str, Span] | None = None,
    splits: Iterable[float] = (),
    input: str | None = None,
    time: Span | None = None,
    flight: int | None = None,
    vehicle_file: bool = True,
) -> Recording:
    """Reads a recording, or one axis of a flight log.

    CSV, Parquet, vectors of MATLAB files, and the logs of PX4, ArduPilot, Betaflight, INAV and MAVLink ground stations, as
    ``pitchid diagnose`` reads them; the options are the command's.

    Parameters
    ----------
    path : path
        The file.
    axis : str, optional
        ``roll``, ``pitch`` or ``yaw``, of a flight log or a recording of several; pitch without it.
    columns : mapping of str to str, optional
        Columns of other names, or arithmetic over columns: ``{"q_rad_s": "-gyro_y*pi/180"}``.
    sections : mapping of str to (float, float), optional
        Sections by time, in seconds of the file's own clock; either end may be None.
    splits : iterable of float
        Times at which a new section begins, s.
    input : str, optional
        ``held`` (a command) or ``interpolated`` (it was measured); held without it.
    time : (float, float), optional
        The part to use, s; either end may be None.
    flight : int, optional
        Which flight of a log that holds several, counted from 1.
    vehicle_file : bool
        Whether ``pitchid.toml`` of the working directory or a folder above counts, as it does for the command.

    Returns
    -------
    Recording

    Raises
    ------
    PitchidError
        A file that cannot be used: which line and column, and what to do.
    """
    words = _words.reading(
        axis=axis,
        columns=columns,
        sections=sections,
        splits=splits,
        input=input,
        time=time,
        flight=flight,
        vehicle_file=vehicle_file,
    )
    (native,) = _native.read(words + _words.files([os.fspath(path)]))
    return Recording(native)
