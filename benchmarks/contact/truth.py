"""The surfaces of the benchmark, and how well a pressure solves a contact problem on one, computed from the pressure alone.

Everything is scaled: the map covers a unit square, E* = 1 and the root mean square slope is 0.1.
"""

from functools import cache

import numpy as np

HURST, ROLL_OFF, SLOPE = 0.8, 8, 0.1


def self_affine(points, seed):
    """A periodic Gaussian map: amplitudes flat up to `ROLL_OFF` waves per side, then as q^(-1 - H), none beyond points/8."""
    cut = max(points // 8, 2 * ROLL_OFF)
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal((points, points)))
    waves = np.hypot(np.fft.fftfreq(points)[:, None], np.fft.rfftfreq(points)[None, :]) * points
    noise *= np.where((waves > 0) & (waves <= cut), np.maximum(waves, ROLL_OFF) ** (-1 - HURST), 0)
    # Of every pair of opposite waves one is stored, except along the columns without waves in x.
    weight = np.where(np.arange(points // 2 + 1) == 0, 1, 2)
    slope = 2 * np.pi * np.sqrt((np.abs(noise) ** 2 * waves**2 * weight).sum()) / points**2
    return np.fft.irfft2(noise, s=(points, points)) * (SLOPE / slope)


@cache
def compliance(points, boundary):
    """Transform of the half-space's response to the pressure in one cell."""
    if boundary == "periodic":
        waves = np.hypot(np.fft.fftfreq(points)[:, None], np.fft.rfftfreq(points)[None, :]) * points
        waves[0, 0] = np.inf
        return 1 / (np.pi * waves)
    # Love's cell of constant pressure: second differences of x asinh(y/x) + y asinh(x/y) at its corners.
    corner = np.arange(-points, points) + 0.5
    x, y = corner[:, None], corner[None, :]
    corners = x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
    cells = np.diff(np.diff(corners, axis=0), axis=1) / (np.pi * points)
    kernel = np.zeros((2 * points, 2 * points))
    # Lags -(n - 1) … n - 1, wrapped.
    lags = np.arange(-points + 1, points) % (2 * points)
    kernel[np.ix_(lags, lags)] = cells
    return np.fft.rfft2(kernel)


def displacement(pressure, boundary):
    points = len(pressure)
    factor = compliance(points, boundary)
    length = points if boundary == "periodic" else 2 * points
    return np.fft.irfft2(np.fft.rfft2(pressure, s=(length, length)) * factor, s=(length, length))[:points, :points]


def residual(pressure, heights, mean_pressure, boundary, hardness=None):
    """The largest of the violations of the conditions of contact, all relative.

    With v = S p - h: mean(p (v - min v)⁺) / (mean(p) h_rms), a bound on the gap in energy (Frank and Wolfe); the largest
    overlap / h_rms with the flat at the mean of -v weighted with p; the error of the load; and pressures outside of
    their bounds / max(p). With a hardness, min v, the flat and the overlap regard cells below it alone.
    """
    cap = np.inf if hardness is None else hardness * (1 - 1e-12)
    v = displacement(pressure, boundary) - heights
    rms = heights.std()
    free = pressure < cap
    least = v[free].min()
    frank_wolfe = (pressure * np.maximum(v - least, 0)).sum() / (pressure.sum() * rms)
    elastic = pressure * free
    plane = -(elastic * v).sum() / elastic.sum() if elastic.sum() > 0 else -least
    overlap = max(0.0, -(least + plane)) / rms
    load = abs(pressure.mean() / mean_pressure - 1)
    above = 0.0 if hardness is None else pressure.max() - hardness
    bounds = max(0.0, -pressure.min(), above) / pressure.max()
    worst = max(frank_wolfe, overlap, load, bounds)
    return float(worst) if np.isfinite(worst) else float("inf")
