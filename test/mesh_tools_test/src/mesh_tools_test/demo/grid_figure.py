"""Potentials of two planners on a regular grid: Dijkstra's diamond beside the front's circle.

Edges of a regular grid lead in few directions. Along them Dijkstra's distances are right, between
them they are too long, however fine the grid is: figure 12 of the paper.
"""
import io
from typing import Any, NamedTuple

import numpy as np
from PIL import Image
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.zoo import grid
from mesh_navigation.base.pose import Pose
from mesh_navigation.commands.picture import plan_picture
from mesh_navigation.planners.dijkstra import DijkstraMeshPlanner
from mesh_navigation.planners.wave_front import WaveFrontPlanner
from mesh_navigation.plugins.planner import PlanResult

from mesh_tools_test.demo.processes import DemoError

CELLS, SIZE = 100, 10.0  # of the grid; meters
NEAR = 10  # edges; errors are counted beyond
ENDS = Pose.at([2.4, 6.2, 0.0]), Pose.at([5.0, 5.0, 0.0])
REACH = 4.9  # meters of potential; the shape of what is nearer is the point of the picture
PICTURE = (640, 560)  # pixels of each of the two


class OnGrid(NamedTuple):
    """What a planner found on the grid.

    distances: (V,) meters, the true ones; largest, mean: error of the potential beyond NEAR edges,
    as a share of the true distance, as far as the potential reaches.
    """

    title: str
    result: PlanResult
    distances: np.ndarray
    largest: float
    mean: float

    @property
    def error(self):
        """The largest error, for people."""
        percent = 100 * self.largest
        return "exact to 0.001 %" if percent < 1e-3 else f"up to {percent:.2g} % too long"


def grid_map():
    """A square grid without costs, all diagonals alike."""
    mesh = grid(cells=CELLS, size=SIZE)
    return MeshMap(mesh.vertices, mesh.faces)


def plans_on_grid(mesh_map):
    """OnGrid of Dijkstra and of the wave front, both potentials up to REACH."""
    planners = ("Dijkstra", DijkstraMeshPlanner), ("Wave front", WaveFrontPlanner)
    return [_plan(title, planner, mesh_map) for title, planner in planners]


def _plan(title: str, make_planner: Any, mesh_map: MeshMap) -> OnGrid:
    offset = 0.0
    for _ in range(2):  # the cost of the first path says how far it is from there to REACH
        planner = make_planner()
        planner.initialize("on_grid", mesh_map, {"goal_dist_offset": offset})
        result = planner.make_plan(*ENDS)
        if not result.succeeded:
            raise DemoError(f"no path of {title} on a regular grid: {result.message}")
        offset = REACH - result.cost
    distances = np.linalg.norm(mesh_map.vertices - ENDS[1].position, axis=1)
    far = (distances > NEAR * SIZE / CELLS) & np.isfinite(result.potential)
    errors = np.abs(result.potential[far] / distances[far] - 1.0)
    return OnGrid(title, result, distances, float(errors.max()), float(errors.mean()))


def grid_figure(mesh_map, found):
    """Both potentials and paths side by side, as an image."""
    width, height = PICTURE
    image = Image.new("RGB", (width * len(found), height))
    for index, each in enumerate(found):
        title = f"{each.title}: {each.error}"
        picture = plan_picture(mesh_map, each.result, ENDS, None, title, PICTURE)
        image.paste(Image.open(io.BytesIO(picture)), (index * width, 0))
    return image
