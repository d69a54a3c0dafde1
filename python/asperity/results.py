"""Results of a study. Made by scripts/generate_python_results.py; do not edit.

The attributes are the keys of ``results.json``: SI units, with the unit in the name. An undefined number is None, and
an interval is [low, high] at 95 %.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

from asperity._methods import CampaignMethods
from asperity._record import Record, WithCompanions


@dataclass(frozen=True, kw_only=True, eq=False)
class ScanOfPart(WithCompanions):
    """One scan of a part."""

    file: str
    """Name of the file."""
    nx: int
    """Points along x."""
    ny: int
    """Points along y."""
    dx_m: float
    """Pitch along x."""
    dy_m: float
    """Pitch along y."""
    missing_points: int
    """Missing points, rejected outliers included."""
    outliers: int
    """Points rejected as outliers."""
    form_radius_m: float | None = None
    """Radius of the cylinder or sphere that was removed, positive for a ridge or cap."""
    Sa_m: float
    """Arithmetical mean height."""
    Sq_m: float
    """Root mean square height."""
    Ssk: float | None
    """Skewness of the heights."""
    Sku: float | None
    """Kurtosis of the heights, 3 for a normal distribution."""
    Sp_m: float
    """Highest peak."""
    Sv_m: float
    """Deepest pit."""
    Sz_m: float
    """Maximum height Sp + Sv."""
    Sdq: float | None
    """Root mean square gradient by forward differences."""
    Sdq_7point: float | None
    """Root mean square gradient by the seven-point stencil."""
    Sdr: float | None
    """Developed interfacial area ratio by triangulation."""
    Sal_m: float | None
    """Autocorrelation length at 0.2."""
    Str: float | None
    """Texture aspect ratio, from 0 for a lay to 1 for none."""
    Std_rad: float | None
    """Direction of the lay, counter-clockwise from x as the map is seen; from 0 to below π, meaningful if Str is
    small.
    """
    Ssw_m: float | None
    """Dominant wavelength."""
    Sk_m: float
    """Core height; by the least-squares line of ISO 25178-2, as the parameters up to Svkx."""
    Spk_m: float
    """Reduced peak height."""
    Svk_m: float
    """Reduced dale depth."""
    Smrk1: float
    """Upper material ratio of the core."""
    Smrk2: float
    """Lower material ratio of the core."""
    Spkx_m: float
    """Height of the highest peak above the core."""
    Svkx_m: float
    """Depth of the deepest dale below the core."""
    Sxp_m: float
    """Peak extreme height, between the material ratios 2.5 % and 50 %."""
    Sk_secant_m: float
    """Core height by the secant; the flattest one, as for the next four parameters."""
    Spk_secant_m: float
    """Reduced peak height by the secant."""
    Svk_secant_m: float
    """Reduced dale depth by the secant."""
    Smrk1_secant: float
    """Upper material ratio of the core by the secant."""
    Smrk2_secant: float
    """Lower material ratio of the core by the secant."""
    Vmp_m: float
    """Peak material volume per area."""
    Vmc_m: float
    """Core material volume per area."""
    Vvc_m: float
    """Core void volume per area."""
    Vvv_m: float
    """Dale void volume per area."""
    psd_reliable_low_rad_per_m: float
    """Lower end of the wavenumbers at which the radial spectrum is reliable."""
    psd_reliable_high_rad_per_m: float
    """Upper end of the wavenumbers at which the radial spectrum is reliable; none is if it is not above the lower
    end.
    """
    psd_upper_limit: str
    """Limit that sets the upper end of the reliable spectrum: `pixel`, `roll_off` or `noise_floor`."""
    psd_corners_m2: float
    """Variance outside the rings of the radial spectrum; in the corners of its plane, or below the first ring."""
    correlation_length_x_m: float | None
    """1/e correlation length along x."""
    correlation_length_y_m: float | None
    """1/e correlation length along y."""
    hurst: float | None
    """Hurst exponent."""
    hurst_se: float | None
    """Standard error of `hurst`."""
    hurst_range_low_m: float | None
    """Shortest lag from which the Hurst exponent was fitted."""
    hurst_range_high_m: float | None
    """Longest lag from which the Hurst exponent was fitted."""
    fractal_dimension: float | None
    """Fractal dimension 3 − H."""
    companions: Mapping[str, Any] = field(default_factory=dict)
    """Further keys: intervals ``x_interval``, standard errors ``x_se`` and the like."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PartStatistics(WithCompanions):
    """Pooled statistics of several scans of a part, and those of the scans. Each pooled statistic `x` is the
    weighted mean over the scans, with `x_interval` and `x_se` of the part, `x_within_std` (the standard error of
    one scan) and `x_between_std` (the standard deviation between places). All are `null` if `x` is undefined on a
    scan.
    """

    scan_count: int
    """Number of scans."""
    nx: int | None
    """Points along x; `null` where the scans differ, as for the next three."""
    ny: int | None
    """Points along y."""
    dx_m: float | None
    """Pitch along x."""
    dy_m: float | None
    """Pitch along y."""
    missing_points: int
    """Missing points of all scans."""
    outliers: int
    """Points of all scans rejected as outliers."""
    psd_reliable_low_rad_per_m: float
    """Lower end of the wavenumbers at which the spectra of all scans are reliable."""
    psd_reliable_high_rad_per_m: float
    """Upper end of the wavenumbers at which the spectra of all scans are reliable."""
    psd_upper_limit: str
    """Limit that sets the upper end of the reliable spectrum: `pixel`, `roll_off` or `noise_floor`."""
    hurst_range_low_m: float | None
    """Shortest lag from which the Hurst exponent of a scan was fitted."""
    hurst_range_high_m: float | None
    """Longest lag from which the Hurst exponent was fitted."""
    scans: list[ScanOfPart]
    """The scans."""
    companions: Mapping[str, Any] = field(default_factory=dict)
    """Further keys: intervals ``x_interval``, standard errors ``x_se`` and the like."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"scans": ScanOfPart}


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceStatistics(WithCompanions):
    """Statistics of a map after levelling; keys as in `asperity surface stats`."""

    nx: int
    """Points along x."""
    ny: int
    """Points along y."""
    dx_m: float
    """Pitch along x."""
    dy_m: float
    """Pitch along y."""
    missing_points: int
    """Missing points, rejected outliers included."""
    outliers: int
    """Points rejected as outliers."""
    form_radius_m: float | None = None
    """Radius of the cylinder or sphere that was removed, positive for a ridge or cap."""
    Sa_m: float
    """Arithmetical mean height."""
    Sq_m: float
    """Root mean square height."""
    Ssk: float | None
    """Skewness of the heights."""
    Sku: float | None
    """Kurtosis of the heights, 3 for a normal distribution."""
    Sp_m: float
    """Highest peak."""
    Sv_m: float
    """Deepest pit."""
    Sz_m: float
    """Maximum height Sp + Sv."""
    Sdq: float | None
    """Root mean square gradient by forward differences."""
    Sdq_7point: float | None
    """Root mean square gradient by the seven-point stencil."""
    Sdr: float | None
    """Developed interfacial area ratio by triangulation."""
    Sal_m: float | None
    """Autocorrelation length at 0.2."""
    Str: float | None
    """Texture aspect ratio, from 0 for a lay to 1 for none."""
    Std_rad: float | None
    """Direction of the lay, counter-clockwise from x as the map is seen; from 0 to below π, meaningful if Str is
    small.
    """
    Ssw_m: float | None
    """Dominant wavelength."""
    Sk_m: float
    """Core height; by the least-squares line of ISO 25178-2, as the parameters up to Svkx."""
    Spk_m: float
    """Reduced peak height."""
    Svk_m: float
    """Reduced dale depth."""
    Smrk1: float
    """Upper material ratio of the core."""
    Smrk2: float
    """Lower material ratio of the core."""
    Spkx_m: float
    """Height of the highest peak above the core."""
    Svkx_m: float
    """Depth of the deepest dale below the core."""
    Sxp_m: float
    """Peak extreme height, between the material ratios 2.5 % and 50 %."""
    Sk_secant_m: float
    """Core height by the secant; the flattest one, as for the next four parameters."""
    Spk_secant_m: float
    """Reduced peak height by the secant."""
    Svk_secant_m: float
    """Reduced dale depth by the secant."""
    Smrk1_secant: float
    """Upper material ratio of the core by the secant."""
    Smrk2_secant: float
    """Lower material ratio of the core by the secant."""
    Vmp_m: float
    """Peak material volume per area."""
    Vmc_m: float
    """Core material volume per area."""
    Vvc_m: float
    """Core void volume per area."""
    Vvv_m: float
    """Dale void volume per area."""
    psd_reliable_low_rad_per_m: float
    """Lower end of the wavenumbers at which the radial spectrum is reliable."""
    psd_reliable_high_rad_per_m: float
    """Upper end of the wavenumbers at which the radial spectrum is reliable; none is if it is not above the lower
    end.
    """
    psd_upper_limit: str
    """Limit that sets the upper end of the reliable spectrum: `pixel`, `roll_off` or `noise_floor`."""
    psd_corners_m2: float
    """Variance outside the rings of the radial spectrum; in the corners of its plane, or below the first ring."""
    correlation_length_x_m: float | None
    """1/e correlation length along x."""
    correlation_length_y_m: float | None
    """1/e correlation length along y."""
    hurst: float | None
    """Hurst exponent."""
    hurst_se: float | None
    """Standard error of `hurst`."""
    hurst_range_low_m: float | None
    """Shortest lag from which the Hurst exponent was fitted."""
    hurst_range_high_m: float | None
    """Longest lag from which the Hurst exponent was fitted."""
    fractal_dimension: float | None
    """Fractal dimension 3 − H."""
    companions: Mapping[str, Any] = field(default_factory=dict)
    """Further keys: intervals ``x_interval``, standard errors ``x_se`` and the like."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CovarianceCandidateResult(Record):
    """A covariance that was tried."""

    model: str
    """Name of the model; `empirical` is the scan's own."""
    misfit: float | None
    """Root mean square of ln(measured/model spectral density) over the reliable band, of a model."""
    slope_ratio: float | None
    """Sdq of random maps over Sdq of the scan; as expected, without sampling."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EmpiricalCovariance(Record):
    """Changes that made the scan's own autocorrelation a covariance. All correlations are relative to the variance."""

    mean_share: float
    """Fraction of the variance removed with the map's mean; lags and variance are corrected for it."""
    standard_error: float
    """Standard error of a lag near zero in a field without correlation there, √(Σρ²/N)."""
    reliable_x_m: float
    """Largest lag along x, over all directions, up to which the estimate is used as it stands."""
    reliable_y_m: float
    """Largest lag along y up to which the estimate is used as it stands."""
    decayed_x: bool
    """Whether the correlation decays along x within the map. Otherwise the taper shortened it."""
    decayed_y: bool
    """Whether the correlation decays along y within the map."""
    taper_change: float
    """Largest change of a lag by the taper."""
    clipped_variance: float
    """Fraction of the variance in negative values of the tapered spectrum, which were set to zero."""
    clipping_change: float
    """Largest change of a lag by the balancing of the spectrum and the end of its factor."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CovarianceResult(Record):
    """Covariance of the random surfaces."""

    model: str
    """Name of the model; `empirical` is the scan's own."""
    std_m: float
    """Standard deviation."""
    length_x_m: float
    """Length ℓ of the model along x: the scale of the Matérn model, the roll-off length of the self-affine one,
    otherwise, and without a model, the lag at which the correlation falls to 1/e.
    """
    length_y_m: float
    """Length ℓ of the model along y."""
    decay_length_x_m: float
    """Lag along x at which the correlation is 1/e, for every model; compares with `correlation_length_x_m` of the
    scan.
    """
    decay_length_y_m: float
    """Lag along y at which the correlation is 1/e."""
    smoothness: float | None
    """Smoothness ν of a Matérn model."""
    hurst: float | None
    """Hurst exponent of a self-affine model."""
    misfit: float | None
    """Root mean square of ln(measured/model spectral density) over the reliable band, where fitted."""
    slope_ratio: float | None
    """Sdq of random maps over Sdq of the scan, within its reliable band; in the root mean square on the scan's grid,
    both S-filtered at `slope_cutoff_m`, where the covariance is the scan's.
    """
    slope_cutoff_m: float | None
    """Cutoff of the S-filter of both Sdq: the end of the scan's reliable band, or four pixels."""
    candidates: list[CovarianceCandidateResult]
    """The covariances that were tried, the most likely model first."""
    empirical: EmpiricalCovariance | None = None
    """Changes that made the scan's own autocorrelation a covariance."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "candidates": CovarianceCandidateResult,
        "empirical": EmpiricalCovariance,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class DistributionResult(Record):
    """A fitted or stated distribution."""

    name: str
    """Name of the distribution."""
    parameters: dict[str, float]
    """Parameters by name; empty for an empirical distribution."""


@dataclass(frozen=True, kw_only=True, eq=False)
class KarhunenLoeveResult(Record):
    """A Karhunen–Loève expansion."""

    modes: int
    """Number of terms."""
    captured_variance: float
    """Fraction of the variance in the terms."""
    captured_slope_variance: float
    """Fraction of the mean squared slope on the patch's grid in the terms."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceResult(WithCompanions):
    """The surface stage. The statistics stand beside the other keys."""

    covariance: CovarianceResult | None = None
    """Covariance of the random surfaces; absent for Weierstrass–Mandelbrot surfaces, which are not made from one."""
    marginal: DistributionResult
    """Marginal distribution of the random surfaces."""
    karhunen_loeve: KarhunenLoeveResult | None
    """Karhunen–Loève expansion on the patches of the pressure stage."""
    scan_count: int | None = None
    """Number of scans."""
    nx: int | None = None
    """Points along x; `null` where the scans differ, as for the next three."""
    ny: int | None = None
    """Points along y."""
    dx_m: float | None = None
    """Pitch along x."""
    dy_m: float | None = None
    """Pitch along y."""
    missing_points: int | None = None
    """Missing points of all scans."""
    outliers: int | None = None
    """Points of all scans rejected as outliers."""
    psd_reliable_low_rad_per_m: float | None = None
    """Lower end of the wavenumbers at which the spectra of all scans are reliable."""
    psd_reliable_high_rad_per_m: float | None = None
    """Upper end of the wavenumbers at which the spectra of all scans are reliable."""
    psd_upper_limit: str | None = None
    """Limit that sets the upper end of the reliable spectrum: `pixel`, `roll_off` or `noise_floor`."""
    hurst_range_low_m: float | None = None
    """Shortest lag from which the Hurst exponent of a scan was fitted."""
    hurst_range_high_m: float | None = None
    """Longest lag from which the Hurst exponent was fitted."""
    scans: list[ScanOfPart] | None = None
    """The scans."""
    form_radius_m: float | None = None
    """Radius of the cylinder or sphere that was removed, positive for a ridge or cap."""
    Sa_m: float | None = None
    """Arithmetical mean height."""
    Sq_m: float | None = None
    """Root mean square height."""
    Ssk: float | None = None
    """Skewness of the heights."""
    Sku: float | None = None
    """Kurtosis of the heights, 3 for a normal distribution."""
    Sp_m: float | None = None
    """Highest peak."""
    Sv_m: float | None = None
    """Deepest pit."""
    Sz_m: float | None = None
    """Maximum height Sp + Sv."""
    Sdq: float | None = None
    """Root mean square gradient by forward differences."""
    Sdq_7point: float | None = None
    """Root mean square gradient by the seven-point stencil."""
    Sdr: float | None = None
    """Developed interfacial area ratio by triangulation."""
    Sal_m: float | None = None
    """Autocorrelation length at 0.2."""
    Str: float | None = None
    """Texture aspect ratio, from 0 for a lay to 1 for none."""
    Std_rad: float | None = None
    """Direction of the lay, counter-clockwise from x as the map is seen; from 0 to below π, meaningful if Str is
    small.
    """
    Ssw_m: float | None = None
    """Dominant wavelength."""
    Sk_m: float | None = None
    """Core height; by the least-squares line of ISO 25178-2, as the parameters up to Svkx."""
    Spk_m: float | None = None
    """Reduced peak height."""
    Svk_m: float | None = None
    """Reduced dale depth."""
    Smrk1: float | None = None
    """Upper material ratio of the core."""
    Smrk2: float | None = None
    """Lower material ratio of the core."""
    Spkx_m: float | None = None
    """Height of the highest peak above the core."""
    Svkx_m: float | None = None
    """Depth of the deepest dale below the core."""
    Sxp_m: float | None = None
    """Peak extreme height, between the material ratios 2.5 % and 50 %."""
    Sk_secant_m: float | None = None
    """Core height by the secant; the flattest one, as for the next four parameters."""
    Spk_secant_m: float | None = None
    """Reduced peak height by the secant."""
    Svk_secant_m: float | None = None
    """Reduced dale depth by the secant."""
    Smrk1_secant: float | None = None
    """Upper material ratio of the core by the secant."""
    Smrk2_secant: float | None = None
    """Lower material ratio of the core by the secant."""
    Vmp_m: float | None = None
    """Peak material volume per area."""
    Vmc_m: float | None = None
    """Core material volume per area."""
    Vvc_m: float | None = None
    """Core void volume per area."""
    Vvv_m: float | None = None
    """Dale void volume per area."""
    psd_corners_m2: float | None = None
    """Variance outside the rings of the radial spectrum; in the corners of its plane, or below the first ring."""
    correlation_length_x_m: float | None = None
    """1/e correlation length along x."""
    correlation_length_y_m: float | None = None
    """1/e correlation length along y."""
    hurst: float | None = None
    """Hurst exponent."""
    hurst_se: float | None = None
    """Standard error of `hurst`."""
    fractal_dimension: float | None = None
    """Fractal dimension 3 − H."""
    companions: Mapping[str, Any] = field(default_factory=dict)
    """Further keys: intervals ``x_interval``, standard errors ``x_se`` and the like."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "covariance": CovarianceResult,
        "marginal": DistributionResult,
        "karhunen_loeve": KarhunenLoeveResult,
        "scans": ScanOfPart,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class PressureQuantile(Record):
    """A quantile of the pressure."""

    probability: float
    """Probability."""
    pressure_pa: float
    """Quantile; 0 up to the probability of no contact."""
    pressure_pa_interval: list[float] | None
    """95 % interval of `pressure_pa`; absent without standard errors."""


PressureMethod = Literal[
    "monte_carlo",
    "latin_hypercube",
    "sobol",
    "polynomial_chaos",
    "polynomial_chaos_log",
    "polynomial_chaos_local",
    "default",
]
"""Method for the pressure."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CoarseEntry(Record):
    """Contact solves on one coarser grid."""

    nx: int
    """Points along x."""
    ny: int
    """Points along y."""
    solves: int
    """Number of solves."""
    work_in_fine_solves: float
    """Work of these solves in fine solves, by cells and iterations."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MethodEntry(Record):
    """One method of the pressure stage."""

    name: PressureMethod
    """Name."""
    fine_solves: int
    """Contact solves."""
    coarse_solves: list[CoarseEntry]
    """Contact solves on coarser grids."""
    work_in_fine_solves: float
    """Work of all solves in fine solves; coarse solves count by cells and iterations."""
    failed_samples: int
    """Contact solves that failed."""
    contact_probability: float | None
    """P(contact)."""
    contact_probability_bias: float | None
    """Bias of P(contact); estimated from samples that a model is not fitted to; absent without a bias."""
    contact_probability_se: float | None
    """The standard error of P(contact) less its bias."""
    contact_probability_interval: list[float] | None
    """95 % interval of `contact_probability`, which allows for bias and error."""
    mean_pa: float | None
    """Mean pressure, zeros out of contact included."""
    mean_bias_pa: float | None
    """Bias of the mean pressure; estimated in the same way."""
    mean_se_pa: float | None
    """The standard error of the mean less its bias."""
    mean_interval: list[float] | None
    """95 % interval of `mean_pa`, which allows for bias and error."""
    std_pa: float | None
    """Standard deviation of the pressure, zeros out of contact included."""
    quantiles: list[PressureQuantile]
    """Quantiles."""
    simultaneous_band_factor: float | None
    """Half width of the simultaneous 95 % band of the distribution function in standard errors, around the estimate
    less its bias; the table `pressure_bands` lists biases and standard errors.
    """
    ks_distance: float | None
    """Kolmogorov–Smirnov distance from the reference."""
    wasserstein_1_over_std: float | None
    """Wasserstein-1 distance from the reference over its standard deviation."""
    coefficients: int | None
    """Coefficients of the expansion."""
    leave_one_out_error: float | None
    """Relative leave-one-out error of the expansion."""
    interval_failure: str | None
    """Reason why there are no intervals."""
    failure: str | None
    """Reason why there is no estimate."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"coarse_solves": CoarseEntry, "quantiles": PressureQuantile}


