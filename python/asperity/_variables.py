"""Random variables with distributions of asperity, SciPy and OpenTURNS."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asperity import _core
from asperity.errors import warn

Numbers = NDArray[np.float64]
# A function of values, or of probabilities, and of whether probabilities are those above.
_Function = Callable[[Numbers, bool], Numbers]

_NORMAL = _core.Marginal("normal")
# Largest difference of F(F⁻¹(p)) from p.
_CONTINUOUS = 1e-6
# Difference of moments at half of the nodes, over the standard deviation, from which a density is not resolved.
_UNRESOLVED = 1e-4
# Least probability of which a standard normal quantile is taken.
_LEAST = float(np.finfo(float).tiny)
# Standard normal variable with this probability.
_FARTHEST = float(_NORMAL.quantile(np.array([_LEAST]), True)[0])


class Variable:
    """Random variable with a continuous distribution, as a function of a standard normal one."""

    def __init__(self, distribution: Any) -> None:
        self._distribution = distribution
        self._quantile, self._probability, (self.low, self.high) = _functions(distribution)
        normal = _core.distribution_nodes()
        #: Values at the nodes, from which the polynomials of a bounded variable follow.
        self.nodes = self.values(normal)
        wrong = self._probability(self.nodes, False) - _NORMAL.probability(normal, False)
        if not np.abs(wrong).max() < _CONTINUOUS:
            raise ValueError("its distribution function is not continuous, or its tails are below the least double")
        if self.bounded and self._unresolved(normal) > _UNRESOLVED:
            warn(
                "the density has gaps or steps, which the polynomials do not resolve: moments and intervals are inexact"
            )

    def _unresolved(self, normal: Numbers) -> float:
        """Return the difference of mean and standard deviation from those at every second node, over the latter."""
        moments = []
        for step in (1, 2):
            weights, values = np.exp(-0.5 * normal[::step] ** 2), self.nodes[::step]
            mean = np.average(values, weights=weights)
            moments.append((mean, np.average((values - mean) ** 2, weights=weights) ** 0.5))
        return float(max(abs(fine - coarse) for fine, coarse in zip(*moments, strict=True)) / moments[0][1])

    def __reduce__(self) -> tuple[Any, ...]:
        return Variable, (self._distribution,)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Variable) and np.array_equal(self.nodes, other.nodes)

    __hash__ = None  # type: ignore[assignment]

    @property
    def bounded(self) -> bool:
        """Whether the support has two ends."""
        return bool(np.isfinite([self.low, self.high]).all())

    def values(self, normal: Numbers) -> Numbers:
        """Return the values at those of the standard normal variable."""
        return _by_tail(normal, _NORMAL.probability, self._quantile)

    def normal(self, values: Numbers, least: float = _LEAST) -> Numbers:
        """Return the values of the standard normal variable; smaller probabilities count as `least`."""
        return _by_tail(values, self._probability, _NORMAL.quantile, least)


def _by_tail(values: Numbers, probability: _Function, quantile: _Function, least: float = _LEAST) -> Numbers:
    """Return the quantiles at the probabilities of values, from the smaller tail, which has all digits."""
    lower, upper = (np.maximum(probability(values, above), least) for above in (False, True))
    return np.where(lower < upper, quantile(lower, False), quantile(upper, True))


def variables_of(distributions: Sequence[Any] | None, count: int | None) -> list[Variable] | None:
    """Return the variables of distributions, of which there should be `count`; None for standard normal ones."""
    if distributions is None:
        return None
    if count is not None and len(distributions) != count:
        raise ValueError(f"{len(distributions)} distributions for {count} variables")
    found = []
    for place, distribution in enumerate(distributions):
        try:
            found.append(Variable(distribution))
        except ValueError as error:
            raise ValueError(f"distribution {place}: {error}") from None
    return found


def nodes_of(variables: list[Variable] | None, count: int) -> list[list[float] | None]:
    """Return the nodes of bounded variables, and None for those with Hermite polynomials."""
    if variables is None:
        return [None] * count
    return [own.nodes.tolist() if own.bounded else None for own in variables]


def arguments(samples: Numbers, variables: list[Variable] | None) -> Numbers:
    """Return the arguments of the polynomials: values of bounded variables, and otherwise standard normal ones."""
    # The compiled module refuses other shapes.
    if variables is None or samples.ndim != 2 or samples.shape[1] != len(variables):  # noqa: PLR2004
        return samples
    found = samples.copy()
    for place, own in enumerate(variables):
        values = samples[:, place]
        beyond = values[(values < own.low) | (values > own.high)]
        if len(beyond):
            raise ValueError(f"variable {place} is {beyond[0]:g}, outside its support from {own.low:g} to {own.high:g}")
        if not own.bounded:
            found[:, place] = own.normal(values)
            far = values[np.abs(found[:, place]) >= _FARTHEST]
            if len(far):
                raise ValueError(f"variable {place} is {far[0]:g}, too far in the tail of its distribution")
    return found


def _functions(distribution: Any) -> tuple[_Function, _Function, tuple[float, float]]:
    """Return quantiles, probabilities and support of a distribution."""
    if isinstance(distribution, str):
        own = _core.Marginal(distribution)
        return own.quantile, own.probability, own.support()
    if hasattr(distribution, "computeQuantile"):
        return _of_openturns(distribution)
    if hasattr(distribution, "iccdf"):
        return (
            lambda p, upper: distribution.iccdf(p) if upper else distribution.icdf(p),
            lambda x, upper: distribution.ccdf(x) if upper else distribution.cdf(x),
            distribution.support(),
        )
    if hasattr(distribution, "ppf"):
        return (
            lambda p, upper: distribution.isf(p) if upper else distribution.ppf(p),
            lambda x, upper: distribution.sf(x) if upper else distribution.cdf(x),
            distribution.support(),
        )
    raise TypeError(f"{distribution!r} is neither a text nor a distribution of SciPy or OpenTURNS")


def _of_openturns(distribution: Any) -> tuple[_Function, _Function, tuple[float, float]]:
    def probability(x: Numbers, upper: bool) -> Numbers:
        own = distribution.computeComplementaryCDF if upper else distribution.computeCDF
        return np.ravel(own(x[:, np.newaxis]))

    own = distribution.getRange()
    low = own.getLowerBound()[0] if own.getFiniteLowerBound()[0] else -np.inf
    high = own.getUpperBound()[0] if own.getFiniteUpperBound()[0] else np.inf
    return lambda p, upper: np.ravel(distribution.computeQuantile(p, upper)), probability, (low, high)
