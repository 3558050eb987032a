"""Maps for tests: meshes with costs of the test's own."""

import numpy as np
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.costs.settings import MapSettings
from mesh_map.map.mesh_map import MeshMap


class MapWithCosts(MeshMap):
    """A map whose costs are given instead of computed by layers; they may be replaced."""

    def __init__(self, mesh, costs=None):
        super().__init__(mesh.vertices, mesh.faces)
        self._version = 0
        self.set_costs(np.zeros(len(mesh.vertices)) if costs is None else costs)

    def set_costs(self, costs):
        self._version += 1
        settings = MapSettings()
        self._given = PlanningCosts(self._version, np.float32(costs), self.geometry, settings)

    def planning_costs(self):
        return self._given


def lifted(mesh, height):
    """The mesh with z = height(x, y)."""
    vertices = mesh.vertices.copy()
    vertices[:, 2] = height(vertices[:, 0], vertices[:, 1])
    return mesh._replace(vertices=vertices)


def lethal_where(mesh, condition):
    """(V,) costs: lethal where the condition on the vertices (V,3) holds, else free."""
    return np.where(condition(mesh.vertices), np.inf, 0.0)


def random_place(mesh, random, costs=None):
    """(3,) m, somewhere on the mesh, in a face whose corners all have finite costs."""
    faces = mesh.faces if costs is None else mesh.faces[np.isfinite(costs)[mesh.faces].all(axis=1)]
    corners = mesh.vertices[faces[random.integers(len(faces))]].astype(np.float64)
    return random.dirichlet([1.0, 1.0, 1.0]) @ corners
