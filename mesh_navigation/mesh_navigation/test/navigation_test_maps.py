"""Maps for tests: meshes of the zoo with costs of the test's own."""

import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mesh_map.edge_weights import PlanningCosts
from mesh_map.layer import LayerResult
from mesh_map.mesh_map import MeshMap
from mesh_map.settings import MapSettings
from mesh_navigation.planners.dijkstra import DijkstraMeshPlanner


class MapWithCosts:
    """A mesh map whose costs are given instead of computed."""

    def __init__(self, mesh, costs=None, layers=None, settings=MapSettings()):
        self._map = MeshMap(mesh.vertices, mesh.faces)
        count = len(mesh.vertices)
        self.costs = np.zeros(count, np.float32) if costs is None else np.float32(costs)
        self.layers = {
            name: SimpleNamespace(result=LayerResult(costs, np.isposinf(costs)))
            for name, costs in (layers or {}).items()
        }
        self._settings, self._version = settings, 0

    def planning_costs(self):
        self._version += 1
        costs = np.float32(self.costs)
        return PlanningCosts(self._version, costs, self._map.geometry, self._settings)

    def __getattr__(self, name):
        return getattr(self._map, name)


def planner_on(mesh_map, **parameters):
    """A Dijkstra planner, ready."""
    planner = DijkstraMeshPlanner()
    assert planner.initialize("dijkstra", mesh_map, parameters) == []
    return planner


def data_file(name):
    """A real mesh; the test is skipped where it is not at hand."""
    repository = Path(__file__).resolve().parents[3]
    folder = Path(os.environ.get("MESH_TOOLS_DATA", repository.parent / "shared" / "data"))
    if not (folder / name).is_file():
        pytest.skip(f"{folder / name} is not there (environment variable MESH_TOOLS_DATA)")
    return folder / name
