"""What the planners found, side by side."""
from typing import NamedTuple

import numpy as np

from mesh_tools_test.demo.layers import EDGE_COST_FACTOR

POTENTIAL = "Potential"  # the layer of the server's vertex costs
HEADER = ("planner", "path [m]", "with costs [m]", "time [ms]", "again [ms]")


class Plan(NamedTuple):
    """One answer of the server.

    positions: (N, 3) meters; cost: what the planner minimized; seconds: from request to answer;
    potential: (V,) float32, the cost from each vertex to the goal.
    """

    positions: np.ndarray
    cost: float
    message: str
    seconds: float
    potential: np.ndarray

    @property
    def length(self):
        """Of the path, from position to position [m]."""
        return float(np.linalg.norm(np.diff(self.positions, axis=0), axis=1).sum())


class Compared(NamedTuple):
    """A row of the comparison; lengths in meters, times in seconds.

    with_costs: what the path costs by one measure for all planners, costs integrated along it.
    again: the same request once more, when the planner knows the potential of the goal.
    """

    title: str
    length: float
    with_costs: float
    seconds: float
    again: float


def compared(title, first, again, mesh_map):
    """The row of a planner's two plans, its path measured on the map."""
    path = mesh_map.queries.path_cost(first.positions)
    with_costs = path.length + EDGE_COST_FACTOR * path.integral
    return Compared(title, path.length, with_costs, first.seconds, again.seconds)


def table(rows):
    """HEADER and one row of texts for each planner."""
    return [HEADER] + [
        (
            row.title,
            f"{row.length:.2f}",
            f"{row.with_costs:.2f}",
            f"{1000 * row.seconds:.0f}",
            f"{1000 * row.again:.0f}",
        )
        for row in rows
    ]


def color_limits(potentials):
    """Limits of a color scale that is the same for all potentials, as far as they are known."""
    highest = 0.0
    for potential in potentials:
        finite = potential[np.isfinite(potential)]
        highest = max(highest, float(finite.max()) if len(finite) else 0.0)
    return 0.0, highest or 1.0
