# %% [markdown]
# # Stick-slip and its limits
#
# **How much damping stops stick-slip, and what do fluctuations of friction change?**
#
# A belt carries a mass on a spring and a damper. In dimensionless form the displacement is X = xc/N, time τ = ω₀t and
# belt velocity V = v_b·mω₀/N. The machine is that of Gaus, Proppe and Zaccardi (2016): μ(v) = 0.1/(1 + 4.2 v), V =
# 0.003, ζ = 0.17.

# %%
import dataclasses

import matplotlib.pyplot as plt
import numpy as np

import asperity

law = asperity.Stribeck(kinetic=0.1, decay=4.2)
machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.17, belt_velocity=0.003)
cycle = asperity.limit_cycle(machine)
print(
    f"{cycle.kind}, period {cycle.period:.9f}, slip {cycle.slip_duration:.9f}, "
    f"re-attachment at {cycle.reattachment_displacement:.9f}"
)

# %% [markdown]
# ## The cycle by hand
#
# The slip phase obeys X″ + 2ζX′ + X = μ(V − X′) from the detachment at X = μ_st − 2ζV, X′ = V until X′ = V again.
# Then the mass sticks and moves with the belt. Twenty lines of Runge and Kutta's method give the same cycle.


# %%
def slip(oscillator, step=1e-3):
    """Integrate one slip; return times, displacements and velocities."""
    zeta, belt, mu = oscillator.damping_ratio, oscillator.belt_velocity, oscillator.static_friction

    def rate(state):
        x, v = state
        return np.array([v, mu / (1 + 4.2 * (belt - v)) - 2 * zeta * v - x])

    state = np.array([mu - 2 * zeta * belt, belt])
    states = [state]
    while len(states) < 3 or state[1] < belt:
        k1 = rate(state)
        k2 = rate(state + step / 2 * k1)
        k3 = rate(state + step / 2 * k2)
        k4 = rate(state + step * k3)
        state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        states.append(state)
    return step * np.arange(len(states)), *np.array(states).T


tau, x, v = slip(machine)
period = tau[-1] + (x[0] - x[-1]) / machine.belt_velocity
print(f"period by hand {period:.3f}")

# %% [markdown]
# ## Critical damping
#
# Two damping ratios matter. Above ζ_H steady sliding is stable: 2ζ_H = aμ_st/(1 + aV)². Above ζ_c no stick-slip cycle
# exists; first-order averaging gives ζ_c ≈ μ_st/(aV²)·[(1 + aV)/√(1 + 2aV) − 1]. The averaged formula assumes small
# weakening, and is within 1 % here.

# %%
belts = np.linspace(0.003, 0.3, 12)
limits = [asperity.critical_damping(dataclasses.replace(machine, belt_velocity=float(belt))) for belt in belts]
hopf = 0.5 * 4.2 * 0.1 / (1 + 4.2 * belts) ** 2
averaged = 0.1 / (4.2 * belts**2) * ((1 + 4.2 * belts) / np.sqrt(1 + 8.4 * belts) - 1)
critical = np.array([own.critical_damping_ratio for own in limits])
coulomb = asperity.Oscillator(
    static_friction=0.4, law=asperity.Coulomb(kinetic=0.3), damping_ratio=0.0, belt_velocity=0.05
)
jump = 0.1 / 0.05

figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
left.plot(np.append(x, x[0]), np.append(v, v[0]), linewidth=1.5)
left.set(xlabel="displacement X", ylabel="velocity X′", title="limit cycle")
right.plot(belts, critical, "o", label="ζ_c, computed")
right.plot(belts, averaged, "-", label="ζ_c, averaged")
right.plot(belts, hopf, "--", label="ζ_H")
right.set(xlabel="belt velocity V", ylabel="damping ratio ζ", title="limits of vibration")
right.legend()
plt.show()

# %% [markdown]
# ## Friction that fluctuates
#
# Now the friction coefficient fluctuates along the sliding distance with a standard deviation of 0.001, a correlation
# length of λ = 0.01 and the Beta(2.1, 5) distribution. Without fluctuation the machine completes 99 cycles in τ =
# 637; with it, it loses about thirty of them. An independent program counted 68.99 ± 0.10.

# %%
settings = {"friction_std": 0.001, "correlation_length": 0.01, "marginal": "beta:2.1,5", "seed": 1}
dampings = (0.17, 0.2048, 0.22, 0.25)
runs = []
for zeta in dampings:
    own = asperity.ensemble(
        dataclasses.replace(machine, damping_ratio=zeta), trajectories=400, duration=637.2, **settings
    )
    runs.append(own)
    print(
        f"ζ = {zeta:.3f}: {own.cycles.mean:4.1f} ± {own.cycles.se:.1f} cycles, "
        f"{own.cycles_deterministic} without fluctuation"
    )

# %% [markdown]
# Above ζ_c, where no cycle exists without fluctuation, many still occur: the sharp limit is smeared.

# %%
figure, axes = plt.subplots(figsize=(5, 2.8), layout="constrained")
for zeta, own in zip(dampings[:2], runs, strict=False):
    axes.hist(own.reattachments.sample, 60, density=True, histtype="step", label=f"ζ = {zeta:.3f}")
axes.axvline(cycle.reattachment_displacement, color="grey", linestyle="--", label="limit cycle, ζ = 0.170")
axes.set(xlabel="displacement X of re-attachment", ylabel="density")
axes.legend(fontsize="small")
plt.show()

# %% [markdown]
# ## The map
#
# The probability that vibration is sustained (at least half of the second half of the time), over damping and belt
# velocity. The grid is refined where the probability changes.

# %%
found = asperity.stability_map(
    machine,
    trajectories=30,
    duration=320,
    damping_ratios=(0.10, 0.30, 4),
    belt_velocities=(0.002, 0.01, 4),
    depth=2,
    allow_clipping=True,
    **settings,
)
figure, axes = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
found.plot(ax=axes)
plt.show()

# %% [markdown]
# ## What was found

# %%
print(
    f"Vibration ends at ζ = {critical[0]:.4f} without fluctuation. With it, {runs[0].cycles.mean:.0f} of "
    f"{runs[0].cycles_deterministic} cycles remain at ζ = 0.17,\n"
    f"and {runs[2].cycles.mean:.0f} cycles occur at ζ = 0.22, above the limit."
)

# %% [markdown]
# Read on: [stick-slip of a mass on a belt](../../docs/vibration.md), [the paper equation by
# equation](../../PAPER.md), and the next page, [the verdict on a brake](../../docs/gallery/07_brake_verdict.md).
