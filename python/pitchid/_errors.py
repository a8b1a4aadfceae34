"""What stops a question."""

from __future__ import annotations


class PitchidError(ValueError):
    """Input that cannot be used: what was found, where, and what to do about it.

    Attributes
    ----------
    message : str
        What was found.
    remedy : str
        What to do.
    file, line, column : str, int, str or None
        Where, as far as that is known; lines are counted from 1.
    """

    def __init__(
        self,
        message: str,
        remedy: str,
        file: str | None = None,
        line: int | None = None,
        column: str | None = None,
    ) -> None:
        super().__init__(message, remedy, file, line, column)
        self.message = message
        self.remedy = remedy
        self.file = file
        self.line = line
        self.column = column

    def __str__(self) -> str:
        return f"{self.message}\n  {self.remedy}"
