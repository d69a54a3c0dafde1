"""Contact of a rough surface with a rigid flat."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity import _core, _plots
from asperity._arrays import numbers
from asperity._record import Record, frame, row, unit_of
from asperity.surface import HeightMap, field_to_xarray

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

FIELDS = ("pressure_pa", "displacement_m", "gap_m", "plastic_displacement_m")


@dataclass(frozen=True, kw_only=True, eq=False)
class ContactSolution(Record):
    """A solved contact. The names are those of ``asperity contact --json``; fields have the shape (ny, nx)."""

    pressure_pa: NDArray[np.float64]
    """Normal pressure, positive in compression."""
    displacement_m: NDArray[np.float64]
    """Elastic displacement, positive away from the flat."""
    gap_m: NDArray[np.float64]
    """Distance between the deformed surface and the flat, 0 in contact."""
    plastic_displacement_m: NDArray[np.float64]
    """Overlap that elastic deformation alone leaves where the pressure is the hardness."""
    contact_fraction: float
    """Fraction of the cells with pressure."""
    contact_fraction_corrected: float | None
    """Fraction of the area in contact, corrected for cells at the border of the contact."""
    plastic_fraction: float
    """Fraction of the cells at the hardness."""
    mean_pressure_pa: float
    """Mean pressure over the whole map."""
    load_n: float
    """Total force on the map."""
    max_pressure_pa: float
    """Highest pressure."""
    mean_gap_m: float
    """Mean gap over the whole map."""
    separation_m: float
    """Height of the flat above the mean of the undeformed heights."""
    penetration_m: float
    """Depth of the flat below the highest undeformed point."""
    mean_compliance_m_per_pa: float | None
    """Displacement of the mean plane per mean pressure of a periodic surface."""
    clusters: int
    """Number of clusters: groups of contact cells that share edges."""
    largest_cluster_fraction: float | None
    """Fraction of the cells in contact that belong to the largest cluster."""
    largest_cluster_m2: float
    """Area of the largest cluster."""
    cluster_labels: NDArray[np.uint32]
    """Cluster of each cell, counted from 1; 0 out of contact."""
    elastic_energy_j: float
    """Elastic energy ½ Σ p u, with that of the stated mean compliance."""
    plastic_work_j: float
    """Plastic work: the hardness times the displaced volume."""
    contact_modulus_pa: float
    """Contact modulus E* of the pair; at the surface of a layer."""
    rms_gradient: float
    """Root mean square gradient of the heights by forward differences."""
    persson_contact_fraction: float | None
    """Contact fraction of Persson's theory, erf(√2 p/(E* h′)) without a hardness; of a half-space only."""
    persson_plastic_fraction: float | None
    """Fraction at the hardness in Persson's theory."""
    bgt_contact_fraction: float | None
    """Contact fraction of Bush, Gibson and Thomas for light elastic contact, √(2π) p/(E* h′)."""
    contact_stiffness_n_per_m: float | None = None
    """Load per approach, if computed; None also in complete contact, where it is infinite."""
    contact_stiffness_pa_per_m: float | None = None
    """Mean pressure per approach, if computed."""
    iterations: int
    """Iterations of the solver."""
    residual: float
    """Largest relative residual, computed afresh from the pressure."""
    dx_m: float
    """Distance between points along x."""
    dy_m: float
    """Distance between points along y."""
    over: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    """Name and values of what is prescribed, if there are several. All other numbers are then arrays over these values,
    and fields have the shape (values, ny, nx).
    """

    def __getitem__(self, place: int) -> ContactSolution:
        """Return the solution at one of several prescribed values, counted from 0."""
        if not self.over:
            raise TypeError("the solution is that of one prescribed value")
        own = {each.name: getattr(self, each.name) for each in fields(self)}
        one = {name: value[place] if isinstance(value, np.ndarray) else value for name, value in own.items()}
        plain = {name: value.item() if isinstance(value, np.generic) else value for name, value in one.items()}
        return ContactSolution(**plain | {"over": {}})

    def _values(self) -> dict[str, Any]:
        return {name: value for name, value in super()._values().items() if self.over or name != "over"}

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the numbers as a data frame with a row, or with a row for each of several prescribed values.

        Fields are left out; the units are in the names.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> wave = 1e-6 * np.cos(2 * np.pi * np.arange(16) / 16) * np.ones((16, 1))
        >>> found = asperity.solve_contact(wave, dx_m=1e-6, modulus_pa=1e9, mean_pressure_pa=[1e6, 2e6])
        >>> list(found.to_dataframe().mean_pressure_pa)
        [1000000.0, 2000000.0]
        """
        if not self.over:
            return super().to_dataframe()
        ((along, values),) = self.over.items()
        return frame([row(self[place]) | {along: value} for place, value in enumerate(values)])

    def to_xarray(self) -> xarray.Dataset:
        """Return the fields with the coordinates of the cell centres; over several values also the numbers.

        Units are attributes, coordinates are in metre.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> wave = 1e-6 * np.cos(2 * np.pi * np.arange(16) / 16) * np.ones((16, 1))
        >>> found = asperity.solve_contact(wave, dx_m=1e-6, modulus_pa=1e9, mean_pressure_pa=1e6)
        >>> found.to_xarray().pressure_pa.attrs["units"]
        'Pa'
        """
        import xarray

        if not self.over:
            arrays = (
                field_to_xarray(getattr(self, name), self.dx_m, self.dy_m, name=name, unit=unit_of(name))
                for name in FIELDS
            )
            return xarray.Dataset({str(array.name): array for array in arrays})
        ((along, values),) = self.over.items()
        own = {each.name: getattr(self, each.name) for each in fields(self) if each.name != along}
        curves = {name: (along, value, {"units": unit_of(name)}) for name, value in own.items() if np.ndim(value) == 1}
        solutions = [self[place].to_xarray() for place in range(len(values))]
        coordinate = xarray.DataArray(values, dims=along, attrs={"units": unit_of(along)}, name=along)
        return xarray.concat(solutions, dim=coordinate).assign(curves)

    def plot(self, field: str = "pressure_pa", *, ax: Axes | None = None) -> Axes:
        """Draw a field over the map, in SI with a prefix.

        Parameters
        ----------
        field
            ``pressure_pa``, ``displacement_m``, ``gap_m`` or ``plastic_displacement_m``.
        ax
            Axes of matplotlib; new ones when left out.

        Raises
        ------
        ValueError
            The field is none of these, or the solution is over several prescribed values.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> wave = 1e-6 * np.cos(2 * np.pi * np.arange(16) / 16) * np.ones((16, 1))
        >>> found = asperity.solve_contact(wave, dx_m=1e-6, modulus_pa=1e9, mean_pressure_pa=1e6)
        >>> found.plot("gap_m").get_xlabel()
        'x (µm)'
        """
        if field not in FIELDS:
            raise ValueError(f"found {field}, expected one of {', '.join(FIELDS)}")
        if self.over:
            raise ValueError("choose one of the prescribed values, such as solution[0]")
        name = field.rpartition("_")[0].replace("_", " ")
        return _plots.field(getattr(self, field), self.dx_m, self.dy_m, name=name, unit=unit_of(field), ax=ax)


def _stacked(values: list[Any]) -> NDArray[Any]:
    return np.array([math.nan if value is None else value for value in values])


def solve_contact(
    heights: HeightMap | ArrayLike,
    *,
    dx_m: float | None = None,
    dy_m: float | None = None,
    modulus_pa: float | None = None,
    youngs_modulus_pa: float | None = None,
    poisson_ratio: float | None = None,
    counterface: HeightMap | ArrayLike | None = None,
    counterface_as_laid: bool = False,
    counterface_youngs_modulus_pa: float | None = None,
    counterface_poisson_ratio: float | None = None,
    layer_thickness_m: float | None = None,
    base_youngs_modulus_pa: float | None = None,
    base_poisson_ratio: float | None = None,
    penetration_m: float | ArrayLike | None = None,
    percentile: float | ArrayLike | None = None,
    mean_pressure_pa: float | ArrayLike | None = None,
    load_n: float | ArrayLike | None = None,
    mean_gap_m: float | ArrayLike | None = None,
    hardness_pa: float | None = None,
    boundary: Literal["periodic", "free"] = "periodic",
    mean_compliance_m_per_pa: float | None = None,
    stiffness: bool = False,
    tolerance: float | None = None,
) -> ContactSolution:
    """Press a rough elastic or elasto-plastic surface against a rigid flat, or against a rough or elastic counterface.

    Parameters
    ----------
    heights
        A `HeightMap`, or heights in metre of shape (ny, nx). No height may be missing.
    dx_m, dy_m
        Distance between points, of an array; `dy_m` is `dx_m` when left out.
    modulus_pa, youngs_modulus_pa, poisson_ratio
        Contact modulus E* = E/(1 − ν²), or Young's modulus E with Poisson's ratio ν (0.3 when left out).
    counterface
        Heights of the other body on the same grid, outwards from its own material; flat when left out.
    counterface_as_laid
        The map of the counterface is in the coordinates of the surface. Otherwise it is turned over to face the
        surface, so that its last column lies on the first column of the surface.
    counterface_youngs_modulus_pa, counterface_poisson_ratio
        Material of the counterface, rigid when left out.
    layer_thickness_m
        Thickness of the surface's material, bonded to a base; a half-space when left out.
    base_youngs_modulus_pa, base_poisson_ratio
        Material of the base, rigid when left out.
    penetration_m, percentile, mean_pressure_pa, load_n, mean_gap_m
        Exactly one: depth of the flat below the highest point, percentage of the heights above the flat, mean pressure,
        total force, or mean gap. Several values, in one dimension, are solved one after another, each from the
        solution before it. The first has the bits of a single call, the others are equal to it within the tolerance.
    hardness_pa
        Upper bound of the pressure; the contact is elastic when left out.
    boundary
        Continuation of the surface beyond the edge of the map.
    mean_compliance_m_per_pa
        Displacement of the mean plane per mean pressure of a periodic surface. When left out: max(L)/(πE*) if the
        position of the flat is prescribed, otherwise 0.
    stiffness
        Also compute the contact stiffness.
    tolerance
        Bound on the relative residuals, 1e-8 when left out.

    Raises
    ------
    ValueError
        A height is missing, all are equal, a number is out of its range, or what is prescribed is not one quantity.
    NotConvergedError
        The residuals stay above the tolerance.
    ResourceError
        Memory does not suffice.

    Examples
    --------
    A sphere, against the solution of Hertz.

    >>> import asperity, numpy as np
    >>> x = np.linspace(-100e-6, 100e-6, 65)
    >>> sphere = -(x**2 + x[:, None] ** 2) / (2 * 10e-3)
    >>> found = asperity.solve_contact(sphere, dx_m=x[1] - x[0], modulus_pa=230e9, load_n=10, boundary="free")
    >>> hertz = (6 * 10 * 230e9**2 / (np.pi**3 * 10e-3**2)) ** (1 / 3)
    >>> bool(abs(found.max_pressure_pa / hertz - 1) < 0.02)
    True

    Several loads.

    >>> found = asperity.solve_contact(sphere, dx_m=x[1] - x[0], modulus_pa=230e9, load_n=[5, 10, 20], boundary="free")
    >>> found.contact_fraction.shape, found.pressure_pa.shape, round(found[1].load_n, 9)
    ((3,), (3, 65, 65), 10.0)
    """
    if isinstance(heights, HeightMap):
        if dx_m is not None or dy_m is not None:
            raise ValueError("a HeightMap has its own dx_m and dy_m")
        dx_m, dy_m, heights = heights.dx_m, heights.dy_m, heights.heights
    if dx_m is None:
        raise ValueError("state dx_m, the distance between points")
    dy_m = dx_m if dy_m is None else dy_m
    prescribed = {
        "penetration_m": penetration_m,
        "percentile": percentile,
        "mean_pressure_pa": mean_pressure_pa,
        "load_n": load_n,
        "mean_gap_m": mean_gap_m,
    }
    settings = {
        "modulus_pa": modulus_pa,
        "youngs_modulus_pa": youngs_modulus_pa,
        "poisson_ratio": poisson_ratio,
        "counterface_as_laid": counterface_as_laid,
        "counterface_youngs_modulus_pa": counterface_youngs_modulus_pa,
        "counterface_poisson_ratio": counterface_poisson_ratio,
        "layer_thickness_m": layer_thickness_m,
        "base_youngs_modulus_pa": base_youngs_modulus_pa,
        "base_poisson_ratio": base_poisson_ratio,
        "stiffness": stiffness,
        **prescribed,
        "hardness_pa": hardness_pa,
        "boundary": boundary,
        "mean_compliance_m_per_pa": mean_compliance_m_per_pa,
        "tolerance": tolerance,
    }
    own = numbers(heights)
    if isinstance(counterface, HeightMap):
        if (counterface.dx_m, counterface.dy_m) != (dx_m, dy_m):
            raise ValueError("the counterface has other distances between points than the surface")
        counterface = counterface.heights
    other = None if counterface is None else numbers(counterface)

    def solved(settings: dict[str, Any], start: NDArray[np.float64] | None) -> dict[str, Any]:
        found: dict[str, Any] = _core.solve_contact(own, dx_m, dy_m, settings, other, start)
        # What does not converge is an error.
        del found["converged"]
        return found

    several = {name: numbers(value) for name, value in prescribed.items() if value is not None and np.ndim(value)}
    if not several:
        return ContactSolution(**solved(settings, None), dx_m=dx_m, dy_m=dy_m)
    name, values = several.popitem()
    if several or values.ndim != 1 or not len(values):
        raise ValueError(f"{name} has the shape {values.shape}; one quantity may have several values, in one dimension")
    found: list[dict[str, Any]] = []
    for value in values:
        start = found[-1]["pressure_pa"] if found else None
        found.append(solved(settings | {name: float(value)}, start))
    same = ("mean_compliance_m_per_pa", "contact_modulus_pa", "rms_gradient")
    stacked: dict[str, Any] = {
        key: found[0][key] if key in same else _stacked([each[key] for each in found]) for key in found[0]
    }
    return ContactSolution(**stacked, dx_m=dx_m, dy_m=dy_m, over={name: values})