@dataclass(frozen=True, kw_only=True, eq=False)
class ScalarQuantile(Record):
    """A quantile of a scalar."""

    probability: float
    """Probability."""
    value: float
    """Quantile."""
    value_interval: list[float]
    """95 % interval of `value`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScalarEntry(Record):
    """A quantity of the whole contact, estimated by the default method."""

    name: str
    """Name with the unit of all values."""
    mean: float
    """Mean."""
    mean_se: float
    """Standard error of `mean`."""
    mean_interval: list[float]
    """95 % interval of `mean`."""
    std: float
    """Standard deviation."""
    quantiles: list[ScalarQuantile]
    """Quantiles."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"quantiles": ScalarQuantile}


@dataclass(frozen=True, kw_only=True, eq=False)
class MapsEntry(Record):
    """Samples and accuracy of the maps of all cells. The maps are fields: `contact_probability`, `pressure_mean`,
    `pressure_quantile_10`, `_50` and `_90`, and `expansion_error`.
    """

    samples: int
    """Samples of contact probabilities and means."""
    kept_samples: int
    """Samples of quantiles, standard errors and the expansion."""
    contact_probability_largest_half_width: float | None
    """Largest half width of the 95 % intervals of the contact probabilities, each cell by itself."""
    mean_largest_se_pa: float | None
    """Largest standard error of the mean pressures."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HomogeneityEntry(Record):
    """Whether cells differ in contact probability or mean pressure."""

    cells: int | None
    """Cells compared."""
    samples: int | None
    """Independent samples of them."""
    contact_p_value: float | None
    """p-value of equal contact probabilities."""
    mean_p_value: float | None
    """p-value of equal mean pressures."""
    p_value: float | None
    """p-value of both."""
    plausible: bool | None
    """Whether the samples do not show that cells differ, at 5 %."""
    failure: str | None
    """Reason why there is no result."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GlobalExpansionEntry(Record):
    """An expansion of the pressures of all cells in the leading standard normal variables."""

    variables: int | None
    """Number of leading standard normal variables."""
    degree: int | None
    """Total degree."""
    coefficients: int | None
    """Coefficients of each cell."""
    leave_one_out_error: float | None
    """Relative leave-one-out error, mean over the cells that vary."""
    failure: str | None
    """Reason why there is no expansion."""


