"""A run over many recordings: what is to be done, given to the workers a little at a time, kept as it comes back."""

from __future__ import annotations

import glob
import json
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import distributed
import pyarrow as pa

from .. import __version__
from .._errors import PitchidError
from . import limited
from .rows import digest, failed
from .table import Table

IN_FLIGHT = 3
"""Files that are given to each thread of the workers at a time: one that it does, and what it goes on with."""
AGAIN = 5
"""How often a file is given out again whose workers were lost."""
LOST_S = 30.0
"""How long the scheduler may be silent, s."""


class Run:
    """A run over a fleet: iterate over its rows as they come, or ask for the table.

    Attributes
    ----------
    total, done, failed : int
        Recordings; how many have a row by now, and how many of these have an error for an answer.
    """

    def __init__(self, paths: list[str], table: Table, arguments: str, engine: dict[str, Any]) -> None:
        self.total, self.done, self.failed = len(paths), 0, 0
        self._table, self._engine = table, engine
        self._work = self._rows(paths, arguments)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """The rows that are new, as they come."""
        return self._work

    def table(self) -> pa.Table:
        """Does what is left, and reads the table.

        Returns
        -------
        pyarrow.Table
            One row a recording, by path.
        """
        for _ in self._work:
            pass
        from .table import read_table

        return read_table(self._table.path)

    def _rows(self, paths: list[str], arguments: str) -> Iterator[dict[str, Any]]:
        table = self._table
        retry = self._engine["retry"]

        def known(path: str) -> str | None:
            row = table.rows.get(path)
            if row is None or (retry and row["status"] == "failed"):
                return None
            same = row["arguments"] == arguments and row["version"] == __version__
            return row["sha256"] if same else None

        jobs = ((path, arguments, known(path), self._engine["limit_s"]) for path in paths)
        try:
            with _client(self._engine["client"], self._engine["workers"]) as client:
                for path, row in spread(client, limited.diagnose, jobs, key=_key):
                    self.done += 1
                    row = _broken(path, arguments, row) if isinstance(row, BaseException) else row
                    if row is None:
                        self.failed += table.rows[path]["status"] == "failed"
                        continue
                    self.failed += row["status"] == "failed"
                    table.add(row)
                    yield row
            table.whole()
        finally:
            table.close()


def _key(job: tuple[Any, ...]) -> Any:
    return job[0]


def _broken(path: str, arguments: str, error: BaseException) -> dict[str, Any]:
    told = f"{path}: no worker lived through it: {error}"
    return failed(path, arguments, told, "look at it alone; a file that needs all memory ends like this")


@contextmanager
def _client(client: distributed.Client | str | None, workers: int | None) -> Iterator[distributed.Client]:
    """The client that is given, one of the scheduler at this address, or one of processes on this machine."""
    if isinstance(client, distributed.Client):
        yield client
    elif client:
        try:
            own = distributed.Client(client, timeout="20s", set_as_default=False)
        except (OSError, ValueError, distributed.TimeoutError) as error:
            told = f"no scheduler answers at {client}: {error}"
            raise PitchidError(told, "start one with dask scheduler, and name its address, tcp://HOST:PORT") from None
        with own:
            yield own
    else:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        settings = {"n_workers": workers or cores, "threads_per_worker": 1, "dashboard_address": None}
        with (
            distributed.LocalCluster(**settings) as cluster,
            distributed.Client(cluster, set_as_default=False) as own,
        ):
            yield own


def spread(client, work, jobs: Iterable[tuple[Any, ...]], key) -> Iterator[tuple[Any, Any]]:
    """Does ``work`` for each of ``jobs`` on the workers, never more at a time than they have use for.

    Parameters
    ----------
    client : distributed.Client
        Whose workers.
    work : callable
        A function that workers can import.
    jobs : iterable of tuple
        Its arguments.
    key : callable
        What a job is called in the answer.

    Yields
    ------
    (key, result)
        In the order in which they are done; the exception where workers were lost over it again and again.

    Raises
    ------
    PitchidError
        The scheduler was lost.
    """
    jobs = iter(jobs)
    # each with how often it was given out again
    flying: dict[distributed.Future, tuple[tuple[Any, ...], int]] = {}

    def give(job: tuple[Any, ...], again: int) -> None:
        flying[client.submit(work, *job, pure=False)] = (job, again)

    heard = time.monotonic()
    while True:
        threads = _threads(client)
        while len(flying) < IN_FLIGHT * threads and client.status == "running":
            job = next(jobs, None)
            if job is None:
                break
            give(job, 0)
        if not flying:
            return
        try:
            with client.as_current():
                ended = distributed.wait(list(flying), timeout=1, return_when="FIRST_COMPLETED").done
        except (distributed.CancelledError, distributed.TimeoutError):
            ended = set()
        if client.status == "running":
            heard = time.monotonic()
        elif time.monotonic() - heard > LOST_S or client.status == "closed":
            told = f"the scheduler was lost with {len(flying)} files under way"
            raise PitchidError(told, "what is done is in the table; run it again to go on")
        for future in ended:
            job, again = flying.pop(future)
            lost, result = _result(future)
            future.release()
            if lost and client.status != "running":
                flying[future] = (job, again)
            elif (lost or isinstance(result, distributed.KilledWorker)) and again < AGAIN:
                give(job, again + 1)
            else:
                yield key(job), result


