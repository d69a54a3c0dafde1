"""Samplers, and polynomial chaos expansions of functions of independent random variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity import _core, _plots
from asperity._arrays import numbers
from asperity._record import Curves, Made
from asperity._variables import Variable, arguments, nodes_of, variables_of
from asperity.errors import warn

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

Sampler = Literal["monte_carlo", "latin_hypercube", "maximin_latin_hypercube", "sobol"]


def design(
    method: Sampler,
    *,
    seed: int,
    samples: int,
    variables: int | None = None,
    distributions: Sequence[Any] | None = None,
) -> NDArray[np.float64]:
    """Return the points of a design, shape (samples, variables).

    Parameters
    ----------
    method
        Sampler.
    seed
        Seed of the points.
    samples
        Number of points.
    variables
        Number of variables. It may be left out if there are `distributions`.
    distributions
        Distribution of each variable, see `Expansion.fit`; standard normal if left out.

    Raises
    ------
    ValueError
        The sampler does not exist, or `variables` and `distributions` contradict each other.

    Examples
    --------
    >>> import asperity, math
    >>> xi = asperity.design("latin_hypercube", seed=1, samples=10, variables=2)
    >>> strata = sorted(int(5 * (1 + math.erf(x / 2**0.5))) for x in xi[:, 0])
    >>> strata == list(range(10))
    True
    >>> x = asperity.design("latin_hypercube", seed=1, samples=10, distributions=["uniform:0,10"])
    >>> sorted(int(value) for value in x[:, 0]) == list(range(10))
    True
    """
    return _design(method, seed, samples, variables, variables_of(distributions, variables))


def _design(
    method: Sampler, seed: int, samples: int, count: int | None, variables: list[Variable] | None
) -> NDArray[np.float64]:
    if variables is not None:
        count = len(variables)
    elif count is None:
        raise ValueError("the number of variables is missing; state `variables` or `distributions`")
    xi: NDArray[np.float64] = _core.design(method, seed, samples, count)
    for place, variable in enumerate(variables or []):
        xi[:, place] = variable.values(xi[:, place])
    return xi


# Leave-one-out error over the variance above which there is a warning.
_LARGE_ERROR = 0.1
# Largest fraction of undefined values.
_UNDEFINED = 0.05
# Standard errors by which samples of independent standard normal variables do not differ from them.
_FAR = 6.0


def _defined(xi: NDArray[np.float64], values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the samples with defined values, with a warning of the others if they are few."""
    undefined = np.flatnonzero(~np.isfinite(values))
    if values.ndim != 1 or len(xi) != len(values) or not 0 < len(undefined) <= _UNDEFINED * len(values):
        return xi, values
    numbered = ", ".join(map(str, undefined[:3])) + (", …" if len(undefined) > 3 else "")  # noqa: PLR2004
    warn(f"{len(undefined)} of {len(values)} values are undefined and left out: samples {numbered}")
    return np.delete(xi, undefined, axis=0), np.delete(values, undefined)


def _require_distributions(points: NDArray[np.float64], variables: list[Variable] | None) -> None:
    """Refuse samples that are not those of independent variables with their distributions."""
    if points.ndim != 2 or not points.size:  # noqa: PLR2004
        return
    stated = "standard normal" if variables is None else "distributed as stated"
    far = _FAR / np.sqrt(len(points))
    xi = points
    if variables is not None:
        # Samples may lie on a bound.
        least = 0.5 / len(points)
        xi = np.column_stack([own.normal(values, least) for own, values in zip(variables, points.T, strict=True)])
    for place, own in enumerate(xi.T):
        # Standard errors of mean and variance; light tails are those of a bounded distribution.
        kurtosis = np.mean((own - own.mean()) ** 4) / max(own.var() ** 2, np.finfo(float).tiny)
        if abs(own.mean()) > far or abs(own.var() - 1) > 2**0.5 * far or kurtosis < 3 - 24**0.5 * far:
            raise ValueError(
                f"variable {place} is not {stated}: as a standard normal variable it has mean {own.mean():.2g}, "
                f"variance {own.var():.2g}, kurtosis {kurtosis:.2g}; state its distribution in `distributions`"
            )
    deviations = xi - xi.mean(axis=0)
    largest = np.abs(np.triu(deviations.T @ deviations / len(xi), 1)).max()
    if largest > far:
        raise ValueError(
            f"the variables are correlated, with a covariance of up to {largest:.2g}; make them independent"
        )


def _parts(statistics: NDArray[np.float64], count: int) -> list[NDArray[np.float64]]:
    """Return first-order, total and second-order indices of `count` variables, or their intervals."""
    first_order, total, second_order = np.split(statistics[2:], [count, 2 * count])
    return [first_order, total, second_order.reshape(count, count, *statistics.shape[1:])]


