"""Exchange with other packages: maps of SurfaceTopography, surfalize, xarray; distributions of SciPy, OpenTURNS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asperity.surface import HeightMap

if TYPE_CHECKING:
    import xarray
    from SurfaceTopography import Topography
    from surfalize import Surface

_UM_PER_M = 1e6
# Largest distance of a coordinate from an equal grid, over the pixel size: above the rounding of single precision.
_EQUAL_STEPS = 1e-3


def from_surfacetopography(topography: Topography) -> HeightMap:
    """Return the map of a topography; see `asperity.HeightMap.from_surfacetopography`."""
    if topography.dim == 1:
        raise ValueError("a line scan is no map; use a two-dimensional Topography")
    if topography.unit is None:
        raise ValueError("the topography has no unit; create it with a unit, such as Topography(..., unit='m')")
    own = topography.to_unit("m")
    dx_m, dy_m = map(float, own.pixel_size)
    return HeightMap.from_array(own.heights().T, dx_m=dx_m, dy_m=dy_m)


def to_surfacetopography(heights: HeightMap, periodic: bool) -> Topography:
    """Return a map as a topography; see `asperity.HeightMap.to_surfacetopography`."""
    from SurfaceTopography import Topography

    ny, nx = heights.shape
    sizes_m = (nx * heights.dx_m, ny * heights.dy_m)
    return Topography(heights.heights.T, sizes_m, periodic=periodic, unit="m")


def from_surfalize(surface: Surface) -> HeightMap:
    """Return the map of a surface; see `asperity.HeightMap.from_surfalize`."""
    heights_m = np.asarray(surface.data, dtype=np.float64) / _UM_PER_M
    if surface.has_masked_points:
        heights_m[surface.mask.to_array()] = np.nan
    return HeightMap.from_array(heights_m, dx_m=surface.step_x / _UM_PER_M, dy_m=surface.step_y / _UM_PER_M)


def to_surfalize(heights: HeightMap) -> Surface:
    """Return a map as a surface; see `asperity.HeightMap.to_surfalize`."""
    from surfalize import Surface

    return Surface(_UM_PER_M * heights.heights, _UM_PER_M * heights.dx_m, _UM_PER_M * heights.dy_m)


def from_xarray(array: xarray.DataArray) -> HeightMap:
    """Return the map of an array; see `asperity.HeightMap.from_xarray`."""
    if set(array.dims) != {"y", "x"}:
        raise ValueError(f"found the dimensions {', '.join(map(str, array.dims))}; a map has y and x")
    _check_metre(array, "the heights")
    for axis in ("x", "y"):
        positions = _positions_m(array, axis)
        if positions.size > 1 and positions[0] > positions[-1]:
            array = array.isel({axis: slice(None, None, -1)})
    return HeightMap.from_array(
        array.transpose("y", "x").to_numpy(), dx_m=_pitch_m(array, "x"), dy_m=_pitch_m(array, "y")
    )


def _check_metre(array: xarray.DataArray, name: str) -> None:
    unit = array.attrs.get("units", "m")
    if unit != "m":
        raise ValueError(f"{name} are in {unit}; convert them to m")


def _positions_m(array: xarray.DataArray, axis: str) -> NDArray[np.float64]:
    """Return the coordinates of an axis."""
    if axis not in array.coords:
        raise ValueError(f"{axis} has no coordinates; assign them in metre")
    _check_metre(array[axis], f"the coordinates {axis}")
    positions = array[axis].to_numpy()
    if positions.dtype.kind not in "fiu":
        raise ValueError(f"the coordinates {axis} are of the type {positions.dtype}; assign numbers in metre")
    return positions.astype(np.float64)


def _pitch_m(array: xarray.DataArray, axis: str) -> float:
    """Return the distance between the points of an axis."""
    position_m = _positions_m(array, axis)
    steps = np.arange(position_m.size)
    # The coordinates of `to_xarray` give the distance without rounding.
    pitch_m = 2 * position_m[0]
    if not np.array_equal((steps + 0.5) * pitch_m, position_m):
        pitch_m = (position_m[-1] - position_m[0]) / (position_m.size - 1)
    offset_m = position_m - position_m[0] - steps * pitch_m
    if not (pitch_m > 0 and np.abs(offset_m).max() <= _EQUAL_STEPS * pitch_m):
        raise ValueError(f"the coordinates {axis} have no equal steps; sort them, or interpolate to such a grid")
    return float(pitch_m)


def is_distribution(value: Any) -> bool:
    """Return whether a value is a distribution of SciPy, frozen or with parameters, or one of OpenTURNS."""
    return _is_frozen(value) or _has_parameters(value) or hasattr(value, "computeQuantile")


def _has_parameters(value: Any) -> bool:
    return hasattr(value, "iccdf")


def _is_frozen(value: Any) -> bool:
    return hasattr(value, "dist") and hasattr(value, "ppf")


def uncertain(distribution: Any, *, unit: str = "", unknown: bool = False) -> dict[str, Any]:
    """State a distribution of SciPy or OpenTURNS as an uncertain value of a study.

    A study takes a distribution of a number, such as a damping ratio, as it is. A quantity of a dictionary needs its
    unit; in a section of `asperity.inputs` it is the SI unit.

    Parameters
    ----------
    distribution
        Of SciPy a ``Normal`` or ``Uniform``, or a frozen ``norm``, ``uniform``, ``triang``, ``beta``, or a ``lognorm``
        with ``loc`` = 0; of OpenTURNS ``Normal``, ``Uniform``, ``Triangular``, ``Beta``, or a ``LogNormal`` with the
        location γ = 0. The median of a ``LogNormal`` of OpenTURNS is rounded, because OpenTURNS stores its logarithm;
        all other parameters are exact.
    unit
        Unit of the numbers of the distribution, such as ``"GPa"``. Left out, the value is a number without a unit.
    unknown
        Whether it is one value that is not known, not a value that varies from part to part.

    Returns
    -------
    dict
        The value in the form of a study file, such as ``{"normal": ["2.0 GPa", "0.2 GPa"]}``.

    Raises
    ------
    ValueError
        A study file has no form for the distribution.

    Examples
    --------
    >>> import asperity, scipy.stats
    >>> asperity.uncertain(scipy.stats.norm(2, 0.25), unit="GPa")
    {'normal': ['2.0 GPa', '0.25 GPa']}
    """
    if not (is_distribution(distribution) or hasattr(distribution, "getImplementation")):
        raise TypeError(f"found {distribution!r}, expected a frozen distribution of SciPy or one of OpenTURNS")
    if _is_frozen(distribution):
        name, parameters = _of_scipy(distribution)
    elif _has_parameters(distribution):
        name, parameters = _of_new_scipy(distribution)
    else:
        name, parameters = _of_openturns(distribution)

    def stated(value: float) -> float | str:
        return f"{value!r} {unit}" if unit else value

    form: dict[str, Any]
    match name, parameters:
        case ("normal" | "uniform", [_, _]) | ("triangular", [_, _, _]):
            form = {name: [stated(value) for value in parameters]}
        case "lognormal", [median, log_std]:
            form = {name: [stated(median), log_std]}
        case "beta", [a, b, low, high]:
            form = {name: [a, b, stated(low), stated(high)]}
        case _:
            known = "a normal, uniform, triangular or beta distribution, or a lognormal one without location"
            raise ValueError(f"a study has no form for {name}; use {known}")
    return {**form, "unknown": True} if unknown else form


def _of_scipy(frozen: Any) -> tuple[str, list[float]]:
    """Return the name of a frozen distribution in a study, and its parameters there."""
    shapes, loc, scale = frozen.dist._parse_args(*frozen.args, **frozen.kwds)
    loc, scale = float(loc), float(scale)
    match frozen.dist.name, [float(shape) for shape in shapes]:
        case "norm", []:
            return "normal", [loc, scale]
        case "uniform", []:
            return "uniform", [loc, loc + scale]
        case "lognorm", [log_std] if loc == 0.0:
            return "lognormal", [scale, log_std]
        case "triang", [mode]:
            return "triangular", [loc, loc + mode * scale, loc + scale]
        case "beta", [a, b]:
            return "beta", [a, b, loc, loc + scale]
        case name, _:
            return f"{name} with loc = {loc}", []


def _of_new_scipy(distribution: Any) -> tuple[str, list[float]]:
    """Return the name of a distribution with parameters in a study, and its parameters there."""
    match type(distribution).__name__:
        case "Normal" | "StandardNormal":
            return "normal", [float(distribution.mu), float(distribution.sigma)]
        case "Uniform":
            return "uniform", [float(distribution.a), float(distribution.b)]
        case name:
            return name, []


def _of_openturns(distribution: Any) -> tuple[str, list[float]]:
    """Return the name of a distribution of OpenTURNS in a study, and its parameters there."""
    import openturns

    own = openturns.Distribution(distribution).getImplementation()
    match own.getClassName(), list(own.getParameter()):
        case "LogNormal", [log_median, log_std, 0.0]:
            return "lognormal", [math.exp(log_median), log_std]
        case "Normal" | "Uniform" | "Triangular" | "Beta" as name, parameters:
            return name.lower(), parameters
        case _:
            return str(distribution), []