def _threads(client: distributed.Client) -> int:
    """How many the workers have; 1 where the scheduler does not answer."""
    try:
        return max(1, sum(client.nthreads().values())) if client.status == "running" else 1
    except (OSError, distributed.TimeoutError):
        # it was lost, and the client does not know yet
        return 1


def _result(future: distributed.Future) -> tuple[bool, Any]:
    """Whether a future was lost on its way, and its result or exception."""
    if future.status in ("cancelled", "lost"):
        return True, None
    try:
        return False, future.result(timeout=LOST_S) if future.status == "finished" else future.exception()
    except (distributed.CancelledError, distributed.TimeoutError, OSError):
        return True, None


def paths_of(of: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> list[str]:
    """The files that paths and patterns (``**`` for any folders) name, each once, with their whole paths."""
    all_ = [of] if isinstance(of, (str, os.PathLike)) else list(of)
    found: dict[str, None] = {}
    for one in [os.fspath(path) for path in all_]:
        matched = sorted(glob.glob(one, recursive=True)) if glob.has_magic(one) and not os.path.exists(one) else [one]
        found |= {os.path.abspath(path): None for path in matched if not os.path.isdir(path)}
    return list(found)


def _arguments(options: dict[str, Any]) -> str:
    """The options of a diagnosis as text, with the hash of the model's file."""
    options = {name: value for name, value in options.items() if value is not None}
    named: dict[str, Any] = {"options": options}
    if "model" in options:
        options["model"] = os.path.abspath(options["model"])
        named["model_sha256"] = digest(options["model"])
    return json.dumps(named, sort_keys=True)


def diagnose(
    paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    client: distributed.Client | str | None = None,
    *,
    out: str | os.PathLike[str],
    model: str | os.PathLike[str] | None = None,
    limit_s: float = 600.0,
    workers: int | None = None,
    retry: bool = False,
    **reading: Any,
) -> Run:
    """Diagnoses many recordings, one row of a table each.

    What is in the table with the same hash of the file, the same arguments and the same version is not run again: a run that was
    broken off, by whatever, goes on where it was. A file that cannot be used, takes too long, or breaks the process down that
    looks at it, is a row with its error.

    Parameters
    ----------
    paths : path, pattern, or several of either
        Files that workers see under the same path; ``**`` stands for any folders.
    client : distributed.Client or str, optional
        A client of Dask, or the address of its scheduler; processes on this machine without it.
    out : path
        The table (Parquet), new or to go on with. While a run is under way its rows are in a folder beside it, with ``.parts``
        behind the name; :func:`read_table` reads both.
    model : path, optional
        The simulation in use today, for all of them.
    limit_s : float
        Longest time for a file, s.
    workers : int, optional
        Processes on this machine, where there is no ``client``; one for each core without it.
    retry : bool
        Whether files that failed before are run again.
    **reading
        How files are read: options of :func:`pitchid.read` but ``vehicle_file``, as workers have folders of their own.

    Returns
    -------
    Run
        To iterate over, or ask for its table; nothing is done before.

    Raises
    ------
    PitchidError
        No files, another run on the same table; while it runs, a scheduler that was lost.
    """
    found = paths_of(paths)
    if not found:
        raise PitchidError("no files of these names", "check the pattern; ** stands for any folders")
    engine = {"client": client, "workers": workers, "limit_s": limit_s, "retry": retry}
    arguments = _arguments({"model": None if model is None else os.fspath(model), **reading})
    return Run(found, Table(out), arguments, engine)