@dataclass(frozen=True, kw_only=True, eq=False)
class IndexEntry(Record):
    """Sobol' indices of one variable."""

    name: str
    """Name of the variable."""
    first_order: float
    """First-order index."""
    first_order_se: float
    """Standard error of `first_order`."""
    first_order_interval: list[float]
    """95 % interval of `first_order`."""
    total: float
    """Total index."""
    total_se: float
    """Standard error of `total`."""
    total_interval: list[float]
    """95 % interval of `total`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SensitivityEntry(Record):
    """Sobol' indices of one quantity with respect to one set of variables: fractions of the variance that an
    expansion explains.
    """

    quantity: str
    """Name of the quantity with its unit."""
    variables: str
    """`local`: the height of the cell and of rings around it; `global`: the leading standard normal variables."""
    indices: list[IndexEntry]
    """One entry for each variable."""
    terms: int | None
    """Terms of the expansion."""
    cross_validated_error: float | None
    """Fraction of the variance that the expansion does not predict, by cross-validation."""
    failure: str | None
    """Reason why there are no indices."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"indices": IndexEntry}


@dataclass(frozen=True, kw_only=True, eq=False)
class PressureResult(Record):
    """The pressure stage."""

    cell: list[int]
    """Cell [row, column] whose pressure is studied."""
    reference_samples: int
    """Contact solves of the reference run; 0 if only the default method is used, whose estimate is then the answer."""
    sites: int
    """Cells of each sample whose pressures are pooled: more than one if the surface is stationary on a periodic
    patch.
    """
    contact_probability: float
    """P(contact): of the reference run or, without one, of the default method."""
    contact_probability_se: float | None
    """Standard error of `contact_probability`."""
    contact_probability_interval: list[float] | None
    """95 % interval of `contact_probability`."""
    mean_pa: float
    """Mean pressure, zeros out of contact included."""
    mean_se_pa: float | None
    """Standard error of `mean_pa`."""
    mean_interval: list[float] | None
    """95 % interval of `mean_pa`."""
    std_pa: float
    """Standard deviation of the pressure, zeros out of contact included."""
    quantiles: list[PressureQuantile]
    """Quantiles of the pressure."""
    ks_resolution: float | None
    """Smallest Kolmogorov–Smirnov distance that the reference resolves at 95 %; `null` without a reference."""
    failed_samples: int
    """Contact solves that failed: those of the reference run or, without one, of the default method."""
    mean_compliance_m_per_pa: float | None
    """Mean compliance of a periodic patch."""
    separation_m: float | None
    """Height of the plane above the mean of the ensemble, where it is fixed in space."""
    methods: list[MethodEntry]
    """One entry per method."""
    scalars: list[ScalarEntry]
    """Quantities of the whole contact."""
    maps: MapsEntry | None
    """Samples and accuracy of the maps of all cells; `null` without maps."""
    homogeneity: HomogeneityEntry | None
    """Test of equal distributions in all cells; `null` without maps."""
    global_expansion: GlobalExpansionEntry | None
    """The expansion of all cells; `null` without maps."""
    sensitivities: list[SensitivityEntry]
    """Sobol' indices, one entry for each quantity and set of variables."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "quantiles": PressureQuantile,
        "methods": MethodEntry,
        "scalars": ScalarEntry,
        "maps": MapsEntry,
        "homogeneity": HomogeneityEntry,
        "global_expansion": GlobalExpansionEntry,
        "sensitivities": SensitivityEntry,
    }


RoughBody = Literal["track", "slider", "both"]
"""Rough body."""


@dataclass(frozen=True, kw_only=True, eq=False)
class OperatingPoint(Record):
    """The friction coefficient at the operating point: the level at the nominal pressure, the percentile that the
    study names or, without a vibration stage, the level with the highest pressure. Windows are weighted by the
    load they carry, as in `at_mean_load`.
    """

    level: str
    """The level in words."""
    percentile: float | None
    """Percentage of the heights above the plane; `null` if not prescribed."""
    penetration_m: float
    """Mean depth of the plane below the highest point of each strip."""
    mean_pressure_pa: float
    """Mean pressure."""
    contact_fraction: float
    """Contact area over nominal area, corrected: the probability of contact at a point."""
    contact_fraction_interval: list[float] | None
    """95 % interval of `contact_fraction`; `null` if the strips contain too few correlation lengths."""
    contact_stiffness_pa_per_m: float | None
    """Contact stiffness −dp̄/dḡ over the nominal area, with the mean gap ḡ, against unloading and small vibration:
    plastic cells move elastically too, and the mean compliance is not part of it. `null` on free strips.
    """
    contact_stiffness_pa_per_m_se: float | None
    """Standard error of `contact_stiffness_pa_per_m` over the strips."""
    mean: float
    """The friction coefficient μ̄ = ΣF/ΣN."""
    mean_interval: list[float] | None
    """95 % interval of `mean` with its whole error: the computation, the difference between random and scanned
    surface, and the limited scan. `null` if strips or scan contain too few correlation lengths.
    """
    mean_computational_interval: list[float] | None
    """95 % interval of `mean` for the random surface: the sampling of its strips and their pitch."""
    mean_sampling_interval: list[float] | None
    """95 % interval of `mean` due to the sampling of strips alone."""
    mean_of_scan: float | None
    """The friction coefficient of the scan itself with all its waves, pressed at the same mean pressure; `null`
    without a scan, with a rough counterface, and for laws that do not depend on the contact.
    """
    grid_error: float | None
    """Error of `mean` after its extrapolation in the pitch of the strips: the last term of the series; `null` if
    half the pitch has no solution.
    """
    saturation: float | None
    """1 − (τ_max/H)/`mean`: the fraction of `mean` that depends on the surface; `null` without a hardness."""
    resolved: bool
    """Whether the strips resolve the surface and resemble the scan: errors of the pitch of at most 3 %, rms slopes
    and friction within 15 % of those of the scan.
    """
    std: float
    """Standard deviation of one window."""
    std_interval: list[float] | None
    """95 % interval of `std`."""
    std_nominal_area: float
    """Standard deviation of the mean over the nominal area."""


Prescribed = Literal["percentile", "mean_pressure", "penetration"]
"""Quantity that a level of the friction stage prescribes."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GoodnessResult(Record):
    """Distances between the windows and the marginal distribution. The p-values allow for the fit and for the
    correlation of the windows.
    """

    kolmogorov_smirnov: float
    """Kolmogorov–Smirnov distance, the largest difference of the distribution functions."""
    kolmogorov_smirnov_p: float
    """p-value of the Kolmogorov–Smirnov distance."""
    anderson_darling: float | None
    """Anderson–Darling statistic A²; `null` if a window lies at an end of the distribution."""
    anderson_darling_p: float | None
    """p-value of the Anderson–Darling statistic."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ReturnLevelResult(Record):
    """A value that μ exceeds once in a distance on average."""

    distance_m: float
    """Sliding distance."""
    mu: float
    """Value of μ."""
    interval: list[float] | None
    """95 % interval of `mu`; `null` if the likelihood does not bound it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TailResult(Record):
    """Upper tail of μ: a generalised Pareto distribution of the peaks over a threshold."""

    largest: float
    """Largest value."""
    threshold: float
    """Threshold of the peaks."""
    peaks: int
    """Number of separate peaks above the threshold."""
    shape: float
    """Shape ξ: the tail ends below 0, is exponential at 0, and has no moments beyond the order 1/ξ above."""
    shape_interval: list[float]
    """95 % interval of `shape`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CorrelationCurveResult(Record):
    """A curve fitted to the estimated correlation by least squares."""

    model: str
    """Name of the family."""
    length_m: float
    """Correlation length ℓ, with the effect of the window."""
    misfit: float
    """Root mean square difference from the estimated correlation."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CorrelationModelResult(Record):
    """A correlation family fitted by likelihood, without the window."""

    model: str
    """Name of the family."""
    length_m: float
    """Correlation length ℓ without the effect of the window; 0 if that explains the whole correlation."""
    length_interval: list[float]
    """95 % interval of `length_m`."""
    aic_difference: float
    """Difference of −2 ln L from the more likely family; divided by the variance of the scores relative to Gaussian
    strips.
    """
    worse_beyond_chance: bool
    """Whether the strips reject this family: the likelihood of the other is at least 20 times as large."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RankedDistributionResult(Record):
    """A fitted distribution in the ranking."""

    name: str
    """Name; it begins with `shifted_` if a shift was fitted, and is `empirical` for the windows' own distribution."""
    aic_difference: float
    """Difference of Akaike's criterion from the first distribution, for the effective number of independent windows."""
    gof: GoodnessResult | None
    """Goodness of fit; `null` for the empirical distribution."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"gof": GoodnessResult}


@dataclass(frozen=True, kw_only=True, eq=False)
class AtMeanLoad(Record):
    """Friction at constant load, μ̄ + (F − μ̄N)/N̄ with the force F and load N of a window; it drives the vibration
    stage.
    """

    mean: float
    """Mean friction coefficient μ̄ = ΣF/ΣN."""
    mean_interval: list[float] | None
    """95 % interval of `mean`: the error of the quotient is, to first order, that of the mean of μ̄ + (F − μ̄N)/N̄."""
    std: float
    """Standard deviation."""
    std_interval: list[float] | None
    """95 % interval of `std`."""
    skewness: float | None
    """Skewness; `null` if friction does not vary."""
    excess_kurtosis: float | None
    """Excess kurtosis; `null` if friction does not vary."""
    correlation_length_m: float | None
    """Correlation length ℓ of the exponential fit, with the effect of the window."""
    correlation_length_m_interval: list[float] | None
    """95 % interval of `correlation_length_m`."""
    correlation_curves: list[CorrelationCurveResult]
    """Both families fitted to the correlation, the closest first; their ℓ includes the effect of the window."""
    correlation_models: list[CorrelationModelResult]
    """Both families fitted without the effect of the window, jointly over windows of W to W/8, the more likely
    first.
    """
    marginal: DistributionResult | None
    """Marginal distribution ranked first by Akaike's criterion."""
    marginal_parameter_intervals: dict[str, list[float] | None]
    """Intervals of its fitted parameters."""
    gof: GoodnessResult | None
    """Goodness of fit; `null` for the empirical distribution."""
    laws: list[RankedDistributionResult]
    """All fitted distributions, ordered by Akaike's criterion. `marginal` is the first whose ends lie within the
    data.
    """
    effective_windows: float
    """Effective number of independent windows."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "correlation_curves": CorrelationCurveResult,
        "correlation_models": CorrelationModelResult,
        "marginal": DistributionResult,
        "gof": GoodnessResult,
        "laws": RankedDistributionResult,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class StationarityResult(Record):
    """Tests for drifts of friction along the strips, at the mean load, as p-values of no drift."""

    trend_per_m: float | None
    """Slope of μ along the strip."""
    trend_p: float | None
    """p-value of the slope."""
    mean_change_p: float | None
    """p-value of the difference between the means of the halves."""
    ends_p: float | None
    """p-value of the difference between ends and middle."""
    variance_change_p: float | None
    """p-value of the difference between the variances of the halves."""
    wander_p: float | None
    """p-value of the wander of the mean; `null` for ten strips or more."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CrossResult(Record):
    """A correlation coefficient of two quantities of the same windows."""

    correlation: float
    """Correlation of contact area and load."""
    interval: list[float]
    """95 % interval of `correlation`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperUpscalingResult(Record):
    """Friction of one window."""

    std: float
    """Standard deviation of μ."""


@dataclass(frozen=True, kw_only=True, eq=False)
class AreaUpscalingResult(Record):
    """Friction of the nominal area."""

    nominal_area_m2: float
    """Nominal area."""
    windows: float
    """Number of windows in the nominal area."""
    variance_reduction: float
    """Variance of μ over the nominal area divided by the variance of one window."""
    std: float
    """Standard deviation of μ."""


@dataclass(frozen=True, kw_only=True, eq=False)
class UpscalingResult(Record):
    """Standard deviation of friction at the mean load under both upscalings."""

    paper: PaperUpscalingResult
    """One window carries the whole normal force (the paper)."""
    area: AreaUpscalingResult
    """Windows average over the nominal area."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"paper": PaperUpscalingResult, "area": AreaUpscalingResult}


