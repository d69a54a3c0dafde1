"""Bases, points and responses that all codes get, made with NumPy alone."""

import itertools
import math

import numpy as np


def total_degree(variables, degree):
    """Multi-indices of total degree, the constant first, shape [terms, variables]."""
    rows = [np.zeros((1, variables), dtype=int)]
    for total in range(1, degree + 1):
        chosen = itertools.combinations_with_replacement(range(variables), total)
        rows.append(np.array([np.bincount(places, minlength=variables) for places in chosen]))
    return np.concatenate(rows)


def hyperbolic(variables, degree, q):
    """Multi-indices with (Σ α^q)^(1/q) ≤ degree."""
    indices = total_degree(variables, degree)
    return indices[(indices**q).sum(axis=1) <= degree**q + 1e-9]


def univariate(x, degree, hermite):
    """Orthonormal polynomials of every variable, shape [degree + 1, points, variables]; the first `hermite` are normal."""
    values = np.empty((degree + 1, *x.shape))
    values[0] = 1.0
    before, b = np.zeros_like(x), np.zeros(x.shape[1])
    for n in range(1, degree + 1):
        following = np.where(np.arange(x.shape[1]) < hermite, math.sqrt(n), n / math.sqrt(4 * n * n - 1))
        values[n] = (x * values[n - 1] - b * before) / following
        before, b = values[n - 1], following
    return values


def design(x, indices, hermite):
    """Ψ_j(ξ_k), shape [points, terms], by broadcasting: one product for every variable."""
    values = univariate(x, indices.max(), hermite)
    matrix = values[indices[:, 0], :, 0]
    for variable in range(1, x.shape[1]):
        matrix = matrix * values[indices[:, variable], :, variable]
    return matrix.T


def points(kind, seed, samples, variables, hermite):
    """Latin hypercube or independent points, the first `hermite` variables normal, the others uniform on [−1, 1]."""
    from scipy.special import ndtri

    random = np.random.default_rng(seed)
    unit = random.random((samples, variables))
    if kind == "latin_hypercube":
        strata = np.stack([random.permutation(samples) for _ in range(variables)], axis=1)
        unit = (strata + unit) / samples
    return np.where(np.arange(variables) < hermite, ndtri(np.clip(unit, 1e-16, 1 - 1e-16)), 2 * unit - 1)


def ishigami(x):
    first, second, third = np.sin(np.pi * x[:, 0]), np.sin(np.pi * x[:, 1]), np.pi * x[:, 2]
    return first + 7 * second**2 + 0.1 * third**4 * first


def borehole(x):
    def between(low, high, x):
        return 0.5 * (low + high) + 0.5 * (high - low) * x

    well = 0.10 + 0.0161812 * x[:, 0]
    log_ratio = 7.71 + 1.0056 * x[:, 1] - np.log(well)
    upper, head = between(63070, 115600, x[:, 2]), between(990, 1110, x[:, 3]) - between(700, 820, x[:, 5])
    lower, length, conductivity = between(63.1, 116, x[:, 4]), between(1120, 1680, x[:, 6]), between(9855, 12045, x[:, 7])
    leak = 2 * length * upper / (log_ratio * well**2 * conductivity)
    return 2 * np.pi * upper * head / (log_ratio * (1 + leak + upper / lower))


def field_at_a_point(x, noise, seed):
    """A response of many variables: an exponential of a sum with falling weights, and noise of the given share."""
    weights = 0.5 / np.arange(1, x.shape[1] + 1)
    clean = np.exp(x @ weights) + x[:, 0] * x[:, 1]
    return clean + noise * clean.std() * np.random.default_rng(seed).standard_normal(len(x))


# Name → function, its variance, multi-indices, normal variables, variables, samples.
ACCURACY = {
    "ishigami": (ishigami, 13.844587940719254, lambda: total_degree(3, 14), 0, 3, 100),
    "borehole": (borehole, 817.69, lambda: hyperbolic(8, 5, 0.75), 2, 8, 150),
}
