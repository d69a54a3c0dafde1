"""Methods of the results of stick-slip, whose attributes are generated."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from asperity import _plots
from asperity._record import Record

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from asperity.vibration_results import Ensemble, StabilityMap


class EnsembleMethods(Record):
    """Methods of an ensemble."""

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the distribution of the displacements at which the mass sticks again."""
        return _plots.ensemble(cast("Ensemble", self), ax)


class StabilityMapMethods(Record):
    """Methods of a stability map."""

    def to_pandas(self) -> pandas.DataFrame:
        """Return the points as a data frame."""
        import pandas

        return pandas.json_normalize([point.to_dict() for point in cast("StabilityMap", self).points])

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the probability with its contours and the limit without fluctuation."""
        return _plots.stability_map(cast("StabilityMap", self), ax)
