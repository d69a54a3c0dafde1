# %% [markdown]
# # From other tools
#
# **How is this called in asperity, and does it give the same number?**
#
# The same work in SurfaceTopography, surfalize, Tamaas, SALib and OpenTURNS and in asperity, on one scan and one function.
# Where two numbers differ, the text says by which convention. [Conventions](../python.md#conventions) has them all.

# %%
import contextlib
import io
import warnings
from importlib.metadata import version

import matplotlib.pyplot as plt
import numpy as np

import asperity

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import openturns
    import surfalize  # noqa: F401
    import tamaas
    from SALib.analyze import sobol as analysis
    from SALib.sample import sobol as saltelli

print(*(f"{name} {version(name)}" for name in ("SurfaceTopography", "surfalize", "tamaas", "SALib", "openturns")))


def compare(title, rows):
    """Print the numbers of two tools beside each other."""
    print(f"{'':28}{title:>20}{'asperity':>16}")
    for name, theirs, ours in rows:
        print(f"{name:28}{theirs:20.6g}{ours:16.6g}")


# %% [markdown]
# ## SurfaceTopography
#
# A `Topography` becomes a `HeightMap`, from its unit to metre. SurfaceTopography has no spectrum of a map with voids;
# `fill` puts random heights into them, and asperity's own spectrum needs no such step.

# %%
scan = asperity.HeightMap.read("../../studies/brake_disc.x3p").fill(seed=1)
topography = scan.to_surfacetopography()

# %%
# SurfaceTopography
plane = topography.detrend("height")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    wavenumber, density = plane.power_spectrum_from_area()

# %%
# asperity
rough = scan.level("plane")
statistics, spectrum = rough.statistics(), rough.psd()

# %%
compare(
    "SurfaceTopography",
    [
        ("rms height (m)", plane.rms_height_from_area(), statistics.Sq_m),
        ("rms gradient", plane.rms_gradient(), statistics.Sdq),
    ],
)
figure, axes = plt.subplots(figsize=(5, 2.8), layout="constrained")
axes.loglog(wavenumber, density, "o", ms=4, label="SurfaceTopography")
axes.loglog(spectrum.q_rad_per_m, spectrum.psd_m4, label="asperity")
axes.set(xlabel="wavenumber q (rad/m)", ylabel="power spectral density (m⁴)")
axes.legend()
plt.show()

# %% [markdown]
# Both spectra are two-sided over the wavevector in rad/m: ∬ P d²q/(2π)² is the variance. SurfaceTopography averages over
# logarithmic bins, asperity over rings of the width 2π/L with a 95 % interval for each.
#
# ## surfalize
#
# surfalize has micrometre, percent and degrees, asperity metre, fractions and radian.

# %%
# surfalize
surface = scan.to_surfalize().level()
theirs = [surface.Sq(), surface.Sku(), surface.Sdq(), surface.Sdr(), surface.Sal(), surface.Spk(), surface.Std()]

# %%
# asperity
ours = [
    statistics.Sq_m / 1e-6,
    statistics.Sku,
    statistics.Sdq,
    statistics.Sdr / 1e-2,
    statistics.Sal_m / 1e-6,
    statistics.Spk_m / 1e-6,
    np.degrees(statistics.Std_rad),
]

# %%
names = ["Sq (µm)", "Sku", "Sdq", "Sdr (%)", "Sal (µm)", "Spk (µm)", "Std (°)"]
compare("surfalize", zip(names, theirs, ours, strict=True))

# %% [markdown]
# - Sdq: surfalize averages each direction over its own differences, asperity over the cells that have both.
# - Sal: between lags the two interpolate the autocorrelation differently.
# - Spk: surfalize samples the Abbott curve at 10,000 ratios, asperity has all heights.
# - Std: surfalize gives the angle at which the spectrum is largest, that of the waves; asperity that of the lay, at about a
#   right angle to it.
#
# ## Tamaas
#
# The same equations: a periodic half-space, of a polymer, pressed with a mean pressure. Tamaas takes the rough body as rigid and the flat
# as elastic, which changes no pressure. Lengths are in one unit, here metre.

# %%
part = rough[128:384, 128:384]
heights, side_m = part.heights - part.heights.mean(), 256 * part.dx_m

# %%
# Tamaas
model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [side_m, side_m], heights.shape)
model.E, model.nu = 2e9, 0.4
with contextlib.redirect_stdout(io.StringIO()):
    tamaas.set_log_level(tamaas.LogLevel.error)
    solver = tamaas.PolonskyKeerRey(model, heights, 1e-12)
    solver.dump_freq = 1_000_000
    solver.solve(10e6)
traction = model.traction

# %%
# asperity
contact = asperity.solve_contact(part, youngs_modulus_pa=2e9, poisson_ratio=0.4, mean_pressure_pa=10e6)

# %%
compare(
    "Tamaas",
    [
        ("contact fraction", (traction > 0).mean(), contact.contact_fraction),
        ("largest pressure (Pa)", traction.max(), contact.max_pressure_pa),
        ("mean pressure (Pa)", traction.mean(), contact.mean_pressure_pa),
    ],
)