@dataclass(frozen=True, kw_only=True, eq=False)
class LevelResult(Record):
    """One level of the friction stage: the quotient F/N of each window, and the process at the mean load."""

    leading: bool
    """Whether this level is the operating point."""
    control: Prescribed
    """Prescribed quantity."""
    percentile: float | None
    """Percentage of the heights above the plane; `null` if not prescribed."""
    penetration_m: float
    """Mean depth of the plane below the highest point of each strip."""
    mean_pressure_pa: float
    """Mean pressure."""
    contact_fraction: float
    """Contact area over nominal area, corrected."""
    plastic_share: float
    """Fraction of the contact cells at the hardness."""
    mean: float | None
    """Mean of F/N; `null` where it does not exist (tail index of at most 1)."""
    mean_interval: list[float] | None
    """95 % interval of `mean`, which allows for the correlation along the strips; `null` if they contain too few
    correlation lengths.
    """
    std: float | None
    """Standard deviation of F/N. Without a variance, for the reason in `no_variance`, it is `null`, and so is every
    other number that needs one.
    """
    std_interval: list[float] | None
    """95 % interval of `std`."""
    coefficient_of_variation: float | None
    """Standard deviation over mean."""
    coefficient_of_variation_interval: list[float] | None
    """95 % interval of `coefficient_of_variation`."""
    skewness: float | None
    """Skewness of μ; `null` if μ does not vary."""
    skewness_interval: list[float] | None
    """95 % interval of `skewness`."""
    excess_kurtosis: float | None
    """Excess kurtosis of μ; `null` if μ does not vary."""
    excess_kurtosis_interval: list[float] | None
    """95 % interval of `excess_kurtosis`."""
    correlation_length_m: float | None
    """Correlation length ℓ of the exponential fit, with the effect of the window."""
    correlation_length_m_interval: list[float] | None
    """95 % interval of `correlation_length_m`."""
    marginal: DistributionResult | None
    """Marginal distribution ranked first by Akaike's criterion."""
    marginal_parameter_intervals: dict[str, list[float] | None]
    """Intervals of its fitted parameters."""
    gof: GoodnessResult | None
    """Goodness of fit."""
    return_levels: list[ReturnLevelResult]
    """Values that μ of a window exceeds once in a sliding distance; empty if the strips contain too few separate
    peaks.
    """
    tail: TailResult | None
    """Upper tail of μ of a window; `null` if the strips contain too few separate peaks."""
    beta: DistributionResult | None
    """The beta distribution with bounds fitted by likelihood."""
    no_variance: str | None
    """Reason why F/N has no variance, and so no standard deviation, marginal distribution or return levels; `null`
    if it has one.
    """
    empty_windows: int
    """Windows without contact, left out."""
    correlation_length_without_window_m: float | None
    """Correlation length without the window, fitted jointly over windows of W to W/8; 0 if the windows explain the
    whole correlation.
    """
    correlation_length_without_window_m_interval: list[float] | None
    """95 % interval of `correlation_length_without_window_m`."""
    correlation_without_window_model: str | None
    """Correlation family of the length without the window: `exponential`, or the smooth `matern` of ν = 5/2."""
    correlation_families_told_apart: bool | None
    """Whether the strips tell the two correlation families apart. If not, the exponential is used, and the interval
    of its length covers the integral scales ∫ρ ds of both.
    """
    correlation_without_window_fit_p: float | None
    """p-value of the fit of the correlation family to the spectrum."""
    correlation_without_window_agreement_p: float | None
    """p-value of the agreement between the lengths under each window alone."""
    window_only: bool | None
    """Whether the correlation is due to the window alone, as the interval of the length without it includes lengths
    below one step.
    """
    between_parts_std: float | None
    """Standard deviation between parts of the slider at the mean load, for one window; friction of a part differs
    from the mean by a constant. `null` for a smooth slider and, if both bodies are rough, at other levels than
    the operating point and for free strips. The fluctuation along the path has the rest of the variance of
    `at_mean_load`.
    """
    between_parts_std_interval: list[float] | None
    """95 % interval of `between_parts_std`; `null` with fewer than four strips."""
    at_mean_load: AtMeanLoad
    """Friction of a body that rests on many windows."""
    stationarity: StationarityResult | None
    """Whether friction drifts along the strips; `null` if it does not vary."""
    area_and_load: CrossResult | None
    """Contact area against load of the windows; `null` if one of them does not vary."""
    upscaling: UpscalingResult
    """Standard deviations over the nominal area."""
    contact_cells_per_window: float
    """Mean number of contact cells in a window."""
    sparse_window_share: float
    """Fraction of the windows with fewer than 30 contact cells."""
    effective_windows: float
    """Effective number of independent windows."""
    failed_samples: int
    """Strips that failed."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "marginal": DistributionResult,
        "gof": GoodnessResult,
        "return_levels": ReturnLevelResult,
        "tail": TailResult,
        "beta": DistributionResult,
        "at_mean_load": AtMeanLoad,
        "stationarity": StationarityResult,
        "area_and_load": CrossResult,
        "upscaling": UpscalingResult,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class CutoffPoint(Record):
    """Mean friction without the waves that are shorter than a cut-off."""

    cutoff_m: float
    """Cut-off wavelength of the Gaussian filter; the first entry is the strips, without a filter."""
    mean: float
    """Friction coefficient μ = ΣF/ΣN."""
    mean_interval: list[float] | None
    """Interval of the mean: it contains the error of the study's own mean and of the ratio to it."""
    rms_slope: float
    """Root mean square gradient of the heights, by differences over the pitch."""
    plastic_fraction: float
    """Fraction of the contact cells at the hardness."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FinerPitch(Record):
    """Mean friction of the same surface on smaller cells, not extrapolated."""

    pitch_m: float
    """Pitch of the cells."""
    mean: float
    """Friction coefficient μ = ΣF/ΣN."""
    mean_interval: list[float] | None
    """95 % interval of `mean`."""
    change: float
    """Difference from the mean at the pitch of the strips; it is not extrapolated either."""
    change_interval: list[float]
    """Interval of the difference, which the common random numbers make narrow."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CutoffResult(Record):
    """Dependence of the mean friction coefficient on the shortest waves of the random surface."""

    mean_pressure_pa: float
    """Mean pressure on every strip: the mean pressure at the operating point."""
    strips: int
    """Strips solved for each entry, with the same random numbers."""
    strip_length_m: float
    """Length of the strips."""
    pitch_m: float
    """Pitch of the strips, the larger one if the two differ."""
    cutoff_m: float
    """Shortest wavelength on the study's own strips: twice the pitch, or the shortest wave that the scan resolves."""
    band_end_m: float | None
    """Shortest wavelength at which the spectrum of the scan is reliable; `null` without a scan, or if there is none."""
    plastic_floor: float | None
    """Least friction coefficient, reached if all contacts are at the hardness; `null` without a hardness."""
    points: list[CutoffPoint]
    """One entry per cut-off, from the study's own upwards, in octaves."""
    finer_pitches: list[FinerPitch]
    """The same surface at the study's own cut-off, solved on half the pitch and, while the error of the pitch
    matters and the work is affordable, on half of that.
    """
    known: str
    """Dependence of the friction coefficient on the shortest waves, in a sentence."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"points": CutoffPoint, "finer_pitches": FinerPitch}


@dataclass(frozen=True, kw_only=True, eq=False)
class ScanCutoff(Record):
    """Friction of the scan without the waves that are shorter than a cut-off."""

    cutoff_m: float
    """Length of the shortest wave."""
    mean: float
    """Friction coefficient μ = ΣF/ΣN, extrapolated in the pitch."""
    mean_interval: list[float]
    """95 % interval for the surface of which the scan is a sample, from the differences between its sixteen tiles."""
    grid_error: float | None
    """Error of the mean due to the pitch; `null` if one pitch was solved."""
    order: float | None
    """Observed order of convergence in the pitch; `null` if it is below 0.5 or unknown."""
    std: float
    """Standard deviation of friction between windows of a sixteenth by a quarter of the scan, at the mean load; 0 in
    results of earlier versions.
    """
    rms_slope: float
    """Root mean square gradient of the heights, by differences over the pixels."""
    plastic_fraction: float
    """Fraction of the contact cells at the hardness."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScanFriction(Record):
    """Friction of the scan itself, pressed at the operating point."""

    size_m: list[float]
    """Size of the pressed part of the scan."""
    pitches_m: list[float]
    """Pitches of the solved grids: the larger pixel size and halves of it."""
    slope_ratio: float | None
    """Rms slope of a strip over that of the scan, both within the resolved waves; `null` if these waves do not fit
    on the maps.
    """
    cut_offs: list[ScanCutoff]
    """One entry per cut-off: without waves shorter than those of the strips, between, and with all waves down to
    twice the pixel.
    """

    _nested: ClassVar[Mapping[str, type[Record]]] = {"cut_offs": ScanCutoff}


