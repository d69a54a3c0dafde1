"""Limit states g of n standard normal variables z, failing where g < 0, with their exact probabilities of failure.

u and v are orthogonal directions that involve all (an even number of) variables. The parameter b sets the probability.
"""

import math

import numpy as np


def directions(z):
    even, odd = z[:, ::2].sum(axis=1), z[:, 1::2].sum(axis=1)
    return (even + odd) / math.sqrt(z.shape[1]), (even - odd) / math.sqrt(z.shape[1])


def linear(z, b):
    return b - directions(z)[0]


def machine(z, b):
    return b + 0.005 * z[:, 1] - 0.5 * (0.1 + 0.02 * z[:, 0])


def parabola(z, b):
    u, _ = directions(z)
    return b - u + 0.1 * ((z**2).sum(axis=1) - u**2)


def branches(z, b):
    u, v = directions(z)
    return np.minimum(b + 0.2 * v**2 - np.abs(u), math.sqrt(2) * (b + 0.5 - np.abs(v)))


def tail(b):
    """P[ξ > b] of a standard normal ξ."""
    return 0.5 * math.erfc(b / math.sqrt(2))


def simpson(f, low, high, steps=4000):
    h = (high - low) / steps
    inner = sum(f(low + i * h) * (4 if i % 2 else 2) for i in range(1, steps))
    return h / 3 * (f(low) + inner + f(high))


def parabola_probability(variables, b):
    """Integral over r² = |z|² − u², which is χ² distributed."""

    def density(r):
        return r ** (variables - 2) * math.exp(-r * r / 2)

    return simpson(lambda r: density(r) * tail(b + 0.1 * r * r), 0, 20) / simpson(density, 0, 20)


def branches_probability(_, b):
    """The branches in v, and the branches in u between them."""

    def density(v):
        return math.exp(-v * v / 2) / math.sqrt(2 * math.pi)

    return 2 * tail(b + 0.5) + simpson(lambda v: density(v) * 2 * tail(b + 0.2 * v * v), -b - 0.5, b + 0.5)


# Function, probability, range of b, formula.
LIMIT_STATES = {
    "linear": (linear, lambda _, b: tail(b), (0, 8), "b − u"),
    "machine": (machine, lambda _, b: tail((b - 0.05) / math.hypot(0.01, 0.005)), (0.05, 0.15),
                "damping margin ζ − w/2 of a machine with linearly weakening friction: ζ ~ N(b, 0.005), weakening w ~ N(0.1, 0.02)"),
    "parabola": (parabola, parabola_probability, (0, 8), "b − u + 0.1 (|z|² − u²)"),
    "branches": (branches, branches_probability, (0, 8), "four branches, min(b + 0.2 v² − |u|, √2 (b + 0.5 − |v|))"),
}


def parameter(name, variables, probability):
    """The b at which failure has this probability, by bisection."""
    _, exact, (low, high), _ = LIMIT_STATES[name]
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if exact(variables, middle) > probability else (low, middle)
    return (low + high) / 2
