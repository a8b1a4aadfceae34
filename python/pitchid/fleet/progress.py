"""A line on standard error: k of n, and the time that is left."""

from __future__ import annotations

import sys
import time


class Progress:
    """Says how far a piece of work is: often on a terminal, now and then in a file."""

    def __init__(self, what: str, total: int, quiet: bool) -> None:
        self.what, self.total, self.quiet = what, total, quiet
        self.done = 0
        self.terminal = sys.stderr.isatty()
        self.begun = self.told = time.monotonic()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if not self.quiet and self.terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)

    def one(self, beside: str = "", done: int | None = None) -> None:
        """One more is done, or so many are; ``beside`` stands behind the count."""
        self.done = self.done + 1 if done is None else done
        last = self.done == self.total
        if self.quiet or (not last and time.monotonic() - self.told < (0.2 if self.terminal else 30)):
            return
        self.told = time.monotonic()
        said = f"{self.what}: {self.done} of {self.total}{beside}"
        if 0 < self.done < self.total:
            left = (self.told - self.begun) / self.done * (self.total - self.done)
            said += f", about {left / 60:.0f} min left" if left > 90 else f", about {left:.0f} s left"
        start, end = ("\r", "\033[K") if self.terminal else ("", "\n")
        print(f"{start}{said}", end=end, file=sys.stderr, flush=True)
