"""
Compiled part of the package asperity.
"""

from _typeshed import Incomplete, SupportsGetItem, SupportsLenAndGetItem
from os import PathLike
from typing import Any, SupportsFloat, SupportsIndex, final

__all__ = ["Expansion", "Marginal", "Oscillator", "RandomSurface", "SurfaceModel", "acf", "check_inputs", "check_study", "cite", "compute", "compute_or_leave", "critical_damping", "design", "distribution_nodes", "ensemble", "ensembles", "fill", "fit_friction_record", "friction_process", "height_map", "level", "limit_cycle", "map_names", "module_program", "parameters_schema", "pooled_statistics", "psd", "read_friction_process", "read_map", "read_study", "rescaled_law", "results_schema", "simulate_friction", "solve_contact", "stability_map", "statistics", "study_part", "study_schema", "toml_of", "trajectory", "unit_of", "vibration_schema", "write_map"]

@final
class Expansion:
    """
    Expansion in orthonormal polynomials of standard normal and of bounded variables.
    """
    def __new__(cls, /, powers: SupportsGetItem[int, SupportsGetItem[int, SupportsIndex]], coefficients: SupportsGetItem[int, SupportsFloat | SupportsIndex], relative_error: SupportsFloat | SupportsIndex | None, variables: SupportsGetItem[int, SupportsGetItem[int, SupportsFloat | SupportsIndex] | None]) -> Expansion:
        """
        Creates an expansion from the powers of its terms, their coefficients, its leave-one-out error and its variables.
        """
    def coefficients(self, /) -> Incomplete: ...
    def evaluate(self, /, xi: Incomplete) -> Incomplete:
        """
        Returns the values at samples.
        """
    @staticmethod
    def fit(xi: Incomplete, values: Incomplete, degree, sparse: bool, variables: SupportsGetItem[int, SupportsGetItem[int, SupportsFloat | SupportsIndex] | None]) -> tuple[Expansion, Incomplete | None]:
        """
        Fits an expansion of total degree `degree`; `sparse` keeps few terms, chosen by cross-validation. Returns also the
        95 % intervals of the `statistics`, shape (statistics, 2), or none.
        """
    def powers(self, /) -> list[list[int]]:
        """
        Returns the powers of the variables in each term.
        """
    def relative_error(self, /) -> float | None:
        """
        Returns the leave-one-out error over the variance.
        """
    def statistics(self, /) -> Incomplete:
        """
        Returns mean, variance, first-order and total Sobol' indices of all variables, and the matrix of the second-order ones.
        """
    def variables(self, /) -> int: ...

@final
class Marginal:
    """
    Distribution that a text states.
    """
    def __new__(cls, /, text: str) -> Marginal: ...
    def probability(self, /, values: Incomplete, upper: bool) -> Incomplete:
        """
        Returns the probabilities not to exceed these values or, with `upper`, to exceed them.
        """
    def quantile(self, /, probability: Incomplete, upper: bool) -> Incomplete:
        """
        Returns the values that are not exceeded with these probabilities or, with `upper`, that are exceeded.
        """
    def support(self, /) -> tuple[float, float]:
        """
        Returns the ends of the support.
        """

@final
class Oscillator:
    """
    Checked oscillator, or an array of oscillators.
    """
    def __new__(cls, /, parameters: dict, columns: SupportsGetItem[int, tuple[str, Incomplete]], shape: SupportsGetItem[int, SupportsIndex] | None) -> Oscillator:
        """
        Replaces numbers of the parameters by columns, which have a value of each machine.
        """
    def warnings(self, /) -> list[str]:
        """
        Returns warnings of implausible parameters, each kind once.
        """

@final
class RandomSurface:
    """
    Generator of random maps on a grid.
    """
    def generate(self, /, xi: SupportsGetItem[int, SupportsFloat | SupportsIndex]) -> Incomplete:
        """
        Returns the map of standard normal variables.
        """
    def pitch_m(self, /) -> tuple[float, float]:
        """
        Returns the distances between points.
        """
    def sample(self, /, seed, count) -> list[Incomplete]:
        """
        Draws maps, the same for any number of threads.
        """
    def xi_len(self, /) -> int:
        """
        Returns the number of standard normal variables of a map.
        """

