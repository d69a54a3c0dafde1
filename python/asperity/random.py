"""Random surfaces: stated, or like measured ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from numpy.typing import ArrayLike

from asperity import _core
from asperity._arrays import numbers
from asperity._record import Made
from asperity.surface import HeightMap

if TYPE_CHECKING:
    from asperity.results import CovarianceResult

T = TypeVar("T", int, float)
Boundary = Literal["free", "periodic"]
Size = float | tuple[float, float]
"""Length along both axes, or along x and y."""
Points = int | tuple[int, int]
"""Number along both axes, or along x and y."""


@dataclass(frozen=True, kw_only=True)
class Covariance:
    """Stationary correlation of the heights."""

    model: Literal["exponential", "squared_exponential", "matern", "self_affine"]
    """Shape of the correlation."""
    correlation_length_m: Size
    """Length of the model: the lag at which the correlation is 1/e for ``exponential`` and ``squared_exponential``, the
    scale for ``matern``, the roll-off length for ``self_affine``.
    """
    hurst: float | None = None
    """Hurst exponent of ``self_affine``."""
    smoothness: float | None = None
    """Smoothness ν of ``matern``."""

    def _settings(self) -> dict[str, object]:
        parameter = {"matern": ("nu", self.smoothness), "self_affine": ("hurst", self.hurst)}.get(self.model)
        if parameter is None:
            return {"model": self.model, "lengths_m": _pair(self.correlation_length_m)}
        name, value = parameter
        if value is None:
            raise ValueError(f"the covariance {self.model} needs {'smoothness' if name == 'nu' else name}")
        return {"model": {self.model: {name: value}}, "lengths_m": _pair(self.correlation_length_m)}


class RandomSurface(Made):
    """Random surface on a grid, a function of standard normal variables ξ."""

    def __init__(self, model: SurfaceModel, size_m: Size, points: Points, boundary: Boundary) -> None:
        self._make(model, _pair(size_m), _pair(points), boundary)

    def _make(self, *state: Any) -> None:
        self._state = state
        model, size_m, points, boundary = state
        self._own: _core.RandomSurface = model._own.on_grid(*points, *size_m, boundary)
        self.dx_m, self.dy_m = self._own.pitch_m()

    def __getstate__(self) -> tuple[Any, ...]:
        return self._state

    @property
    def xi_len(self) -> int:
        """Number of standard normal variables of a map."""
        return self._own.xi_len()

    def sample(self, seed: int, count: int = 1) -> list[HeightMap]:
        """Draw maps.

        Parameters
        ----------
        seed, count
            Map number i depends on the seed and i alone, and is that of ``asperity surface generate``.

        Raises
        ------
        ResourceError
            Memory does not suffice.

        Examples
        --------
        >>> import asperity
        >>> covariance = asperity.Covariance(model="exponential", correlation_length_m=20e-6)
        >>> field = asperity.Spectral(covariance=covariance, rms_height_m=1e-6, size_m=200e-6, points=64)
        >>> field.sample(seed=1, count=2)[0]
        HeightMap(64 × 64 points, 3.125e-06 × 3.125e-06 m, 0 missing)
        """
        return [HeightMap._of(heights, self.dx_m, self.dy_m) for heights in self._own.sample(seed, count)]

    def generate(self, xi: ArrayLike) -> HeightMap:
        """Return the map of given variables, linear in them if the heights are normal.

        Parameters
        ----------
        xi
            Standard normal variables, shape (`xi_len`,), from the largest variance to the least.

        Raises
        ------
        ValueError
            There are more or fewer, or one is not finite.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> covariance = asperity.Covariance(model="exponential", correlation_length_m=20e-6)
        >>> field = asperity.Spectral(covariance=covariance, rms_height_m=1e-6, size_m=200e-6, points=64)
        >>> float(field.generate(np.zeros(field.xi_len)).heights.max())
        0.0
        """
        heights = self._own.generate(numbers(xi))
        return HeightMap._of(heights, self.dx_m, self.dy_m)


class Spectral(RandomSurface):
    """Normal field with a covariance, by circulant embedding.

    Examples
    --------
    >>> import asperity
    >>> covariance = asperity.Covariance(model="exponential", correlation_length_m=20e-6)
    >>> field = asperity.Spectral(covariance=covariance, rms_height_m=1e-6, size_m=200e-6, points=64)
    >>> first, second = field.sample(seed=1, count=2)
    >>> first
    HeightMap(64 × 64 points, 3.125e-06 × 3.125e-06 m, 0 missing)
    """

    def __init__(
        self, *, covariance: Covariance, rms_height_m: float, size_m: Size, points: Points, boundary: Boundary = "free"
    ) -> None:
        settings = _translated("spectral", covariance, rms_height_m, "normal")
        super().__init__(SurfaceModel(settings), size_m, points, boundary)


class KarhunenLoeve(RandomSurface):
    """Normal field as a truncated Karhunen-Loève expansion; left out, `modes` contain 90 % of the slope variance.

    Examples
    --------
    >>> import asperity
    >>> covariance = asperity.Covariance(model="squared_exponential", correlation_length_m=50e-6)
    >>> field = asperity.KarhunenLoeve(covariance=covariance, rms_height_m=1e-6, size_m=200e-6, points=32)
    >>> field.xi_len < 32 * 32
    True
    """

    def __init__(
        self,
        *,
        covariance: Covariance,
        rms_height_m: float,
        size_m: Size,
        points: Points,
        modes: int | None = None,
        boundary: Boundary = "free",
    ) -> None:
        settings = _translated("karhunen_loeve", covariance, rms_height_m, "normal")
        super().__init__(SurfaceModel({**settings, "modes": modes}), size_m, points, boundary)


class Translation(RandomSurface):
    """Field whose heights have a marginal distribution, translated from a normal field.

    Parameters
    ----------
    marginal
        Shape of the distribution of heights, such as ``beta:2.1,5``.
    translation
        ``plain`` gives the normal field the covariance, ``corrected`` the heights.

    Examples
    --------
    >>> import asperity
    >>> covariance = asperity.Covariance(model="exponential", correlation_length_m=20e-6)
    >>> grid = {"size_m": 200e-6, "points": 64}
    >>> field = asperity.Translation(covariance=covariance, rms_height_m=1e-6, marginal="beta:2.1,5", **grid)
    >>> bool(abs(field.sample(seed=1)[0].heights).max() < 5e-6)
    True
    """

    def __init__(
        self,
        *,
        covariance: Covariance,
        rms_height_m: float,
        marginal: str,
        size_m: Size,
        points: Points,
        translation: Literal["plain", "corrected"] = "plain",
        boundary: Boundary = "free",
    ) -> None:
        settings = _translated("spectral", covariance, rms_height_m, marginal)
        model = SurfaceModel({**settings, "translation": translation})
        super().__init__(model, size_m, points, boundary)


class WeierstrassMandelbrot(RandomSurface):
    """Fractal surface: a sum of cosines of random phase, of dimension between 2 and 3.

    Examples
    --------
    >>> import asperity
    >>> field = asperity.WeierstrassMandelbrot(rms_height_m=1e-6, fractal_dimension=2.3, size_m=1e-4, points=64)
    >>> field.sample(seed=1)[0]
    HeightMap(64 × 64 points, 1.5625e-06 × 1.5625e-06 m, 0 missing)
    """

    def __init__(self, *, rms_height_m: float, fractal_dimension: float, size_m: Size, points: Points) -> None:
        settings = {
            "generator": "weierstrass_mandelbrot",
            "rms_height_m": rms_height_m,
            "fractal_dimension": fractal_dimension,
        }
        super().__init__(SurfaceModel(settings), size_m, points, "free")


class SurfaceModel(Made):
    """Random surface with the statistics of measured ones; see `fit`."""

    def __init__(self, settings: dict[str, object], scans: Sequence[HeightMap] = ()) -> None:
        self._make(settings, list(scans))

    def _make(self, *state: Any) -> None:
        self._state = state
        settings, scans = state
        measured = [(scan.heights, scan.dx_m, scan.dy_m, dict(scan._history)) for scan in scans]
        self._own = _core.SurfaceModel(settings, measured)

    def __getstate__(self) -> tuple[Any, ...]:
        return self._state

    @staticmethod
    def fit(
        scans: HeightMap | Sequence[HeightMap],
        *,
        generator: Literal["karhunen_loeve", "spectral", "weierstrass_mandelbrot"] = "karhunen_loeve",
        marginal: str = "measured",
        translation: Literal["plain", "corrected"] = "plain",
        modes: int | None = None,
    ) -> SurfaceModel:
        """Fit a random surface to one or several scans of a part. Remove the form of the scans before.

        Parameters
        ----------
        scans
            The levelled scans.
        generator
            Kind of random surface.
        marginal
            ``measured``, or the shape of a distribution such as ``normal``.
        translation
            Process with the measured covariance: the underlying normal field, or the heights.
        modes
            Number of terms of a Karhunen-Loève expansion.

        Raises
        ------
        ValueError
            The scans do not show what the surface needs, such as a correlation length within their field.

        Examples
        --------
        >>> import asperity
        >>> scan = asperity.artificial_surface(
        ...     rms_height_m=1e-6, hurst=0.8, size_m=1e-4, points=128, correlation_length_m=1e-5, seed=1
        ... )
        >>> asperity.SurfaceModel.fit(scan, generator="spectral").covariance is None
        False
        """
        maps = [scans] if isinstance(scans, HeightMap) else scans
        settings: dict[str, object] = {
            "generator": generator,
            "marginal": None if marginal == "measured" else marginal,
            "modes": modes,
        }
        if generator != "weierstrass_mandelbrot":
            settings["translation"] = translation
        return SurfaceModel(settings, maps)

    @property
    def rms_height_m(self) -> float:
        """Standard deviation of the heights."""
        return self._own.rms_height_m()

    @property
    def covariance(self) -> CovarianceResult | None:
        """Selected covariance; None for a Weierstrass-Mandelbrot surface."""
        from asperity.results import CovarianceResult

        found = self._own.covariance()
        return None if found is None else CovarianceResult.from_dict(found)

    def on_grid(self, *, size_m: Size, points: Points, boundary: Boundary = "free") -> RandomSurface:
        """Return the generator of maps of a size.

        Parameters
        ----------
        size_m, points
            Side in metre and number of points, or both along x and y.
        boundary
            ``free``, or ``periodic`` maps that continue beyond their edges.

        Raises
        ------
        ValueError
            A number is not positive, or the model has no such map.

        Examples
        --------
        >>> import asperity
        >>> scan = asperity.artificial_surface(
        ...     rms_height_m=1e-6, hurst=0.8, size_m=1e-4, points=128, correlation_length_m=1e-5, seed=1
        ... )
        >>> model = asperity.SurfaceModel.fit(scan, generator="spectral")
        >>> model.on_grid(size_m=5e-5, points=64).sample(seed=1)[0]
        HeightMap(64 × 64 points, 7.8125e-07 × 7.8125e-07 m, 0 missing)
        """
        return RandomSurface(self, size_m, points, boundary)


def artificial_surface(
    *,
    rms_height_m: float,
    hurst: float,
    size_m: Size,
    points: Points,
    correlation_length_m: Size,
    seed: int,
) -> HeightMap:
    """Draw a periodic self-affine surface.

    Its power spectral density falls as (1 + (qℓ)²)^(−1−H).

    Parameters
    ----------
    rms_height_m
        Standard deviation of the heights.
    hurst
        Hurst exponent H, between 0 and 1.
    size_m, points
        Side and number of points, or both along x and y.
    correlation_length_m
        Roll-off length ℓ, or that along x and y.
    seed
        Seed of the map.

    Raises
    ------
    ValueError
        A number is out of its range.

    Examples
    --------
    >>> import asperity
    >>> asperity.artificial_surface(
    ...     rms_height_m=1e-6, hurst=0.8, size_m=1e-4, points=128, correlation_length_m=1e-5, seed=1
    ... )
    HeightMap(128 × 128 points, 7.8125e-07 × 7.8125e-07 m, 0 missing)
    """
    covariance = Covariance(model="self_affine", hurst=hurst, correlation_length_m=correlation_length_m)
    field = Spectral(
        covariance=covariance, rms_height_m=rms_height_m, size_m=size_m, points=points, boundary="periodic"
    )
    return field.sample(seed)[0]


def _translated(generator: str, covariance: Covariance, rms_height_m: float, marginal: str) -> dict[str, object]:
    return {
        "generator": generator,
        "covariance": covariance._settings(),
        "rms_height_m": rms_height_m,
        "marginal": marginal,
    }


def _pair(value: T | tuple[T, T]) -> tuple[T, T]:
    return value if isinstance(value, tuple) else (value, value)
