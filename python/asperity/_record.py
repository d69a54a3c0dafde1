"""Base of all results: named attributes that mirror JSON."""

from __future__ import annotations

import dataclasses
import html
import math
import warnings
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from asperity import _core
from asperity._arrays import is_chunked
from asperity.errors import AsperityWarning

if TYPE_CHECKING:
    import pandas
    import xarray

M = TypeVar("M", bound="Made")
R = TypeVar("R", bound="Record")


def equal(first: Any, second: Any) -> bool:
    """Return whether two values are equal; arrays by their values, and NaN with NaN."""
    if isinstance(first, np.ndarray) and isinstance(second, np.ndarray):
        has_nan = first.dtype.kind == second.dtype.kind == "f"
        return np.array_equal(first, second, equal_nan=has_nan)
    if is_chunked(first) and is_chunked(second):
        # The name of an array of Dask is that of its computation.
        return bool(first.name == second.name)
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        return first.keys() == second.keys() and all(equal(first[key], second[key]) for key in first)
    if isinstance(first, (list, tuple)) and type(first) is type(second):
        return len(first) == len(second) and all(map(equal, first, second))
    if any(isinstance(value, np.ndarray) or is_chunked(value) for value in (first, second)):
        return False
    both_nan = isinstance(first, float) and isinstance(second, float) and math.isnan(first) and math.isnan(second)
    return both_nan or bool(first == second)


class ByValue:
    """Dataclass whose objects are equal if their fields are, arrays included."""

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(map(equal, self._state(), other._state()))

    __hash__ = None  # type: ignore[assignment]

    def _state(self) -> tuple[Any, ...]:
        fields = dataclasses.fields(self)  # type: ignore[arg-type]
        return tuple(getattr(self, field.name) for field in fields if field.compare)


class Arguments(ByValue):
    """Dataclass of arguments. It can be hashed if its fields can."""

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(self._state())


class Made:
    """Object over a compiled one. Its state, from which it is made again, decides equality and is pickled.

    It does not change, so that a copy is the object itself.
    """

    def _make(self, *state: Any) -> None:
        raise NotImplementedError

    def __getstate__(self) -> tuple[Any, ...]:
        raise NotImplementedError

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AsperityWarning)
            self._make(*state)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return equal(self.__getstate__(), other.__getstate__())

    __hash__ = None  # type: ignore[assignment]

    def __copy__(self: M) -> M:
        return self

    def __deepcopy__(self: M, memo: object) -> M:
        return self


class Record(ByValue):
    """A result. Its attributes are the keys of the JSON object that the command line prints."""

    #: Classes of the values that are objects, or lists of objects.
    _nested: ClassVar[Mapping[str, type[Record]]] = {}

    @classmethod
    def from_dict(cls: type[R], data: Mapping[str, Any]) -> R:
        """Create the result from a dictionary, such as a part of ``results.json``."""
        known = {field.name for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
        values = {key: cls._typed(key, value) for key, value in data.items()}
        others = {key: values.pop(key) for key in data if key not in known}
        if others and "companions" not in known:
            raise ValueError(f"{cls.__name__} has no key {', '.join(others)}; another version of asperity wrote it")
        if others:
            values["companions"] = others
        found = cls(**values)
        # Absent keys and those that are null are both None here, and differ in JSON.
        object.__setattr__(found, "_keys", tuple(data))
        return found

    @classmethod
    def _typed(cls, key: str, value: Any) -> Any:
        kind = cls._nested.get(key)
        if kind is None or value is None:
            return value
        return [kind.from_dict(item) for item in value] if isinstance(value, list) else kind.from_dict(value)

    def to_dict(self) -> dict[str, Any]:
        """Return the result as dictionaries, lists, numbers and strings."""
        return {key: _plain(value) for key, value in self._values().items()}

    def _values(self) -> dict[str, Any]:
        fields = dataclasses.fields(self)  # type: ignore[arg-type]
        keys = self.__dict__.get("_keys") or [field.name for field in fields]
        return {key: getattr(self, key) for key in keys}

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the result as a data frame of one row; the names of nested values are joined by dots.

        Undefined numbers are NaN. Arrays are left out.
        """
        return frame([row(self)])

    def _repr_html_(self) -> str:
        return _html(self)


class Curves(Record):
    """A result with curves."""

    #: Name of the abscissae of each curve.
    _curves: ClassVar[Mapping[str, str]]

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the curves and their abscissae as columns. The shorter ones end with NaN."""
        import pandas

        names = dict.fromkeys(name for curve, along in self._curves.items() for name in (along, curve))
        return pandas.DataFrame({name: pandas.Series(getattr(self, name)) for name in names})

    def to_xarray(self) -> xarray.Dataset:
        """Return the curves over their abscissae, with the unit of each; the other values are attributes."""
        import xarray

        def array(name: str, along: str) -> tuple[str, Any, dict[str, str]]:
            return along, getattr(self, name), {"units": unit_of(name)}

        curves = {name: array(name, along) for name, along in self._curves.items()}
        coordinates = {along: array(along, along) for along in self._curves.values()}
        return xarray.Dataset(curves, coordinates, row(self))


class WithCompanions(Record):
    """A result whose statistics ``x`` have companions such as ``x_interval`` and ``x_se``."""

    def __getattr__(self, name: str) -> Any:
        """Return a companion of a statistic."""
        try:
            return self.__dict__["companions"][name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has no attribute {name}") from None

    def __dir__(self) -> list[str]:
        """List the attributes with the companions."""
        return [*super().__dir__(), *self.__dict__.get("companions", {})]


def row(record: Record) -> dict[str, Any]:
    """Return the values of a result without arrays; undefined numbers are NaN."""
    return {key: _cell(value) for key, value in record._values().items() if not isinstance(value, np.ndarray)}


def _cell(value: Any) -> Any:
    if value is None:
        return math.nan
    return row(value) if isinstance(value, Record) else _plain(value)


def frame(rows: Iterable[Mapping[str, Any]]) -> pandas.DataFrame:
    """Return rows as a data frame; the names of nested values are joined by dots."""
    import pandas

    return pandas.json_normalize(list(rows))


def unit_of(name: str) -> str:
    """Return the SI unit that the name of a quantity ends with; 1 without one."""
    return _core.unit_of(name) or "1"


def _plain(value: Any) -> Any:
    if isinstance(value, Record):
        return value.to_dict()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value


def _html(value: Any) -> str:
    if isinstance(value, Record):
        names = [field.name for field in dataclasses.fields(value)]  # type: ignore[arg-type]
        shown = [(name, getattr(value, name)) for name in names]
        rows = (
            f"<tr><th>{html.escape(name)}</th><td>{_html(item)}</td></tr>" for name, item in shown if item is not None
        )
        return f"<details open><summary>{type(value).__name__}</summary><table>{''.join(rows)}</table></details>"
    if isinstance(value, np.ndarray):
        return html.escape(f"array {value.shape}, {value.dtype}")
    if isinstance(value, list) and value and isinstance(value[0], Record):
        title = f"{len(value)} × {type(value[0]).__name__}"
        return f"<details><summary>{title}</summary>{''.join(map(_html, value))}</details>"
    return html.escape(f"{value:.6g}" if isinstance(value, float) else str(value))
