"""Costs in the wave's speed: detours exactly when they are cheaper, refraction, fine graphs."""

from functools import lru_cache

import meshes
import numpy as np
import pytest
from cost_oracles import fine_graph_potential, refracted
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs import zoo

TURNED = (False, True)  # the mesh as it is, and with its vertices in another order


class Plane:
    """A plane with what a meter takes at each vertex; places are (x, y)."""

    def __init__(self, mesh, slowness, scrambled=False):
        made = meshes.TestMesh(mesh.name, mesh.vertices, mesh.faces)
        slowness = np.asarray(slowness, np.float32)
        if scrambled:
            made, new = meshes.renumbered(made)
            moved = np.zeros_like(slowness)
            moved[new] = slowness
            slowness = moved
        self.mesh, self.slowness = made, slowness
        self.geometry = MeshGeometry(made.vertices, made.faces)
        self.solver = WaveFrontSolver.of(self.geometry)
        self.tracer = FieldTracer.of(self.geometry)

    def place(self, x, y):
        return self.geometry.closest_face(np.array([x, y, 0.0]), 0.5)

    def path(self, start, goal):
        """The least time and the way, from and to any places."""
        field = self.solver.solve(self.place(*goal), slowness=self.slowness)
        return self.tracer.path(field, self.place(*start))


# A wall from x = 2 to 8 divides the plane. Below it, the straight way leads over an area from x = 4
# to 6; above it, all is cheap.
START, GOAL = (1.0, 1.0), (9.0, 1.0)
CELLS = 80


@lru_cache(maxsize=None)
def corridors(scrambled):
    mesh = zoo.grid(cells=CELLS, size=10.0)
    x, y = mesh.vertices[:, 0].astype(np.float64), mesh.vertices[:, 1].astype(np.float64)
    slowness = np.ones(len(x))
    slowness[(x > 2 - 1e-6) & (x < 8 + 1e-6) & (y > 2 - 1e-6) & (y < 3 + 1e-6)] = np.inf
    area = (x > 4 - 1e-6) & (x < 6 + 1e-6) & (y < 2.01)
    return mesh, slowness, area


def corridor_path(cost, scrambled=False):
    mesh, slowness, area = corridors(scrambled)
    return Plane(mesh, np.where(area & np.isfinite(slowness), cost, slowness), scrambled).path(
        START, GOAL
    )


def straight_time(cost):
    """Along y = 1: 2 m of the area, and a cell on either side where slowness is between."""
    cell = 10.0 / CELLS
    return 8.0 - 2.0 - 2 * cell + 2.0 * cost + 2 * cell * (1.0 + cost) / 2


def detour_time():
    """Around the wall and the cells next to it, which have a closed corner."""
    cell = 10.0 / CELLS
    first = np.hypot(1.0 - cell, 2.0) + np.hypot(cell, cell)  # the diagonal cuts this corner
    return first + 6.0 + cell + np.hypot(1.0 - cell, 2.0 + cell)


FLIP = (detour_time() - 6.0 + 10.0 / CELLS) / (2.0 + 10.0 / CELLS)


@pytest.mark.parametrize("scrambled", TURNED)
@pytest.mark.parametrize("share", [0.5, 0.9, 0.99, 1.01, 1.1, 3.0, 1000.0])
def test_the_detour_is_taken_exactly_when_it_is_cheaper(share, scrambled):
    path = corridor_path(FLIP * share, scrambled)
    highest = path.points[:, 1].max()
    if share < 1:
        assert highest < 1.9
        np.testing.assert_allclose(path.potentials[0], straight_time(FLIP * share), rtol=0.005)
    else:
        assert highest > 3.0
        np.testing.assert_allclose(path.potentials[0], detour_time(), rtol=0.005)
        np.testing.assert_allclose(path.length, detour_time(), rtol=0.001)


def test_where_the_way_changes():
    assert straight_time(FLIP) == pytest.approx(detour_time())
    low, high = FLIP * 0.5, FLIP * 2.0
    for _ in range(12):
        middle = (low + high) / 2
        taken = corridor_path(middle).points[:, 1].max() > 2.5
        low, high = (low, middle) if taken else (middle, high)
    assert low == pytest.approx(FLIP, rel=0.01)


def test_without_costs_that_count_the_straight_way_is_taken():
    path = corridor_path(1.0)
    np.testing.assert_allclose(path.length, 8.0, rtol=1e-5)
    assert np.abs(path.points[:, 1] - 1.0).max() < 1e-3


