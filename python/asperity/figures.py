"""Figures 2 to 5 of Gaus, Proppe and Zaccardi, *Meccanica dei Materiali e delle Strutture* VI (2016) 1, 115–122.

Each function draws the results of one study in ``studies/`` of the source. ``PAPER.md`` lists the gaps of the paper and
the differences from print. The figures need matplotlib (``pip install '.[plot]'``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asperity import _plots

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from asperity.study import StudyResults


def _panels(rows: int, columns: int, count: int) -> tuple[Figure, list[Axes]]:
    import matplotlib.pyplot as plt

    size = (4.4 * columns, 3.8 * rows)
    figure, grid = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False)
    axes = list(grid.flat)
    for ax in axes[count:]:
        ax.remove()
    if count > 1:
        for letter, ax in zip("abcdef", axes[:count], strict=False):
            ax.set_title(f"({letter})", loc="right", fontsize="medium")
    return figure, axes[:count]


def figure_2(results: StudyResults) -> Figure:
    """Draw the distribution of the contact pressure by method; the study is ``paper_fig2.toml``.

    The expansions of the paper are fitted to samples in contact alone, which biases them; the figure shows them beside
    a Monte Carlo reference.

    Parameters
    ----------
    results
        Results of the study.

    Raises
    ------
    ValueError
        The results are those of another study; the message lists the figures that can be drawn.

    Examples
    --------
    >>> import asperity
    >>> results = asperity.run_study("studies/paper_fig2.toml")  # doctest: +SKIP
    >>> asperity.figures.figure_2(results).savefig("figure_2.pdf")  # doctest: +SKIP
    """
    figure, (ax,) = _panels(1, 1, 1)
    results.plot("pressure_cdf", ax=ax)
    return figure


def figure_3(results: StudyResults) -> Figure:
    """Draw friction against penetration, and its correlation and distribution; the study is ``paper_fig3.toml``.

    Panels: mean, standard deviation and coefficient of variation with 95 % intervals; correlation along the sliding
    distance; histogram with the fitted distribution. The correlation length is that of the window.

    Parameters
    ----------
    results
        Results of the study.

    Raises
    ------
    ValueError
        The results are those of another study; the message lists the figures that can be drawn.

    Examples
    --------
    >>> import asperity
    >>> results = asperity.run_study("studies/paper_fig3.toml")  # doctest: +SKIP
    >>> asperity.figures.figure_3(results).savefig("figure_3.pdf")  # doctest: +SKIP
    """
    _plots.require(results, "friction_levels", "friction_acf", "friction_histogram")
    figure, axes = _panels(2, 3, 5)
    for name, ax in zip(("mean", "std", "coefficient_of_variation"), axes, strict=False):
        _plots.friction_over(results, name, ax)
    results.plot("friction_acf", ax=axes[3])
    results.plot("friction_histogram", ax=axes[4])
    return figure


def figure_4(results: StudyResults) -> Figure:
    """Draw a trajectory of the mass over time and in the phase plane; the study is ``paper_fig5.toml``.

    The trajectory has fluctuating friction, the cycle beside it has not.

    Parameters
    ----------
    results
        Results of the study.

    Raises
    ------
    ValueError
        The results are those of another study; the message lists the figures that can be drawn.

    Examples
    --------
    >>> import asperity
    >>> results = asperity.run_study("studies/paper_fig5.toml")  # doctest: +SKIP
    >>> asperity.figures.figure_4(results).savefig("figure_4.pdf")  # doctest: +SKIP
    """
    _plots.require(results, "limit_cycle")
    if "trajectory" not in results.tables:
        raise ValueError("the run has no trajectory, because friction would be clipped too much")
    figure, (left, right) = _panels(1, 2, 2)
    tau, displacement, velocity = (
        _plots.column(results, "trajectory", name) for name in ("tau", "displacement", "velocity")
    )
    left.plot(tau, displacement, color=_plots.BLUE, lw=0.8)
    left.set(xlabel="time τ = ω₀t", ylabel="displacement X = xc/N")
    right.plot(displacement, velocity, color=_plots.BLUE, lw=0.6, label="with fluctuation")
    cycle = [_plots.column(results, "limit_cycle", name) for name in ("displacement", "velocity")]
    right.plot(*cycle, color=_plots.ORANGE, ls="--", label="without")
    right.set(xlabel="displacement X", ylabel="velocity dX/dτ")
    _plots.legend(right)
    return figure


def figure_5(results: StudyResults) -> Figure:
    """Draw phase portrait, re-attachment and lost cycles; the study is ``paper_fig5.toml``.

    Panels: limit cycle with points of trajectories; distribution of the displacement at which the mass sticks again;
    number of cycles over the damping ratio, with and without fluctuation of friction.

    Parameters
    ----------
    results
        Results of the study.

    Raises
    ------
    ValueError
        The results are those of another study; the message lists the figures that can be drawn.

    Examples
    --------
    >>> import asperity
    >>> results = asperity.run_study("studies/paper_fig5.toml")  # doctest: +SKIP
    >>> asperity.figures.figure_5(results).savefig("figure_5.pdf")  # doctest: +SKIP
    """
    names: tuple[_plots.StudyFigure, ...] = ("limit_cycle", "reattachment", "cycles_over_damping")
    _plots.require(results, *names)
    figure, axes = _panels(1, 3, 3)
    for name, ax in zip(names, axes, strict=True):
        results.plot(name, ax=ax)
    return figure
