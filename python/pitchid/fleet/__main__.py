"""``python -m pitchid.fleet 'logs/**/*.ulg' --out table.parquet [--scheduler tcp://HOST:PORT]``."""

from __future__ import annotations

import argparse
import sys

from .._errors import PitchidError
from . import diagnose, report
from .progress import Progress


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m pitchid.fleet", description="Diagnoses many recordings on Dask.")
    parser.add_argument("paths", nargs="+", help="files or patterns; ** stands for any folders")
    parser.add_argument("--out", required=True, metavar="TABLE.parquet", help="the table, new or to go on with")
    parser.add_argument("--report", metavar="PAGE.html", help="write a page: which craft differ from their siblings")
    parser.add_argument("--craft", metavar="REGEX", help="where a path names (?P<type>...), (?P<craft>...), (?P<when>...)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="Dask's scheduler; processes on this machine without it")
    parser.add_argument("--workers", type=int, metavar="N", help="processes on this machine [default: one a core]")
    parser.add_argument("--limit", type=float, default=600, metavar="S", help="longest time for a file [default: 600]")
    parser.add_argument("--retry", action="store_true", help="run files again that failed before")
    parser.add_argument("--model", metavar="MODEL.toml", help="the simulation in use today")
    parser.add_argument("--axis", choices=["roll", "pitch", "yaw"])
    parser.add_argument("--column", action="append", default=[], metavar="NAME=EXPR", help="as pitchid diagnose has it")
    parser.add_argument("--input", choices=["held", "interpolated"])
    parser.add_argument("--quiet", "-q", action="store_true", help="print no progress")
    return parser.parse_args()


def main() -> int:
    """Does it; 0 where every file has a row, 2 where the arguments or the scheduler could not be used."""
    asked = _arguments()
    columns = dict(column.split("=", 1) for column in asked.column if "=" in column) or None
    try:
        run = diagnose(
            asked.paths,
            asked.scheduler,
            out=asked.out,
            model=asked.model,
            limit_s=asked.limit,
            workers=asked.workers,
            retry=asked.retry,
            axis=asked.axis,
            columns=columns,
            input=asked.input,
        )
        with Progress("diagnosing", run.total, asked.quiet) as progress:
            for _ in run:
                progress.one(f", {run.failed} failed", run.done)
        if asked.report:
            report(asked.out, out=asked.report, craft=asked.craft)
    except (PitchidError, OSError) as error:
        print(f"{error}", file=sys.stderr)
        return 2
    print(f"{run.total} recordings, {run.failed} failed: {asked.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
