"""Contact, friction and friction-induced vibration of measured rough surfaces, with uncertainty.

Numbers are in SI units, with the unit in the name. Fields are arrays of shape (ny, nx), row 0 at the top; missing
heights are NaN. The same seed gives the same result on any number of threads.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from asperity import laws
from asperity.chaos import Expansion, design
from asperity.contact import ContactSolution, solve_contact
from asperity.errors import AsperityWarning, FormatError, NotConvergedError, ResourceError
from asperity.friction import FrictionProcess, fit_friction_record, friction_process
from asperity.interop import uncertain
from asperity.laws import *  # noqa: F403
from asperity.random import (
    Covariance,
    KarhunenLoeve,
    Spectral,
    SurfaceModel,
    Translation,
    WeierstrassMandelbrot,
    artificial_surface,
)
from asperity.surface import HeightMap
from asperity.vibration import Oscillator, critical_damping, ensemble, limit_cycle, stability_map

if TYPE_CHECKING:
    from asperity.study import pressure_distribution, run_campaign, run_study, verdict

__all__ = [
    "AsperityWarning",
    "ContactSolution",
    "Covariance",
    "Expansion",
    "FormatError",
    "FrictionProcess",
    "HeightMap",
    "KarhunenLoeve",
    "NotConvergedError",
    "Oscillator",
    "ResourceError",
    "Spectral",
    "SurfaceModel",
    "Translation",
    "WeierstrassMandelbrot",
    "artificial_surface",
    "critical_damping",
    "design",
    "ensemble",
    "fit_friction_record",
    "friction_process",
    "limit_cycle",
    "pressure_distribution",
    "run_campaign",
    "run_study",
    "solve_contact",
    "stability_map",
    "uncertain",
    "verdict",
]
__all__ += laws.__all__

__version__ = version("asperity")

# Modules that take long to load, by the names that they define.
_LAZY = {name: "study" for name in ("pressure_distribution", "run_campaign", "run_study", "verdict")}


def __getattr__(name: str) -> Any:
    if name == "figures":
        return import_module("asperity.figures")
    if name in _LAZY:
        return getattr(import_module(f"asperity.{_LAZY[name]}"), name)
    raise AttributeError(f"module asperity has no attribute {name}")
