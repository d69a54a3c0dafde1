# %% [markdown]
# # Contact against closed forms
#
# **How exact is a computed contact, and how fine must the grid be?**
#
# `solve_contact` minimises the energy of an elastic half-space under pressures between zero and the hardness. Three
# contacts have closed forms: a sphere (Hertz), a wave (Westergaard), and a sphere whose pressure is bounded by the
# hardness.

# %%
import matplotlib.pyplot as plt
import numpy as np

import asperity

# %% [markdown]
# ## A sphere: Hertz
#
# A steel ball of 10 mm under 10 N: contact radius a = (3FR/4E\*)^(1/3) = 68.8 µm, largest pressure p₀ = 3F/(2πa²) =
# 1.01 GPa, penetration δ = a²/R = 0.473 µm.

# %%
modulus_pa, radius_m, load_n = 210e9 / (1 - 0.3**2), 10e-3, 10.0
a_m = (3 * load_n * radius_m / (4 * modulus_pa)) ** (1 / 3)
p0_pa, delta_m = 3 * load_n / (2 * np.pi * a_m**2), a_m**2 / radius_m


def sphere(points, half_m, radius_m):
    """Heights of a paraboloid on cells, its top at a corner of cells."""
    dx_m = 2 * half_m / points
    x = (np.arange(points) + 0.5) * dx_m - half_m
    return -(x**2 + x[:, None] ** 2) / (2 * radius_m), dx_m, x


errors = {}
for points in (32, 64, 128, 256, 512):
    heights, dx_m, x = sphere(points, 1.2 * a_m, radius_m)
    ball = asperity.solve_contact(heights, dx_m=dx_m, modulus_pa=modulus_pa, load_n=load_n, boundary="free")
    exact = p0_pa * np.sqrt(np.maximum(1 - (x**2 + x[:, None] ** 2) / a_m**2, 0))
    of_pressure = np.sqrt(np.mean((ball.pressure_pa - exact) ** 2)) / p0_pa
    of_area = abs(ball.contact_fraction_corrected * (2.4 * a_m) ** 2 / (np.pi * a_m**2) - 1)
    errors[a_m / dx_m] = of_pressure, of_area
    print(f"{a_m / dx_m:5.1f} cells per radius: error of pressure {of_pressure:.1e}, of area {of_area:.1e}")

# %% [markdown]
# The pressure falls to zero like a square root at the border of the contact, where cells of constant pressure follow
# it badly. So the root-mean-square error falls about in proportion to the cell size. The area is corrected for cells
# at the border; its error is below 2 % with 13 cells per radius and below 0.5 % from 27 on.

# %%
cells = np.array(list(errors))
pressure_error, area_error = np.array(list(errors.values())).T
order = -np.polyfit(np.log(cells), np.log(pressure_error), 1)[0]
print(f"order of the error of the pressure: {order:.2f}")

figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
r = np.linspace(0, 1.2, 400)
left.plot(r, np.sqrt(np.maximum(1 - r**2, 0)), "k-", linewidth=1, label="Hertz")
left.plot(np.abs(x[256:]) / a_m, ball.pressure_pa[256, 256:] / p0_pa, "o", markersize=2, label="512 points")
left.set(xlabel="distance from the centre r/a", ylabel="pressure p/p₀")
left.legend()
right.loglog(cells, pressure_error, "o-", label="pressure (rms)")
right.loglog(cells, area_error, "s-", label="corrected area")
right.set_xticks(cells, [f"{own:.0f}" for own in cells])
right.minorticks_off()
right.set(xlabel="cells per contact radius", ylabel="relative error")
right.legend()
plt.show()

# %% [markdown]
# ## A wave: Westergaard
#
# A sinusoid of amplitude h and wavelength λ closes completely at p\* = πE\*h/λ. At a mean pressure p̄ below it the
# contact has the width 2a with p̄/p\* = sin²(πa/λ), and the pressure peaks at 2√(p̄p\*). At a quarter of p\* a third
# of the wave is in contact, the peak is p\*, and the mean gap is 0.4034 h.

# %%
wavelength_m, amplitude_m, points = 100e-6, 0.5e-6, 512
p_star_pa = np.pi * modulus_pa * amplitude_m / wavelength_m
wave = amplitude_m * np.cos(2 * np.pi * (np.arange(points) + 0.5) / points) * np.ones((4, 1))
ratio = np.array([0.1, 0.25, 0.5, 0.75])
waves = [
    asperity.solve_contact(wave, dx_m=wavelength_m / points, modulus_pa=modulus_pa, mean_pressure_pa=share * p_star_pa)
    for share in ratio
]
width = 2 / np.pi * np.arcsin(np.sqrt(ratio))
gap = np.array([0.6697414907, 0.4034264097, 0.1534264097, 0.0342384457])

figure, axes = plt.subplots(figsize=(5, 2.8), layout="constrained")
for share, own in zip(ratio, waves, strict=True):
    axes.plot(
        (np.arange(points) + 0.5) / points,
        np.roll(own.pressure_pa[0], points // 2) / p_star_pa,
        label=f"p̄ = {share} p*",
    )
axes.set(xlabel="position x/λ", ylabel="pressure p/p*")
axes.legend(fontsize="small")
plt.show()

# %% [markdown]
# ## A sphere that yields
#
# With `hardness_pa` the pressure cannot exceed H. At a fixed penetration a cap of 0.6 p₀ lowers the force to 0.916 of
# Hertz and enlarges the contact to 1.083 of his circle.

# %%
heights, dx_m, x = sphere(256, 0.16, 1.0)
p0 = 2 / np.pi * np.sqrt(0.01)
capped = {
    share: asperity.solve_contact(
        heights, dx_m=dx_m, modulus_pa=1.0, penetration_m=0.01 + heights.max(), hardness_pa=share * p0, boundary="free"
    )
    for share in (0.8, 0.6, 0.4)
}
force = np.array([own.load_n for own in capped.values()]) / (4 / 3 * 0.01**1.5)
area = np.array([own.contact_fraction_corrected for own in capped.values()]) * 0.32**2 / (np.pi * 0.01)
for (share, own), f, a in zip(capped.items(), force, area, strict=True):
    yields = own.plastic_fraction / own.contact_fraction
    print(f"H = {share} p0: force {f:.3f}, area {a:.3f} of Hertz; {yields:.0%} of the contact yields")

figure, axes = plt.subplots(figsize=(5, 2.8), layout="constrained")
for share, own in capped.items():
    axes.plot(x / 0.1, own.pressure_pa[128] / p0, label=f"H = {share} p₀")
axes.plot(x / 0.1, np.sqrt(np.maximum(1 - (x / 0.1) ** 2, 0)), "k--", linewidth=1, label="Hertz")
axes.set(xlabel="position x/a", ylabel="pressure p/p₀", xlim=(-1.5, 1.5))
axes.legend(fontsize="small")
plt.show()

# %% [markdown]
# ## What was found

# %%
print(
    f"With {cells[1]:.0f} cells per contact radius the rms error of the pressure is {pressure_error[1]:.1%} of p0 "
    f"and falls with order {order:.1f};\nthe error of the corrected area is {area_error[1]:.1%}."
)

# %% [markdown]
# Read on: [choose tolerance and grid](../../docs/contact-solver.md), [1,000 checked
# contacts](../../docs/validation/contact.md), and the next page, [the distribution of the
# pressure](../../docs/gallery/04_pressure_distribution.md).
