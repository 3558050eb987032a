"""Where the benchmark plans: the rough outdoor world, with costs of its own."""

from functools import cached_property
from typing import Any, List, NamedTuple, Optional

import numpy as np
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.costs.settings import MapSettings
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.outdoor_world import outdoor_world

NOISE = 0.003  # meters
DISTANCE = 17.0  # meters, about that of the paper's path in the Stone Quarry


class Place(NamedTuple):
    """A point of the surface."""

    face: int
    position: np.ndarray  # (3,) float64, m


class PlanningWorld:
    """A geometry, and the ground of it: the largest component.

    Attributes:
        geometry: the world, prepared.
        source: the vertex in the middle of the ground.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.geometry = MeshGeometry(vertices, faces)
        components = self.geometry.topology.components
        self.ground = components == np.argmax(np.bincount(components))
        middle = self.geometry.vertices[self.ground].mean(axis=0, dtype=np.float64)
        offsets = self.geometry.vertices[:, :2] - middle[:2].astype(np.float32)
        distances = np.where(self.ground, np.square(offsets).sum(axis=1), np.inf)
        self.source = int(np.argmin(distances))

    vertices = property(lambda self: self.geometry.vertices)
    faces = property(lambda self: self.geometry.faces)
    topology = property(lambda self: self.geometry.topology)

    @cached_property
    def costs(self) -> np.ndarray:
        """(V,) float32 between 0 and 1, hills and valleys of about 10 m."""
        x, y = self.vertices[:, 0], self.vertices[:, 1]
        costs = 0.5 + 0.25 * np.sin(x * 0.6) + 0.25 * np.cos(y * 0.7 + 0.2 * x)
        return np.clip(costs, 0.0, 1.0).astype(np.float32)

    @cached_property
    def _usable_faces(self) -> np.ndarray:
        usable = self.ground[self.faces].all(axis=1)
        usable[self.geometry.faces_without_area] = False
        return np.flatnonzero(usable)

    def vertex_at(self, potential: np.ndarray, distance: float = DISTANCE) -> int:
        """The vertex whose potential is nearest to a distance."""
        finite = np.where(np.isfinite(potential), potential, np.inf)
        return int(np.argmin(np.abs(finite - distance)))

    def places(self, count: int, random: np.random.Generator) -> List[Place]:
        """Points of the ground, anywhere in faces that have an area."""
        faces = random.choice(self._usable_faces, count)
        shares = random.dirichlet((1.0, 1.0, 1.0), count)
        corners = self.vertices[self.faces[faces]].astype(np.float64)
        positions = np.einsum("nk,nkd->nd", shares, corners)
        return [Place(int(face), position) for face, position in zip(faces, positions)]

    def face_at(self, vertex: int) -> Place:
        """A place very near to a vertex: the middle of a face around it."""
        face = int(self.topology.faces_of(vertex)[0])
        return Place(face, self.vertices[self.faces[face]].mean(axis=0, dtype=np.float64))


class CostedMap:
    """A mesh map whose costs are given instead of computed by layers."""

    def __init__(self, geometry: MeshGeometry, costs: np.ndarray) -> None:
        self._map = MeshMap.of(geometry)
        self.costs, self._settings = costs, MapSettings()
        self._now = PlanningCosts(1, costs, geometry, self._settings)

    def planning_costs(self) -> PlanningCosts:
        """What planners use."""
        return self._now

    def set_costs(self, vertices: np.ndarray, values: Any) -> None:
        """Other costs of some vertices ((K,) ascending)."""
        costs, before = self._now.costs.copy(), self._now
        costs[vertices] = values
        version = before.version + 1
        self._now = PlanningCosts(
            version, costs, self._map.geometry, self._settings, before, vertices
        )
        self.costs = costs

    def __getattr__(self, name: str) -> Any:
        return getattr(self._map, name)


def planning_world(faces: int, noise: float = NOISE, seed: int = 0) -> PlanningWorld:
    """The world of about that many faces with that much noise of each height (m)."""
    world = outdoor_world(faces=faces, seed=seed)
    vertices = np.array(world.vertices, np.float64)
    vertices[:, 2] += np.random.default_rng(seed).normal(0.0, noise, len(vertices))
    return PlanningWorld(vertices.astype(np.float32), world.faces)


def divided(world: PlanningWorld) -> PlanningWorld:
    """Each face cut into four at the middles of its sides."""
    edges, sides = world.topology.edges, world.topology.face_edges.astype(np.int64)
    middles = (world.vertices[edges[:, 0]] + world.vertices[edges[:, 1]]) / 2
    between = _opposite(world.faces, edges, sides) + len(world.vertices)
    corners = world.faces.astype(np.int64)
    parts = [
        np.stack([corners[:, k], between[:, (k + 2) % 3], between[:, (k + 1) % 3]], axis=1)
        for k in range(3)
    ]
    faces = np.concatenate(parts + [between]).astype(np.uint32)
    return PlanningWorld(np.concatenate([world.vertices, middles]), faces)


def _opposite(faces: np.ndarray, edges: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """(F, 3) the edges of faces so that edge k is opposite to corner k."""
    found = np.zeros(faces.shape, np.int64)
    for corner in range(3):
        for side in range(3):
            has = (edges[sides[:, side]] == faces[:, corner, None]).any(axis=1)
            found[~has, corner] = sides[~has, side]
    return found


def patch(world: PlanningWorld, count: int, near: Optional[int] = None) -> np.ndarray:
    """(K,) ascending: about that many vertices nearest to one, by default in the middle."""
    center = world.vertices[world.source if near is None else near]
    count = min(count, len(world.vertices))
    squares = np.square(world.vertices - center).sum(axis=1)
    return np.sort(np.argpartition(squares, count - 1)[:count]).astype(np.uint32)
