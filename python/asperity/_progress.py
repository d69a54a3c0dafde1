"""Progress of long computations."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

Progress = bool | Callable[[str, int, int], object]
"""True shows a line on a terminal or in a notebook; a function gets the task, the blocks done and all blocks."""

# Least time between two changes of the line.
_TICK_S = 0.2


def callback(progress: Progress) -> Callable[[str, int, int], object] | None:
    """Return the function to call, or None."""
    if not isinstance(progress, bool):
        return progress
    if progress and _in_notebook():
        return _Line(_Output().show)
    return _Line(_overwrite) if progress and sys.stderr.isatty() else None


def _in_notebook() -> bool:
    """Return whether the program runs in a kernel, not only imports one."""
    interactive = sys.modules.get("IPython")
    return interactive is not None and getattr(interactive.get_ipython(), "kernel", None) is not None


def _overwrite(text: str) -> None:
    """Show a text on the line of the terminal; what follows overwrites it."""
    sys.stderr.write(text.ljust(79) + "\r")
    sys.stderr.flush()


class _Output:
    """Output of a notebook that changes."""

    def __init__(self) -> None:
        self.handle: Any = None

    def show(self, text: str) -> None:
        from IPython.display import Pretty, display

        own = Pretty(text)  # type: ignore[no-untyped-call]
        if self.handle is None:
            self.handle = display(own, display_id=True)  # type: ignore[no-untyped-call]
        else:
            self.handle.update(own)


class _Line:
    """A line with the time so far, the last task and its remaining time."""

    def __init__(self, show: Callable[[str], object]) -> None:
        self.show = show
        self.begun = self.shown = time.monotonic()
        self.started: dict[str, float] = {}

    def __call__(self, what: str, done: int, total: int) -> None:
        now = time.monotonic()
        elapsed = now - self.started.setdefault(what, now)
        if now - self.shown < _TICK_S:
            return
        self.shown = now
        left = f", {elapsed * (total - done) / done:.0f} s left" if 0 < done < total else ""
        self.show(f"{now - self.begun:.0f} s; {what}: {done} of {total}{left}")
