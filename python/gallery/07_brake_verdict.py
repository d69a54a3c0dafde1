# %% [markdown]
# # The verdict on a brake
#
# **How probable is vibration, given how uncertain the values are, and what makes it improbable?**
#
# A machine vibrates by stick-slip if its damping ratio ζ is below a limit ζ_v. Both are uncertain. `verdict` returns
# the probability, the values that decide it, and the change of a value that makes vibration improbable.

# %%
from statistics import NormalDist

import matplotlib.pyplot as plt
import numpy as np

import asperity

# %% [markdown]
# ## A case of known answer
#
# If friction weakens linearly, μ − b·v, the limit is b/2. With b ~ N(0.1, 0.02) and ζ ~ N(0.055, 0.005) the margin ζ
# − b/2 is normal, N(0.005, 0.01118): vibration has the probability 0.3274, b decides 0.8 of the variance of the
# margin and ζ 0.2, and ζ must rise to 0.0684 for a probability of 5 %.

# %%
machine = {
    "mass": "1 kg",
    "natural_frequency": "316 rad/s",
    "normal_force": "2.5 kN",
    "nominal_area": "833 mm^2",
    "dimensionless_belt_velocity": 0.1,
    "static_friction": 0.4,
    "friction_std": 0,
}
linear = {"velocity_law": "linear", "linear_weakening": "0.1 ± 0.02", "damping_ratio": "0.055 ± 0.005"}
remedy = {"input": "vibration.damping_ratio", "range": [0.01, 0.2]}
known = asperity.verdict(
    {"seed": 1, "vibration": machine | linear, "verdict": {"duration": "2 s", "remedies": [remedy]}}, progress=False
)
share = {driver.input: driver.first_order for driver in known.drivers}
reach = {own.probability: own.value for own in known.remedies[0].reach}
margin = NormalDist(0.055 - 0.1 / 2, float(np.hypot(0.005, 0.02 / 2)))
enough = 0.05 - margin.stdev * NormalDist().inv_cdf(0.05)
print(f"probability {known.probability:.4f}, exact {margin.cdf(0):.4f}")
print(f"damping ratio for 5 %: {reach[0.05]:.4f}, exact {enough:.4f}")

# %% [markdown]
# ## A brake
#
# One pad of 15 kg at 100 Hz under 10 kN, on a disc that creeps at 20 mm/s. Its friction comes from contact: strips of
# a rough disc of stated roughness are pressed against the pad. Damping varies from brake to brake, and so does the
# hardness of the pad. The Stribeck coefficient is one value that nobody measured: it is *unknown*, within limits.

# %%
brake = {
    "seed": 2016,
    "surface": {
        "generator": "spectral",
        "covariance": "exponential",
        "rms_height": "0.8 um",
        "correlation_length": "16 um",
        "marginal": "normal",
    },
    "material": {
        "youngs_modulus": "10 GPa",
        "poisson_ratio": 0.25,
        "hardness": "100 ± 10 MPa",
        "shear_strength": "38 MPa",
    },
    "friction": {
        "strip": ["4 mm", "128 um"],
        "points": [1024, 32],
        "window": "400 um",
        "boundary": "periodic",
        "mean_pressures": ["2 MPa"],
        "realisations": 8,
    },
    "vibration": {
        "mass": "15 kg",
        "natural_frequency": "100 Hz",
        "damping_ratio": "0.05 ± 0.006",
        "normal_force": "10 kN",
        "nominal_area": "5000 mm^2",
        "belt_velocity": "20 mm/s",
        "stribeck": {"uniform": ["0.2 s/m", "0.3 s/m"], "unknown": True},
    },
    "verdict": {
        "duration": "0.5 s",
        "half_width": 0.06,
        "evaluations": 1024,
        "remedies": [{"input": "vibration.damping_ratio", "range": [0.01, 0.2]}],
    },
}
results = asperity.run_study(brake, only="verdict", progress=False)
found = results.verdict
low, high = found.probability_interval
print(f"probability of vibration {found.probability:.2f} (95 %: {low:.2f} to {high:.2f})")
print(f"central values: ζ = 0.05, limit {found.nominal.limit_damping_ratio:.3f}, vibrates: {found.nominal.vibrates}")
margins = results.tables["verdict_samples"]
vibrates = np.array([name == "stick_slip" for name in margins["name"]])

# %% [markdown]
# Each sampled brake has its own hardness, damping and Stribeck coefficient. A harder pad touches on less area, so
# friction is lower and the limit of vibration too.

# %%
figure, panels = plt.subplots(1, 2, figsize=(8.5, 3), layout="constrained")
mu, hardness = margins["friction_coefficient"], margins["material.hardness"] / 1e6
panels[0].scatter(hardness, mu, s=4)
panels[0].set(xlabel="hardness of the pad (MPa)", ylabel="friction coefficient")
bins = np.linspace(-0.04, 0.03, 43)
panels[1].hist(margins["damping_margin"][vibrates], bins, alpha=0.7, label="vibrates")
panels[1].hist(margins["damping_margin"][~vibrates], bins, alpha=0.7, label="does not", hatch="//")
panels[1].set(xlabel="margin ζ − ζ_v", ylabel="sampled brakes")
panels[1].legend(fontsize="small")
plt.show()

# %% [markdown]
# ## What decides, and what nobody knows
#
# Sobol' indices divide the variance of the margin among the values. `range_reduction` is the fraction by which the
# range of the margin narrows once a value is known: the largest is worth measuring next. An unknown value does not
# average out over brakes, so the probability itself has a range.

# %%
for driver in found.drivers:
    print(f"{driver.input:26} first order {driver.first_order:.2f}, range narrows by {driver.range_reduction:.0%}")
guess = found.guesses[0]
print(
    f"probability {guess.probability_at_q05:.2f} with a low Stribeck coefficient, "
    f"{guess.probability_at_q95:.2f} with a high one"
)

# %% [markdown]
# ## What helps
#
# A remedy moves the central value of one input. More damping, with the same standard deviation from brake to brake:

# %%
targets = found.remedies[0].reach
for own in targets:
    least, most = own.value_interval
    print(f"damping ratio {own.value:.4f} ({least:.4f} to {most:.4f}) for a probability of {own.probability:.0%}")

figure, axes = plt.subplots(figsize=(5.5, 2.8), layout="constrained")
names = [driver.input.partition(".")[2].replace("_", " ") for driver in found.drivers]
axes.barh(names, [driver.total for driver in found.drivers], color="lightgrey", label="total")
axes.barh(names, [driver.first_order for driver in found.drivers], height=0.4, label="first order")
axes.set(xlabel="Sobol' index of the margin", xlim=(0, 0.5))
axes.legend(fontsize="small", loc="lower right")
plt.show()

# %% [markdown]
# ## What was found

# %%
print(
    f"The brake vibrates with the probability {found.probability:.2f} ({low:.2f} to {high:.2f}). "
    f"A central damping ratio of {targets[0].value:.3f} lowers it to 5 %,\n"
    f"and the Stribeck coefficient, which nobody measured, "
    f"moves it between {guess.probability_at_q05:.2f} and {guess.probability_at_q95:.2f}."
)

# %% [markdown]
# Read on: [how probable vibration is](../../docs/verdict.md), [500 machines solved
# wholly](../../docs/validation/verdict.md), and [one study over many values](../../docs/campaigns.md).
