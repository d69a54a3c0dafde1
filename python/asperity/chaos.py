"""Samplers, and polynomial chaos expansions of functions of standard normal variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity import _core, _plots
from asperity._arrays import numbers
from asperity._record import Curves, Made
from asperity.errors import warn

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Sampler = Literal["monte_carlo", "latin_hypercube", "maximin_latin_hypercube", "sobol"]


def design(method: Sampler, *, seed: int, samples: int, variables: int) -> NDArray[np.float64]:
    """Return the points of a design as standard normal variables, shape (samples, variables).

    Examples
    --------
    >>> import asperity, math
    >>> xi = asperity.design("latin_hypercube", seed=1, samples=10, variables=2)
    >>> strata = sorted(int(5 * (1 + math.erf(x / 2**0.5))) for x in xi[:, 0])
    >>> strata == list(range(10))
    True
    """
    xi: NDArray[np.float64] = _core.design(method, seed, samples, variables)
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


def _require_standard_normal(xi: NDArray[np.float64]) -> None:
    """Refuse samples that are not those of independent standard normal variables."""
    if xi.ndim != 2 or not xi.size:  # noqa: PLR2004
        return
    far = _FAR / np.sqrt(len(xi))
    for place, own in enumerate(xi.T):
        # Standard errors of mean and variance; light tails are those of a bounded distribution.
        kurtosis = np.mean((own - own.mean()) ** 4) / max(own.var() ** 2, np.finfo(float).tiny)
        if abs(own.mean()) > far or abs(own.var() - 1) > 2**0.5 * far or kurtosis < 3 - 24**0.5 * far:
            raise ValueError(
                f"variable {place} is not standard normal: mean {own.mean():.2g}, variance {own.var():.2g}, kurtosis "
                f"{kurtosis:.2g}; transform it to a standard normal variable"
            )
    deviations = xi - xi.mean(axis=0)
    largest = np.abs(np.triu(deviations.T @ deviations / len(xi), 1)).max()
    if largest > far:
        raise ValueError(
            f"the variables are correlated, with a covariance of up to {largest:.2g}; make them independent"
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class SobolIndices(Curves):
    """Fractions of the variance, by variable."""

    first_order: NDArray[np.float64]
    """Fraction of the variable alone."""
    total: NDArray[np.float64]
    """Fraction of the variable with all its interactions."""

    _curves: ClassVar[Mapping[str, str]] = {"first_order": "variable", "total": "variable"}

    @property
    def variable(self) -> NDArray[np.int64]:
        """Numbers of the variables, counted from 0."""
        return np.arange(len(self.total))

    def plot(self, names: Sequence[str] | None = None, *, ax: Axes | None = None) -> Axes:
        """Draw the indices; `names` are those of the variables."""
        return _plots.sobol_indices(self, names, ax)


class Expansion(Made):
    """Expansion in orthonormal Hermite polynomials of standard normal variables ξ; see `fit` and `of`."""

    def __init__(self, own: _core.Expansion) -> None:
        self._own = own

    def _make(self, *state: Any) -> None:
        powers, coefficients, relative_error = state
        self._own = _core.Expansion(powers.tolist(), coefficients.tolist(), relative_error)

    def __getstate__(self) -> tuple[Any, ...]:
        return self.powers, self.coefficients, self.relative_error

    @staticmethod
    def fit(xi: ArrayLike, values: ArrayLike, *, degree: int, sparse: bool = False) -> Expansion:
        """Fit an expansion to values of a function by least squares.

        Parameters
        ----------
        xi
            Independent standard normal variables, shape (samples, variables). Others are refused.
        values
            Value of the function at each sample. Up to 5 % may be undefined; they are left out with a warning.
        degree
            Total degree of the polynomials.
        sparse
            Keep few terms, chosen by cross-validation. Then there may be fewer samples than terms.

        Examples
        --------
        >>> import asperity
        >>> xi = asperity.design("latin_hypercube", seed=1, samples=100, variables=2)
        >>> expansion = asperity.Expansion.fit(xi, 2 + xi[:, 0] + 3 * xi[:, 0] * xi[:, 1], degree=2)
        >>> round(expansion.mean, 9), round(expansion.variance, 9)
        (2.0, 10.0)
        """
        points, found = _defined(numbers(xi), numbers(values))
        _require_standard_normal(points)
        expansion = Expansion(_core.Expansion.fit(points, found, degree, sparse))
        error = expansion.relative_error
        if expansion.variance > 0 and (error is None or error > _LARGE_ERROR):
            known = "undefined" if error is None else f"{error:.2g} of the variance"
            warn(f"the leave-one-out error of the expansion is {known}; more samples or another degree may help")
        return expansion

    @staticmethod
    def of(
        function: Callable[[NDArray[np.float64]], float],
        *,
        variables: int,
        degree: int,
        samples: int,
        seed: int,
        method: Sampler = "sobol",
        sparse: bool = False,
    ) -> Expansion:
        """Expand a function of standard normal variables.

        Parameters
        ----------
        function
            Function of an array of `variables` values.
        variables
            Number of variables.
        degree, sparse
            See `fit`.
        samples
            Number of calls.
        seed, method
            Design of the calls.

        Examples
        --------
        >>> import asperity
        >>> expansion = asperity.Expansion.of(lambda xi: xi[0] ** 2, variables=1, degree=2, samples=20, seed=1)
        >>> round(expansion.variance, 9)
        2.0
        """
        xi = design(method, seed=seed, samples=samples, variables=variables)
        return Expansion.fit(xi, [float(function(row)) for row in xi], degree=degree, sparse=sparse)

    def evaluate(self, xi: ArrayLike) -> NDArray[np.float64]:
        """Return the values at samples of shape (samples, variables)."""
        values: NDArray[np.float64] = self._own.evaluate(numbers(xi))
        return values

    @property
    def mean(self) -> float:
        """Mean of the function."""
        return self._own.mean()

    @property
    def variance(self) -> float:
        """Variance of the function."""
        return self._own.variance()

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
        """Return the first-order and total Sobol' indices of all variables; NaN without a variance, with a warning."""
        if self.variance == 0:
            warn("the function does not vary: it has no variance, and no indices")
        first_order, total = self._own.sobol_indices()
        return SobolIndices(first_order=first_order, total=total)