@dataclass(frozen=True, kw_only=True, eq=False)
class UncertainParameter(Record):
    """An uncertain parameter of the surface."""

    name: str
    """`rms_height` in metre, `correlation_length` along x in metre, or `skewness`."""
    mean: float
    """Mean."""
    std: float
    """Standard deviation."""
    law: DistributionResult
    """Distribution."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"law": DistributionResult}


@dataclass(frozen=True, kw_only=True, eq=False)
class ParameterIndexResult(Record):
    """Sobol' indices of one parameter."""

    parameter: str
    """Name of the parameter."""
    first: float
    """First order: the fraction of the variance that it explains alone."""
    first_interval: list[float]
    """95 % interval of `first`."""
    total: float
    """Total: together with all others."""
    total_interval: list[float]
    """95 % interval of `total`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class UncertainResponse(Record):
    """One moment of friction over the parameters; `null` where it is undefined, for the `reason`."""

    name: str
    """`mean`, `std`, `coefficient_of_variation` or `correlation_length_m`."""
    value: float | None
    """Mean over the parameters."""
    value_interval: list[float] | None
    """Interval of that mean, which allows for the finite numbers of strips and points."""
    std: float | None
    """Standard deviation over the parameters."""
    std_interval: list[float] | None
    """95 % interval of `std`."""
    interval: list[float] | None
    """Interval that contains the moment for 95 % of the parameters."""
    loo_error: float | None
    """Relative leave-one-out error of the expansion in the parameters: the variance that it does not explain."""
    noise_standard_error: float | None
    """Standard error of `value` by the choice of the strips."""
    noise_share: float | None
    """Fraction of the variance over the points that is due to the choice of the strips."""
    sobol: list[ParameterIndexResult]
    """Sobol' indices; empty where there are none."""
    reason: str | None
    """Reason why there are no indices or no numbers at all."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"sobol": ParameterIndexResult}


@dataclass(frozen=True, kw_only=True, eq=False)
class FailedPoint(Record):
    """A point without a result."""

    point: int
    """Place in the design."""
    reason: str
    """Reason."""


@dataclass(frozen=True, kw_only=True, eq=False)
class UncertainLevel(Record):
    """Friction of one level over the parameters."""

    control: Prescribed
    """Prescribed quantity, the same for all surfaces."""
    percentile: float | None
    """Percentage of the heights above the plane."""
    mean_pressure_pa: float | None
    """Prescribed mean pressure."""
    penetration_m: float | None
    """Prescribed penetration."""
    responses: list[UncertainResponse]
    """Moments of the quotient F/N of each window."""
    at_mean_load: list[UncertainResponse]
    """Moments at the mean load."""
    failures: list[FailedPoint]
    """Points without a result, with the reason."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "responses": UncertainResponse,
        "at_mean_load": UncertainResponse,
        "failures": FailedPoint,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class UncertaintyResult(Record):
    """`friction.uncertainty` of `results.json`."""

    points: int
    """Surfaces, each of other parameters."""
    realisations: int
    """Strips of each."""
    parameters: list[UncertainParameter]
    """Uncertain parameters."""
    levels: list[UncertainLevel]
    """Levels, in the order of those of the stage."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"parameters": UncertainParameter, "levels": UncertainLevel}


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionResult(Record):
    """The friction stage."""

    body: RoughBody
    """Body that is rough. Unless it is the track alone, windows along the strips are no path: correlation lengths,
    drifts and return levels are `null` or empty, and standard deviations are those between windows of different
    parts.
    """
    window_m: float
    """Length of the window."""
    window_width_m: float
    """Width of the window."""
    strip_width_m: float
    """Width of the strip."""
    mean_compliance_m_per_pa: float | None
    """Mean compliance of a periodic strip."""
    realisations: int
    """Strips per level."""
    operating_point: OperatingPoint
    """The friction coefficient that drives the vibration, and that the report and the program state."""
    levels: list[LevelResult]
    """Levels of contact."""
    cutoff: CutoffResult | None = None
    """Mean friction over the shortest wavelength; absent for Coulomb's law, and if there is no solution."""
    scan: ScanFriction | None
    """Friction of the scan itself at the operating point; `null` without a scan."""
    uncertainty: UncertaintyResult | None = None
    """Friction over uncertain parameters of the surface; absent if the study states none."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "operating_point": OperatingPoint,
        "levels": LevelResult,
        "cutoff": CutoffResult,
        "scan": ScanFriction,
        "uncertainty": UncertaintyResult,
    }


MotionKind = Literal["stick_slip", "overtaking", "slip_cycle", "flutter", "divergence", "none"]
"""Kind of motion."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CycleResult(Record):
    """A deterministic limit cycle of any kind; keys as in `asperity vibration cycle`."""

    damping_ratio: float
    """Damping ratio."""
    limit_cycle: bool
    """Whether there is a cycle."""
    period: float | None
    """Period τ."""
    slip_duration: float | None
    """Duration τ of the slip."""
    reattachment_displacement: float | None
    """Displacement X at re-attachment."""
    displacement_min: float | None
    """Least displacement X."""
    displacement_max: float | None
    """Largest displacement X."""
    velocity_min: float | None
    """Least velocity dX/dτ."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MapResolutionResult(Record):
    """Resolution of the transition of the probability in a map."""

    x: float
    """Width of the smallest cells along x."""
    y: float
    """Width of the smallest cells along y."""
    unresolved_share: float
    """Fraction of the cells on the contour of 50 % in which the probability falls from 95 % to 5 %, so that the
    width of the transition is less than a cell and not known.
    """


@dataclass(frozen=True, kw_only=True, eq=False)
class MapResult(Record):
    """Parameters and resolution of a stability map."""

    x: str
    """First parameter: `damping_ratio` or `belt_velocity`."""
    y: str
    """Second parameter: `belt_velocity`, `friction_std` or `load_ratio`."""
    resolution: MapResolutionResult
    """Widths of the smallest cells, and whether they resolve the transition."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"resolution": MapResolutionResult}


