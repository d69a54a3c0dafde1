"""Height maps of measured and random surfaces."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from asperity import _core, _plots
from asperity._arrays import numbers
from asperity._record import Curves
from asperity.errors import warn

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from SurfaceTopography import Topography
    from surfalize import Surface

    from asperity.results import PartStatistics, SurfaceStatistics

_AS_MEASURED = {"level": "none", "outliers": 0, "lost": 0, "radius_m": None}
# Degrees of the polynomials with about as many parameters as the forms.
_DEGREES = {"none": -1, "mean": 0, "plane": 1, "quadratic": 2, "cylinder": 2, "sphere": 2}


@dataclass(frozen=True, kw_only=True, eq=False)
class Autocorrelation(Curves):
    """Correlation of the heights at the lags along both axes."""

    lag_x_m: NDArray[np.float64]
    """Lags along x, up to half the map."""
    acf_x: NDArray[np.float64]
    """Correlation at these lags, 1 at lag 0."""
    lag_y_m: NDArray[np.float64]
    """Lags along y."""
    acf_y: NDArray[np.float64]
    """Correlation at these lags."""
    correlation_length_x_m: float | None
    """Lag along x at which the correlation falls to 1/e."""
    correlation_length_y_m: float | None
    """Lag along y at which the correlation falls to 1/e."""
    variance_m2: float
    """Variance of the heights."""

    _curves: ClassVar[Mapping[str, str]] = {"acf_x": "lag_x_m", "acf_y": "lag_y_m"}

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the correlation along both axes."""
        return _plots.autocorrelation(self, ax)


