"""Sections of a study: named inputs, as numbers in SI, texts with units or distributions."""

from __future__ import annotations

import atexit
import dataclasses
import hashlib
import numbers
import os
import pathlib
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, ClassVar, Protocol

from asperity.interop import is_distribution, uncertain
from asperity.surface import HeightMap


class _Frozen(Protocol):
    def ppf(self, q: Any) -> Any: ...


class _OpenTurns(Protocol):
    def computeQuantile(self, prob: Any) -> Any: ...  # noqa: N802


Uncertain = _Frozen | _OpenTurns | Mapping[str, object] | str
Scan = str | os.PathLike[str] | HeightMap


@cache
def _folder() -> pathlib.Path:
    """Return a folder for the maps of this process, which its end removes."""
    folder = tempfile.mkdtemp(prefix="asperity-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return pathlib.Path(folder)


def _file_of(heights: HeightMap) -> str:
    """Write a map to a file named after its content, and return the path."""
    content = hashlib.sha256(heights.heights.tobytes() + f"{heights.dx_m!r} {heights.dy_m!r}".encode()).hexdigest()
    path = _folder() / f"{content[:16]}.gwy"
    if not path.exists():
        heights.write(path)
    return os.fspath(path)


def stated(value: Any, unit: str = "") -> Any:  # noqa: PLR0911
    """Return a value in the form of a study file; a number has the unit."""
    if isinstance(value, (str, bool)):
        return value
    if isinstance(value, numbers.Integral) and not unit:
        return int(value)
    if isinstance(value, numbers.Real):
        return f"{float(value)!r} {unit}" if unit else float(value)
    if isinstance(value, HeightMap):
        return _file_of(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if is_distribution(value):
        return uncertain(value, unit=unit)
    if isinstance(value, Mapping):
        return {key: stated(inner) for key, inner in value.items()}
    if isinstance(value, Iterable):
        return [stated(inner, unit) for inner in value]
    raise TypeError(f"found {value!r}, expected a number, a text, a distribution or a list")


class Section:
    """Inputs of a study. What is None is left out, so that its default counts.

    Sections are equal if a study file states them alike.
    """

    #: SI units of the quantities.
    _units: ClassVar[Mapping[str, str]] = {}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Section) or type(other) is not type(self):
            return NotImplemented
        return self.to_dict() == other.to_dict()

    __hash__ = None  # type: ignore[assignment]

    def to_dict(self) -> dict[str, Any]:
        """Return the inputs in the form of a study file."""
        found = {}
        for own in dataclasses.fields(self):  # type: ignore[arg-type]
            value = getattr(self, own.name)
            if value is not None:
                try:
                    is_section = isinstance(value, Section)
                    found[own.name] = value.to_dict() if is_section else stated(value, self._units.get(own.name, ""))
                except (TypeError, ValueError) as error:
                    raise type(error)(f"{own.name}: {error}") from None
        return found


def with_folder(value: Any, folder: str, key: str = "") -> Any:
    """Return values of a study file in a folder with absolute paths."""
    if isinstance(value, Mapping):
        return {name: with_folder(inner, folder, name) for name, inner in value.items()}
    if isinstance(value, list):
        return [with_folder(inner, folder, key) for inner in value]
    return os.path.join(folder, value) if key in ("file", "friction_process", "samples") else value
