"""The planners of the demo, how they are drawn, and the configuration of the server."""
from dataclasses import dataclass
from typing import Any, Mapping, Tuple

import yaml

from mesh_tools_test.demo.layers import EDGE_COST_FACTOR


@dataclass(frozen=True, eq=False)
class Shown:
    """A planner of the server and its path in RViz."""

    name: str
    type: str
    title: str
    color: Tuple[int, int, int]
    params: Mapping[str, Any]


# Beyond the start, as far as there is a way.
WHOLE_MAP = {"goal_dist_offset": 10000.0}  # meters
# Dijkstra's edges and the front take 1 + EDGE_COST_FACTOR * cost times their length (the edges'
# factor is the map's to say); the exact geodesic knows only lengths. Colors are of Okabe and Ito,
# which the color-blind tell apart; those of paths are dark ones.
DIJKSTRA = Shown(
    "dijkstra_mesh_planner",
    "dijkstra_mesh_planner/DijkstraMeshPlanner",
    "Dijkstra",
    (0, 0, 0),
    WHOLE_MAP,
)
WAVE_FRONT = Shown(
    "wave_front_planner",
    "wave_front_planner/WaveFrontPlanner",
    "Wave front",
    (0, 114, 178),
    {**WHOLE_MAP, "cost_factor": EDGE_COST_FACTOR},
)
EXACT = Shown("mmp_planner", "mmp_planner/MMPPlanner", "Exact geodesic", (213, 94, 0), {})
PLANNERS = (DIJKSTRA, WAVE_FRONT, EXACT)
RADIUS = 0.25  # m, of the simulated robot


def planner_config():
    """YAML for the namespace of the server: its planners, and time enough for any of them."""
    config = {
        "planners": [{"name": each.name, "type": each.type} for each in PLANNERS],
        "planner_patience": 60.0,
        "robot_radius": RADIUS,
    }
    config.update((each.name, dict(each.params)) for each in PLANNERS if each.params)
    return yaml.safe_dump(config, sort_keys=False)