@dataclass(frozen=True, kw_only=True, eq=False)
class RadialSpectrum(Curves):
    """Radially averaged power spectral density, two-sided, in rings of the width 2π/min(Lx, Ly).

    The sum of ``coefficients * psd_m4`` over the area Lx·Ly, with `psd_corners_m2`, is the mean square of the heights
    about their mean: of a periodogram under the window, Σw²z²/Σw², of a correlogram that of the map.
    """

    q_rad_per_m: NDArray[np.float64]
    """Mean wavenumber of each ring."""
    psd_m4: NDArray[np.float64]
    """Mean power spectral density of each ring; of a correlogram it may be negative where noise exceeds it."""
    psd_low_m4: NDArray[np.float64]
    """Lower end of its 95 % interval; NaN where the density is not positive."""
    psd_high_m4: NDArray[np.float64]
    """Upper end of its 95 % interval."""
    degrees_of_freedom: NDArray[np.float64]
    """Degrees of freedom of each mean."""
    coefficients: NDArray[np.float64]
    """Number of wavevectors of each ring."""
    psd_corners_m2: float
    """Variance of the wavevectors on no ring: beyond the last, and below the first of an oblong map."""
    method: str
    """``periodogram`` under a Hann window, with a resolution of two rings, where small voids are filled; or
    ``correlogram``, the transform of the autocovariance under a Parzen window, with a resolution of four, where larger
    voids would be seen in the spectrum."""
    reliable_low_rad_per_m: float
    """Lower end of the wavenumbers at which the spectrum shows the surface."""
    reliable_high_rad_per_m: float
    """Upper end of these wavenumbers."""
    upper_limit: str
    """Limit that sets the upper end: ``pixel``, ``roll_off`` or ``noise_floor``."""

    _curves: ClassVar[Mapping[str, str]] = {
        "psd_m4": "q_rad_per_m",
        "psd_low_m4": "q_rad_per_m",
        "psd_high_m4": "q_rad_per_m",
        "degrees_of_freedom": "q_rad_per_m",
        "coefficients": "q_rad_per_m",
    }

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the spectrum, with the wavenumbers at which it shows the surface."""
        return _plots.radial_spectrum(self, ax)


@dataclass(frozen=True, eq=False)
class HeightMap:
    """Heights on a regular grid; missing heights are NaN.

    `read` and `from_array` create maps. ``numpy.asarray`` of a map returns its heights, and ``scan[10:50, :]`` the map
    of some rows and columns.
    """

    heights: NDArray[np.float64]
    """Heights in metre, shape (ny, nx), row 0 at the top; read-only."""
    dx_m: float
    """Distance between points along x."""
    dy_m: float
    """Distance between points along y."""
    _history: Mapping[str, Any] = field(default_factory=lambda: _AS_MEASURED, kw_only=True, repr=False)

    def __post_init__(self) -> None:
        heights = numbers(self.heights)
        if heights.ndim != 2:  # noqa: PLR2004
            raise ValueError(f"the heights have the shape {heights.shape}, expected (ny, nx)")
        heights = _core.height_map(heights, self.dx_m, self.dy_m)
        heights.flags.writeable = False
        object.__setattr__(self, "heights", heights)

    @classmethod
    def _of(
        cls, heights: NDArray[np.float64], dx_m: float, dy_m: float, history: Mapping[str, Any] = _AS_MEASURED
    ) -> HeightMap:
        """Return the map of checked heights that nothing else changes, without a copy."""
        heights.flags.writeable = False
        own = object.__new__(cls)
        own.__dict__.update(heights=heights, dx_m=dx_m, dy_m=dy_m, _history=history)
        return own

    def __reduce__(self) -> tuple[Any, ...]:
        return HeightMap._of, (self.heights, self.dx_m, self.dy_m, self._history)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.heights, dtype, copy=copy)

    def __getitem__(self, place: tuple[slice, slice]) -> HeightMap:
        """Return the map of some rows and columns; steps multiply the distances between points.

        Raises
        ------
        TypeError
            `place` is not one slice of the rows and one of the columns.
        ValueError
            No rows or columns are left, or a step is negative.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> scan = asperity.HeightMap.from_array(np.zeros((6, 8)), dx_m=1e-6)
        >>> scan[:, 2:8:2]
        HeightMap(3 × 6 points, 2e-06 × 1e-06 m, 0 missing)
        """
        match place:
            case (slice() as rows, slice() as columns):
                steps = [part.indices(count)[2] for part, count in zip(place, self.shape, strict=True)]
            case _:
                raise TypeError(
                    f"found [{place!r}], expected slices of rows and columns, such as [10:50, :]; "
                    "single heights are in `heights`"
                )
        heights = self.heights[rows, columns]
        if min(steps) < 0 or heights.size == 0:
            raise ValueError(f"found [{rows}, {columns}], expected rising slices inside {self.shape}")
        dy_m, dx_m = steps[0] * self.dy_m, steps[1] * self.dx_m
        return HeightMap._of(np.ascontiguousarray(heights), dx_m, dy_m, self._history)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, HeightMap):
            return NotImplemented
        pitches = (self.dx_m, self.dy_m) == (other.dx_m, other.dy_m)
        return pitches and np.array_equal(self.heights, other.heights, equal_nan=True)

    __hash__ = None  # type: ignore[assignment]

    @staticmethod
    def read(
        path: str | os.PathLike[str],
        *,
        channel: str | int | None = None,
        dx_m: float | None = None,
        dy_m: float | None = None,
        height_unit: str | None = None,
        decimal: str | None = None,
    ) -> HeightMap:
        """Read a measured surface. The content of the file decides its format, not its name.

        Parameters
        ----------
        path
            File of a format that ``asperity formats`` lists.
        channel
            Map to read from a file that contains several: its name, or its number counted from 1.
        dx_m, dy_m
            Distance between points, required for files that store none; `dy_m` is `dx_m` when left out.
        height_unit
            Unit of the heights (``m``, ``mm``, ``um`` or ``nm``). Heights of files that state none count as metre; the
            unit is required if they would then exceed the field of view.
        decimal
            Decimal sign (``comma`` or ``point``) of a text file, required if every comma may be a decimal sign or
            separate thousands, as in ``1,234``.

        Raises
        ------
        OSError
            The file cannot be read.
        FormatError
            The file is damaged, or of a format that is not read.
        ValueError
            The file leaves open what an argument states, such as the unit of its heights.

        Examples
        --------
        >>> import asperity, numpy as np, pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     np.save(path := pathlib.Path(folder, "scan.npy"), [[0.0, 1.0], [0.5, 0.0]])
        ...     asperity.HeightMap.read(path, dx_m=2e-6, height_unit="um")
        HeightMap(2 × 2 points, 2e-06 × 2e-06 m, 0 missing)
        """
        name = None if channel is None else str(channel)
        heights, pitch_m, notes = _core.read_map(os.fspath(path), name, dx_m, dy_m, height_unit, decimal)
        for note in notes:
            warn(f"{path}: {note}")
        return HeightMap._of(heights, *pitch_m)

    @staticmethod
    def channels(path: str | os.PathLike[str]) -> list[str]:
        """Return the names of the maps of a file; empty for formats with a single map.

        Parameters
        ----------
        path
            File of a format that ``asperity formats`` lists.

        Raises
        ------
        OSError
            The file cannot be read.
        FormatError
            The file is damaged, or of a format that is not read.

        Examples
        --------
        >>> import asperity, pathlib, tempfile
        >>> scan = asperity.HeightMap([[0.0, 1e-6], [1e-6, 0.0]], dx_m=1e-6, dy_m=1e-6)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     scan.write(path := pathlib.Path(folder, "scan.gwy"))
        ...     asperity.HeightMap.channels(path)
        ['Height']
        """
        return _core.map_names(path)

    @staticmethod
    def from_array(z: ArrayLike, *, dx_m: float, dy_m: float | None = None) -> HeightMap:
        """Create a map.

        Parameters
        ----------
        z
            Heights in metre, shape (ny, nx). NaN, infinite and masked heights are missing.
        dx_m, dy_m
            Distance between points; `dy_m` is `dx_m` when left out.

        Raises
        ------
        ValueError
            The heights have another shape, all are missing, or a distance is not positive.

        Examples
        --------
        >>> import asperity
        >>> asperity.HeightMap.from_array([[0.0, 1e-6], [float("nan"), 2e-6]], dx_m=1e-6)
        HeightMap(2 × 2 points, 1e-06 × 1e-06 m, 1 missing)
        """
        dy_m = dx_m if dy_m is None else dy_m
        return HeightMap(numbers(z), dx_m, dy_m)

    @staticmethod
    def from_xarray(array: xarray.DataArray) -> HeightMap:
        """Create a map from an array with the dimensions y and x, such as that of `to_xarray`.

        The row with the smallest y is row 0, and the column with the smallest x column 0. The coordinates rise or fall
        in equal steps; their distance is the pixel size.

        Parameters
        ----------
        array
            Heights, with coordinates in metre; an attribute ``units`` other than ``m`` is an error.

        Raises
        ------
        ValueError
            Dimensions, steps or units differ from these.

        Examples
        --------
        >>> import asperity, xarray
        >>> y, x = [0.0, 1e-6], [0.0, 2e-6, 4e-6]
        >>> asperity.HeightMap.from_xarray(xarray.DataArray([[0.0, 1e-9, 0.0]] * 2, {"y": y, "x": x}, ("y", "x")))
        HeightMap(3 × 2 points, 2e-06 × 1e-06 m, 0 missing)
        """
        from asperity import interop

        return interop.from_xarray(array)

    @staticmethod
    def from_surfacetopography(topography: Topography) -> HeightMap:
        """Create a map from a ``Topography`` of SurfaceTopography, from its unit to metre.

        ``heights()[i, j]`` becomes the height in row j and column i, so that row 0 is the line that the readers of
        SurfaceTopography take from the top of the image. Undefined heights are missing. The periodic flag is dropped:
        the boundary is an argument of `asperity.solve_contact`.

        Parameters
        ----------
        topography
            Topography of two dimensions, with a unit.

        Raises
        ------
        ValueError
            The topography is a line, or has no unit.

        Examples
        --------
        >>> from SurfaceTopography import read_topography  # doctest: +SKIP
        >>> asperity.HeightMap.from_surfacetopography(read_topography("scan.x3p"))  # doctest: +SKIP
        """
        from asperity import interop

        return interop.from_surfacetopography(topography)

    @staticmethod
    def from_surfalize(surface: Surface) -> HeightMap:
        """Create a map from a ``Surface`` of surfalize, from micrometre to metre.

        Parameters
        ----------
        surface
            Rows and columns keep their order. Masked points and those that were not measured are missing.

        Raises
        ------
        ValueError
            All points are missing.

        Examples
        --------
        >>> import asperity, numpy as np, surfalize
        >>> asperity.HeightMap.from_surfalize(surfalize.Surface(np.zeros((3, 4)), 1.0, 1.0))
        HeightMap(4 × 3 points, 1e-06 × 1e-06 m, 0 missing)
        """
        from asperity import interop

        return interop.from_surfalize(surface)

    @property
    def is_prepared(self) -> bool:
        """Whether `level` made the map, so that it is not as measured."""
        return self._history != _AS_MEASURED

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of columns, (ny, nx)."""
        ny, nx = self.heights.shape
        return ny, nx

    def __repr__(self) -> str:
        """Return shape, pixel size and missing points."""
        missing = int(np.isnan(self.heights).sum())
        return (
            f"HeightMap({self.shape[1]} × {self.shape[0]} points, {self.dx_m:g} × {self.dy_m:g} m, {missing} missing)"
        )

    def fill(
        self,
        *,
        seed: int,
        level: str = "plane",
        covariance: Literal["measured", "fitted"] = "measured",
        marginal: Literal["measured", "normal"] = "measured",
        nugget: float = 0.0,
    ) -> HeightMap:
        """Return the map with random heights where they are missing, which continue the heights present.

        Heights that are present do not change. The result is one possible surface out of many, and a map as measured.

        Parameters
        ----------
        seed
            Seed of the random heights.
        level
            Form that is removed before and added back afterwards; see `level`.
        covariance
            Covariance of the random heights: that of the map, or the model that fits it best.
        marginal
            Their distribution: that of the heights present, or normal.
        nugget
            Variance of the measurement noise over that of the heights.

        Raises
        ------
        ValueError
            The map has too few heights, or an option is wrong.
        ResourceError
            Memory does not suffice.

        Examples
        --------
        >>> import asperity
        >>> size = {"rms_height_m": 1e-6, "size_m": 64e-6, "points": 64}
        >>> scan = asperity.artificial_surface(hurst=0.8, correlation_length_m=5e-6, seed=1, **size)
        >>> heights = scan.heights.copy()
        >>> heights[20:22, 30] = float("nan")
        >>> asperity.HeightMap(heights, scan.dx_m, scan.dy_m).fill(seed=1)
        HeightMap(64 × 64 points, 1e-06 × 1e-06 m, 0 missing)
        """
        options = {"seed": seed, "level": level, "covariance": covariance, "marginal": marginal, "nugget": nugget}
        return HeightMap(_core.fill(self.heights, self.dx_m, self.dy_m, options), self.dx_m, self.dy_m)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the map to a file.

        Missing heights are stored as such. GWY stores the heights without rounding.

        Parameters
        ----------
        path
            File, whose extension decides the format: ``.x3p``, ``.sur``, ``.sdf``, ``.gwy``, ``.npy``, ``.txt`` or
            ``.vti``.

        Raises
        ------
        FormatError
            The extension is that of no format that is written, or the map does not fit into the format.
        OSError
            The file cannot be written.

        Examples
        --------
        >>> import asperity, pathlib, tempfile
        >>> scan = asperity.HeightMap([[0.0, 1e-6], [1e-6, 0.0]], dx_m=1e-6, dy_m=1e-6)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     scan.write(path := pathlib.Path(folder, "scan.gwy"))
        ...     asperity.HeightMap.read(path) == scan
        True
        """
        _core.write_map(path, self.heights, self.dx_m, self.dy_m)

    def level(
        self,
        form: str = "plane",
        *,
        outliers: float | None = None,
        s_filter_m: float | None = None,
        l_filter_m: float | None = None,
        robust: bool = False,
    ) -> HeightMap:
        """Return the roughness: the map without form, outliers and filtered waves.

        Parameters
        ----------
        form
            ``none``, ``mean``, ``plane``, ``quadratic``, ``polynomial:N``, ``cylinder`` or ``sphere``.
        outliers
            Heights farther from the median than this many robust standard deviations become missing.
        s_filter_m, l_filter_m
            Cut-offs of the Gaussian filters of ISO 16610-61 that remove shorter, and longer, waves.
        robust
            Whether the L-filter resists grooves and spikes (ISO 16610-71).

        Raises
        ------
        ValueError
            The form is not known or the heights do not determine it, or a cut-off is not between pixel and field.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> y, x = np.mgrid[:4, :5]
        >>> tilted = asperity.HeightMap.from_array(1e-6 * x - 2e-6 * y, dx_m=1e-6)
        >>> bool(abs(tilted.level("plane").heights).max() < 1e-18)
        True
        """
        steps = {
            "level": form,
            "outliers": outliers,
            "s_filter_m": s_filter_m,
            "l_filter_m": l_filter_m,
            "robust": robust,
        }
        heights, history = _core.level(self.heights, self.dx_m, self.dy_m, steps)
        if history["lost"]:
            warn(f"the robust filter found no surface around {history['lost']} heights; they count as missing")
        return HeightMap._of(heights, self.dx_m, self.dy_m, _joined(self._history, history))

    def statistics(self) -> SurfaceStatistics:
        """Return ISO 25178-2 parameters, correlation lengths and the fractal dimension, with 95 % intervals.

        The attributes are the keys of ``asperity surface stats --json``, with SI units in their names. Nothing is
        removed before; see `level`.

        Raises
        ------
        ValueError
            All heights are equal.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> wave = 1e-6 * np.sin(2 * np.pi * np.arange(64) / 16) * np.ones((64, 1))
        >>> found = asperity.HeightMap.from_array(wave, dx_m=1e-6).statistics()
        >>> round(found.Sq_m / 1e-6 * 2**0.5, 12)
        1.0
        """
        from asperity.results import SurfaceStatistics

        return SurfaceStatistics.from_dict(_core.statistics(self.heights, self.dx_m, self.dy_m, dict(self._history)))

    def acf(self) -> Autocorrelation:
        """Return the autocorrelation along both axes, at lags in metre up to half the map.

        Raises
        ------
        ValueError
            All heights are equal.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> wave = 1e-6 * np.cos(2 * np.pi * np.arange(64) / 16) * np.ones((64, 1))
        >>> found = asperity.HeightMap.from_array(wave, dx_m=1e-6).acf()
        >>> round(float(found.acf_x[16]), 6), round(float(found.acf_x[8]), 6)
        (1.0, -1.0)
        """
        return Autocorrelation.from_dict(_core.acf(self.heights, self.dx_m, self.dy_m))

    def psd(self) -> RadialSpectrum:
        """Return the radially averaged power spectral density in m⁴ over the wavenumber in rad/m.

        Raises
        ------
        ValueError
            All heights are equal.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> wave = 1e-6 * np.cos(2 * np.pi * np.arange(64) / 16) * np.ones((64, 1))
        >>> found = asperity.HeightMap.from_array(wave, dx_m=1e-6).psd()
        >>> round(2 * np.pi / float(found.q_rad_per_m[found.psd_m4.argmax()]) / 1e-6)  # µm
        16
        """
        return RadialSpectrum.from_dict(_core.psd(self.heights, self.dx_m, self.dy_m))

    def to_xarray(self) -> xarray.DataArray:
        """Return the heights with the coordinates of the cell centres in metre; y rises with the row, as in `plot`.

        Examples
        --------
        >>> import asperity
        >>> asperity.HeightMap.from_array([[0.0, 1e-6], [0.0, 2e-6]], dx_m=1e-6).to_xarray().x.values
        array([5.0e-07, 1.5e-06])
        """
        return field_to_xarray(self.heights, self.dx_m, self.dy_m, name="height", unit="m")

    def to_surfacetopography(self, *, periodic: bool = False) -> Topography:
        """Return the map as a ``Topography`` of SurfaceTopography, in metre; missing heights are masked.

        The heights keep their bits. SurfaceTopography stores the size of the map, so its pixel size may differ from
        `dx_m` in the last bit.

        Parameters
        ----------
        periodic
            Whether the surface continues periodically beyond the edge of the map.

        Examples
        --------
        >>> import asperity
        >>> scan = asperity.HeightMap.from_array([[0.0, 1e-6], [0.0, 2e-6]], dx_m=1e-6)
        >>> scan.to_surfacetopography().rms_height_from_area()  # doctest: +SKIP
        """
        from asperity import interop

        return interop.to_surfacetopography(self, periodic)

    def to_surfalize(self) -> Surface:
        """Return the map as a ``Surface`` of surfalize.

        surfalize has micrometre as its unit, so that heights may change in the last bit when they return to metre.

        Examples
        --------
        >>> import asperity
        >>> round(asperity.HeightMap.from_array([[0.0, 1e-6], [0.0, 2e-6]], dx_m=3e-6).to_surfalize().step_x, 9)
        3.0
        """
        from asperity import interop

        return interop.to_surfalize(self)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the heights; the colours span all but the extreme 0.2 % of them.

        Parameters
        ----------
        ax
            Axes of matplotlib; new ones when left out.

        Examples
        --------
        >>> import asperity
        >>> asperity.HeightMap.from_array([[0.0, 1e-6], [0.0, 2e-6]], dx_m=1e-6).plot().get_xlabel()
        'x (µm)'
        """
        return _plots.heights(self.heights, self.dx_m, self.dy_m, ax)


