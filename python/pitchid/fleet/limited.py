"""Diagnosis with a time limit: in a child process, as nothing else ends a file that hangs."""

from __future__ import annotations

import atexit
import json
import os
import queue
import subprocess
import sys
import threading
import time
from typing import Any

from .rows import failed

START_S = 300.0
"""How long a process may take to start, s: on a machine that is busy otherwise."""

_own = threading.local()


class Child:
    """A process that diagnoses for this thread."""

    def __init__(self) -> None:
        # workers share the cores already
        environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "pitchid.fleet.child"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            encoding="utf-8",
            env=environment,
        )
        self.answers: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()
        atexit.register(self.end)
        # to start is none of a file's time
        self.answers.get(timeout=START_S)

    def _listen(self) -> None:
        for line in self.process.stdout or ():
            self.answers.put(line)
        self.answers.put(None)

    def ask(self, question: dict[str, Any], limit_s: float) -> dict[str, Any]:
        """What it tells in this time: ``sha256``, ``row``, and ``ended`` where the process ended instead."""
        told: dict[str, Any] = {}
        until = time.monotonic() + limit_s
        try:
            print(json.dumps(question), file=self.process.stdin, flush=True)
            while "row" not in told and "ended" not in told:
                line = self.answers.get(timeout=max(0.0, until - time.monotonic()))
                told |= {"ended": self.process.wait()} if line is None else json.loads(line)
        except BrokenPipeError:
            told["ended"] = self.process.wait()
        except queue.Empty:
            pass
        return told

    def end(self) -> None:
        """Ends the process."""
        atexit.unregister(self.end)
        self.process.kill()
        self.process.wait()


def diagnose(path: str, arguments: str, known: str | None, limit_s: float) -> dict[str, Any] | None:
    """The row of a file, whatever it does; None where it still is the one whose hash is ``known``."""
    child = getattr(_own, "child", None)
    if child is None or child.process.poll() is not None:
        child = _own.child = Child()
    question = {"path": path, "arguments": arguments, "known": known}
    told = child.ask(question, limit_s)
    if "row" in told:
        return told["row"]
    child.end()
    hashed = {"sha256": told.get("sha256")}
    if "ended" in told:
        error = f"{path}: the diagnosis broke down, its process ended with status {told['ended']}"
        return failed(path, arguments, error, "look at it alone; a file that needs all memory ends like this", **hashed)
    error = f"{path}: not done after {limit_s:g} s"
    return failed(path, arguments, error, "look at it alone, or give it more time", took_s=limit_s, **hashed)
