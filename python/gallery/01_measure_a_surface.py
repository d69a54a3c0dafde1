# %% [markdown]
# # Measure a surface
#
# **How rough is this brake disc, and how well does one scan show it?**
#
# A scan is one finite, filtered sample of a surface. Each number from it needs the band of wavelengths that it
# belongs to and an interval. The scan of this page is synthetic: 1 mm × 1 mm of a brake disc with pits, spikes and
# missing points.

# %%
import matplotlib.pyplot as plt
import numpy as np

import asperity

scan = asperity.HeightMap.read("../../studies/brake_disc.x3p")
plane = scan.level("plane")
print(scan)

# %% [markdown]
# ## Spikes first
#
# `level("plane")` subtracts the least-squares plane. The kurtosis of what remains is 8, that of a normal distribution
# is 3: a few heights far from the surface determine it, so asperity gives no interval. `outliers=5` removes heights
# beyond five robust standard deviations and fits the plane again. They become missing (NaN), as the voids of the scan
# are; nothing is filled.

# %%
surface = scan.level("plane", outliers=5)
before, found = plane.statistics(), surface.statistics()
print(f"kurtosis with spikes     {before.Sku:.2f}, interval {before.Sku_interval}")
print(f"kurtosis without spikes  {found.Sku:.2f}, interval {found.Sku_interval[0]:.2f} to {found.Sku_interval[1]:.2f}")
print(f"points removed           {found.missing_points - before.missing_points} of {scan.heights.size}")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3), width_ratios=[1, 1.3], layout="constrained")
surface.plot(ax=left)
bins = np.linspace(-13, 13, 261)
for name, own, filled in (("with spikes", plane, False), ("without", surface, True)):
    heights_um = own.heights[np.isfinite(own.heights)] * 1e6
    right.hist(heights_um, bins, density=True, histtype="stepfilled" if filled else "step", alpha=0.7, label=name)
normal = np.exp(-0.5 * (bins * 1e-6 / found.Sq_m) ** 2) / (np.sqrt(2 * np.pi) * found.Sq_m * 1e6)
right.plot(bins, normal, "k--", linewidth=1, label="normal, same Sq")
right.set(xlabel="height (µm)", ylabel="density (1/µm)", yscale="log", ylim=(2e-5, 100))
right.legend(loc="upper left", fontsize="small")
plt.show()

# %% [markdown]
# ## Parameters with intervals
#
# The parameters are those of ISO 25178-2. Each 95 % interval is estimated from the one map: the map contains a
# limited number of correlation lengths, and neighbouring heights are not independent.

# %%
for name, unit, scale in (("Sq_m", "µm", 1e6), ("Ssk", "", 1), ("Sku", "", 1), ("Sdq", "", 1)):
    low, high = (scale * end for end in getattr(found, f"{name}_interval"))
    print(f"{name.removesuffix('_m'):4} {scale * getattr(found, name):7.3f} {unit:2}  95 %: {low:.3f} to {high:.3f}")

# %% [markdown]
# ## Autocorrelation: how far do heights know each other?
#
# The correlation length is the lag at which the autocorrelation falls to 1/e. This disc has a direction: sliding
# follows x.

# %%
acf = surface.acf()
figure, axes = plt.subplots(figsize=(5, 2.8), layout="constrained")
acf.plot(ax=axes)
axes.set_xlim(0, 100)
plt.show()
x_m, y_m = acf.correlation_length_x_m, acf.correlation_length_y_m
print(f"correlation lengths: {x_m * 1e6:.1f} µm along x, {y_m * 1e6:.1f} µm along y")

# %% [markdown]
# ## Spectrum: what does the reliable band mean?
#
# Waves longer than half the map occur too few times to be averaged, and levelling removes part of them. Waves
# shorter than four points are not resolved. Between these limits the spectrum shows the surface. Here the band is 8 µm
# to 512 µm.

# %%
psd = surface.psd()
low, high = psd.reliable_low_rad_per_m, psd.reliable_high_rad_per_m
figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
psd.plot(ax=axes)
plt.show()
longest_m, shortest_m = 2 * np.pi / low, 2 * np.pi / high

# %% [markdown]
# The integral of the spectrum over d²q/(2π)² is the variance of the heights; with the weight q² it is that of the
# slopes. Heights belong to the band. Slopes gain with every shorter wave. Elastic contact depends on slopes, so a
# friction coefficient is known only as far as this band is, unless the contacts yield.

# %%
q = psd.q_rad_per_m
inside = (q >= low) & (q <= high)
rings = psd.psd_m4 * q * np.gradient(q) / (2 * np.pi)
height_share, slope_share = (np.sum(w[inside]) / np.sum(w) for w in (rings, rings * q**2))
rms_slope = {cut: scan.level("plane", outliers=5, s_filter_m=cut).statistics().Sdq for cut in (8e-6, 16e-6)}
print(f"inside the band: {height_share:.0%} of the variance of heights, {slope_share:.0%} of that of slopes")
print(
    f"Sdq: {found.Sdq:.3f} as measured",
    *(f"{v:.3f} without waves below {c * 1e6:.0f} µm" for c, v in rms_slope.items()),
    sep=", ",
)

# %% [markdown]
# ## What was found

# %%
low_um, high_um = (1e6 * end for end in found.Sq_m_interval)
print(
    f"For wavelengths from {shortest_m * 1e6:.0f} µm to {longest_m * 1e6:.0f} µm the disc has "
    f"Sq = {found.Sq_m * 1e6:.3f} µm (95 %: {low_um:.3f} to {high_um:.3f} µm)\n"
    f"and correlation lengths of {x_m * 1e6:.0f} µm and {y_m * 1e6:.0f} µm."
)

# %% [markdown]
# Read on: [measured and random surfaces](../../docs/surfaces.md), [coverage of the
# intervals](../../docs/validation/statistics.md), and the next page, [surfaces like this
# one](../../docs/gallery/02_twins.md).