@final
class SurfaceModel:
    """
    Model of a random surface, independent of any grid.
    """
    def __new__(cls, /, settings: dict, scans: SupportsGetItem[int, tuple[Incomplete, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex, dict]]) -> SurfaceModel: ...
    def covariance(self, /) -> Any | None:
        """
        Returns the covariance; `None` for a Weierstrass–Mandelbrot surface.
        """
    def on_grid(self, /, nx, ny, size_x_m: SupportsFloat | SupportsIndex, size_y_m: SupportsFloat | SupportsIndex, boundary: str) -> RandomSurface:
        """
        Makes the generator of maps on a grid of `nx` × `ny` points.
        """
    def rms_height_m(self, /) -> float:
        """
        Returns the standard deviation of the heights.
        """

def acf(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex) -> dict:
    """
    Computes the autocorrelation along both axes.
    """

def check_inputs(study: dict) -> None:
    """
    Checks the values of a study; its scans are not read.
    """

def check_study(request: Incomplete) -> dict:
    """
    Returns the stages of a study with their cost, warnings, and reasons why it cannot run.
    """

def cite(folder: str | PathLike[str], bibtex: bool) -> list[str]:
    """
    Returns the works behind the methods of the run in a folder, as sentences or as entries of BibTeX.
    """

def compute(request: Incomplete, campaign: bool, progress: Any | None, out: str | PathLike[str] | None) -> dict:
    """
    Computes a study or, with `campaign`, a campaign. Returns results, tables and fields; with `out` also writes the folder, and goes on from the blocks that
    an interrupted computation left beside it.
    """

def compute_or_leave(request: Incomplete, progress: Any | None, run: str | PathLike[str], out: str | PathLike[str] | None, parts: SupportsGetItem[int, str | PathLike[str]], threads: SupportsIndex, count: SupportsIndex | None, start_s: SupportsFloat | SupportsIndex) -> tuple[dict | None, dict | None]:
    """
    Computes as `compute` does, with blocks beside `run` and in `parts`, until a loop that `threads` threads elsewhere finish earlier: in
    `count` parts, or as many as follow from the work, of which the first begins after `start_s` seconds. Returns the results or that loop.
    """

def critical_damping(oscillator: Oscillator) -> Any:
    """
    Finds the damping ratios at which vibration ends, with the keys of `asperity vibration critical-damping --json`.
    """

def design(method: str, seed, samples, variables) -> Incomplete:
    """
    Plans a design and returns its standard normal variables, shape (samples, variables).
    """

def distribution_nodes() -> Incomplete:
    """
    Returns the standard normal values at which the polynomials of a bounded distribution need its translation.
    """

def ensemble(oscillator: Oscillator, fluctuation: Any, std: SupportsFloat | SupportsIndex, length: SupportsFloat | SupportsIndex, allow_clipping: bool, trajectories, duration: SupportsFloat | SupportsIndex, seed, drive: str, progress: Any | None) -> Any:
    """
    Simulates many trajectories over a random friction fluctuation.
    """

def ensembles(oscillator: Oscillator, fluctuation: Any, stds: SupportsGetItem[int, SupportsFloat | SupportsIndex], lengths: SupportsGetItem[int, SupportsFloat | SupportsIndex], allow_clipping: bool, trajectories, duration: SupportsFloat | SupportsIndex, seed, drive: str, progress: Any | None) -> Any:
    """
    Simulates an ensemble of each machine of an array, with its own fluctuation, of which `stds` and `lengths` are columns; see [`Fluctuation::model`]. All have the
    same seed.
    """

def fill(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex, options: dict) -> Incomplete:
    """
    Fills missing heights with random ones that continue the map, as `asperity surface fill` does.
    """

def fit_friction_record(friction: Incomplete, step_m: SupportsFloat | SupportsIndex, marginal: str, detrend: str, low_pass_m: SupportsFloat | SupportsIndex | None, decimation) -> Any:
    """
    Fits a process to a record of the friction coefficient at equal steps; NaN marks gaps.
    """

