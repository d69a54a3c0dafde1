"""Sections of a study. Made by scripts/generate_python_results.py; do not edit.

A quantity is a number in the SI unit that its description states, or a text with any unit, such as ``"210 GPa"``. A
value that may be uncertain is also a frozen distribution of SciPy, a distribution of OpenTURNS, or one of the forms of
a study file: ``"10 ± 0.5 GPa"``, ``"8 GPa .. 12 GPa"``, ``{"lognormal": ["10 GPa", 0.05], "unknown": True}``.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

from asperity._section import Scan, Section, Uncertain


@dataclass(frozen=True, kw_only=True, eq=False)
class Surface(Section):
    """Measured or modelled surface; required by pressure and friction."""

    file: Scan | Sequence[Scan] | None = None
    """Scan file, relative to the study file, or a list of scans of one part. The statistics of several scans are
    pooled. Random surfaces then have the correlation of all pairs of heights and the distribution of all heights,
    each relative to the form of its own scan. All scans must have the same pixel size. Maps and figures show the
    first scan.
    """
    channel: str | int | None = None
    """Height map to read from a file that contains several: its name, or its number counted from 1."""
    pixel_size: float | str | tuple[float | str, float | str] | None = None
    """Pixel size (x, y), or one value for both. Required for a scan that states none; replaces the size stated in
    the file. A number is in m.
    """
    height_unit: str | None = None
    """Unit of the heights, such as `um`. Heights of a scan that states none count as metre; the key is required if
    they would then exceed the field of view. It replaces the unit stated in the file, and a conversion factor in
    the header of a text file.
    """
    decimal: Literal["comma", "point"] | None = None
    """Decimal sign of a text file in which every comma may be a decimal sign or separate thousands, as in `1,234`.
    Required for such a file.
    """
    isotropic: bool | None = None
    """Whether the surface has no lay. A study takes a profile, heights along one line, only for such a surface: its
    spectrum is then that in all directions.
    """
    level: str | None = None
    """Form removed from the scan. By default plane."""
    outliers: float | None = None
    """Limit in robust standard deviations from the median beyond which heights count as missing."""
    s_filter: float | str | None = None
    """Cutoff of the S-filter, which removes shorter waves of the scan. A number is in m."""
    l_filter: float | str | None = None
    """Cutoff of the L-filter, which removes longer waves of the scan. A number is in m."""
    robust_filter: bool | None = None
    """Whether the L-filter is robust against grooves and spikes."""
    cut_off: float | str | Uncertain | None = None
    """Length of the shortest wave of the random surfaces that exists physically, shorter or longer than the waves
    that the scan resolves. When left out, the random surfaces have the waves that the scan resolves, and a
    verdict takes the length as unknown between these and twice the pixel. Not used by the Weierstrass–Mandelbrot
    generator. A number is in m. It is a positive value.
    """
    generator: Literal["karhunen_loeve", "weierstrass_mandelbrot", "spectral"] | None = None
    """Generator of the random surfaces. By default karhunen_loeve."""
    covariance: (
        Literal["measured", "empirical", "squared_exponential", "exponential", "matern", "self_affine"] | None
    ) = None
    """Covariance of the random surfaces; not used by the Weierstrass–Mandelbrot generator. By default measured."""
    rms_height: float | str | Uncertain | None = None
    """Standard deviation of the heights of the random surfaces, if not measured. A number is in m. It is a positive
    value between 1e-50 and 1e50 m.
    """
    correlation_length: float | str | tuple[float | str | Uncertain, float | str | Uncertain] | Uncertain | None = None
    """Correlation lengths (x, y) of the random surfaces, or one for both, if not measured: the parameter ℓ of the
    model. For the exponential and the squared exponential model it is the lag at which the correlation is 1/e.
    For the Matérn model it is the scale and for the self-affine model the roll-off length; their correlation
    falls to 1/e at another lag. A number is in m. It is a positive value.
    """
    hurst: float | Uncertain | None = None
    """Hurst exponent of a self-affine model. It is a Hurst exponent strictly between 0 and 1."""
    smoothness: float | Uncertain | None = None
    """Smoothness ν of a Matérn model. It is a positive value."""
    fractal_dimension: float | Uncertain | None = None
    """Fractal dimension, between 2 and 3, of the Weierstrass–Mandelbrot generator. It is a value strictly between 2
    and 3.
    """
    marginal: str | None = None
    """Marginal distribution of the heights: `measured`, `normal`, `beta:A,B`, …; not used by the
    Weierstrass–Mandelbrot generator. By default measured.
    """
    translation: Literal["plain", "corrected"] | None = None
    """Method that imposes the marginal distribution. By default plain."""
    modes: int | None = None
    """Number of terms of the Karhunen–Loève expansion. When left out, enough for 90 % of the slope variance of a
    patch, or all Fourier modes if more than 400 are needed.
    """
    mean_mode: bool | None = None
    """Whether patches include the constant Fourier mode, so that their mean heights differ. Without it the variance
    of the other modes is scaled to the total. Applies to Karhunen–Loève expansions on periodic patches.
    """
    rescale: bool | None = None
    """Treatment of the variance that a truncated Karhunen–Loève expansion of normal heights lacks. `true` scales all
    heights of a patch by one factor, so that the modes have the full variance on average over the patch; `false`
    leaves the heights lower. When left out, the marginal distribution is imposed at every point, as for any other
    distribution.
    """
    body: Literal["track", "slider", "both"] | None = None
    """Body that is rough: the `track`, over which the slider passes, or the `slider`, which carries its contacts
    along. When left out, `both` with a rough `[counterface]`, otherwise the track. Friction depends on it.
    """

    _units: ClassVar[Mapping[str, str | tuple[str, ...]]] = {
        "pixel_size": "m",
        "s_filter": "m",
        "l_filter": "m",
        "cut_off": "m",
        "rms_height": "m",
        "correlation_length": "m",
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Counterface(Section):
    """Body that is pressed against the surface; smooth and rigid when left out."""

    youngs_modulus: float | str | Uncertain | None = None
    """Young's modulus; rigid when left out. A number is in Pa. It is a positive value."""
    poisson_ratio: float | Uncertain | None = None
    """Poisson's ratio; 0.3 when left out. It is a Poisson ratio above -1 and at most 0.5."""
    hardness: float | str | Uncertain | None = None
    """Hardness. The lower hardness of the two bodies bounds the pressure. A number is in Pa. It is a positive value."""
    file: Scan | Sequence[Scan] | None = None
    """Scan file, relative to the study file, or a list of scans of one part."""
    channel: str | int | None = None
    """Height map to read from a file that contains several: its name, or its number counted from 1."""
    pixel_size: float | str | tuple[float | str, float | str] | None = None
    """Pixel size (x, y), or one value for both. A number is in m."""
    height_unit: str | None = None
    """Unit of the heights, such as `um`, as in `[surface]`."""
    decimal: Literal["comma", "point"] | None = None
    """Decimal sign of a text file, as in `[surface]`."""
    level: str | None = None
    """Form removed from the scan."""
    outliers: float | None = None
    """Limit in robust standard deviations from the median beyond which heights count as missing."""
    s_filter: float | str | None = None
    """Cutoff of the S-filter, which removes shorter waves of the scan. A number is in m."""
    l_filter: float | str | None = None
    """Cutoff of the L-filter, which removes longer waves of the scan. A number is in m."""
    robust_filter: bool | None = None
    """Whether the L-filter is robust against grooves and spikes."""
    covariance: (
        Literal["measured", "empirical", "squared_exponential", "exponential", "matern", "self_affine"] | None
    ) = None
    """Covariance of the random counterface; measured when left out."""
    rms_height: float | str | None = None
    """Standard deviation of the heights, if not measured. A number is in m."""
    correlation_length: float | str | tuple[float | str, float | str] | None = None
    """Correlation lengths (x, y), or one for both, if not measured. A number is in m."""
    hurst: float | None = None
    """Hurst exponent of a self-affine model."""
    smoothness: float | None = None
    """Smoothness ν of a Matérn model."""
    fractal_dimension: float | None = None
    """Fractal dimension, between 2 and 3, of the Weierstrass–Mandelbrot generator."""
    marginal: str | None = None
    """Marginal distribution of the heights; measured when left out."""
    translation: Literal["plain", "corrected"] | None = None
    """Method that imposes the marginal distribution; that of `[surface]` when left out."""

    _units: ClassVar[Mapping[str, str | tuple[str, ...]]] = {
        "youngs_modulus": "Pa",
        "hardness": "Pa",
        "pixel_size": "m",
        "s_filter": "m",
        "l_filter": "m",
        "rms_height": "m",
        "correlation_length": "m",
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Material(Section):
    """Elastic and plastic properties; required by every stage but the first."""

    youngs_modulus: float | str | Uncertain
    """Young's modulus. A number is in Pa. It is a positive value."""
    poisson_ratio: float | Uncertain | None = None
    """Poisson's ratio. It is a Poisson ratio above -1 and at most 0.5. By default 0.3."""
    hardness: float | str | Uncertain | None = None
    """Hardness, the largest pressure; contact is elastic when left out. A number is in Pa. It is a positive value."""
    shear_strength: float | str | Uncertain | None = None
    """Shear strength τ_max of the contacts; required by friction. A number is in Pa. It is a positive value."""

    _units: ClassVar[Mapping[str, str | tuple[str, ...]]] = {
        "youngs_modulus": "Pa",
        "hardness": "Pa",
        "shear_strength": "Pa",
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressure(Section):
    """Distribution of the random pressure."""

    size: tuple[float | str, float | str]
    """Size (x, y) of a patch. A number is in m."""
    points: tuple[int, int]
    """Points (x, y) of a patch."""
    boundary: Literal["free", "periodic"] | None = None
    """Boundary of a patch. By default free."""
    cell: tuple[int, int] | None = None
    """Cell [row, column] of the studied pressure, counted from 0 at the top left; the centre [ny/2, nx/2] when left
    out.
    """
    mean_compliance: float | str | None = None
    """Mean compliance of a periodic patch. A number is in m/Pa."""
    percentile: float | None = None
    """Percentage of the heights (of the ensemble) above the plane before deformation."""
    penetration: float | str | None = None
    """Depth of the plane below the highest point of each patch. A number is in m."""
    mean_pressure: float | str | None = None
    """Mean pressure on each patch. A number is in Pa."""
    methods: (
        Sequence[
            Literal[
                "monte_carlo",
                "latin_hypercube",
                "sobol",
                "polynomial_chaos",
                "polynomial_chaos_log",
                "polynomial_chaos_local",
                "default",
            ]
        ]
        | None
    ) = None
    """Methods beside `default`, whose estimate is the answer. With others, a reference is computed and all are
    compared with it. By default ['default'].
    """
    fine_solves: int | None = None
    """Number of contact solutions for each method. By default 500."""
    reference_samples: int | None = None
    """Number of contact solutions of the reference run, 5000 when left out; needs other methods than `default`."""
    variables: int | None = None
    """Number of leading variables of the chaos expansion. By default 8."""
    degree: int | None = None
    """Total degree of the chaos expansion. By default 3."""
    stiffness: bool | None = None
    """Whether to estimate the normal stiffness of the contact too. By default False."""
    tolerance: float | None = None
    """Relative tolerance of each contact solve. By default 1e-06."""

    _units: ClassVar[Mapping[str, str | tuple[str, ...]]] = {
        "size": "m",
        "mean_compliance": "m/Pa",
        "penetration": "m",
        "mean_pressure": "Pa",
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Friction(Section):
    """Friction coefficient as a process."""

    strip: tuple[float | str, float | str] | None = None
    """Size (x, y) of a strip; it slides along x. When left out, ten windows along and some correlation lengths of
    the scan across, or 6 mm and 75 µm without a scan. A number is in m.
    """
    points: tuple[int, int] | None = None
    """Points (x, y) of a strip. When left out, four to the shortest wave of the scan, or 2048 and 32 without a scan."""
    window: float | str | None = None
    """Length of the window along x. When left out, a tenth of the strip, or 600 µm without a scan. A number is in m."""
    window_width: float | str | None = None
    """Width of the window along y; the width of the strip when left out. Narrower windows lie side by side on a
    periodic strip, and each track gives its own record. A number is in m.
    """
    window_shape: Literal["rectangle", "ellipse"] | None = None
    """Shape of the window."""
    law: Literal["bowden_tabor", "pressure_dependent", "adhesion_ploughing", "coulomb"] | None = None
    """Friction law. Its τ_max is `shear_strength` of `[material]`. By default bowden_tabor."""
    pressure_coefficient: float | Uncertain | None = None
    """Coefficient α of the pressure-dependent law. It is zero or a positive value."""
    coefficient: float | Uncertain | None = None
    """Friction coefficient μ of Coulomb's law. It is a positive value."""
    boundary: Literal["free", "periodic"] | None = None
    """Boundary of a strip. By default periodic."""
    mean_compliance: float | str | None = None
    """Mean compliance of a periodic strip. A number is in m/Pa."""
    percentiles: Sequence[float] | None = None
    """Levels as percentages of the heights (of the ensemble) above the plane, which has the same position in space
    for all strips. Five default levels when left out, unless other levels are stated.
    """
    mean_pressures: Sequence[float | str] | None = None
    """Further levels: mean pressures on each strip. A number is in Pa."""
    penetrations: Sequence[float | str] | None = None
    """Further levels: depths of the plane below the highest point of each strip. A number is in m."""
    nominal_area: float | str | Uncertain | None = None
    """Area over which windows average in the `area` upscaling; when left out, the area of `[vibration]`, or else 833
    mm². A number is in m^2. It is a positive value.
    """
    realisations: int | None = None
    """Strips per level. By default 20."""
    tolerance: float | None = None
    """Relative tolerance of each contact solve. By default 1e-06."""
    uncertainty: Mapping[str, object] | None = None
    """Uncertain parameters of the surface."""

    _units: ClassVar[Mapping[str, str | tuple[str, ...]]] = {
        "strip": "m",
        "window": "m",
        "window_width": "m",
        "mean_compliance": "m/Pa",
        "mean_pressures": "Pa",
        "penetrations": "m",
        "nominal_area": "m^2",
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Vibration(Section):
    """Stick-slip or mode coupling of a mass on a belt."""

    model: Literal["stick_slip", "mode_coupling"] | None = None
    """Model of the machine."""
    mass: float | str | Uncertain
    """Mass m. A number is in kg. It is a positive value."""
    natural_frequency: float | str | Uncertain
    """Natural angular frequency ω₀ = √(c/m). A number is in rad/s. It is a positive value."""
    damping_ratio: float | Uncertain
    """Damping ratio ζ = d/(2mω₀). It is zero or a positive value."""
    normal_force: float | str | Uncertain
    """Normal force N. A number is in N. It is a positive value."""
    nominal_area: float | str | Uncertain
    """Area that carries the normal force. A number is in m^2. It is a positive value."""
    belt_velocity: float | str | Uncertain | None = None
    """Velocity of the belt. A number is in m/s. It is a positive value."""
    dimensionless_belt_velocity: float | Uncertain | None = None
    """Velocity of the belt as V = v_b m ω₀/N. It is a positive value."""
    spring_angles: tuple[float | Uncertain, float | Uncertain] | None = None
    """Directions of the two inclined springs of `mode_coupling` in degrees, from the belt's velocity towards the
    belt. It is a number.
    """
    springs: tuple[float | Uncertain, float | Uncertain] | None = None
    """Stiffnesses of these springs in units of mω₀². It is zero or a positive value."""
    contact_spring: float | Literal["surface"] | Uncertain | None = None
    """Stiffness of the contact spring of `mode_coupling` in units of mω₀², or `"surface"`. It is a positive value."""
    forcing: float | str | None = None
    """Harmonic force on the mass. A number is in N."""
    forcing_frequency: float | str | None = None
    """Angular frequency of the harmonic force. A number is in rad/s."""
    kinetic_share: float | Uncertain | None = None
    """Ratio of the kinetic friction coefficient at vanishing velocity to the static one. It is a ratio above 0, at
    most 1. By default 1.0.
    """
    velocity_law: Literal["stribeck", "linear", "exponential", "table"] | None = None
    """Dependence of friction on the velocity. By default stribeck."""
    stribeck: float | str | Uncertain | None = None
    """Stribeck coefficient a of μ_k/(1 + a|v|), per unit of dimensionless velocity or in s/m; 4.2 when left out. It
    is zero or a positive value.
    """
    linear_weakening: float | Uncertain | None = None
    """Slope b of the linear law, per unit of dimensionless velocity. It is zero or a positive value."""
    stribeck_velocity: float | str | Uncertain | None = None
    """Velocity v₀ of the exponential law. A number is in m/s. It is a positive value."""
    high_speed_share: float | Uncertain | None = None
    """Ratio of the friction coefficient at high velocity to the kinetic one, for the exponential law. It is a ratio
    above 0, at most 1.
    """
    friction_table: Sequence[tuple[float | str, float]] | None = None
    """Points (velocity, coefficient) of a friction law, from velocity 0 on; constant beyond the last. Coefficients
    count relative to the first, which stands for the kinetic friction coefficient. A number is in m/s.
    """
    generator: Literal["autoregressive", "spectral", "jacobi", "renewal"] | None = None
    """Generator of the fluctuation. When left out, the generator of the fitted process, or else the recursion if it
    reproduces the correlation.
    """
    drive: Literal["distance", "time"] | None = None
    """Argument of the fluctuation. By default distance."""
    upscaling: Literal["area", "paper"] | None = None
    """Upscaling that the report shows first; both are computed. By default area."""
    level: float | None = None
    """Friction level, as a percentile of `[friction]`; when left out, the level solved at N/nominal_area."""
    allow_clipping: bool | None = None
    """Whether more than 5 % of the friction values may be clipped to stay positive."""
    damping_sweep: tuple[float, float, int] | None = None
    """Damping ratios: from, to, count. By default [0.05, 0.3, 11]."""
    trajectories: int | None = None
    """Number of trajectories per damping ratio. By default 200."""
    duration: float | None = None
    """Dimensionless duration ω₀t of a trajectory. By default 640.0."""
    map: Mapping[str, object] | None = None
    """A stability map."""
    friction_process: str | os.PathLike[str] | None = None
    """File of a fitted process, relative to the study file, for studies without a friction stage: the
    `friction_process.json` of another study, or the fit of a measured record. If it has a Stribeck coefficient,
    this replaces `stribeck`.
    """
    static_friction: float | Uncertain | None = None
    """Mean (static) friction coefficient, for studies without a friction stage. It is a positive value."""
    friction_std: float | Uncertain | None = None
    """Standard deviation of the friction of one window, for studies without a friction stage. It is zero or a
    positive value.
    """
    friction_correlation_length: float | str | Uncertain | None = None
    """Correlation length of the friction of one window, for studies without a friction stage. A number is in m. It
    is a positive value.
    """
    friction_marginal: str | None = None
    """Marginal distribution of the friction coefficient, for studies without a friction stage."""

    _units: ClassVar[Mapping[str, str | tuple[str, ...]]] = {
        "mass": "kg",
        "natural_frequency": "rad/s",
        "normal_force": "N",
        "nominal_area": "m^2",
        "belt_velocity": "m/s",
        "forcing": "N",
        "forcing_frequency": "rad/s",
        "stribeck_velocity": "m/s",
        "friction_table": ("m/s", ""),
        "friction_correlation_length": "m",
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Uncertainty(Section):
    """Dependence of uncertain values."""

    correlation: Sequence[tuple[str, str, float]] | None = None
    """Spearman's rank correlations of pairs of uncertain values, each named `section.key`."""
    surface: bool | None = None
    """Whether the verdict counts what the scans leave uncertain of the surface and of the counterface. By default
    True.
    """


@dataclass(frozen=True, kw_only=True, eq=False)
class Verdict(Section):
    """Probability of vibration over the uncertain values, and what changes it."""

    duration: float | str | None = None
    """Duration T after which a machine with fluctuating friction must still vibrate; that of `[vibration]` when left
    out. A number is in s.
    """
    threshold: float | None = None
    """Fraction of the time: a machine counts as vibrating if it vibrates longer than this fraction of the second
    half of the duration. By default 0.1.
    """
    remedies: Sequence[Mapping[str, object]] | None = None
    """Values to change until the probability reaches the targets; when left out, of uncertain machines whose
    friction does not fluctuate, the damping ratio, and the load, or for coupled modes a stated friction
    coefficient, if no contact needs to be solved for it.
    """
    targets: Sequence[float] | None = None
    """Probabilities to reach. By default [0.05, 0.01]."""
    half_width: float | None = None
    """Half width of the 95 % interval of the probability at which sampling stops. By default 0.02."""
    evaluations: int | None = None
    """Largest number of machines that are evaluated for the probability. By default 65536."""

    _units: ClassVar[Mapping[str, str | tuple[str, ...]]] = {"duration": "s"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Sections(Section):
    """Study file: scan or surface model, stages, and the seed of every random draw."""

    seed: int
    """Seed of every random draw."""
    name: str | None = None
    """Name of the study, of which its run folder gets its name; that of the file when left out."""
    valid_share: float | None = None
    """Least fraction of valid samples of each kind, above 0, at most 1; statistics of fewer are refused."""
    unstated: Sequence[str] | None = None
    """Names, `section.key`, of the values below that are defaults because the first study file left them out. The
    study of a run folder lists them.
    """
    surface: Surface | None = None
    """Measured or modelled surface; required by pressure and friction."""
    counterface: Counterface | None = None
    """Body that is pressed against the surface; smooth and rigid when left out."""
    material: Material | None = None
    """Elastic and plastic properties; required by every stage but the first."""
    pressure: Pressure | None = None
    """Distribution of the random pressure."""
    friction: Friction | None = None
    """Friction coefficient as a process."""
    vibration: Vibration | None = None
    """Stick-slip or mode coupling of a mass on a belt."""
    uncertainty: Uncertainty | None = None
    """Dependence of uncertain values."""
    verdict_plan: Verdict | None = None
    """Probability of vibration over the uncertain values, and what changes it."""


__all__ = ["Counterface", "Friction", "Material", "Pressure", "Surface", "Uncertainty", "Verdict", "Vibration"]
