"""
Compiled part of the package asperity.
"""

from _typeshed import Incomplete
from os import PathLike
from typing import Any, SupportsFloat, SupportsIndex, final

__all__ = ["Oscillator", "acf", "critical_damping", "ensemble", "height_map", "level", "limit_cycle", "psd", "read_map", "results_schema", "run_study", "solve_contact", "stability_map", "statistics"]

@final
class Oscillator:
    """
    Checked oscillator.
    """
    def __new__(cls, /, parameters: dict) -> Oscillator: ...

def acf(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex) -> dict:
    """
    Computes the autocorrelation along both axes.
    """

def critical_damping(oscillator: Oscillator) -> Any:
    """
    Finds the damping ratios at which vibration ends, with the keys of `asperity vibration critical-damping --json`.
    """

def ensemble(oscillator: Oscillator, fluctuation: dict, trajectories: SupportsIndex, duration: SupportsFloat | SupportsIndex, seed: SupportsIndex, drive: str, progress: Any | None) -> Any:
    """
    Simulates many trajectories over a random friction fluctuation.
    """

def height_map(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex) -> Incomplete:
    """
    Copies heights into a checked map: infinite heights count as missing.
    """

def level(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex, steps: dict) -> tuple[Incomplete, Any]:
    """
    Removes form, outliers and filtered waves. Returns the heights, and what was done to them.
    """

def limit_cycle(oscillator: Oscillator) -> Any:
    """
    Finds the vibration that develops from a start in stick, with the keys of `asperity vibration cycle --json`.
    """

def psd(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex) -> dict:
    """
    Computes the radially averaged power spectral density.
    """

def read_map(path: str | PathLike[str], channel: str | None, dx_m: SupportsFloat | SupportsIndex | None, dy_m: SupportsFloat | SupportsIndex | None, height_unit: str | None) -> tuple[Incomplete, tuple[float, float], list[str]]:
    """
    Reads a height map from a file.
    """

def results_schema() -> str:
    """
    Returns the JSON Schema of results, from which the dataclasses are generated.
    """

def run_study(study: Any, only: str | None, seed: SupportsIndex | None, progress: Any | None, out: str | PathLike[str] | None) -> dict:
    """
    Runs a study, the path of a file or a dictionary. Returns results, tables and fields; with `out` also writes the run
    folder.
    """

def solve_contact(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex, settings: dict) -> dict:
    """
    Solves a contact problem. Returns fields and numbers, with the keys of `asperity contact --json`.
    """

def stability_map(oscillator: Oscillator, fluctuation: dict, axes: dict, trajectories: SupportsIndex, duration: SupportsFloat | SupportsIndex, seed: SupportsIndex, progress: Any | None) -> Any:
    """
    Maps the probability of sustained vibration over two parameters.
    """

def statistics(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex, history: dict) -> Any:
    """
    Computes the statistics of a map, with the keys of `asperity surface stats --json`.
    """
