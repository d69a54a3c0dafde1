# %% [markdown]
# # Friction as a process, and the window question
#
# **Does the correlation length of friction belong to the surface, or to the window over which friction was averaged?**
#
# A slider or a sensor averages friction over a window that moves along the path. Neighbouring windows overlap, so
# their means are correlated even if friction is not.

# %%
import warnings

import matplotlib.pyplot as plt
import numpy as np

import asperity

# %% [markdown]
# ## The window alone
#
# The mean of white friction over a window W has a triangular correlation, 1 − s/W, with the integral scale W/2. An
# exponential fitted to the triangle of W = 600 µm returns a length between 322 µm and 368 µm that depends on the
# range of lags, although there is no correlation at all.

# %%
window_m = 600e-6
lengths_m = np.linspace(100e-6, 800e-6, 7001)
fitted = {}
for end in (1, 2):
    lag_m = np.linspace(0, end * window_m, 600)
    triangle = np.maximum(1 - lag_m / window_m, 0)
    misfit = [np.sum((np.exp(-lag_m / length) - triangle) ** 2) for length in lengths_m]
    fitted[end] = lengths_m[np.argmin(misfit)]
    print(f"lags up to {end} W: length of the fit {fitted[end] * 1e6:.0f} µm")

# %% [markdown]
# ## Variance that a window leaves
#
# Friction with the correlation e^(−s/ℓ) keeps the fraction 2ℓ/W·[1 − (ℓ/W)(1 − e^(−W/ℓ))] of its variance over a
# window: 0.518 for ℓ = 250 µm and W = 600 µm. A stated process and moving means of its realisation show it.

# %%
length_m, step_m = 250e-6, 10e-6
process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=length_m, marginal="beta:2.1,5")
record = process.simulate(length_m=10.0, step_m=step_m, seed=1)


def kept(window_m):
    """Fraction of the variance that a window keeps."""
    ratio = length_m / window_m
    return 2 * ratio * (1 - ratio * (1 - np.exp(-1 / ratio)))


windows_m = np.array([100, 200, 400, 600, 1200, 2400]) * 1e-6
variances = []
for own in windows_m:
    cells = round(own / step_m)
    means = np.convolve(record, np.full(cells, 1 / cells), mode="valid")
    variances.append(means.var() / record.var())

figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3), layout="constrained")
shown = slice(0, 1000)
left.plot(np.arange(1000) * step_m * 1e3, record[shown], linewidth=0.6, label="μ(s)")
smooth = np.convolve(record[:1059], np.full(60, 1 / 60), mode="valid")
left.plot((np.arange(1000) + 30) * step_m * 1e3, smooth, linewidth=1.8, label="mean over 600 µm")
left.set(xlabel="sliding distance s (mm)", ylabel="friction coefficient")
left.set_ylim(top=0.245)
left.legend(fontsize="small", loc="upper right", ncols=2)
w = np.geomspace(60e-6, 4e-3, 100)
right.semilogx(w * 1e6, kept(w), "-", label="closed form")
right.semilogx(windows_m * 1e6, variances, "o", label="10 m of record")
right.set(xlabel="window W (µm)", ylabel="variance kept")
right.legend(fontsize="small")
plt.show()

# %% [markdown]
# ## A record, fitted
#
# `fit_friction_record` returns the process of a record with 95 % intervals. Here the truth is known: mean 0.2,
# standard deviation 0.01, length 250 µm. About one interval in twenty misses the truth by chance, so twenty records
# of 100 mm are fitted and the intervals that contain the truth are counted.

# %%
record_process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=length_m)
covered = {"mean": 0, "std": 0, "length": 0}
for index in range(20):
    values = record_process.simulate(length_m=0.1, step_m=2 * step_m, seed=2, index=index)
    with warnings.catch_warnings():
        # Of twenty records, one or two deviate by chance from the distribution or the correlation that is fitted.
        warnings.simplefilter("ignore")
        found = asperity.fit_friction_record(values, step_m=2 * step_m, marginal="normal")
    for name, interval, truth in (
        ("mean", found.mean_interval, 0.2),
        ("std", found.std_interval, 0.01),
        ("length", found.correlation.length_m_interval, length_m),
    ):
        covered[name] += interval[0] <= truth <= interval[1]
print("intervals of 20 that contain the truth:", covered)
low, high = (1e6 * end for end in found.correlation.length_m_interval)
print(f"last record: length {found.correlation.length_m * 1e6:.0f} µm, 95 %: {low:.0f} µm to {high:.0f} µm")

# %% [markdown]
# ## Friction of a rough strip
#
# Now friction comes from contact: strips of a rough surface are pressed against a flat, and windows of W, W/2, W/4
# and W/8 slide along. If the length belonged to the surface, it would be the same for all windows.

# %%
study = {
    "seed": 2016,
    "surface": {
        "generator": "spectral",
        "covariance": "squared_exponential",
        "rms_height": "1 um",
        "correlation_length": "20 um",
        "marginal": "normal",
    },
    "material": {"youngs_modulus": "210 GPa", "hardness": "2 GPa", "shear_strength": "385 MPa"},
    "friction": {
        "strip": ["6 mm", "80 um"],
        "points": [2048, 32],
        "window": "600 um",
        "boundary": "periodic",
        "percentiles": [50.0],
        "realisations": 24,
    },
}
results = asperity.run_study(study, progress=False)
level, table = results.friction.levels[0], results.tables["friction_windows"]
for window, length in zip(table["window_m"], table["correlation_length_m"], strict=True):
    print(f"window {window * 1e6:5.0f} µm: fitted length {length * 1e6:4.0f} µm, {length / window:.2f} W")
print("due to the window alone:", level.window_only)

figure, axes = plt.subplots(figsize=(5.5, 3), layout="constrained")
acf = results.tables["friction_acf"]
axes.plot(acf["lag_m"] * 1e6, acf["acf"], "o", markersize=3, label="friction of the strips")
axes.plot(
    acf["lag_m"] * 1e6, acf["fit"], "--", label=f"exponential, {level.at_mean_load.correlation_length_m * 1e6:.0f} µm"
)
axes.plot(acf["lag_m"] * 1e6, acf["window_only"], "-", label="window alone")
axes.set(xlabel="lag (µm)", ylabel="autocorrelation", xlim=(0, 1500))
axes.legend(fontsize="small")
plt.show()

# %% [markdown]
# ## What was found

# %%
first, last = table["correlation_length_m"][0], table["correlation_length_m"][-1]
print(
    f"The fitted length falls from {first * 1e6:.0f} µm to {last * 1e6:.0f} µm as the window falls from "
    f"{table['window_m'][0] * 1e6:.0f} µm to {table['window_m'][-1] * 1e6:.0f} µm:\nit belongs to the window. "
    "State a correlation length of friction together with its window."
)

# %% [markdown]
# Read on: [friction as a random process](../../docs/friction.md), [validation](../../docs/validation/friction.md),
# and the next page, [stick-slip](../../docs/gallery/06_stick_slip_map.md).
