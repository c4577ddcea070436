"""Pictures of a rig and of what it measures: rigcal.Rig.plot and its like.

Matplotlib is imported when the first picture is made.
"""

from ._graph import plot_graph
from ._match import plot_match
from ._monitor import plot_monitor
from ._rig import plot_rig
from ._style import need
from ._views import plot_residuals, plot_views

__all__ = [
    "need",
    "plot_graph",
    "plot_match",
    "plot_monitor",
    "plot_residuals",
    "plot_rig",
    "plot_views",
]
