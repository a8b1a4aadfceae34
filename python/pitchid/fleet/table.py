"""The table of a fleet: parts that are written while it grows, and the whole.

What a run has done lies in parts beside the table, each written whole or not at all; the next run, or the end of this one, puts
them into the table. A later row of a path stands for an earlier one.
"""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

import filelock
import pyarrow as pa
import pyarrow.parquet as pq

from .._errors import PitchidError
from .rows import SCHEMA

PART_ROWS = 200
"""Rows of a part."""
PART_S = 5.0
"""How long a row waits for its part, s."""


def _whole(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Writes a file whole or not at all."""
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with open(beside, "wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)


def _write(table: pa.Table, path: Path) -> None:
    _whole(path, lambda file: pq.write_table(table, file, compression="zstd"))


def _write_text(text: str, path: str | os.PathLike[str]) -> None:
    _whole(Path(path), lambda file: file.write(text.encode()))


def _of(rows: list[dict[str, Any]]) -> pa.Table:
    return pa.Table.from_pylist(rows, schema=SCHEMA)


class Table:
    """A table that one run writes."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.parts = self.path.with_name(self.path.name + ".parts")
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._lock = filelock.FileLock(self.path.with_name(f".{self.path.name}.lock"))
        try:
            self._lock.acquire(timeout=0)
        except filelock.Timeout:
            told = f"{self.path}: another run writes this table"
            raise PitchidError(told, "wait for it, or name another table", str(self.path)) from None
        self._waiting: list[dict[str, Any]] = []
        self._written = time.monotonic()
        # what an earlier run left behind
        self.rows = {row["path"]: row for row in read_table(self.path).to_pylist()}
        numbers = [int(part.stem) for part in _parts(self.parts)]
        self._number = max(numbers, default=0)

    def add(self, row: dict[str, Any]) -> None:
        """Adds a row; it is safe on disk after at most :data:`PART_S` and a few rows more."""
        self.rows[row["path"]] = row
        self._waiting.append(row)
        if len(self._waiting) >= PART_ROWS or time.monotonic() - self._written > PART_S:
            self.keep()

    def keep(self) -> None:
        """Writes what waits as a part."""
        if self._waiting:
            self.parts.mkdir(exist_ok=True)
            self._number += 1
            _write(_of(self._waiting), self.parts / f"{self._number:08}.parquet")
            self._waiting = []
        self._written = time.monotonic()

    def whole(self) -> None:
        """Writes the table with all rows, by path, and does away with the parts."""
        self.keep()
        _write(_of([self.rows[path] for path in sorted(self.rows)]), self.path)
        shutil.rmtree(self.parts, ignore_errors=True)

    def close(self) -> None:
        """Keeps what waits, and lets others write."""
        self.keep()
        self._lock.release()


def _parts(folder: Path) -> list[Path]:
    return sorted(folder.glob("[0-9]*.parquet"))


def read_table(path: str | os.PathLike[str]) -> pa.Table:
    """Reads a table, with the parts of a run that has not come to its end.

    Parameters
    ----------
    path : path
        The table, as ``out`` named it.

    Returns
    -------
    pyarrow.Table
        One row a recording, by path; empty where there is none yet.
    """
    path = Path(path)
    files = ([path] if path.exists() else []) + _parts(path.with_name(path.name + ".parts"))
    rows: dict[str, dict[str, Any]] = {}
    for file in files:
        rows |= {row["path"]: row for row in pq.read_table(file, schema=SCHEMA).to_pylist()}
    return _of([rows[key] for key in sorted(rows)])
