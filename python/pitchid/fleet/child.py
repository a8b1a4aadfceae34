"""A process that diagnoses one file after another, and can be killed: ``python -m pitchid.fleet.child``.

Says that it is ready, reads a JSON object a line, and answers with the hash of the file and its row, a line each; ends with
its parent, whatever it is doing.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
from typing import Any

from .rows import of_file


def _listen(heard: queue.Queue[str]) -> None:
    for line in sys.stdin:
        heard.put(line)
    # nobody is there any more: not even a file that hangs may keep this process
    os._exit(0)


def main() -> None:
    """Answers until standard input ends."""
    # what libraries print must not get between the answers
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)

    def tell(what: dict[str, Any]) -> None:
        print(json.dumps(what), file=answers, flush=True)

    tell({"ready": True})
    heard: queue.Queue[str] = queue.Queue()
    threading.Thread(target=_listen, args=(heard,), daemon=True).start()
    while True:
        asked = json.loads(heard.get())
        tell({"row": of_file(**asked, hashed_as=lambda sha256: tell({"sha256": sha256}))})


if __name__ == "__main__":
    main()