# %% [markdown]
# ## SALib and OpenTURNS
#
# Sobol' indices of the Ishigami function, whose exact values are 0.3139, 0.4424 and 0. SALib needs N(k + 2) calls of the
# function for k variables; an expansion, here and in OpenTURNS, takes N.


# %%
def ishigami(x):
    """Return the values at samples of shape (samples, 3)."""
    return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


# %%
# SALib
problem = {"num_vars": 3, "names": ["x1", "x2", "x3"], "bounds": [[-np.pi, np.pi]] * 3}
samples = saltelli.sample(problem, 1024, calc_second_order=False, seed=1)
saltelli_indices = analysis.analyze(problem, ishigami(samples), calc_second_order=False, seed=1)

# %%
# OpenTURNS
distribution = openturns.JointDistribution([openturns.Uniform(-np.pi, np.pi)] * 3)
x = openturns.LowDiscrepancyExperiment(openturns.SobolSequence(), distribution, 1024).generate()
y = openturns.Sample(ishigami(np.array(x))[:, None])
enumerate_all = openturns.LinearEnumerateFunction(3)
basis = openturns.OrthogonalProductPolynomialFactory([openturns.LegendreFactory()] * 3, enumerate_all)
terms = enumerate_all.getStrataCumulatedCardinal(9)
algorithm = openturns.FunctionalChaosAlgorithm(x, y, distribution, openturns.FixedStrategy(basis, terms))
algorithm.run()
chaos_indices = openturns.FunctionalChaosSobolIndices(algorithm.getResult())

# %%
# asperity; the distributions are texts, or those of OpenTURNS or SciPy
uniform = openturns.Uniform(-np.pi, np.pi)
expansion = asperity.Expansion.of(
    ishigami, distributions=[uniform] * 3, degree=9, samples=1024, seed=1, vectorized=True
)
indices = expansion.sobol_indices()

# %%
exact = [0.31390519, 0.44241114, 0]
calls = {"SALib": len(samples), "OpenTURNS": len(x), "asperity": 1024}
found = {
    "SALib": saltelli_indices["S1"],
    "OpenTURNS": [chaos_indices.getSobolIndex(i) for i in range(3)],
    "asperity": indices.first_order,
}
for name, own in found.items():
    print(f"{name:10}{calls[name]:6} calls  S1 {np.round(own, 4)}  error {np.abs(np.array(own) - exact).max():.1e}")

# %% [markdown]
# ## Names
#
# | | SurfaceTopography | surfalize | Gwyddion | MountainsMap | asperity |
# |---|---|---|---|---|---|
# | remove a plane | `detrend("height")` | `level()` | Level Data | Levelling, least squares | `level("plane")` |
# | rms height | `rms_height_from_area()` | `Sq()` | Statistical Quantities: Sq | Sq | `statistics().Sq_m` |
# | rms gradient | `rms_gradient()` | `Sdq()` | Statistical Quantities: Sdq | Sdq | `statistics().Sdq` |
# | autocorrelation | `autocorrelation_from_area()`: ½⟨(Δz)²⟩ | `get_autocorrelation_function()` | 2D ACF, in m² | Autocorrelation | `acf()`: 1 at lag 0 |
# | spectrum | `power_spectrum_from_area()` | `get_fourier_transform()` | 1D and 2D PSDF | Averaged PSD | `psd()` |
# | short waves off | `filter` | `filter` | Spline or Gaussian filter | S-filter | `level(s_filter_m=…)` |
# | fill voids | `interpolate_undefined_data` | `fill_nonmeasured()` | Data Correction | Fill in non-measured points | `fill(seed=…)`, random |
#
# | | Tamaas | ContactMechanics | asperity |
# |---|---|---|---|
# | half-space | `ModelFactory.createModel` | `PeriodicFFTElasticHalfSpace`, `FreeFFTElasticHalfSpace` | `boundary="periodic"`, `"free"` |
# | modulus | `model.E`, `model.nu` | E*, one number | `youngs_modulus_pa` and `poisson_ratio`, or `modulus_pa` = E* |
# | load | `solver.solve(pressure)` | `minimize_proxy(offset=…)`, a distance | one of five keywords, or a list of values |
# | hardness | `KatoSaturated` | plastic topography | `hardness_pa=…` |
#
# | | OpenTURNS | SALib | UQLab | asperity |
# |---|---|---|---|---|
# | samples | `LowDiscrepancyExperiment`, `LHSExperiment` | `sample.sobol`, `sample.latin` | `uq_getSample` | `design` |
# | expansion | `FunctionalChaosAlgorithm` | – | `uq_createModel`, `MetaType = 'PCE'` | `Expansion.fit`, `Expansion.of` |
# | Sobol' indices | `FunctionalChaosSobolIndices` | `analyze.sobol` | `uq_createAnalysis`, `Type = 'Sensitivity'` | `sobol_indices()` |
# | sparse terms | `LeastSquaresMetaModelSelectionFactory` | – | `Method = 'LARS'` | `sparse=True` |
