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

import numpy as np

from asperity.errors import warn
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
    folder, process = tempfile.mkdtemp(prefix="asperity-"), os.getpid()

    def remove() -> None:
        # A process that this one forked ends before it.
        if os.getpid() == process:
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    return pathlib.Path(folder)


def _file_of(heights: HeightMap) -> str:
    """Write a map to a file named after its content, and return the path."""
    head = f"{heights.shape} {heights.dx_m!r} {heights.dy_m!r} ".encode()
    path = _folder() / f"{hashlib.sha256(head + heights.heights.tobytes()).hexdigest()[:32]}.gwy"
    if not path.exists():
        heights.write(path)
    return os.fspath(path)


def _owned(value: Any) -> Any:
    """Return a value that later changes of the caller's lists and arrays do not change."""
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and not value.ndim):
        return value.item()
    if isinstance(value, (str, bytes, HeightMap, os.PathLike, Section)) or is_distribution(value):
        return value
    if isinstance(value, Mapping):
        return {key: _owned(inner) for key, inner in value.items()}
    return tuple(map(_owned, value)) if isinstance(value, Iterable) else value


# Places of the parameters of a distribution that have its unit, where not all have it.
_WITH_UNIT = {"lognormal": (0,), "beta": (2, 3)}
_Unit = str | tuple[str, ...]


def stated(value: Any, unit: _Unit = "") -> Any:  # noqa: PLR0911
    """Return a value in the form of a study file; a number has the unit, one of a row that of its column."""
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
        return uncertain(value, unit=str(unit))
    if isinstance(value, Mapping):
        return {key: _parameters(key, inner, str(unit)) for key, inner in value.items()}
    if isinstance(value, Iterable) and not isinstance(value, bytes):
        rows = isinstance(unit, tuple)
        return [list(map(stated, inner, unit)) if rows else stated(inner, unit) for inner in value]
    raise TypeError(f"found {value!r}, expected a number, a text, a distribution or a list")


def _parameters(name: str, values: Any, unit: str) -> Any:
    """Return the parameters of a named distribution with their unit."""
    if isinstance(values, (str, bool)) or not isinstance(values, Iterable):
        return stated(values)
    places = _WITH_UNIT.get(name)
    return [stated(own, unit if places is None or place in places else "") for place, own in enumerate(values)]


def stated_study(study: Mapping[str, Any]) -> dict[str, Any]:
    """Return a study as a dictionary in which distributions, maps and paths have the form of a study file."""
    return {key: _inner(value, key) for key, value in study.items()}


def _inner(value: Any, name: str) -> Any:
    if isinstance(value, Mapping):
        return {key: _inner(own, f"{name}.{key}") for key, own in value.items()}
    if isinstance(value, (list, tuple)):
        return [_inner(own, f"{name}[{place}]") for place, own in enumerate(value)]
    if not (isinstance(value, (HeightMap, os.PathLike)) or is_distribution(value)):
        return value
    try:
        return stated(value)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


class Section:
    """Inputs of a study. What is None is left out, so that its default counts.

    Sections are equal if a study file states them alike.
    """

    #: SI units of the quantities; of rows, those of the columns.
    _units: ClassVar[Mapping[str, str | tuple[str, ...]]] = {}

    def __post_init__(self) -> None:
        for own in dataclasses.fields(self):  # type: ignore[arg-type]
            object.__setattr__(self, own.name, _owned(getattr(self, own.name)))
        scans = [own for own in self._maps() if isinstance(own, HeightMap)]
        for name in ("height_unit", "pixel_size"):
            if scans and getattr(self, name, None) is not None:
                raise ValueError(f"{name}: the heights and the pixel size of a HeightMap are in m")
        if any(own.is_prepared for own in scans):
            warn("the map was levelled or filtered before, which the results do not know; state `level` instead")

    @classmethod
    def _names(cls) -> list[str]:
        """Return the keys."""
        return [own.name for own in dataclasses.fields(cls)]  # type: ignore[arg-type]

    def _maps(self) -> Iterable[Any]:
        """Return the scans."""
        file = getattr(self, "file", None)
        return file if isinstance(file, tuple) else (file,)

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