@dataclass(frozen=True, kw_only=True, eq=False)
class SobolIndices(Curves):
    """Fractions of the variance, by variable, with 95 % intervals.

    The intervals contain the choice of the samples, by a jackknife, and the variance that the expansion does not
    explain, by its leave-one-out error. They take the samples as independent and the terms as given, and are NaN if the
    error is undefined. They are too narrow for functions with heavy tails, such as Student's t, of few samples.
    """

    first_order: NDArray[np.float64]
    """Fraction of the variable alone."""
    total: NDArray[np.float64]
    """Fraction of the variable with all its interactions."""
    second_order: NDArray[np.float64]
    """Fraction of the interaction of two variables alone, shape (variables, variables): symmetric, with NaN on the
    diagonal.
    """
    first_order_interval: NDArray[np.float64]
    """Limits for each variable, shape (variables, 2)."""
    total_interval: NDArray[np.float64]
    """Limits for each variable, shape (variables, 2)."""
    second_order_interval: NDArray[np.float64]
    """Limits for each pair of variables, shape (variables, variables, 2)."""

    _curves: ClassVar[Mapping[str, str]] = {"first_order": "variable", "total": "variable"}

    @property
    def variable(self) -> NDArray[np.int64]:
        """Numbers of the variables, counted from 0."""
        return np.arange(len(self.total))

    def to_xarray(self) -> xarray.Dataset:
        """Return the indices and their intervals over the numbers of the variables, those of pairs over both."""
        import xarray

        own, pair = ("variable",), ("variable", "other")
        axes = {"first_order": own, "total": own, "second_order": pair}
        limits = {f"{name}_interval": (*axis, "limit") for name, axis in axes.items()}
        numbers = {"variable": self.variable, "other": self.variable, "limit": ["low", "high"]}
        return xarray.Dataset({name: (axis, getattr(self, name)) for name, axis in (axes | limits).items()}, numbers)

    def plot(self, names: Sequence[str] | None = None, *, ax: Axes | None = None) -> Axes:
        """Draw the indices; `names` are those of the variables."""
        return _plots.sobol_indices(self, names, ax)


