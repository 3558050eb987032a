"""What each picture of RViz shows: one thing, that is."""
from typing import NamedTuple, Optional, Tuple

from mesh_map.costs.combination import COMBINED_COSTS

from mesh_tools_test.demo.planners import DIJKSTRA, WAVE_FRONT, Shown
from mesh_tools_test.demo.plans import POTENTIAL


class Picture(NamedTuple):
    """limits: of the colors, in the unit of the layer; None: those of all potentials.

    planner: whose path is shown; track: whether the way of the robot is shown once there is one.
    """

    file: str
    title: str
    layer: str
    limits: Optional[Tuple[float, float]] = None
    planner: Optional[Shown] = None
    track: bool = False


POTENTIALS = (
    Picture(
        "dijkstra.png",
        "Potential of Dijkstra: along edges, which makes lines of equal cost jagged",
        POTENTIAL,
        planner=DIJKSTRA,
    ),
    Picture(
        "wave_front.png",
        "Potential of the wave front: across faces, so that lines of equal cost are smooth",
        POTENTIAL,
        planner=WAVE_FRONT,
    ),
)
LAYERS = (
    Picture("roughness.png", "Roughness of the ground", "roughness", (0.0, 0.8)),
    Picture("inflation.png", "Inflation around what is lethal", "inflation", (0.0, 1.0)),
)
# The only one of --short; else with the robot at the goal.
PLAN = Picture(
    "rviz.png",
    "Costs of all layers together, and the plan of the wave front",
    COMBINED_COSTS,
    (0.0, 1.0),
    WAVE_FRONT,
    track=True,
)
ALL = (*POTENTIALS, *LAYERS, PLAN)