@dataclass(frozen=True, kw_only=True, eq=False)
class DampingResult(Record):
    """Cycle counts at one damping ratio."""

    damping_ratio: float
    """Damping ratio."""
    kind: MotionKind
    """Kind of motion without noise."""
    cycles_deterministic: int
    """Slips that reach a negative velocity, without noise."""
    cycles_mean: float
    """Mean number of slips that reach a negative velocity, with noise."""
    cycles_se: float
    """Standard error of `cycles_mean`."""
    difference_mean: float
    """Slips lost by noise, M_diff = M_det − E M."""
    difference_interval: list[float]
    """95 % interval of `difference_mean`."""
    share_in_cycle: float
    """Fraction of the time in vibration."""
    vibration_share: float
    """Mean fraction of the second half of the time in vibration."""
    vibration_share_se: float
    """Standard error of `vibration_share`."""
    sustained_share: float
    """Fraction of the trajectories that vibrate for at least half of the second half of their time."""
    sustained_share_interval: list[float]
    """95 % interval of `sustained_share`."""
    failed_samples: int
    """Trajectories that failed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CrossingResult(Record):
    """Damping ratio at which the mean fraction of the second half of the duration spent in vibration, started in
    stick, falls below a level.
    """

    share: float
    """Fraction of the second half of the time in vibration."""
    damping_ratio: float | None
    """Damping ratio; `null` if there is none."""
    damping_ratio_interval: list[float] | None
    """95 % interval of `damping_ratio`."""
    reason: str | None = None
    """Reason why there is no damping ratio."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PointsResult(Record):
    """Distribution of points along the trajectories."""

    count: int
    """Number of points."""
    mean: float | None
    """Mean displacement."""
    std: float | None
    """Standard deviation."""
    skewness: float | None
    """Skewness."""
    excess_kurtosis: float | None
    """Excess kurtosis."""
    normality_p: float | None
    """p-value of normality."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionResult(Record):
    """Regularity and persistence of vibration."""

    period_mean: float | None
    """Mean time τ from one cycle to the next, as long as vibration is not lost."""
    period_std: float | None
    """Standard deviation of the time τ from one cycle to the next."""
    stick_share: float
    """Fraction of the time in stick."""
    stick_share_se: float
    """Standard error of `stick_share` over trajectories."""
    share_in_cycle: float
    """Fraction of the time in vibration."""
    kind_shares: dict[str, float]
    """Fraction of the time in each kind of motion."""
    exit_rate: float | None
    """Losses of vibration per τ in it."""
    exit_rate_interval: list[float] | None
    """95 % interval of `exit_rate`."""
    entry_rate: float | None
    """Returns to vibration per τ out of it."""
    entry_rate_interval: list[float] | None
    """95 % interval of `entry_rate`."""
    left_share: float
    """Fraction of the trajectories that leave vibration at all."""
    left_share_interval: list[float]
    """95 % interval of `left_share`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EnsembleResult(Record):
    """Ensembles over the damping sweep for one upscaling."""

    friction_std: float
    """Standard deviation of μ."""
    clipped_fraction: float
    """Fraction of the friction values that are clipped to stay positive."""
    damping: list[DampingResult]
    """One entry per damping ratio."""
    crossings: list[CrossingResult]
    """Damping ratios at which vibration falls below 95, 50 and 5 % of the second half of the duration."""
    reattachment: PointsResult
    """Distribution of the re-attachment points at the study's damping ratio."""
    release: PointsResult
    """Distribution of the points at which the mass leaves the belt, at the study's damping ratio."""
    motion: MotionResult | None
    """Motion in time at the study's damping ratio; `null` if friction is constant."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "damping": DampingResult,
        "crossings": CrossingResult,
        "reattachment": PointsResult,
        "release": PointsResult,
        "motion": MotionResult,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class VibrationResult(Record):
    """The vibration stage."""

    damping_ratio: float
    """Damping ratio ζ of the study."""
    belt_velocity: float
    """Dimensionless belt velocity V."""
    static_friction: float
    """Mean friction coefficient μ_st."""
    level_percentile: float | None
    """Percentile of the level of the friction stage that is used; `null` if the level is at N/nominal_area or
    friction is stated.
    """
    level_mean_pressure_pa: float | None
    """Mean pressure of the level of the friction stage."""
    friction_correlation_length_m: float | None
    """Correlation length of μ; `null` for a rough slider, whose friction is constant for each part."""
    correlation_length: float | None
    """Correlation length of μ in X, as sliding distance over N/c."""
    marginal: DistributionResult | None
    """Marginal distribution of μ; `null` if friction is constant."""
    variance_reduction: float
    """Variance of μ over the nominal area divided by the variance of one window."""
    critical_damping_ratio: float | None
    """Damping ratio ζ_c above which no cycle reaches the belt velocity; `null` if the search failed."""
    hopf_damping_ratio: float | None
    """Damping ratio ζ_H below which steady sliding is unstable."""
    limit_damping_ratio: float | None
    """Damping ratio ζ_v above which no vibration persists; `null` if the search failed."""
    kind: MotionKind
    """Kind of motion without fluctuation, started in stick, at the study's damping ratio."""
    steady_sliding_unstable: bool | None
    """Whether steady sliding is unstable at the study's damping ratio; `null` under forcing."""
    kick_m_per_s: float | None
    """Smallest change of velocity, of either sign, after which a machine that slides steadily vibrates; `null` if
    none is needed, none suffices, or under forcing.
    """
    cycle: CycleResult
    """The deterministic motion at the study's damping ratio."""
    upscaling: str
    """Upscaling that the study uses: `area` or `paper`; both are computed."""
    map: MapResult | None = None
    """The stability map, if one is asked for; its numbers are tables."""
    paper: EnsembleResult
    """One window carries the whole normal force (the paper)."""
    area: EnsembleResult
    """Windows average over the nominal area."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "marginal": DistributionResult,
        "cycle": CycleResult,
        "map": MapResult,
        "paper": EnsembleResult,
        "area": EnsembleResult,
    }


CoupledMotion = Literal["cycle", "steady", "locked", "irregular"]
"""Long-term motion."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CoupledCycleResult(Record):
    """Limit cycle of two coupled modes."""

    frequency_hz: float
    """Frequency of the limit cycle."""
    velocity_amplitude_m_per_s: float
    """Half the difference of the largest and the smallest velocity along the belt."""
    displacement_amplitude_m: float
    """Half the difference of the largest and the smallest displacement along the belt."""
    normal_amplitude_m: float
    """Half the difference of the largest and the smallest displacement across the belt."""
    stick_share: float
    """Fraction of the period in stick."""
    flight_share: float
    """Fraction of the period off the belt."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ModeCouplingResult(Record):
    """The machine with the mean friction coefficient, without fluctuation. Stiffnesses are in units of mω₀²."""

    damping_ratio: float
    """Damping ratio ζ: dampers of 2ζmω₀ along and across the belt."""
    belt_velocity: float
    """Dimensionless belt velocity V."""
    friction: float
    """Mean friction coefficient μ."""
    stiffness: list[float]
    """Stiffness k₁₁, k₁₂, k₂₂ in mω₀² of the mass in contact, without friction."""
    contact_spring: float
    """Stiffness of the contact spring in mω₀²."""
    contact_stiffness_n_per_m: float
    """Stiffness of the contact spring with its unit."""
    coalescence: float | None
    """Friction coefficient at which the undamped modes meet; `null` if friction separates them."""
    critical_friction: float | None
    """Least friction coefficient μ_c at which steady sliding is unstable; `null` if it never is."""
    friction_margin: float | None
    """Margin μ_c − μ."""
    limit_damping_ratio: float | None
    """Damping ratio that just keeps steady sliding stable; `null` if none does."""
    steady_sliding_unstable: bool
    """Whether steady sliding is unstable."""
    kind: MotionKind
    """Kind of the motion: `flutter`, `divergence` or `none`."""
    onset_frequency_hz: float | None
    """Frequency at which flutter begins at μ_c; `null` without flutter."""
    mode_frequencies_hz: list[float]
    """Frequencies of the two modes of small motion, the slow one first; 0 without vibration."""
    mode_growth_rates_per_s: list[float]
    """Growth rates of the two modes of small motion."""
    motion: CoupledMotion | None
    """Long-term motion, started 1 % away from steady sliding; `null` if steady sliding does not exist or is neutral."""
    cycle: CoupledCycleResult | None
    """The limit cycle; `null` if there is none."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"cycle": CoupledCycleResult}


