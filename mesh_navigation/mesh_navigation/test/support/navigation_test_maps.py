"""Maps for tests: meshes of the zoo with costs of the test's own."""

import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_map.costs.cleared_costs import ClearedCosts
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.costs.layer import LayerResult
from mesh_map.costs.settings import MapSettings
from mesh_map.map.mesh_map import MeshMap
from mesh_navigation.planners.dijkstra import DijkstraMeshPlanner
from mesh_navigation.planners.mmp import MMPPlanner
from mesh_navigation.planners.wave_front import CVPMeshPlanner, WaveFrontPlanner

ALL_PLANNERS = [DijkstraMeshPlanner, WaveFrontPlanner, CVPMeshPlanner, MMPPlanner]
FRONT_PLANNERS = ALL_PLANNERS[1:]

PASSABLE = [mesh for mesh in zoo.all_meshes() if len(mesh.faces)]
BY_NAME = {"ids": lambda mesh: mesh.name}


class MapWithCosts:
    """A mesh map whose costs are given instead of computed."""

    clearable_layers = ()

    def __init__(self, mesh, costs=None, layers=None, settings=MapSettings()):
        self._map = MeshMap(mesh.vertices, mesh.faces)
        count = len(mesh.vertices)
        self.costs = np.zeros(count, np.float32) if costs is None else np.float32(costs)
        self.layers = {
            name: SimpleNamespace(result=LayerResult(costs, np.isposinf(costs)))
            for name, costs in (layers or {}).items()
        }
        self._settings, self._planning = settings, None

    def planning_costs(self):
        """The same as long as the costs are."""
        costs, known = np.float32(self.costs), self._planning
        if known is None or not np.array_equal(costs, known.costs, equal_nan=True):
            version = 1 if known is None else known.version + 1
            self._planning = PlanningCosts(version, costs, self._map.geometry, self._settings)
        return self._planning

    def cleared_costs(self):
        """Nothing in here comes from sensors."""
        results = {name: layer.result for name, layer in self.layers.items()}
        return ClearedCosts(self.planning_costs(), results)

    def __getattr__(self, name):
        return getattr(self._map, name)


def planner_on(mesh_map, cls=DijkstraMeshPlanner, **parameters):
    """A planner, ready."""
    planner = cls()
    assert planner.initialize("planner", mesh_map, parameters) == []
    return planner


def vertex_at(mesh, point):
    """The vertex nearest to a point (3,)."""
    return int(np.argmin(np.linalg.norm(mesh.vertices - point, axis=1)))


def distances_from_surface(mesh_map, polyline, spacing=0.01):
    """(N,) m: how far points all along a polyline are from the mesh."""
    steps = np.diff(polyline, axis=0)
    pieces = np.maximum((np.linalg.norm(steps, axis=1) / spacing).astype(int), 1)
    owners = np.repeat(np.arange(len(steps)), pieces + 1)
    begins = np.cumsum(pieces + 1) - (pieces + 1)
    shares = (np.arange(len(owners)) - begins[owners]) / pieces[owners]
    points = polyline[owners] + shares[:, None] * steps[owners]
    return mesh_map.spatial_index.closest_batch(points=points).distances


def point_on(mesh, face, weights):
    return weights @ mesh.vertices[mesh.faces[face]].astype(np.float64)


def random_pairs(mesh, count, seed=0):
    """(face, point) of start and goal, uniform over the faces."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        faces = rng.integers(len(mesh.faces), size=2)
        yield [(face, point_on(mesh, face, rng.dirichlet([1, 1, 1]))) for face in faces]


def data_file(name):
    """A real mesh; the test is skipped where it is not at hand."""
    repository = Path(__file__).resolve().parents[4]
    folder = Path(os.environ.get("MESH_TOOLS_DATA", repository.parent / "shared" / "data"))
    if not (folder / name).is_file():
        pytest.skip(f"{folder / name} is not there (environment variable MESH_TOOLS_DATA)")
    return folder / name
