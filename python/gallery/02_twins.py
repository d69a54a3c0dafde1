# %% [markdown]
# # Surfaces like the measured one
#
# **Which random surface has the heights, the correlation and the slopes of the scan?**
#
# One scan is one realisation. Contact and friction need many surfaces with the same statistics. `SurfaceModel.fit`
# chooses a covariance by its likelihood in the reliable band of the scan, and a distribution of the heights; three
# generators draw maps.

# %%
import matplotlib.pyplot as plt
import numpy as np

import asperity

surface = asperity.HeightMap.read("../../studies/brake_disc.x3p").level("plane", outliers=5)
models = {
    "spectral": asperity.SurfaceModel.fit(surface, generator="spectral"),
    "karhunen_loeve": asperity.SurfaceModel.fit(surface, generator="karhunen_loeve", modes=400),
}
found = surface.statistics()
covariance = models["spectral"].covariance
print(f"covariance: {covariance.model}, slopes {covariance.slope_ratio:.2f} times those of the scan")

# %% [markdown]
# | generator | use |
# |---|---|
# | spectral | all waves that the scan resolves, exact covariance |
# | Karhunen–Loève | few variables, for polynomial chaos; the truncation removes short waves and their slopes |
# | Weierstrass–Mandelbrot | a fractal with a given dimension; no correlation length |
#
# The structure function of this scan has no range of scales that follows a power law, so its fractal dimension cannot
# be measured and the fractal is not fitted. It has the rms height of the scan and a stated dimension of 2.3.

# %%
points, size_m = 128, 256e-6
labels = {
    "spectral": "spectral",
    "karhunen_loeve": "Karhunen–Loève",
    "weierstrass_mandelbrot": "Weierstrass–Mandelbrot",
}
generators = {name: model.on_grid(size_m=size_m, points=points) for name, model in models.items()}
generators["weierstrass_mandelbrot"] = asperity.WeierstrassMandelbrot(
    rms_height_m=found.Sq_m, fractal_dimension=2.3, size_m=size_m, points=points
)
drawn = {name: generator.sample(seed=1, count=8) for name, generator in generators.items()}
figure, panels = plt.subplots(1, 4, figsize=(9, 2.6), layout="constrained")
shown = {"scan": surface.heights[100:228, 100:228]} | {labels[name]: maps[0].heights for name, maps in drawn.items()}
for axes, (name, heights) in zip(panels, shown.items(), strict=True):
    image = axes.imshow(heights * 1e6, extent=(0, 256, 256, 0), vmin=-2.5, vmax=2.5)
    axes.set_title(name, fontsize="medium")
    axes.set_xlabel("x (µm)")
    axes.tick_params(labelleft=axes is panels[0])
panels[0].set_ylabel("y (µm)")
figure.colorbar(image, ax=panels, label="height (µm)", extend="both")
plt.show()

# %% [markdown]
# ## Statistics
#
# Eight maps of each generator against the scan. A patch of 256 µm contains few correlation lengths, so single maps
# scatter; means over the eight are compared.

# %%
print(f"{'':24}{'Sq (µm)':>9}{'Ssk':>8}{'Sku':>8}{'Sdq':>8}")
print(f"{'scan':24}{found.Sq_m * 1e6:9.3f}{found.Ssk:8.2f}{found.Sku:8.2f}{found.Sdq:8.3f}")
slopes = {}
for name, maps in drawn.items():
    # Statistics of all maps together: their means belong to the surface, not to the form.
    heights = np.array([own.heights for own in maps])
    rms = heights.std()
    skewness, kurtosis = (np.mean((heights - heights.mean()) ** power) / rms**power for power in (3, 4))
    slopes[name] = np.sqrt(np.mean([own.statistics().Sdq ** 2 for own in maps]))
    print(f"{name:24}{rms * 1e6:9.3f}{skewness:8.2f}{kurtosis:8.2f}{slopes[name]:8.3f}")
# The scan resolves waves down to 8 µm, four pixels; its shorter waves have the rest of its slopes.
resolved = surface.level("mean", s_filter_m=8e-6).statistics().Sdq

# %% [markdown]
# ## Spectra
#
# The spectra show what the table cannot: where each generator departs from the scan. The truncated Karhunen–Loève
# expansion ends at the shortest wave of its modes, so its slopes are too small; the fractal has no plateau at long
# waves. The spectral surfaces end at 8 µm, the shortest wave that the scan resolves with pixels of 2 µm.

# %%
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
measured = surface.psd()
axes.loglog(measured.q_rad_per_m, measured.psd_m4, "k", linewidth=2, label="scan")
for (name, maps), style in zip(drawn.items(), ("-", "--", ":"), strict=True):
    spectra = [own.psd() for own in maps]
    axes.loglog(spectra[0].q_rad_per_m, np.mean([own.psd_m4 for own in spectra], 0), style, label=labels[name])
axes.axvspan(measured.reliable_low_rad_per_m, measured.reliable_high_rad_per_m, color="tab:green", alpha=0.12)
axes.set(xlabel="wavenumber q (rad/m)", ylabel="power spectral density (m⁴)", ylim=(1e-29, 1e-20))
axes.legend(fontsize="small")
plt.show()

# %% [markdown]
# ## For those who come from MATLAB
#
# `artificial_surface` draws a periodic self-affine surface from its root-mean-square height, Hurst exponent and
# roll-off length, as the function of that name in MATLAB does. Its spectrum is proportional to (1 + (qℓ)²)^(−1−H),
# which falls as q^(−3.6) for H = 0.8. Close to the Nyquist wavenumber, waves too short for the grid fold back and
# lift it, so the fit ends at a quarter of that.

# %%
fractal = asperity.artificial_surface(
    rms_height_m=1e-6, hurst=0.8, size_m=1e-3, points=512, correlation_length_m=50e-6, seed=1
)
# A periodic map needs no window: its spectrum by Fourier transform.
power = np.abs(np.fft.fft2(fractal.heights)) ** 2
k = 2 * np.pi * np.fft.fftfreq(512, fractal.dx_m)
q = np.hypot(k, k[:, None])
own = (q > 0) & (q < k.max() / 4)
exponent = np.polyfit(np.log(1 + (q[own] * 50e-6) ** 2), np.log(power[own]), 1)[0]
print(f"exponent {exponent:.2f}, expected {-1 - 0.8:.2f}")

# %% [markdown]
# ## What was found

# %%
print(
    f"The spectral generator has {slopes['spectral'] / found.Sdq:.0%} of the rms slope of the scan, "
    f"400 Karhunen-Loève modes {slopes['karhunen_loeve'] / found.Sdq:.0%},\n"
    f"the fractal {slopes['weierstrass_mandelbrot'] / found.Sdq:.0%}: "
    "use the spectral one for contact, the expansion where few variables matter more."
)

# %% [markdown]
# Read on: [measured and random surfaces](../../docs/surfaces.md), [the covariance of a
# scan](../../docs/decisions/012-covariance-of-a-scan.md), and the next page,
# [contact](../../docs/gallery/03_contact.md).
