"""Progress of long computations."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

Progress = bool | Callable[[str, int, int], object]
"""True shows a line on a terminal or in a notebook; a function gets the task, the blocks done and all blocks."""


def callback(progress: Progress) -> Callable[[str, int, int], object] | None:
    """Return the function to call, or None."""
    if not isinstance(progress, bool):
        return progress
    return _Line() if progress and (sys.stderr.isatty() or "ipykernel" in sys.modules) else None


class _Line:
    """A line that shows the last task and its remaining time."""

    def __init__(self) -> None:
        self.started: dict[str, float] = {}

    def __call__(self, what: str, done: int, total: int) -> None:
        elapsed = time.monotonic() - self.started.setdefault(what, time.monotonic())
        left = f", {elapsed * (total - done) / done:.0f} s left" if 0 < done < total else ""
        end = "\n" if done == total else ""
        sys.stderr.write(f"\r{what}: {done} of {total}{left}".ljust(79) + end)
        sys.stderr.flush()
