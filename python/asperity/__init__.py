"""Contact, friction and friction-induced vibration of measured rough surfaces, with uncertainty.

Numbers are in SI units, with the unit in the name. Fields are arrays of shape (ny, nx), row 0 at the top; missing
heights are NaN. The same seed gives the same result on any number of threads.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING

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
from asperity.surface import HeightMap, pooled_statistics
from asperity.vibration import Oscillator, critical_damping, ensemble, limit_cycle, stability_map, trajectory

if TYPE_CHECKING:
    from asperity import dask as dask
    from asperity import figures as figures
    from asperity import inputs as inputs
    from asperity.study import (
        Study,
        cite,
        friction_distribution,
        pressure_distribution,
        run_campaign,
        run_study,
        verdict,
    )

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
    "Study",
    "SurfaceModel",
    "Translation",
    "WeierstrassMandelbrot",
    "artificial_surface",
    "cite",
    "critical_damping",
    "design",
    "ensemble",
    "fit_friction_record",
    "friction_distribution",
    "friction_process",
    "limit_cycle",
    "pooled_statistics",
    "pressure_distribution",
    "run_campaign",
    "run_study",
    "solve_contact",
    "stability_map",
    "trajectory",
    "uncertain",
    "verdict",
]
__all__ += laws.__all__

__version__ = version("asperity")

# Names that take long to load: modules, and functions of the module `study`.
_MODULES = ("dask", "figures", "inputs")
_OF_STUDY = ("Study", "cite", "friction_distribution", "pressure_distribution", "run_campaign", "run_study", "verdict")

# A type checker takes a module with this function to have every name.
if not TYPE_CHECKING:

    def __getattr__(name):
        if name in _MODULES:
            return import_module(f"asperity.{name}")
        if name in _OF_STUDY:
            return getattr(import_module("asperity.study"), name)
        raise AttributeError(f"module asperity has no attribute {name}")


def __dir__() -> list[str]:
    return sorted([*__all__, *_MODULES, "__all__", "__doc__", "__file__", "__name__", "__path__", "__version__"])
