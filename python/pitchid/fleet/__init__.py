"""Many recordings at once, on Dask: a table with a row for each, and which craft differ from their siblings.

>>> from pitchid import fleet
>>> run = fleet.diagnose("logs/**/*.ulg", out="fleet.parquet")      # doctest: +SKIP
>>> for row in run:                                                 # doctest: +SKIP
...     print(row["path"], row["verdict"])
>>> fleet.report("fleet.parquet", out="fleet.html")                 # doctest: +SKIP

Needs ``pip install 'pitchid[fleet]'``. From the shell: ``python -m pitchid.fleet --help``.
"""

from .page import report
from .rows import SCHEMA, answer
from .run import Run, diagnose
from .siblings import estimates, siblings
from .table import read_table

__all__ = ["SCHEMA", "Run", "answer", "diagnose", "estimates", "read_table", "report", "siblings"]