MachineModel = Literal["stick_slip", "mode_coupling"]
"""Model of the machine."""

ErrorCause = Literal["machines", "strips", "expansion", "scan", "grid", "model"]
"""Cause of an error."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Quantiles(Record):
    """Quantiles of a distribution."""

    q05: float
    """5 % quantile."""
    q50: float
    """Median."""
    q95: float
    """95 % quantile."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ErrorSource(Record):
    """Part of the interval of the probability."""

    source: ErrorCause
    """Its cause."""
    half_width: float
    """Distance from the probability to the farther end of the interval if this were its only cause."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LearntFriction(Record):
    """Friction of the contact as a function of the uncertain values, learnt from solved strips."""

    inputs: list[str]
    """Names of the values."""
    points: int
    """Number of solved points."""
    points_near_limit: int
    """Number of them near the limit of vibration."""
    difference_near_limit: float | None
    """Root-mean-square relative difference between the solved and the predicted mean friction coefficient at the
    last points near the limit, before they were used.
    """
    standard_error: float
    """Relative standard error of the mean friction coefficient."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NominalMachine(Record):
    """The machine with all values at their centres."""

    vibrates: bool
    """Whether it vibrates if its motion begins in stick."""
    kind: MotionKind
    """Kind of its motion."""
    steady_sliding_unstable: bool
    """Whether its steady sliding is unstable."""
    kick_m_per_s: float | None
    """Smallest change of velocity after which it vibrates from steady sliding; `null` if none is needed or none
    suffices.
    """
    limit_damping_ratio: float | None
    """Damping ratio ζ_v above which no vibration persists; with mode coupling the one that just keeps steady sliding
    stable, `null` if none does.
    """
    damping_margin: float
    """Margin ζ − ζ_v; with mode coupling the margin of the friction coefficient, μ_c − μ."""
    damping_margin_interval: list[float] | None
    """95 % interval of the margin, by the errors of a computed friction coefficient; `null` if it has none, and in
    results of earlier versions.
    """


@dataclass(frozen=True, kw_only=True, eq=False)
class VibratingMachines(Record):
    """Vibration of the machines that vibrate."""

    kinds: dict[str, float]
    """Fraction of each kind of motion."""
    frequency_hz: Quantiles | None
    """Frequency."""
    velocity_amplitude_m_per_s: Quantiles | None
    """Half the difference of the largest and the smallest velocity."""
    displacement_amplitude_m: Quantiles | None
    """Half the difference of the largest and the smallest displacement."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "frequency_hz": Quantiles,
        "velocity_amplitude_m_per_s": Quantiles,
        "displacement_amplitude_m": Quantiles,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class MarginQuantile(Record):
    """Quantile of the margin."""

    probability: float
    """Probability of a smaller margin."""
    damping_margin: float
    """Margin ζ − ζ_v; with mode coupling the margin of the friction coefficient, μ_c − μ."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Driver(Record):
    """Sensitivity to one uncertain value."""

    input: str
    """Name of the value, `section.key`."""
    first_order: float
    """Fraction of the variance that the value explains alone."""
    first_order_interval: list[float]
    """Its 95 % interval."""
    total: float
    """Fraction of the variance that is left if all other values are known."""
    total_interval: list[float]
    """Its 95 % interval."""
    shapley: float | None
    """Shapley effect, a fraction of the variance; `null` for independent values."""
    shapley_interval: list[float] | None
    """Its 95 % interval."""
    range_reduction: float | None
    """Fraction by which the 5–95 % range of the margin narrows on average once the value is known; `null` for the
    event.
    """


@dataclass(frozen=True, kw_only=True, eq=False)
class Guess(Record):
    """Effect of one unknown value."""

    input: str
    """Name of the value, `section.key`."""
    probability_at_q05: float
    """Probability of vibration with the value at its 5 % quantile."""
    probability_at_q95: float
    """Probability of vibration with the value at its 95 % quantile."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reach(Record):
    """Central value that reaches one probability."""

    probability: float
    """Probability of vibration."""
    value: float | None
    """Nearest central value in the range at which vibration is at most as probable; `null` if there is none."""
    value_interval: list[float] | None
    """Its 95 % interval: the error of the computation."""
    friction_coefficient: float | None
    """Friction coefficient that is left there."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Risk(Record):
    """Probability at one central value."""

    value: float
    """The central value."""
    probability: float
    """Probability of vibration."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Remedy(Record):
    """Change of the central value of one input."""

    input: str
    """Name of the value, `section.key`."""
    unit: str
    """SI unit of the value; empty for a number."""
    held: str | None
    """Damping that stays constant: `damper`, the coefficient c = 2ζmω₀ in N s/m, or `damping_ratio`, ζ; `null` for a
    change of the damping ratio itself.
    """
    now: float
    """Its present central value."""
    range: list[float]
    """Range in which values are searched."""
    friction_coefficient_now: float | None
    """Friction coefficient at the present value."""
    reach: list[Reach]
    """Values that reach the target probabilities."""
    risk: list[Risk]
    """Probability from the present value to beyond the farthest of these; of the first remedy that has one, empty
    for the others.
    """

    _nested: ClassVar[Mapping[str, type[Record]]] = {"reach": Reach, "risk": Risk}


@dataclass(frozen=True, kw_only=True, eq=False)
class TurningPoint(Record):
    """Value at which the machine begins or ceases to vibrate while all its other values stay."""

    input: str
    """Name of the value, `section.key`."""
    unit: str
    """Unit of its values; empty for a number."""
    now: float
    """Present value."""
    value: float | None
    """The nearest such value between a tenth and ten times the present one; `null` if there is none."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ProbabilityMapAxis(Record):
    """One input of a map."""

    input: str
    """Name of the value, `section.key`."""
    unit: str
    """SI unit of the value; empty for a number."""
    values: list[float]
    """Central values."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ProbabilityMap(Record):
    """Probability of vibration over the central values of two inputs."""

    x: ProbabilityMapAxis
    """First input."""
    y: ProbabilityMapAxis
    """Second input."""
    probability: list[list[float]]
    """Probability that a machine vibrates whose motion begins in stick: one row per value of `y`, one column per
    value of `x`.
    """
    leaves_out_fluctuation: bool
    """Whether the friction of the study fluctuates. The map is that of its mean, without fluctuation."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"x": ProbabilityMapAxis, "y": ProbabilityMapAxis}


@dataclass(frozen=True, kw_only=True, eq=False)
class AreaAsOne(Record):
    """Probability of vibration if a number of independent windows share the load."""

    windows: float
    """Number of windows: 1 is the paper's reading, the last is the nominal area over the area of one window."""
    friction_std: float
    """Standard deviation of the friction coefficient along the path and between the parts of a rough slider, of the
    machine with all values at their centres.
    """
    probability: float
    """Probability that a machine vibrates whose motion begins in stick."""
    probability_interval: list[float]
    """Its 95 % interval: the error of the sample."""


InputValue = int | float | str
"""Value of an input."""

InputKind = Literal["measured", "stated", "uncertain", "unknown", "default", "example"]
"""Origin of the value of an input."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RestsOn(Record):
    """Input of the verdict."""

    input: str
    """Name of the input, `section.key`."""
    value: InputValue
    """Central value; of `surface.file` and `counterface.file` the number of scans."""
    unit: str
    """SI unit of the value; empty for a number or a name."""
    kind: InputKind
    """Origin of the value."""
    range: list[float] | None
    """5 % and 95 % quantile of an uncertain or unknown value."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Assumed(Record):
    """Effect of a number that the study does not state: asperity assumes a default, which counts as exact."""

    input: str
    """Name of the value, `section.key`."""
    value: float
    """The default."""
    range: list[float]
    """Range of the value: 0.9 to 1 for `vibration.kinetic_share`, and 2.1 to 8.4, half to twice the default, for
    `vibration.stribeck`.
    """
    probability_at: list[float]
    """`probability` with the value at the low and the high end of its range."""
    probability_interval_at: list[list[float]]
    """Their 95 % intervals: the error of the computation."""
    expected_vibration_share_at: list[float]
    """`expected_vibration_share` with the value at the low and the high end of its range."""