def pooled_statistics(scans: Sequence[HeightMap]) -> PartStatistics:
    """Return the statistics of a part from scans at several places, with 95 % intervals that include its variation.

    Parameters
    ----------
    scans
        Two or more levelled scans; each counts as one place.

    Raises
    ------
    ValueError
        There are fewer than two scans, or the heights of one are all equal.

    Examples
    --------
    >>> import asperity
    >>> like = {"rms_height_m": 1e-6, "hurst": 0.8, "size_m": 1e-4, "points": 64, "correlation_length_m": 5e-6}
    >>> scans = [asperity.artificial_surface(**like, seed=seed) for seed in range(3)]
    >>> found = asperity.pooled_statistics(scans)
    >>> found.scan_count, found.Sq_m_interval[0] < 1e-6 < found.Sq_m_interval[1]
    (3, True)
    """
    from asperity.results import PartStatistics

    given = [(scan.heights, scan.dx_m, scan.dy_m, dict(scan._history)) for scan in scans]
    return PartStatistics.from_dict(_core.pooled_statistics(given))


def _joined(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """Return what two preparations did: the highest form, and the sums of the points that they removed."""

    def degree(history: Mapping[str, Any]) -> int:
        form = history["level"]
        return _DEGREES[form] if form in _DEGREES else int(form.removeprefix("polynomial:"))

    return {
        "level": max(first, second, key=degree)["level"],
        "outliers": first["outliers"] + second["outliers"],
        "lost": first["lost"] + second["lost"],
        "radius_m": second["radius_m"] if first["radius_m"] is None else first["radius_m"],
    }


def field_to_xarray(values: NDArray[np.float64], dx_m: float, dy_m: float, *, name: str, unit: str) -> xarray.DataArray:
    """Return a field on a grid with the coordinates of the cell centres."""
    import xarray

    ny, nx = values.shape
    coordinates = {"y": (np.arange(ny) + 0.5) * dy_m, "x": (np.arange(nx) + 0.5) * dx_m}
    array = xarray.DataArray(values, coordinates, ("y", "x"), name, {"units": unit})
    for axis in ("x", "y"):
        array[axis].attrs["units"] = "m"
    return array
