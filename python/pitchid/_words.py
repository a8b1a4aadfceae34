"""Options of a function as the words of the command's line."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, Union

Path = Union[str, "os.PathLike[str]"]
Span = tuple[Union[float, None], Union[float, None]]


def span(of: Span) -> str:
    """Writes a part of a recording, FROM..TO in seconds; either end may be None."""
    begin, end = of
    return f"{'' if begin is None else repr(float(begin))}..{'' if end is None else repr(float(end))}"


def paths(of: Any) -> list[str]:
    """One path or several, as texts."""
    return [os.fspath(of)] if isinstance(of, (str, os.PathLike)) else [os.fspath(path) for path in of]


def sections(of: Mapping[str, Span] | None) -> list[str]:
    """Sections by time: NAME=FROM..TO."""
    return [f"{name}={span(part)}" for name, part in (of or {}).items()]


def reading(
    *,
    model: Path | None = None,
    axis: str | None = None,
    columns: Mapping[str, str] | None = None,
    sections: Mapping[str, Span] | None = None,
    splits: Iterable[float] = (),
    input: str | None = None,
    time: Span | None = None,
    flight: int | None = None,
    vehicle_file: bool = True,
) -> list[str]:
    """The options of how recordings are read."""
    words = option("--model", None if model is None else os.fspath(model))
    words += option("--axis", axis)
    words += [f"--column={name}={of}" for name, of in (columns or {}).items()]
    words += [f"--section={name}={span(part)}" for name, part in (sections or {}).items()]
    words += [f"--split={float(at)!r}" for at in splits]
    words += option("--input", input)
    words += option("--time", None if time is None else span(time))
    words += option("--flight", flight)
    return words + ([] if vehicle_file else ["--no-vehicle-file"])


def option(name: str, value: object) -> list[str]:
    """One option; nothing where it has no value."""
    return [] if value is None else [f"{name}={value}"]


def files(of: Iterable[str]) -> list[str]:
    """File names at the end of a line, whatever they begin with."""
    return ["--", *of]
