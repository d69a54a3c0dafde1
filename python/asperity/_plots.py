"""Plots of maps, spectra, solutions and results. `asperity.figures` composes those of the paper."""

from __future__ import annotations

import io
import math
from base64 import b64encode
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from asperity.chaos import SobolIndices
    from asperity.friction import FrictionProcess
    from asperity.study import StudyResults
    from asperity.surface import Autocorrelation, RadialSpectrum
    from asperity.vibration import Trajectory
    from asperity.vibration_results import Ensemble, StabilityMap

Values = NDArray[np.float64]

StudyFigure = Literal[
    "height_acf",
    "height_psd_radial",
    "pressure_cdf",
    "friction_levels",
    "friction_acf",
    "friction_histogram",
    "limit_cycle",
    "reattachment",
    "cycles_over_damping",
    "sustained_over_damping",
    "stability_map",
    "verdict_margin",
    "drivers",
]

# Colours that differ for every kind of colour vision (Okabe and Ito).
BLUE, ORANGE, GREEN, PURPLE, GREY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#666666"
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, "#E69F00", "#56B4E9")
DASHES = ("-", "--", "-.", ":", (0, (5, 1)), (0, (1, 1)))
_PREFIXES = {-4: "p", -3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M", 3: "G"}
# At most so many correlation lengths of a realisation are drawn.
_LENGTHS = 20
_STEPS_PER_LENGTH = 50


def axes_of(ax: Axes | None) -> Axes:
    """Return the axes, new ones without any."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    _, made = plt.subplots(layout="constrained")
    return made


def scaled(unit: str, *values: Any) -> tuple[float, str]:
    """Return the factor and the unit with a prefix in which the largest of the values has one to three digits."""
    known = [np.abs(np.asarray(own, dtype=np.float64)) for own in values]
    largest = max((float(np.max(own, where=np.isfinite(own), initial=0.0)) for own in known), default=0.0)
    if unit in {"", "1"} or not largest > 0:
        return 1.0, "" if unit == "1" else unit
    power = min(max(math.floor(math.log10(largest) / 3), min(_PREFIXES)), max(_PREFIXES))
    return float(10.0 ** (-3 * power)), _PREFIXES[power] + unit


def _label(name: str, unit: str) -> str:
    return f"{name} ({unit})" if unit else name


def legend(ax: Axes, **options: Any) -> None:
    """Place the legend above the axes, where it covers no data."""
    count = len(ax.get_legend_handles_labels()[0])
    place: dict[str, Any] = {"bbox_to_anchor": (0, 1), "borderaxespad": 0.2, "ncols": min(count, 2) or 1}
    ax.legend(loc="lower left", fontsize="small", **({"frameon": False} | place | options))


def heights(values: Values, dx_m: float, dy_m: float, ax: Axes | None) -> Axes:
    """Draw heights; the colours span all but the extreme 0.2 % of them."""
    ax = field(values, dx_m, dy_m, name="height", unit="m", ax=ax)
    (image,) = ax.get_images()
    shown = np.asarray(image.get_array())
    if np.isfinite(shown).any():
        image.set_clim(*np.nanpercentile(shown, [0.1, 99.9]))
    return ax


def field(values: Values, dx_m: float, dy_m: float, *, name: str, unit: str, ax: Axes | None) -> Axes:
    """Draw values on a grid, row 0 at the top, with a colour bar."""
    ax = axes_of(ax)
    ny, nx = values.shape
    length, length_unit = scaled("m", [nx * dx_m, ny * dy_m])
    factor, value_unit = scaled(unit, values)
    # y rises with the row, as in `to_xarray`.
    extent = (0.0, nx * dx_m * length, ny * dy_m * length, 0.0)
    image = ax.imshow(factor * values, extent=extent, origin="upper", interpolation="nearest")
    bar = ax.figure.colorbar(image, ax=ax, shrink=0.8)
    bar.set_label(_label(name, value_unit))
    ax.set(xlabel=_label("x", length_unit), ylabel=_label("y", length_unit))
    return ax


def autocorrelation(found: Autocorrelation, ax: Axes | None) -> Axes:
    """Draw the correlation along both axes."""
    ax = axes_of(ax)
    factor, unit = scaled("m", found.lag_x_m, found.lag_y_m)
    ax.plot(factor * found.lag_x_m, found.acf_x, color=BLUE, label="along x")
    ax.plot(factor * found.lag_y_m, found.acf_y, color=ORANGE, ls="--", label="along y")
    ax.axhline(math.exp(-1), color=GREY, lw=0.8, ls=":", label="1/e")
    ax.set(xlabel=_label("lag", unit), ylabel="correlation of the heights")
    legend(ax)
    return ax


def radial_spectrum(found: RadialSpectrum, ax: Axes | None) -> Axes:
    """Draw the spectrum, with the wavenumbers at which it shows the surface."""
    ax = axes_of(ax)
    ax.axvspan(found.reliable_low_rad_per_m, found.reliable_high_rad_per_m, color=GREEN, alpha=0.15, label="reliable")
    ax.loglog(found.q_rad_per_m, found.psd_m4, color=BLUE, label="measured")
    ax.set(xlabel="wavenumber (rad/m)", ylabel="power spectral density (m⁴)")
    legend(ax)
    return ax


def sobol_indices(found: SobolIndices, names: Sequence[str] | None, ax: Axes | None) -> Axes:
    """Draw the fractions of the variance by variable."""
    count = len(found.total)
    if names is None:
        names = [f"ξ{number}" for number in range(1, count + 1)]
    if len(names) != count:
        raise ValueError(f"{len(names)} names for {count} variables")
    return _bars(axes_of(ax), names, found.first_order, found.total)


def _bars(ax: Axes, names: Sequence[str], first_order: Any, total: Any) -> Axes:
    places = np.arange(len(names))
    ax.barh(places - 0.2, first_order, 0.4, color=BLUE, label="alone")
    ax.barh(places + 0.2, total, 0.4, color=ORANGE, label="with interactions")
    ax.set_yticks(places, names)
    ax.invert_yaxis()
    ax.set(xlabel="fraction of the variance", xlim=(0, max(1.0, float(np.max(total)))))
    legend(ax)
    return ax


def friction_process(process: FrictionProcess, length_m: float | None, seed: int, ax: Axes | None) -> Axes:
    """Draw one realisation with mean and twice the standard deviation."""
    ax = axes_of(ax)
    correlation = process.correlation
    own_m = 0.0 if correlation is None else max(correlation.length_m, correlation.window_m or 0.0)
    length_m = _LENGTHS * own_m if length_m is None else length_m
    if not length_m > 0:
        raise ValueError("the process has no correlation length; state length_m")
    step_m = min(own_m, length_m) / _STEPS_PER_LENGTH if own_m > 0 else length_m / (_LENGTHS * _STEPS_PER_LENGTH)
    friction = process.simulate(length_m=length_m, step_m=step_m, seed=seed)
    factor, unit = scaled("m", [length_m])
    ax.axhspan(
        process.mean - 2 * process.std, process.mean + 2 * process.std, color=BLUE, alpha=0.15, label="mean ± 2σ"
    )
    ax.axhline(process.mean, color=GREY, lw=0.8)
    ax.plot(factor * step_m * np.arange(friction.size), friction, color=BLUE, lw=0.8, label="one realisation")
    ax.set(xlabel=_label("sliding distance", unit), ylabel="friction coefficient")
    legend(ax)
    return ax


def ensemble(found: Ensemble, ax: Axes | None) -> Axes:
    """Draw the distribution of the displacements at which the mass sticks again."""
    ax = axes_of(ax)
    own = found.reattachments
    ax.hist(own.sample, bins="auto", density=True, color=BLUE, alpha=0.6, label=f"{own.count} cycles")
    if own.mean is not None and own.std:
        _normal(ax, own.mean, own.std)
    ax.set(xlabel="displacement X at re-attachment", ylabel="density")
    legend(ax)
    return ax


def phase_portrait(found: Trajectory, ax: Axes | None) -> Axes:
    """Draw velocity over displacement."""
    ax = axes_of(ax)
    ax.plot(found.displacement, found.velocity, color=BLUE, lw=1)
    ax.plot(found.displacement[0], found.velocity[0], "o", color=GREY, label=f"start, τ = {found.tau[0]:g}")
    ax.set(xlabel="displacement X", ylabel="velocity X′")
    legend(ax)
    return ax


def _normal(ax: Axes, mean: float, std: float) -> None:
    x = np.linspace(mean - 4 * std, mean + 4 * std, 200)
    density = np.exp(-0.5 * ((x - mean) / std) ** 2) / (std * math.sqrt(2 * math.pi))
    ax.plot(x, density, color=GREY, ls="--", label="normal, same moments")


def stability_map(found: StabilityMap, ax: Axes | None) -> Axes:
    """Draw the probability with its contours and the limit without fluctuation."""
    cells = [(cell["x"], cell["y"], cell["probability"]) for cell in found.cells]
    lines = [(contour.level, line) for contour in found.contours for line in contour.lines]
    return _probability_map(axes_of(ax), found.axes, cells, lines, found.limit)


def _probability_map(
    ax: Axes,
    names: Sequence[str],
    cells: Sequence[tuple[Any, Any, float]],
    contours: Sequence[tuple[float, Any]],
    limit: Sequence[Any],
) -> Axes:
    from matplotlib.collections import PolyCollection

    corners = [[(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])] for x, y, _ in cells]
    shades = PolyCollection(corners, cmap="cividis", edgecolors="face", linewidths=0.3)
    shades.set_array(np.array([probability for *_, probability in cells]))
    shades.set_clim(0, 1)
    ax.add_collection(shades)
    dashes = {0.05: ":", 0.5: "-", 0.95: "--"}
    known = set()
    for level, line in contours:
        x, y = np.transpose(line)
        label = None if level in known else f"{100 * level:.0f} %"
        known.add(level)
        ax.plot(x, y, color="white", lw=1.2, ls=dashes.get(level, "-"), label=label)
    for number, line in enumerate(limit):
        x, y = np.transpose(line)
        ax.plot(x, y, color=ORANGE, lw=1.5, label=None if number else "limit without fluctuation")
    ax.autoscale_view()
    ax.margins(0)
    ax.figure.colorbar(shades, ax=ax).set_label("probability of sustained vibration")
    ax.set(xlabel=_words(names[0]), ylabel=_words(names[1]))
    # White lines need a dark legend.
    legend(ax, frameon=True, facecolor=GREY, labelcolor="white")
    return ax


def _words(name: str) -> str:
    return name.replace("_", " ")


def study_figure(results: StudyResults, name: str, ax: Axes | None) -> Axes:
    """Draw a figure of a run."""
    require(results, name)
    return _FIGURES[name](results, axes_of(ax))


def first_figure(results: StudyResults) -> str:
    """Return the figure nearest to the answer as an image of HTML; empty without one, or without matplotlib."""
    wanted = ("verdict_margin", "limit_cycle", "friction_levels", "pressure_cdf", "height_acf")
    name = next((name for name in wanted if _has(results, name)), None)
    if name is None or find_spec("matplotlib") is None:
        return ""
    from matplotlib.figure import Figure

    # A figure of its own, which no notebook shows by itself.
    figure = Figure(figsize=(4.8, 3.2), layout="constrained")
    image = io.BytesIO()
    try:
        study_figure(results, name, figure.subplots())
        figure.savefig(image, format="png", dpi=100)
    except Exception:
        # Such as text by TeX without TeX; the answer is shown without the figure.
        return ""
    return f'<img alt="{name.replace("_", " ")}" src="data:image/png;base64,{b64encode(image.getvalue()).decode()}">'


def require(results: StudyResults, *names: str) -> None:
    """Raise a ValueError if one of the figures cannot be drawn."""
    drawn = [own for own in get_args(StudyFigure) if _has(results, own)]
    for name in names:
        if name in drawn:
            continue
        known = name in get_args(StudyFigure)
        reason = "the run has no results for this figure" if known else "no figure has this name"
        raise ValueError(f"{name}: {reason}; these can be drawn: {', '.join(drawn) or 'none'}")


def _has(results: StudyResults, name: str) -> bool:
    if name == "drivers":
        return results.verdict is not None and bool(results.verdict.drivers)
    tables = {
        "reattachment": _main(results, "reattachment"),
        "sustained_over_damping": "cycles_over_damping",
        "stability_map": "map_cells",
        "verdict_margin": "verdict_samples",
    }
    return tables.get(name, name) in results.tables


def _main(results: StudyResults, table: str) -> str:
    """Return the name of a table of the main upscaling."""
    upscaling = results.vibration.upscaling if results.vibration is not None else "area"
    return f"{table}_{upscaling}"


def column(results: StudyResults, table: str, name: str) -> Values:
    """Return a column of numbers."""
    return np.asarray(results.tables[table][name], dtype=np.float64)


def _height_acf(results: StudyResults, ax: Axes) -> Axes:
    table = results.tables["height_acf"]
    factor, unit = scaled("m", column(results, "height_acf", "lag_m"))
    lag = factor * column(results, "height_acf", "lag_m")
    for axis, colour in (("x", BLUE), ("y", ORANGE)):
        low, high = (column(results, "height_acf", f"acf_{axis}_{end}") for end in ("low", "high"))
        ax.fill_between(lag, low, high, color=colour, alpha=0.15, lw=0)
        ax.plot(lag, column(results, "height_acf", f"acf_{axis}"), color=colour, label=f"measured along {axis}")
        if f"fit_{axis}" in table:
            ax.plot(
                lag, column(results, "height_acf", f"fit_{axis}"), color=colour, ls="--", label=f"model along {axis}"
            )
    ax.set(xlabel=_label("lag", unit), ylabel="correlation of the heights")
    legend(ax)
    return ax


def _height_psd(results: StudyResults, ax: Axes) -> Axes:
    q, psd, low, high = (
        column(results, "height_psd_radial", name)
        for name in ("wavenumber_rad_per_m", "psd_m4", "psd_low_m4", "psd_high_m4")
    )
    ax.fill_between(q, low, high, color=BLUE, alpha=0.15, lw=0, label="95 %")
    ax.loglog(q, psd, color=BLUE, label="measured")
    if "psd_model_m4" in results.tables["height_psd_radial"]:
        ax.loglog(q, column(results, "height_psd_radial", "psd_model_m4"), color=ORANGE, ls="--", label="model")
    ax.set(xlabel="wavenumber (rad/m)", ylabel="power spectral density (m⁴)")
    legend(ax)
    return ax


# Names of the methods of the pressure, in the order of the table.
_METHODS = {
    "reference": "Monte Carlo reference",
    "monte_carlo": "Monte Carlo",
    "latin_hypercube": "Latin hypercube",
    "sobol": "Sobol' points",
    "polynomial_chaos": "polynomial chaos",
    "polynomial_chaos_log": "polynomial chaos of ln p",
    "polynomial_chaos_local": "local polynomial chaos",
    "default": "multilevel (default)",
}


def _pressure_cdf(results: StudyResults, ax: Axes) -> Axes:
    pressure = column(results, "pressure_cdf", "pressure_pa")
    factor, unit = scaled("Pa", pressure)
    names = [name for name in results.tables["pressure_cdf"] if name != "pressure_pa"]
    styles = zip([*COLOURS, "black"], [*DASHES, *DASHES], strict=False)
    for name in names:
        is_reference = name == "reference"
        colour, dashes = (GREY, "-") if is_reference else next(styles)
        ax.plot(
            factor * pressure,
            column(results, "pressure_cdf", name),
            color=colour,
            ls=dashes,
            lw=3.0 if is_reference else 1.2,
            alpha=0.5 if is_reference else 1.0,
            label=_METHODS.get(name, _words(name)),
        )
    ax.set(xlabel=_label("contact pressure", unit), ylabel="cumulative probability", ylim=(None, 1.005))
    legend(ax)
    return ax


def friction_over(results: StudyResults, name: str, ax: Axes) -> Axes:
    """Draw a moment of friction over the penetration, with its interval."""
    depth = column(results, "friction_levels", "penetration_m")
    factor, unit = scaled("m", depth)
    order = np.argsort(depth)
    value, low, high = (column(results, "friction_levels", name + end)[order] for end in ("", "_low", "_high"))
    ax.fill_between(factor * depth[order], low, high, color=BLUE, alpha=0.15, lw=0, label="95 %")
    ax.plot(factor * depth[order], value, color=BLUE, marker="o", ms=4)
    words = {
        "mean": "mean of μ",
        "std": "standard deviation of μ",
        "coefficient_of_variation": "coefficient of variation",
    }
    ax.set(xlabel=_label("penetration", unit), ylabel=words[name])
    legend(ax)
    return ax


def _friction_acf(results: StudyResults, ax: Axes) -> Axes:
    factor, unit = scaled("m", column(results, "friction_acf", "lag_m"))
    lag = factor * column(results, "friction_acf", "lag_m")
    ax.plot(lag, column(results, "friction_acf", "acf"), color=BLUE, label="computed")
    for name, label, colour, dashes in (
        ("fit", "exponential", ORANGE, "--"),
        ("fit_matern", "Matérn", GREY, "--"),
        ("window_only", "window alone", GREEN, ":"),
        ("windowed_fit", "window and process", PURPLE, "-."),
    ):
        if name in results.tables["friction_acf"]:
            ax.plot(lag, column(results, "friction_acf", name), color=colour, ls=dashes, label=label)
    ax.axhline(0, color=GREY, lw=0.6)
    ax.set(xlabel=_label("lag of the sliding distance", unit), ylabel="correlation of μ")
    legend(ax)
    return ax


def _friction_histogram(results: StudyResults, ax: Axes) -> Axes:
    mu, density = (column(results, "friction_histogram", name) for name in ("mu", "density"))
    ax.bar(mu, density, width=float(np.median(np.diff(mu))), color=BLUE, alpha=0.5, label="computed")
    for name, label, colour, dashes in (
        ("fitted_density", "fitted", ORANGE, "-"),
        ("beta_density", "Beta", GREEN, "--"),
        ("normal_density", "normal", GREY, ":"),
    ):
        if name in results.tables["friction_histogram"]:
            ax.plot(mu, column(results, "friction_histogram", name), color=colour, ls=dashes, label=label)
    ax.locator_params(axis="x", nbins=5)
    ax.set(xlabel="friction coefficient μ", ylabel="density")
    legend(ax)
    return ax


def _limit_cycle(results: StudyResults, ax: Axes) -> Axes:
    if "phase_cloud" in results.tables:
        cloud = [column(results, "phase_cloud", name) for name in ("displacement", "velocity")]
        ax.plot(*cloud, ".", ms=1.5, color=BLUE, alpha=0.4, label="trajectories")
    cycle = [column(results, "limit_cycle", name) for name in ("displacement", "velocity")]
    ax.plot(*cycle, color=ORANGE, label="limit cycle")
    ax.set(xlabel="displacement X", ylabel="velocity dX/dτ")
    legend(ax)
    return ax


def _reattachment(results: StudyResults, ax: Axes) -> Axes:
    table = _main(results, "reattachment")
    x, density, normal = (column(results, table, name) for name in ("displacement", "density", "normal_density"))
    ax.bar(x, density, width=float(np.median(np.diff(x))), color=BLUE, alpha=0.6, label="computed")
    ax.plot(x, normal, color=GREY, ls="--", label="normal, same moments")
    ax.set(xlabel="displacement X at re-attachment", ylabel="density")
    legend(ax)
    return ax


def _over_damping(results: StudyResults, ax: Axes, curves: Mapping[str, tuple[str, str]], label: str) -> Axes:
    damping = column(results, "cycles_over_damping", "damping_ratio")
    upscaling = _main(results, "")[1:]
    for (name, (colour, words)), dashes in zip(curves.items(), DASHES, strict=False):
        own = name.format(upscaling)
        ax.plot(
            damping, column(results, "cycles_over_damping", own), color=colour, ls=dashes, marker="o", ms=3, label=words
        )
        if f"{own}_low" in results.tables["cycles_over_damping"]:
            low, high = (column(results, "cycles_over_damping", f"{own}_{end}") for end in ("low", "high"))
            ax.fill_between(damping, low, high, color=colour, alpha=0.2, lw=0)
    limit = results.vibration and results.vibration.limit_damping_ratio
    if limit:
        ax.axvline(limit, color=GREY, lw=0.8, ls=":", label="limit without fluctuation")
    ax.set(xlabel="damping ratio ζ", ylabel=label)
    legend(ax)
    return ax


def _cycles_over_damping(results: StudyResults, ax: Axes) -> Axes:
    curves = {"cycles_deterministic": (GREY, "without fluctuation"), "{}_cycles_mean": (BLUE, "with fluctuation")}
    return _over_damping(results, ax, curves, "cycles per trajectory")


def _sustained_over_damping(results: StudyResults, ax: Axes) -> Axes:
    curves = {"{}_sustained_share": (BLUE, "trajectories that keep vibrating")}
    return _over_damping(results, ax, curves, "fraction")


def _stability_map(results: StudyResults, ax: Axes) -> Axes:
    names = [name for name in results.tables["map_contours"] if name not in {"level", "line"}]
    of = results.tables["map_cells"]
    ends = [np.transpose([of[f"{name}_low"], of[f"{name}_high"]]).astype(float) for name in names]
    cells = list(zip(*ends, column(results, "map_cells", "probability"), strict=True))
    return _probability_map(
        ax,
        names,
        cells,
        _lines(results, "map_contours", names),
        [line for _, line in _lines(results, "map_limit", names)],
    )


def _lines(results: StudyResults, table: str, names: Sequence[str]) -> list[tuple[float, Values]]:
    if table not in results.tables or not len(results.tables[table][names[0]]):
        return []
    number = column(results, table, "line")
    points = np.transpose([column(results, table, name) for name in names])
    level = column(results, table, "level") if "level" in results.tables[table] else np.full(number.size, np.nan)
    starts = np.flatnonzero(np.diff(number, prepend=number[0] - 1))
    return [(float(level[own[0]]), points[own]) for own in np.split(np.arange(number.size), starts[1:])]


def _verdict_margin(results: StudyResults, ax: Axes) -> Axes:
    margin = column(results, "verdict_samples", "damping_margin")
    edges = np.histogram_bin_edges(margin, bins="auto").tolist()
    for own, colour, label in (
        (margin[margin < 0], ORANGE, "vibrates"),
        (margin[margin >= 0], BLUE, "does not vibrate"),
    ):
        ax.hist(own, bins=edges, color=colour, alpha=0.7, label=label)
    ax.axvline(0, color=GREY, lw=0.8)
    name = "ζ − ζ_v" if results.mode_coupling is None else "μ_c − μ"
    ax.set(xlabel=f"margin {name}", ylabel="sampled machines")
    legend(ax)
    return ax


def _drivers(results: StudyResults, ax: Axes) -> Axes:
    assert results.verdict is not None
    drivers = results.verdict.drivers
    names = [driver.input for driver in drivers]
    return _bars(ax, names, [driver.first_order for driver in drivers], [driver.total for driver in drivers])


_FIGURES: dict[str, Callable[[StudyResults, Axes], Axes]] = {
    "height_acf": _height_acf,
    "height_psd_radial": _height_psd,
    "pressure_cdf": _pressure_cdf,
    "friction_levels": lambda results, ax: friction_over(results, "mean", ax),
    "friction_acf": _friction_acf,
    "friction_histogram": _friction_histogram,
    "limit_cycle": _limit_cycle,
    "reattachment": _reattachment,
    "cycles_over_damping": _cycles_over_damping,
    "sustained_over_damping": _sustained_over_damping,
    "stability_map": _stability_map,
    "verdict_margin": _verdict_margin,
    "drivers": _drivers,
}