def friction_process(process: Any) -> Any:
    """
    Checks a process, a dictionary with the keys of its file, and completes it.
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

def map_names(path: str | PathLike[str]) -> list[str]:
    """
    Returns the names of the height maps of a file.
    """

def module_program(library: str | PathLike[str]) -> Any:
    """
    Returns the file of this module and its libraries on this machine, which determine the last bits of results.
    """

def parameters_schema() -> str:
    """
    Returns the JSON Schema of the parameters of an oscillator, from which the dataclasses of the velocity laws are generated.
    """

def pooled_statistics(scans: SupportsGetItem[int, tuple[Incomplete, SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex, dict]]) -> Any:
    """
    Computes the statistics of a part of several scans, with the keys of `asperity surface stats --json`.
    """

def psd(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex) -> dict:
    """
    Computes the radially averaged power spectral density.
    """

def read_friction_process(path: str | PathLike[str]) -> Any:
    """
    Reads a process from a file.
    """

def read_map(path: str | PathLike[str], channel: str | None, dx_m: SupportsFloat | SupportsIndex | None, dy_m: SupportsFloat | SupportsIndex | None, height_unit: str | None, decimal: str | None) -> tuple[Incomplete, tuple[float, float], list[str]]:
    """
    Reads a height map from a file.
    """

def read_study(path: str | PathLike[str]) -> Any:
    """
    Returns the content of a study file, which is checked.
    """

def rescaled_law(law: dict, factor: SupportsFloat | SupportsIndex) -> Any:
    """
    Returns a velocity law in a unit of velocity that is larger by a factor.
    """

def results_schema() -> str:
    """
    Returns the JSON Schema of results, from which the dataclasses are generated.
    """

def simulate_friction(process: Any, length_m: SupportsFloat | SupportsIndex, step_m: SupportsFloat | SupportsIndex, seed, index) -> Incomplete:
    """
    Draws values of the friction coefficient along a path.
    """

def solve_contact(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex, settings: dict, counterface_m: Incomplete | None, start_pa: Incomplete | None) -> Any:
    """
    Solves a contact problem, with a rough counterface and from the pressure `start_pa` if they are given. Returns fields
    and numbers, with the keys of `asperity contact --json`.
    """

def stability_map(oscillator: Oscillator, fluctuation: Any, std: SupportsFloat | SupportsIndex, length: SupportsFloat | SupportsIndex, allow_clipping: bool, axes: dict, trajectories, duration: SupportsFloat | SupportsIndex, seed, progress: Any | None) -> Any:
    """
    Maps the probability of sustained vibration over two parameters.
    """

def statistics(heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex, history: dict) -> Any:
    """
    Computes the statistics of a map, with the keys of `asperity surface stats --json`.
    """

def study_part(request: Incomplete, part: tuple[SupportsIndex, SupportsIndex], folder: str | PathLike[str]) -> bool:
    """
    Computes a part, number and count, of the blocks that can be computed now, into a folder. Blocks in the folder above
    it are used. Returns whether all are known.
    """

def study_schema() -> str:
    """
    Returns the JSON Schema of studies, from which the classes of their sections are generated.
    """

def toml_of(study: dict) -> str:
    """
    Returns the text of a study file.
    """

def trajectory(oscillator: Oscillator, tau: Incomplete, start: SupportsLenAndGetItem[SupportsFloat | SupportsIndex] | None, fluctuation: Any | None, std: SupportsFloat | SupportsIndex, length: SupportsFloat | SupportsIndex, allow_clipping: bool, seed, index, drive: str) -> dict:
    """
    Simulates a trajectory at rising times, from the state (X, X′) `start`.
    """

def unit_of(name: str) -> str:
    """
    Returns the SI unit that the name of a number ends with; empty if it states none.
    """

def vibration_schema() -> str:
    """
    Returns the JSON Schema of the answers of this module, from which the dataclasses are generated.
    """

def write_map(path: str | PathLike[str], heights_m: Incomplete, dx_m: SupportsFloat | SupportsIndex, dy_m: SupportsFloat | SupportsIndex) -> None:
    """
    Writes a height map to a file, in the format of its extension.
    """
