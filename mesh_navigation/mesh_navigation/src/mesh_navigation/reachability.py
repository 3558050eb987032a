"""Whether there can be a way at all, and words with numbers where there is none."""

from functools import cached_property

import numpy as np

from mesh_map.topology import Topology

from mesh_navigation.outcomes import GetPathOutcome
from mesh_navigation.places import Place
from mesh_navigation.planner import PlanFailure
from mesh_navigation.pose import vector_text
from mesh_navigation.slowness import Ground


class Components:
    """The connected parts of a mesh, numbered from 1 for people."""

    def __init__(self, topology: Topology) -> None:
        self._topology = topology

    def number(self, place: Place) -> int:
        """That of a place."""
        return int(self._topology.components[place.anchor.corners[0]]) + 1

    @cached_property
    def sizes(self) -> np.ndarray:
        """(C,) numbers of vertices."""
        topology = self._topology
        return np.bincount(topology.components, minlength=topology.component_count)

    def check_same(self, origin: Place, target: Place) -> None:
        """
        Raises:
            PlanFailure: start and goal are in different ones.
        """
        start, goal = self.number(origin), self.number(target)
        if start != goal:
            raise PlanFailure(
                GetPathOutcome.NO_PATH_FOUND,
                f"no path: start is in component {start} of {self._topology.component_count}, "
                f"goal in component {goal}",
            )


def not_reached(
    components: Components, origin: Place, target: Place, ground: Ground, potential: np.ndarray
) -> PlanFailure:
    """The failure of a search that has seen everything around the goal, but not the start.

    Args:
        components: of the map.
        origin, target: start and goal.
        ground: what may be passed.
        potential: (V,) of the search.
    """
    number = components.number(target)
    reached = int(np.count_nonzero(np.isfinite(potential)))
    return PlanFailure(
        GetPathOutcome.NO_PATH_FOUND,
        f"no path: {reached} of {components.sizes[number - 1]} vertices of component {number} can "
        f"be reached from the goal, none of them at the start {vector_text(origin.position)}; "
        f"{ground.blocked_count} vertices of the map are lethal, unknown or over the cost limit "
        f"{ground.cost_limit:.3g}",
        potential,
    )
