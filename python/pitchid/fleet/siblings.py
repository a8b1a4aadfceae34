"""Which craft differ from their siblings.

Flights i of craft c estimate a parameter with known errors, ``y_ci = m + b_c + w_ci + e_ci``: what differs from craft to craft
(b, variance tau2), from flight to flight of one craft (w, variance omega2), and the error of the estimate (e, from its
interval). Variances come from moments (DerSimonian and Laird 1986), omega2 over all craft of a type together. A craft is held
against its siblings without it: the distance of its mean over the error of a prediction of one more craft, by Student's t. The
most deviant are set aside one after another, and outliers are all up to the last that is beyond chance (Rosner's generalised
extreme Studentized deviate, 1983), so that two of them do not hide one another. p-values are multiplied by the number of craft
and of parameters.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import numpy as np
import pyarrow as pa
from scipy import stats

LEVEL = 0.05
"""A craft is told where so large a difference among as many alike is rarer than this."""
LEAST_CRAFT = 4
"""Craft below which nobody can be told from the others."""
LEAST_FLIGHTS = 4
"""Flights below which no drift can be told."""
MOST_OUTLIERS = 1 / 3
"""Share of the craft that may be outliers."""
NORMAL_95 = 1.959964
DRIFTING = ("trim", "dM_du", "Mc", "delay")
"""Parameters whose drift is asked: trim, effectiveness, friction, delay."""

FOLDERS = r"(?:(?P<type>[^/\\]+)[/\\])?(?P<craft>[^/\\]+)[/\\][^/\\]+$"
"""Where a path names the craft if nothing else is said: TYPE/CRAFT/FLIGHT."""
DATE = re.compile(r"(?<!\d)(20\d\d)[-_]?([01]\d)[-_]?([0-3]\d)(?:[T_-]?([0-2]\d)[-_:]?([0-5]\d)[-_:]?([0-5]\d)?)?")


@dataclass
class Flight:
    """One estimate of a parameter."""

    path: str
    craft: str
    when: float
    value: float
    error: float


@dataclass
class Craft:
    """A craft among its siblings."""

    name: str
    flights: int
    value: float
    error: float
    away: float
    """Difference from the siblings' mean, in errors of the prediction."""
    p: float
    """Of so large a difference by chance, for the number of craft and parameters."""
    outlier: bool = False


@dataclass
class Drift:
    """How a parameter of a craft moves from flight to flight, or a day."""

    craft: str
    parameter: str
    unit: str
    per: str
    slope: float
    low: float
    high: float
    p: float
    flights: list[Flight] = field(repr=False)


@dataclass
class Parameter:
    """A parameter over the craft of a type."""

    name: str
    of: str
    unit: str
    median: float
    spread: float
    """Standard deviation from craft to craft, beyond the errors."""
    within: float
    """Standard deviation from flight to flight of one craft, beyond the errors."""
    craft: list[Craft]
    flights: list[Flight] = field(repr=False)


@dataclass
class Type:
    """The craft of a type."""

    name: str
    craft: list[str]
    verdicts: dict[str, int]
    parameters: list[Parameter]
    drifts: list[Drift]
    per: str


def _named(path: str, craft: str | None) -> tuple[str, str, str | None]:
    """Type, craft, and what the path says of the time."""
    found = re.search(craft or FOLDERS, path)
    groups = found.groupdict() if found else {}
    return groups.get("type") or "-", groups.get("craft") or "-", groups.get("when")


def _moment(of: list[int]) -> datetime:
    year, month, day, hour, minute, second = of
    return datetime(year, month, day, hour, minute, second)


def _time(path: str, when: str | None) -> datetime | None:
    text = when if when is not None else path.replace("\\", "/").rsplit("/", 1)[-1]
    found = DATE.search(text)
    try:
        return _moment([int(part) for part in found.groups(default="0")]) if found else None
    except ValueError:
        return None