def strips_of(cells, slow):
    """Slowness 1 up to the middle of 10 m and `slow` from there, and the strips that makes."""
    mesh = zoo.grid(cells=cells, size=10.0)
    cell = 10.0 / cells
    slowness = np.where(mesh.vertices[:, 0] > 5.0 + cell / 2, slow, 1.0)
    ramp = [(5.0 + cell * (k + 1) / 8, 1.0 + (slow - 1.0) * (k + 0.5) / 8) for k in range(8)]
    return mesh, slowness, [(5.0, 1.0)] + ramp + [(np.inf, slow)]


@pytest.mark.parametrize("scrambled", TURNED)
@pytest.mark.parametrize("slow", [0.5, 1.5, 3.0])
@pytest.mark.parametrize("ends", [((1.0, 2.0), (9.0, 8.0)), ((2.0, 7.0), (8.0, 2.5))])
def test_refraction(ends, slow, scrambled):
    """Snell's law: sin(angle) times slowness is alike on both sides of a step of costs."""
    start, goal = ends
    mesh, slowness, strips = strips_of(100, slow)
    path = Plane(mesh, slowness, scrambled).path(start, goal)
    time, crossings = refracted(start, goal, strips)
    assert path.potentials[0] == pytest.approx(time, rel=0.005)

    points = path.points[:, :2]
    before, after = (np.interp(x, points[:, 0], points[:, 1]) for x in (5.0, 5.1))
    assert before == pytest.approx(crossings[0], abs=0.25)  # of 10 m; the time hardly depends on it
    sines = [
        abs(y1 - y0) / np.hypot(x1 - x0, y1 - y0)
        for (x0, y0), (x1, y1) in ((start, (5.0, before)), ((5.1, after), goal))
    ]
    assert sines[0] == pytest.approx(slow * sines[1], rel=0.05 if slow < 2 else 0.2)
    straight = np.hypot(goal[0] - start[0], goal[1] - start[1])
    assert path.length > straight * (1 + 1e-4)


def test_refraction_is_exact_in_the_limit():
    errors = []
    for cells in (25, 50, 100, 200):
        mesh, slowness, strips = strips_of(cells, 2.0)
        path = Plane(mesh, slowness).path((1.0, 2.0), (9.0, 8.0))
        errors.append(abs(path.potentials[0] / refracted((1.0, 2.0), (9.0, 8.0), strips)[0] - 1))
    assert errors[-1] < 0.002 and errors[-1] < 0.5 * errors[0]


def smooth(points):
    x, y = points[:, 0], points[:, 1]
    return 1.0 + 0.8 * (1 + np.sin(1.3 * x) * np.cos(1.7 * y))


def rough(points):
    return np.random.default_rng(5).uniform(1.0, 3.0, len(points))


def holes(points):
    slowness = smooth(points)
    slowness[np.random.default_rng(6).random(len(points)) < 0.1] = np.inf
    return slowness


def terrain():
    return meshes.terrain(size=30)


def plane():
    made = zoo.jittered_plane(cells=30, size=3.0)
    return meshes.TestMesh(made.name, made.vertices, made.faces)


# Smooth costs: within what lines between points that divide edges in four are too long. Where
# costs jump from vertex to vertex, the front is as good as their mean over three corners.
@pytest.mark.parametrize(
    "make, costs, above, below",
    [
        (plane, smooth, 0.015, 0.03),
        (terrain, smooth, 0.03, 0.07),
        (plane, rough, 0.09, 0.04),
        (terrain, rough, 0.18, 0.05),
        (plane, holes, 0.05, 0.03),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_agreement_with_a_fine_graph(make, costs, above, below):
    mesh = make()
    slowness = costs(mesh.vertices.astype(np.float64))
    geometry = MeshGeometry(mesh.vertices, mesh.faces)
    source = len(slowness) // 2 + 15
    slowness[source] = 1.0
    field = WaveFrontSolver.of(geometry).solve(source, slowness=slowness.astype(np.float32))
    expected = fine_graph_potential(mesh, source, slowness.astype(np.float32), pieces=4)
    open_ones = np.isfinite(expected)
    assert open_ones.sum() > 500
    assert np.isinf(field.potential[np.isinf(slowness)]).all()
    far = open_ones & (expected > 10 * np.nanmin(slowness) * float(geometry.edge_lengths.mean()))
    share = field.potential[far] / expected[far] - 1.0
    assert share.max() < above and share.min() > -below
    assert abs(np.median(share)) < min(above, below)


def test_the_metrication_error_of_the_fine_graph_itself():
    """What the bounds above rest on: without costs, it is up to three percent too long."""
    mesh = plane()
    source = len(mesh.vertices) // 2
    distances = np.linalg.norm(mesh.vertices - mesh.vertices[source], axis=1)
    far = distances > 0.5
    share = fine_graph_potential(mesh, source, pieces=4)[far] / distances[far] - 1.0
    assert share.min() > -1e-5 and share.max() < 0.03