class Expansion(Made):
    """Expansion of a function of independent random variables in orthonormal polynomials; see `fit` and `of`.

    A variable with a bounded distribution has the polynomials that are orthonormal under this distribution, such as
    those of Legendre if it is uniform. Any other variable has the Hermite polynomials of the standard normal variable
    Φ⁻¹(F(x)) with its distribution function F: its own polynomials may not converge, and amplify errors.
    """

    def __init__(self, own: _core.Expansion, intervals: NDArray[np.float64], variables: list[Variable] | None) -> None:
        self._own, self._intervals, self._variables = own, intervals, variables

    def _make(self, *state: Any) -> None:
        powers, coefficients, relative_error, self._intervals, self._variables = state
        nodes = nodes_of(self._variables, powers.shape[1])
        self._own = _core.Expansion(powers.tolist(), coefficients.tolist(), relative_error, nodes)

    def __getstate__(self) -> tuple[Any, ...]:
        return self.powers, self.coefficients, self.relative_error, self._intervals, self._variables

    @staticmethod
    def fit(
        xi: ArrayLike,
        values: ArrayLike,
        *,
        degree: int,
        sparse: bool = False,
        distributions: Sequence[Any] | None = None,
    ) -> Expansion:
        """Fit an expansion to values of a function by least squares.

        Parameters
        ----------
        xi
            Samples of the independent variables, shape (samples, variables). Samples that do not have the
            distributions of the variables are refused.
        values
            Value of the function at each sample. Up to 5 % may be undefined; they are left out with a warning.
        degree
            Total degree of the polynomials.
        sparse
            Keep few terms, chosen by cross-validation. Then there may be fewer samples than terms.
        distributions
            Continuous distribution of each variable: a frozen distribution of SciPy, a distribution of OpenTURNS, or
            a text such as ``"normal:MEAN,STD"``, ``"uniform:LOW,HIGH"``, ``"lognormal:MU,SIGMA"`` (of the logarithm),
            ``"weibull:SHAPE,SCALE"``, ``"gamma:SHAPE,SCALE"``, ``"beta:A,B,LOW,HIGH"`` or
            ``"triangular:LOW,MODE,HIGH"``. Standard normal if left out.

        Raises
        ------
        ValueError
            There are too few samples, a value is not finite, a distribution is not continuous, or the samples do not
            have the distributions.

        Examples
        --------
        >>> import asperity
        >>> xi = asperity.design("latin_hypercube", seed=1, samples=100, variables=2)
        >>> expansion = asperity.Expansion.fit(xi, 2 + xi[:, 0] + 3 * xi[:, 0] * xi[:, 1], degree=2)
        >>> round(expansion.mean, 9), round(expansion.variance, 9)
        (2.0, 10.0)
        """
        points = numbers(xi)
        count = points.shape[1] if points.ndim == 2 else None  # noqa: PLR2004
        return Expansion._fit(points, numbers(values), degree, sparse, variables_of(distributions, count))

    @staticmethod
    def _fit(
        xi: NDArray[np.float64],
        values: NDArray[np.float64],
        degree: int,
        sparse: bool,
        variables: list[Variable] | None,
    ) -> Expansion:
        points, found = _defined(xi, values)
        own_points = arguments(points, variables)
        _require_distributions(points, variables)
        nodes = nodes_of(variables, points.shape[-1])
        own, intervals = _core.Expansion.fit(own_points, found, degree, sparse, nodes)
        if intervals is None:
            intervals = np.full((len(own.statistics()), 2), np.nan)
        expansion = Expansion(own, intervals, variables)
        error = expansion.relative_error
        if expansion.variance > 0 and (error is None or error > _LARGE_ERROR):
            known = "undefined" if error is None else f"{error:.2g} of the variance"
            warn(f"the leave-one-out error of the expansion is {known}; more samples or another degree may help")
        return expansion

    @staticmethod
    def of(
        function: Callable[[NDArray[np.float64]], ArrayLike],
        *,
        variables: int | None = None,
        degree: int,
        samples: int,
        seed: int,
        method: Sampler = "sobol",
        sparse: bool = False,
        distributions: Sequence[Any] | None = None,
        vectorized: bool = False,
    ) -> Expansion:
        """Expand a function of independent random variables.

        Parameters
        ----------
        function
            Function of an array of `variables` values.
        variables
            Number of variables. It may be left out if there are `distributions`.
        degree, sparse, distributions
            See `fit`.
        samples
            Number of calls.
        seed, method
            Design of the calls.
        vectorized
            Call the function once, with all samples as an array of shape (samples, variables). It returns an array of
            shape (samples,).

        Raises
        ------
        ValueError
            See `fit` and `design`; or a vectorized function returned another shape.

        Examples
        --------
        >>> import asperity
        >>> expansion = asperity.Expansion.of(lambda xi: xi[0] ** 2, variables=1, degree=2, samples=20, seed=1)
        >>> round(expansion.variance, 9)
        2.0
        >>> product = asperity.Expansion.of(
        ...     lambda x: x[:, 0] * x[:, 1], distributions=["uniform:0,1", "triangular:0,0,1"],
        ...     degree=2, samples=64, seed=1, vectorized=True,
        ... )
        >>> round(product.mean, 6)
        0.166667
        """
        own = variables_of(distributions, variables)
        xi = _design(method, seed, samples, variables, own)
        if not vectorized:
            return Expansion._fit(xi, np.array([float(function(row)) for row in xi.copy()]), degree, sparse, own)  # type: ignore[arg-type]
        values = numbers(function(xi.copy()))
        if values.shape != (samples,):
            raise ValueError(f"the function returned an array of shape {values.shape}, expected ({samples},)")
        return Expansion._fit(xi, values, degree, sparse, own)

    def evaluate(self, xi: ArrayLike) -> NDArray[np.float64]:
        """Return the values of the expansion.

        Parameters
        ----------
        xi
            Samples, shape (samples, variables).

        Raises
        ------
        ValueError
            A sample is beyond the bounds of its variable, or so far in a tail that no double has its probability.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> square = asperity.Expansion.of(lambda xi: xi[0] ** 2, variables=1, degree=2, samples=20, seed=1)
        >>> np.round(square.evaluate([[0.0], [3.0]]), 9) + 0.0
        array([0., 9.])
        """
        values: NDArray[np.float64] = self._own.evaluate(arguments(numbers(xi), self._variables))
        return values

    @property
    def mean(self) -> float:
        """Mean of the function."""
        return float(self._own.statistics()[0])

    @property
    def mean_interval(self) -> tuple[float, float]:
        """95 % interval of the mean; see `SobolIndices`."""
        low, high = self._intervals[0]
        return float(low), float(high)

    @property
    def variance(self) -> float:
        """Variance of the function."""
        return float(self._own.statistics()[1])

    @property
    def variance_interval(self) -> tuple[float, float]:
        """95 % interval of the variance; see `SobolIndices`."""
        low, high = self._intervals[1]
        return float(low), float(high)

    @property
    def relative_error(self) -> float | None:
        """Leave-one-out mean square error over the variance; None if undefined."""
        return self._own.relative_error()

    @property
    def coefficients(self) -> NDArray[np.float64]:
        """Coefficients of the terms; the first is the mean."""
        values: NDArray[np.float64] = self._own.coefficients()
        return values

    @property
    def powers(self) -> NDArray[np.int64]:
        """Degrees of the polynomials in each variable, shape (terms, variables)."""
        return np.array(self._own.powers(), dtype=np.int64)

    def sobol_indices(self) -> SobolIndices:
        """Return the Sobol' indices of all variables; NaN without a variance, with a warning.

        Examples
        --------
        >>> import asperity, numpy as np
        >>> sum_of_two = asperity.Expansion.of(lambda xi: xi[0] + 2 * xi[1], variables=2, degree=1, samples=20, seed=1)
        >>> np.round(sum_of_two.sobol_indices().first_order, 9)
        array([0.2, 0.8])
        """
        if self.variance == 0:
            warn("the function does not vary: it has no variance, and no indices")
        count = self.powers.shape[1]
        first_order, total, second_order = _parts(self._own.statistics(), count)
        limits = _parts(self._intervals, count)
        return SobolIndices(
            first_order=first_order,
            total=total,
            second_order=second_order,
            first_order_interval=limits[0],
            total_interval=limits[1],
            second_order_interval=limits[2],
        )