def estimates(table: pa.Table, craft: str | None = None) -> list[dict[str, Any]]:
    """The parameters of all recordings, one row an estimate.

    Parameters
    ----------
    table : pyarrow.Table
        As :func:`pitchid.fleet.read_table` reads it.
    craft : str, optional
        A regular expression with the groups ``craft`` and perhaps ``type`` and ``when``, searched in the path; without it
        the folder of a file is the craft and the folder above the type.

    Returns
    -------
    list of dict
        ``type``, ``craft``, ``when``, ``path``, ``name``, ``of``, ``unit``, ``value``, ``low``, ``high``; a recording
        that is there twice (same hash) counts once.
    """
    rows, seen = [], set()
    for row in table.select(["path", "sha256", "status", "parameters"]).to_pylist():
        if row["status"] != "answered" or row["sha256"] in seen:
            continue
        seen.add(row["sha256"])
        kind, name, when = _named(row["path"], craft)
        of = {"type": kind, "craft": name, "when": _time(row["path"], when), "path": row["path"]}
        rows += [of | parameter for parameter in row["parameters"]]
    return rows


def _scatter(values: np.ndarray, errors: np.ndarray, times: np.ndarray | None = None) -> tuple[float, float]:
    """Scatter about the mean, or about a line over ``times``, beyond the errors; and what a variance of one would add to it."""
    w = 1 / errors**2
    x = np.ones((1, len(values)))
    if times is not None and len(times) >= LEAST_FLIGHTS and np.ptp(times) > 0:
        x = np.stack([x[0], times - times.mean()])
    inverse = np.linalg.inv(x * w @ x.T)
    rest = values - inverse @ (x @ (w * values)) @ x
    return float(np.sum(w * rest**2) - (len(values) - len(x))), float(np.sum(w) - np.trace(inverse @ (x * w**2 @ x.T)))


def _variance(scatters: list[tuple[float, float]]) -> float:
    """Variance beyond the errors (DerSimonian and Laird, groups pooled)."""
    excess, scale = (sum(part) for part in zip(*scatters, strict=True))
    return max(0.0, excess / scale) if scale > 0 else 0.0


def _against(values: np.ndarray, errors: np.ndarray, k: int) -> tuple[float, float]:
    """Distance of craft ``k`` from the others over the error of a prediction, and its p-value."""
    others = np.delete(np.arange(len(values)), k)
    y, s = values[others], errors[others]
    tau2 = _variance([_scatter(y, s)])
    w = 1 / (s**2 + tau2)
    mean = np.sum(w * y) / np.sum(w)
    away = (values[k] - mean) / np.sqrt(errors[k] ** 2 + tau2 + 1 / np.sum(w))
    return float(away), float(2 * stats.t.sf(abs(away), len(y) - 1))


def _craft(flights: list[Flight], tests: int) -> tuple[list[Craft], float]:
    """The craft of a parameter, each against its siblings, and the variance from flight to flight."""
    values = np.array([flight.value for flight in flights])
    errors = np.array([flight.error for flight in flights])
    owners = np.array([flight.craft for flight in flights])
    times = np.array([flight.when for flight in flights])
    # a craft that drifts says nothing of the scatter of the others
    of = [owners == name for name in np.unique(owners)]
    omega2 = _variance([_scatter(values[own], errors[own], times[own]) for own in of])
    weights = 1 / (errors**2 + omega2)
    found = []
    for name in dict.fromkeys(owners.tolist()):
        w, y = weights[owners == name], values[owners == name]
        found.append(Craft(name, len(y), float(np.sum(w * y) / np.sum(w)), float(np.sum(w) ** -0.5), 0.0, 1.0))
    if len(found) < LEAST_CRAFT:
        return found, omega2
    left, last = list(found), 0
    aside: list[Craft] = []
    # Rosner's approximation is a little free with fewer than 25: each step counts as a further test
    steps = max(1, int(MOST_OUTLIERS * len(found)))
    while len(aside) < steps and len(left) >= LEAST_CRAFT:
        means, errors_ = np.array([c.value for c in left]), np.array([c.error for c in left])
        judged = [_against(means, errors_, k) for k in range(len(left))]
        k = min(range(len(left)), key=lambda k: judged[k][1])
        left[k].away, left[k].p = judged[k][0], min(1.0, judged[k][1] * len(left) * tests * steps)
        aside.append(left.pop(k))
        last = len(aside) if aside[-1].p < LEVEL else last
    for craft in aside[:last]:
        craft.outlier = True
    # all others, and all that were set aside in vain, against those that stay
    stay = [craft for craft in found if not craft.outlier]
    for craft in found:
        among = stay if not craft.outlier else [*stay, craft]
        means, errors_ = np.array([c.value for c in among]), np.array([c.error for c in among])
        craft.away, p = _against(means, errors_, next(k for k, c in enumerate(among) if c is craft))
        craft.p = min(1.0, p * len(found) * tests)
    return found, omega2


