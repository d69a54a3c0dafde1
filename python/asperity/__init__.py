"""Contact, friction and friction-induced vibration of measured rough surfaces, with uncertainty.

Numbers are in SI units, with the unit in the name. Fields are arrays of shape (ny, nx), row 0 at the top; missing
heights are NaN. The same seed gives the same result on any number of threads.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from asperity.contact import ContactSolution, solve_contact
from asperity.errors import FormatError, NotConvergedError, ResourceError
from asperity.surface import HeightMap
from asperity.vibration import (
    Coulomb,
    Exponential,
    Forcing,
    Linear,
    Oscillator,
    Stribeck,
    Tabulated,
    critical_damping,
    ensemble,
    limit_cycle,
    stability_map,
)

if TYPE_CHECKING:
    from asperity.study import run_study

__all__ = [
    "ContactSolution",
    "Coulomb",
    "Exponential",
    "Forcing",
    "FormatError",
    "HeightMap",
    "Linear",
    "NotConvergedError",
    "Oscillator",
    "ResourceError",
    "Stribeck",
    "Tabulated",
    "critical_damping",
    "ensemble",
    "limit_cycle",
    "run_study",
    "solve_contact",
    "stability_map",
]

__version__ = version("asperity")

# Modules that take long to load, by the names that they define.
_LAZY = {"run_study": "study"}


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(import_module(f"asperity.{_LAZY[name]}"), name)
    raise AttributeError(f"module asperity has no attribute {name}")