@dataclass(frozen=True, kw_only=True, eq=False)
class VerdictResult(Record):
    """Probability of vibration over the uncertain values of a study, what decides it and what changes it."""

    model: MachineModel
    """Model of the machine. It decides what a margin is."""
    expected_vibration_share: float
    """Expected fraction of the second half of the duration in which a machine vibrates whose motion begins in stick."""
    expected_vibration_share_interval: list[float]
    """Its 95 % interval: the error of the computation."""
    friction_unresolved: bool
    """Whether the friction coefficient is not resolved (`resolved` of the operating point is false): the probability
    is then no answer.
    """
    unresolved_by: list[ErrorCause]
    """Why it is not: the pitch of the strips, or their difference from the scan. Empty if it is."""
    probability: float
    """Probability that a machine whose motion begins in stick vibrates longer than the fraction
    `vibration_threshold` of the second half of the duration, in the mean over realisations of friction. With mode
    coupling, the probability that steady sliding is unstable.
    """
    probability_interval: list[float]
    """Its 95 % interval: the error of the computation."""
    probability_half: float
    """Probability that a machine whose motion begins in stick vibrates for at least half of the second half of the
    duration.
    """
    probability_half_interval: list[float]
    """Its 95 % interval: the error of the computation."""
    vibration_threshold: float
    """Fraction of the time above which a machine with fluctuating friction counts as vibrating."""
    friction_fluctuates: bool
    """Whether the verdict counts a fluctuation of friction along the path, so that a machine may vibrate for a part
    of the time. One whose standard deviation is below 1e-4 of the mean does not count. Then `probability`,
    `expected_vibration_share` and `probability_half` are equal.
    """
    probability_from_steady_sliding: float | None
    """Probability that a machine vibrates which slides steadily at first and is not kicked; `null` if friction
    fluctuates, because the fluctuation starts vibration.
    """
    probability_from_steady_sliding_interval: list[float] | None
    """Its 95 % interval: the error of the computation."""
    probability_range: list[float] | None
    """Range of the probability over the values that are unknown: its 5 and 95 % quantiles. `null` if none is
    unknown.
    """
    probability_over_unknowns: Quantiles | None
    """Quantiles of the probability over the values that are unknown; `null` if none is."""
    error_sources: list[ErrorSource]
    """Parts of the half width of `probability_interval`, largest first."""
    friction: LearntFriction | None
    """Friction as a function of the uncertain values; `null` if it does not depend on them."""
    evaluations: int
    """Number of machines that were evaluated."""
    failed_samples: int
    """Number of them that have no answer."""
    first_failure: str | None = None
    """Reason of the first of them."""
    duration_s: float
    """Duration T of the event."""
    leaves_out_fluctuation: bool
    """Whether the verdict leaves out the fluctuation of friction that the study has: with mode coupling the mean
    friction coefficient decides.
    """
    nominal: NominalMachine
    """The machine with all values at their centres."""
    if_vibrating: VibratingMachines | None
    """The vibration of machines that vibrate; `null` if no sampled machine does."""
    margin_quantiles: list[MarginQuantile]
    """Quantiles of the margin."""
    drivers: list[Driver]
    """Sensitivity of the margin."""
    event_drivers: list[Driver]
    """Sensitivity of the event; empty for probabilities below 5 or above 95 %."""
    guesses: list[Guess]
    """Effect of each unknown value."""
    remedies: list[Remedy]
    """Changes that reach the target probabilities."""
    turning_points: list[TurningPoint]
    """If no value is uncertain and the mean friction decides, what each number of the machine would have to be;
    otherwise empty.
    """
    map: ProbabilityMap | None
    """Probability over the central values of the first two remedies of the study file; `null` if it states fewer."""
    area_as_one: list[AreaAsOne] | None
    """Probability against the number of windows that share the load; `null` if friction neither fluctuates nor
    differs between parts, or is averaged over an unknown area.
    """
    assumptions: list[str]
    """Assumptions of the verdict, in sentences."""
    rests_on: list[RestsOn]
    """Inputs of the verdict with their origin; empty in results of earlier versions."""
    assumed: list[Assumed]
    """Probability with each number that the study does not state at the ends of its range; empty in results of
    earlier versions.
    """

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "probability_over_unknowns": Quantiles,
        "error_sources": ErrorSource,
        "friction": LearntFriction,
        "nominal": NominalMachine,
        "if_vibrating": VibratingMachines,
        "margin_quantiles": MarginQuantile,
        "drivers": Driver,
        "event_drivers": Driver,
        "guesses": Guess,
        "remedies": Remedy,
        "turning_points": TurningPoint,
        "map": ProbabilityMap,
        "area_as_one": AreaAsOne,
        "rests_on": RestsOn,
        "assumed": Assumed,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Results(Record):
    """The content of `results.json`."""

    schema_version: int
    """Version of the keys."""
    seed: int
    """Seed of the study."""
    surface: SurfaceResult | None = None
    """The surface stage."""
    counterface: SurfaceResult | None = None
    """Roughness of the counterface, with the keys of `surface`; absent if it is smooth."""
    pressure: PressureResult | None = None
    """The pressure stage."""
    friction: FrictionResult | None = None
    """The friction stage."""
    vibration: VibrationResult | None = None
    """The vibration stage."""
    mode_coupling: ModeCouplingResult | None = None
    """The machine of two modes that friction couples, in place of `vibration`."""
    verdict: VerdictResult | None = None
    """The probability of vibration over uncertain values."""
    assumptions: list[str]
    """Assumptions, in sentences."""
    warnings: list[str]
    """Warnings, in sentences."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "surface": SurfaceResult,
        "counterface": SurfaceResult,
        "pressure": PressureResult,
        "friction": FrictionResult,
        "vibration": VibrationResult,
        "mode_coupling": ModeCouplingResult,
        "verdict": VerdictResult,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class VariedKey(Record):
    """Key of a study that differs between the members."""

    key: str
    """Name, `section.key`; of a component of a list `section.key[0]`, of the standard deviations of uncertain values
    `section.key_std`.
    """
    unit: str
    """SI unit of the values; empty for numbers and texts."""
    sampled: bool
    """Whether the values are draws of a distribution."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MemberRemedy(Record):
    """Change of one value of a member that makes vibration improbable."""

    input: str
    """Name of the value, `section.key`."""
    unit: str
    """SI unit of the value; empty for a number."""
    probability: float
    """Probability of vibration."""
    value: float | None
    """Nearest central value in the range of the study at which vibration is at most as probable; `null` if there is
    none.
    """


@dataclass(frozen=True, kw_only=True, eq=False)
class MemberResult(Record):
    """One member of a campaign: its values, and its answers or the reason why it has none."""

    scan: str | None = None
    """Scan, relative to the campaign file; absent if the members have the scan of the study."""
    values: list[InputValue]
    """Values of the keys: numbers in SI, uncertain ones at their centres, or texts as stated."""
    failed: bool
    """Whether the member has no answer."""
    reason: str | None = None
    """Reason of the failure."""
    friction_mean: float | None
    """Mean friction coefficient, of the operating point or as stated."""
    friction_std: float | None
    """Standard deviation of the friction coefficient of one window."""
    limit_damping_ratio: float | None
    """Damping ratio above which no vibration persists, with uncertain values at their centres."""
    damping_margin: float | None
    """Margin of the damping: damping ratio minus `limit_damping_ratio`."""
    kind: MotionKind | None
    """Kind of motion, with uncertain values at their centres."""
    vibrates: bool | None
    """Whether the machine vibrates if its motion begins in stick, with uncertain values at their centres."""
    probability: float | None
    """Probability of vibration over the uncertain values."""
    probability_interval: list[float] | None
    """Its 95 % interval: the error of the computation."""
    probability_range: list[float] | None
    """Its 90 % range over the values that are not known."""
    remedy: MemberRemedy | None
    """First of the changes that make vibration improbable."""
    warnings: int | None
    """Number of warnings."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"remedy": MemberRemedy}


@dataclass(frozen=True, kw_only=True, eq=False)
class MemberWarning(Record):
    """Warning of some members."""

    warning: str
    """The warning with the numbers of the first of these members."""
    members: list[int]
    """Numbers of the members, counted from 1."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CampaignResults(CampaignMethods):
    """Rows of all members of a campaign."""

    schema_version: int
    """Version of the keys."""
    seed: int
    """Seed of the campaign."""
    keys: list[VariedKey]
    """Keys that differ between the members, in the order of their values."""
    members: list[MemberResult]
    """The members in their order."""
    rests_on: list[RestsOn]
    """Inputs of the verdict that all members have in common, with their origin; empty in results of earlier
    versions.
    """
    warnings: list[str]
    """Warnings, in sentences."""
    member_warnings: list[MemberWarning]
    """Warnings of the members. Warnings that differ in numbers only are one."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "keys": VariedKey,
        "members": MemberResult,
        "rests_on": RestsOn,
        "member_warnings": MemberWarning,
    }