def _drift(flights: list[Flight], parameter: Parameter, per: str, tests: int) -> Drift | None:
    """The slope of a craft's estimates over time; errors beyond those of the estimates are seen in the scatter."""
    if len(flights) < LEAST_FLIGHTS:
        return None
    x = np.array([flight.when for flight in flights])
    y = np.array([flight.value for flight in flights])
    w = 1 / (np.array([flight.error for flight in flights]) ** 2 + parameter.within**2)
    x = x - np.sum(w * x) / np.sum(w)
    sxx = np.sum(w * x**2)
    if sxx <= 0:
        return None
    slope = float(np.sum(w * x * y) / sxx)
    rest = y - np.sum(w * y) / np.sum(w) - slope * x
    freedom = len(x) - 2
    error = float(np.sqrt(max(1.0, np.sum(w * rest**2) / freedom) / sxx))
    p = float(2 * stats.t.sf(abs(slope) / error, freedom))
    reach = float(stats.t.isf(0.025, freedom)) * error
    name = flights[0].craft
    return Drift(name, parameter.name, parameter.unit, per, slope, slope - reach, slope + reach, min(1.0, p * tests), flights)


def siblings(table: pa.Table, craft: str | None = None) -> list[Type]:
    """The craft of each type, parameter by parameter, and which of them differ from their siblings.

    Parameters
    ----------
    table : pyarrow.Table
        As :func:`pitchid.fleet.read_table` reads it.
    craft : str, optional
        As :func:`estimates` takes it.

    Returns
    -------
    list of Type
    """
    rows = estimates(table, craft)
    verdicts: dict[str, dict[str, int]] = {}
    owners: dict[str, dict[str, None]] = {}
    seen = set()
    for row in table.select(["path", "sha256", "verdict", "status"]).to_pylist():
        if row["status"] == "answered" and row["sha256"] not in seen:
            seen.add(row["sha256"])
            kind, name, _ = _named(row["path"], craft)
            counts = verdicts.setdefault(kind, {})
            counts[row["verdict"]] = counts.get(row["verdict"], 0) + 1
            owners.setdefault(kind, {})[name] = None
    return [_type(kind, list(owners[kind]), verdicts[kind], [r for r in rows if r["type"] == kind]) for kind in sorted(verdicts)]


def _type(kind: str, names: list[str], verdicts: dict[str, int], rows: list[dict[str, Any]]) -> Type:
    dated = all(row["when"] is not None for row in rows)
    per = "day" if dated else "flight"
    order: dict[str, float] = {}
    for name in names:
        paths = sorted({row["path"] for row in rows if row["craft"] == name})
        order |= {path: float(k) for k, path in enumerate(paths)}
    grouped: dict[tuple[str, str, str], list[Flight]] = {}
    for row in rows:
        low, high = row["low"], row["high"]
        if row["value"] is None or low is None or high is None or not high > low:
            continue
        when = row["when"].timestamp() / 86400 if dated else order[row["path"]]
        error = (high - low) / 2 / NORMAL_95
        key = (row["name"], row["of"], row["unit"])
        grouped.setdefault(key, []).append(Flight(row["path"], row["craft"], when, row["value"], error))
    kept = {key: flights for key, flights in grouped.items() if len({f.craft for f in flights}) >= 2}
    parameters = []
    for (name, of, unit), flights in sorted(kept.items(), key=lambda item: (item[0][1], item[0][0])):
        craft, omega2 = _craft(flights, len(kept))
        means, errors = np.array([c.value for c in craft]), np.array([c.error for c in craft])
        alike = ~np.array([c.outlier for c in craft])
        tau2 = _variance([_scatter(means[alike], errors[alike])])
        median = float(np.median(means))
        parameters.append(Parameter(name, of, unit, median, float(np.sqrt(tau2)), float(np.sqrt(omega2)), craft, flights))
    asked = [one for one in parameters if one.name in DRIFTING]
    tests = max(1, len(names) * len(asked))
    drifts = [
        _drift(sorted((f for f in one.flights if f.craft == name), key=lambda f: f.when), one, per, tests)
        for one in asked
        for name in names
    ]
    return Type(kind, names, verdicts, parameters, [drift for drift in drifts if drift], per)
