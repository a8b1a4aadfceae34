"""The page of a fleet: which craft differ from their siblings, and how."""

from __future__ import annotations

import os
from collections import Counter
from importlib import resources
from typing import Any

import jinja2
import numpy as np
import pyarrow as pa

from .. import __version__, _native
from .siblings import LEAST_CRAFT, LEAST_FLIGHTS, LEVEL, Parameter, Type, siblings
from .table import _write_text, read_table

MOST_DRIFTS = 12
"""Drifts that are told, the strongest."""


def number(value: float) -> str:
    """Three significant digits."""
    if value == 0 or not np.isfinite(value):
        return "0" if value == 0 else "–"
    magnitude = int(np.floor(np.log10(abs(value))))
    small = -4 <= magnitude < 5
    text = f"{value:.{max(0, 2 - magnitude)}f}" if small else f"{value / 10.0**magnitude:.2f}e{magnitude}"
    return text.replace("-", "−")


def odds(p: float) -> str:
    """A chance as people say it."""
    if p >= 0.5:
        return "is what chance gives"
    if p < 1e-9:
        return "comes by chance in fewer than one fleet of 1,000,000,000"
    return f"comes by chance in one fleet of {float(f'{1 / p:.2g}'):,.0f}"


def unit(of: str) -> str:
    """A unit behind a number; nothing for a pure number."""
    return "" if of == "1" else of


def _chart(parameter: Parameter) -> dict[str, str]:
    """Each craft with its interval, those that stand out by themselves."""
    craft = sorted(parameter.craft, key=lambda one: one.value)
    points = [(float(k), one.value, 1.96 * one.error, one.outlier) for k, one in enumerate(craft, 1)]
    low, high = (parameter.median + sign * 1.96 * parameter.spread for sign in (-1, 1))
    ends = (0.5, len(craft) + 0.5)
    series = [
        ("siblings, 95 %", "measured", "band", [(x, low, high) for x in ends]),
        ("stand out", "before", "dots", [point[:3] for point in points if point[3]]),
        ("craft", "ink", "dots", [point[:3] for point in points if not point[3]]),
    ]
    title = f"{parameter.name}, {parameter.unit}" if unit(parameter.unit) else parameter.name
    names = ", ".join(f"{k} {one.name}" for k, one in enumerate(craft, 1)) if len(craft) <= 24 else "craft, by size"
    drawn = [one for one in series if one[3]]
    svg = _native.chart(f"{parameter.name} of each craft", names, title, 150, drawn)
    return {"svg": svg, "told": f"{parameter.name} of each craft with its 95 % interval, in the order of size."}


def _told(type_: Type) -> dict[str, Any]:
    """What the page says of a type."""
    found = [(craft, parameter) for parameter in type_.parameters for craft in parameter.craft if craft.outlier]
    found.sort(key=lambda one: one[0].p)
    outliers = [{"craft": craft, "parameter": parameter} for craft, parameter in found]
    verdicts = ", ".join(f"{count} {verdict.replace('_', ' ')}" for verdict, count in sorted(type_.verdicts.items()))
    drawn = [one for one in type_.parameters if len(one.craft) >= LEAST_CRAFT]
    drawn.sort(key=lambda one: min(craft.p for craft in one.craft))
    return {
        "name": type_.name,
        "craft": type_.craft,
        "told": f"verdicts: {verdicts}",
        "parameters": type_.parameters,
        "outliers": outliers,
        "charts": [_chart(one) for one in drawn[:8]],
        "drifts": sorted(type_.drifts, key=lambda one: one.p)[:MOST_DRIFTS],
        "per": type_.per,
    }


def report(
    table: pa.Table | str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    craft: str | None = None,
) -> str:
    """Writes which craft differ from their siblings, and how, as a page that needs nothing else.

    Parameters
    ----------
    table : pyarrow.Table or path
        The table of :func:`pitchid.fleet.diagnose`.
    out : path, optional
        Where the page goes.
    craft : str, optional
        A regular expression with the groups ``craft`` and perhaps ``type`` and ``when`` (a date), searched in each path:
        ``r"(?P<type>\\w+)-(?P<craft>\\d+)/"``. Without it the folder of a file is the craft, and the folder above the type.

    Returns
    -------
    str
        The page.
    """
    source = "a table" if isinstance(table, pa.Table) else os.fspath(table)
    table = table if isinstance(table, pa.Table) else read_table(table)
    types = [_told(one) for one in siblings(table, craft)]
    rows = table.select(["path", "sha256", "status", "error", "remedy"]).to_pylist()
    hashes = Counter(row["sha256"] for row in rows if row["status"] == "answered")
    outliers = [one for type_ in types for one in type_["outliers"]]
    names = list(dict.fromkeys(one["craft"].name for one in outliers))
    headline = "No craft differs from its siblings"
    if names:
        listed = " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
        headline = f"{listed} {'differs from its' if len(names) == 1 else 'differ from their'} siblings"
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    environment.filters |= {"number": number, "odds": odds, "unit": unit}
    template = environment.from_string(resources.files(__package__).joinpath("page.html").read_text(encoding="utf-8"))
    body = template.render(
        headline=headline,
        rows=rows,
        failures=[row for row in rows if row["status"] == "failed"],
        copies=sum(hashes.values()) - len(hashes),
        craft=sum(len(type_["craft"]) for type_ in types),
        types=types,
        outliers=outliers,
        least=LEAST_CRAFT,
        least_flights=LEAST_FLIGHTS,
        level=LEVEL,
        source=source,
        version=__version__,
    )
    page = _native.page(headline, body)
    if out is not None:
        _write_text(page, out)
    return page
