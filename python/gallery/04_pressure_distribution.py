# %% [markdown]
# # The distribution of the contact pressure
#
# **How is the pressure at a point of a contact distributed, and which method finds it with few contact solutions?**
#
# The surface is random, so the pressure at one point is: zero with the probability 1 − P(contact), otherwise a value
# up to the hardness. The study is that of figure 2 of Gaus, Proppe and Zaccardi (2016) with fewer points and samples;
# `studies/paper_fig2.toml` has the full sizes.

# %%
import matplotlib.pyplot as plt
import numpy as np

import asperity

study = {
    "seed": 2016,
    "surface": {
        "generator": "karhunen_loeve",
        "covariance": "squared_exponential",
        "rms_height": "1 um",
        "correlation_length": "20 um",
        "marginal": "normal",
        "modes": 101,
    },
    "material": {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3, "hardness": "2 GPa"},
    "pressure": {
        "size": ["200 um", "200 um"],
        "points": [32, 32],
        "boundary": "free",
        "percentile": 50.0,
        "fine_solves": 500,
        "methods": [
            "monte_carlo",
            "latin_hypercube",
            "sobol",
            "polynomial_chaos",
            "polynomial_chaos_log",
            "polynomial_chaos_local",
            "default",
        ],
        "reference_samples": 10000,
        "variables": 8,
        "degree": 2,
    },
}
results = asperity.run_study(study, progress=False)
pressure = results.pressure

# %% [markdown]
# ## One contact, and the probability of contact
#
# The flat is at the median height. Before deformation half of the surface is above it; the contact deforms its
# surroundings downwards, so on a free patch the probability of contact is at most one half everywhere. It is highest
# at the edges, where fewer neighbours push the surface away.

# %%
figure, panels = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
sample, contact = results.fields["pressure_sample"], results.fields["contact_probability"]
sample.plot(ax=panels[0])
contact.plot(ax=panels[1])
plt.show()
inner, border = contact.values[8:-8, 8:-8].mean(), np.concatenate([contact.values[0], contact.values[-1]]).mean()
print(f"contact probability {inner:.3f} in the middle, {border:.3f} at two edges")

# %% [markdown]
# ## Methods compared
#
# All methods have 500 contact solutions on the grid of the study; the reference has 10,000 others. Their
# Kolmogorov–Smirnov distances are the largest differences of the distribution functions.

# %%
for method in pressure.methods:
    low, high = method.contact_probability_interval
    print(
        f"{method.name:22} P(contact) {method.contact_probability:.3f} ({low:.3f} to {high:.3f})"
        f"  mean {method.mean_pa / 1e6:4.0f} MPa  distance {method.ks_distance:.3f}"
    )
print(f"{'reference':22} P(contact) {pressure.contact_probability:.3f}, mean {pressure.mean_pa / 1e6:.0f} MPa")
own = {method.name: method for method in pressure.methods}
widths = {name: np.ptp(method.contact_probability_interval) for name, method in own.items()}
gain = (widths["monte_carlo"] / widths["default"]) ** 2
work = 500 + sum(grid.work_in_fine_solves for grid in own["default"].coarse_solves)
low, high = own["default"].contact_probability_interval
known_low, known_high = pressure.contact_probability_interval

# %% [markdown]
# The expansions of the paper, equations (8) and (9), are fitted to the samples in contact and clipped at zero. This
# truncated regression is biased, and eight leading modes explain little of the pressure at one point. The default
# method adds coarse solutions and the local heights around the point as predictors; its estimate is unbiased for any
# predictor.

# %%
table = results.tables["pressure_cdf"]
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
axes.plot(table["pressure_pa"] / 1e9, table["reference"], "k", linewidth=3, alpha=0.4, label="reference, 10,000")
styles = {"monte_carlo": "-", "polynomial_chaos": "--", "polynomial_chaos_log": ":", "default": "-."}
for name, style in styles.items():
    axes.plot(table["pressure_pa"] / 1e9, table[name], style, label=name.replace("_", " "))
axes.set(xlabel="pressure (GPa)", ylabel="probability of a lower pressure", ylim=(0.65, 1.01))
axes.legend(fontsize="small", loc="upper left")
plt.show()
yielding = (1 - np.interp(1.99e9, table["pressure_pa"], table["reference"])) / pressure.contact_probability
print(f"{yielding:.0%} of the pressures in contact are at the hardness")

# %% [markdown]
# ## What was found

# %%
print(
    f"The point is in contact with the probability {own['default'].contact_probability:.3f} ({low:.3f} to {high:.3f}) "
    f"and carries {own['default'].mean_pa / 1e6:.0f} MPa on average.\n"
    f"For this interval plain Monte Carlo needs {gain * 500:,.0f} fine solutions; "
    f"the default did the work of {work:,.0f}."
)

# %% [markdown]
# Read on: [the distribution of the random pressure](../../docs/pressure.md),
# [validation](../../docs/validation/pressure.md), and the next page, [friction as a
# process](../../docs/gallery/05_friction_process.md).
