"""A row of the table: what is kept of one recording."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable
from typing import Any

import pyarrow as pa

from .. import __version__
from .._errors import PitchidError
from ..answers import Diagnosis, Estimate
from ..questions import diagnose
from ..recording import Recording, read

PARAMETER = pa.struct(
    [
        ("name", pa.string()),
        ("of", pa.string()),
        ("unit", pa.string()),
        ("value", pa.float64()),
        ("low", pa.float64()),
        ("high", pa.float64()),
    ]
)
EFFECT = pa.struct(
    [
        ("id", pa.string()),
        ("locus", pa.string()),
        ("probability", pa.float64()),
        ("share", pa.float64()),
        ("alternatives", pa.list_(pa.string())),
    ]
)

SCHEMA = pa.schema(
    [  # type: ignore[arg-type]
        ("path", pa.string()),
        ("sha256", pa.string()),
        ("bytes", pa.int64()),
        ("arguments", pa.string()),
        ("version", pa.string()),
        ("status", pa.string()),
        ("error", pa.string()),
        ("remedy", pa.string()),
        ("line", pa.int64()),
        ("column", pa.string()),
        ("took_s", pa.float64()),
        ("axis", pa.string()),
        ("length_s", pa.float64()),
        ("samples", pa.int64()),
        ("step_s", pa.float64()),
        ("verdict", pa.string()),
        ("summary", pa.string()),
        ("effects", pa.list_(EFFECT)),
        ("remainder_share", pa.float64()),
        ("parameters", pa.list_(PARAMETER)),
        ("vaf_before_percent", pa.float64()),
        ("vaf_after_percent", pa.float64()),
        ("checks_found", pa.list_(pa.string())),
        ("notes", pa.list_(pa.string())),
        ("answer", pa.string()),
    ]
)
"""Columns of the table.

``status`` is ``answered`` or ``failed``; ``arguments`` are the options of the diagnosis with the hashes of the files that they
name; ``vaf_before_percent`` and ``vaf_after_percent`` are of predictions 1 s ahead on held-out sections, in the mean;
``parameters`` are those of the model with what was missing, each effect's after those of the plant, and ``trim``, the command
that holds the craft; ``answer`` is the JSON of the whole answer.
"""


def digest(path: str) -> str:
    """SHA-256 of a file."""
    found = hashlib.sha256()
    with open(path, "rb") as file:
        while piece := file.read(1 << 20):
            found.update(piece)
    return found.hexdigest()


def failed(path: str, arguments: str, error: str, remedy: str, **more: Any) -> dict[str, Any]:
    """The row of a recording without an answer."""
    row = dict.fromkeys(SCHEMA.names)
    row |= {"path": path, "arguments": arguments, "version": __version__, "status": "failed"}
    return row | {"error": error, "remedy": remedy} | more


def of_file(path: str, arguments: str, known: str | None, hashed_as: Callable[[str], None]) -> dict[str, Any] | None:
    """Diagnoses a file: its row, or None where it still is the one whose hash is ``known``; tells the hash beforehand."""
    begun = time.perf_counter()
    try:
        size, hashed = os.path.getsize(path), digest(path)
    except OSError as error:
        return failed(path, arguments, f"{path}: {error.strerror}", "check the path, and who may read it")
    hashed_as(hashed)
    if hashed == known:
        return None
    options = json.loads(arguments)["options"]
    of_input = {"sha256": hashed, "bytes": size}
    try:
        model = options.pop("model", None)
        recording = read(path, vehicle_file=False, **options)
        found: Diagnosis = diagnose(recording, model=model)  # type: ignore[assignment]
    except PitchidError as error:
        where = {"line": error.line, "column": error.column, "took_s": time.perf_counter() - begun}
        return failed(path, arguments, error.message, error.remedy, **of_input, **where)
    row = of_answer(found, recording)
    row |= {"path": path, "arguments": arguments, "took_s": time.perf_counter() - begun}
    return row | of_input


def of_answer(found: Diagnosis, recording: Recording) -> dict[str, Any]:
    """What is kept of an answer."""
    effects = [
        {
            "id": effect.id,
            "locus": effect.locus,
            "probability": effect.probability,
            "share": effect.share,
            "alternatives": [other.id for other in effect.alternatives],
        }
        for effect in found.effects
    ]
    row = dict.fromkeys(SCHEMA.names)
    return row | {
        "version": __version__,
        "status": "answered",
        "axis": recording.axis,
        "length_s": len(recording) * recording.step,
        "samples": len(recording),
        "step_s": recording.step,
        "verdict": found.verdict,
        "summary": found.summary,
        "effects": effects,
        "remainder_share": found.remainder["share"] if found.remainder else None,
        "parameters": _parameters(found),
        "vaf_before_percent": _ahead(found, "baseline"),
        "vaf_after_percent": _ahead(found, "extended"),
        "checks_found": [check.cause for check in found.data_checks if check.state == "found"],
        "notes": found.notes,
        "answer": found.to_json().decode(),
    }


def _parameters(found: Diagnosis) -> list[dict[str, Any]]:
    of_effects = [(effect.id, one) for effect in found.effects for one in effect.parameters]
    kept = [("", one) for one in found.parameters.values() if all(one != other for _, other in of_effects)]
    kept += of_effects
    if found.balance:
        command = found.balance["command"]
        kept.append(("", Estimate("trim", command["unit"], command["value"], tuple(command["ci95"]))))
    return [
        {"name": one.name, "of": of, "unit": one.unit, "value": one.value, "low": one.ci95[0], "high": one.ci95[1]}
        for of, one in kept
    ]


def _ahead(found: Diagnosis, model: str) -> float | None:
    """Mean VAF of predictions 1 s ahead over the held-out sections."""
    figures = [section[model].get("1.0") for section in found.fit.held_out.values()]
    values = [figure["value"] for figure in figures if figure and figure["value"] is not None]
    return sum(values) / len(values) if values else None


def answer(row: dict[str, Any]) -> Diagnosis:
    """The whole answer of a row.

    Parameters
    ----------
    row : dict
        A row of the table, with status ``answered``.

    Returns
    -------
    Diagnosis
    """
    return Diagnosis.from_json(row["answer"])
