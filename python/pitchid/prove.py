"""``python -m pitchid.prove --cases 10000 --scheduler tcp://HOST:PORT``: the proof of ``pitchid prove``, on Dask.

Cases are independent. The folder and what is printed are those of the command, byte for byte, whatever the number of workers:
all truths are sealed, and their hashes printed, before the first diagnosis; what the folder holds already is not done again.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterable
from typing import Any

import distributed

from . import _native
from ._errors import PitchidError
from .fleet.progress import Progress
from .fleet.run import _client, spread


def _conceal(case: int, seed: int, air: str) -> tuple[str, str, str]:
    return _native.conceal(seed, air, case)


def _answer(case: int, question: list[str]) -> list[str]:
    return _native.answer(*question)


def _done(
    client: distributed.Client,
    work: Callable[..., Any],
    jobs: Iterable[tuple[Any, ...]],
    keep: Callable[[int, Any], None],
    progress: Progress,
) -> None:
    for case, result in spread(client, work, jobs, key=lambda job: job[0]):
        if isinstance(result, BaseException):
            raise result
        keep(case, result)
        progress.one()


def prove(
    cases: int = 24,
    *,
    seed: int = 1,
    out: str | os.PathLike[str] = "pitchid-proof",
    air: str = "band_passed",
    resume: bool = False,
    client: distributed.Client | str | None = None,
    workers: int | None = None,
    say: Callable[[str], object] = print,
    quiet: bool = True,
) -> None:
    """Conceals physics in many simulated vehicles, seals the truth, diagnoses, and counts what was found.

    Parameters
    ----------
    cases : int
        Number of cases.
    seed : int
        Seed that draws them.
    out : path
        Folder for cases and results, as ``pitchid prove`` writes it.
    air : str
        Kind of background.
    resume : bool
        Whether to go on in a folder where a proof was begun.
    client : distributed.Client or str, optional
        A client of Dask, or the address of its scheduler; processes on this machine without it.
    workers : int, optional
        Processes on this machine.
    say : callable
        Takes what the command prints.
    quiet : bool
        Whether no progress is printed to standard error.

    Raises
    ------
    PitchidError
        A folder that cannot be used, or a scheduler that was lost: with ``resume`` it goes on.
    """
    proof = _native.Proof(out, seed, cases, air, resume)
    with _client(client, workers) as own:
        unsealed = [case for case in range(cases) if not proof.is_sealed(case)]
        jobs = ((case, seed, air) for case in unsealed)
        with Progress("concealing", len(unsealed), quiet) as progress:
            _done(own, _conceal, jobs, lambda case, files: proof.keep(case, *files), progress)
        say(proof.seals())
        unanswered = [case for case in range(cases) if not proof.is_answered(case)]
        questions = ((case, proof.question(case)) for case in unanswered)
        with Progress("diagnosing", len(unanswered), quiet) as progress:
            _done(own, _answer, questions, proof.keep_answer, progress)
    say(proof.count())


def main() -> int:
    """Does it; 0 where the proof was made, 2 where arguments, folder or scheduler could not be used."""
    parser = argparse.ArgumentParser(prog="python -m pitchid.prove", description="The proof of pitchid prove, on Dask.")
    parser.add_argument("--cases", type=int, default=24, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--out", default="pitchid-proof", metavar="DIR", help="folder for the cases and the results")
    parser.add_argument("--air", default="band_passed", metavar="WORD", help="kind of background")
    parser.add_argument("--resume", action="store_true", help="go on in a folder where a proof was begun")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="Dask's scheduler; processes on this machine without it")
    parser.add_argument("--workers", type=int, metavar="N", help="processes on this machine [default: one a core]")
    parser.add_argument("--quiet", "-q", action="store_true", help="print neither progress nor tables")
    asked = parser.parse_args()
    try:
        prove(
            asked.cases,
            seed=asked.seed,
            out=asked.out,
            air=asked.air,
            resume=asked.resume,
            client=asked.scheduler,
            workers=asked.workers,
            say=(lambda _: None) if asked.quiet else (lambda text: print(text, end="")),
            quiet=asked.quiet,
        )
    except (PitchidError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
