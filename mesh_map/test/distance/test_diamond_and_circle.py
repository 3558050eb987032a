"""On a regular grid, Dijkstra's potential is a diamond, that of the wave front a circle."""

import numpy as np
import pytest
from mesh_map.distance.dijkstra import DijkstraSolver
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs import zoo

CELLS = 100


@pytest.fixture(scope="module")
def fields():
    """Potentials of both from the middle of a square of 10 m, and the straight distances."""
    mesh = zoo.grid(cells=CELLS, size=10.0)
    geometry = MeshGeometry(mesh.vertices, mesh.faces)
    goal = len(mesh.vertices) // 2
    solver = DijkstraSolver(topology=geometry.topology, edge_lengths=geometry.edge_lengths)
    diamond = solver.solve(goal).potential.astype(np.float64)
    circle = WaveFrontSolver.of(geometry).solve(goal).potential.astype(np.float64)
    offsets = mesh.vertices.astype(np.float64) - mesh.vertices[goal]
    return diamond, circle, offsets


def beyond_ten_edges(offsets):
    distances = np.linalg.norm(offsets, axis=1)
    return distances > 10 * 10.0 / CELLS, distances


def test_dijkstra_is_more_than_15_percent_off(fields):
    diamond, _, offsets = fields
    far, distances = beyond_ten_edges(offsets)
    errors = diamond[far] / distances[far] - 1.0
    assert errors.min() >= -1e-6 and errors.max() > 0.15 and errors.mean() > 0.1


def test_the_front_is_less_than_a_thousandth_off(fields):
    _, circle, offsets = fields
    far, distances = beyond_ten_edges(offsets)
    assert np.abs(circle[far] / distances[far] - 1.0).max() < 0.001


def test_lines_of_equal_potential(fields):
    """Between the axis that diagonals follow and the other one, only a circle looks alike."""
    diamond, circle, offsets = fields
    ring = np.abs(np.linalg.norm(offsets, axis=1) - 3.0) < 0.05
    angles = np.arctan2(offsets[ring, 1], offsets[ring, 0])
    assert len(np.unique(np.round(angles, 1))) > 50  # all around
    spread = [np.ptp(values[ring]) for values in (diamond, circle)]
    assert spread[0] > 1.0 and spread[1] < 0.11

    # what Dijkstra computes on this grid: one diagonal is a short cut, the other is not
    x, y = offsets[:, 0], offsets[:, 1]
    straight = np.where(x * y > 0, np.hypot(1, 1) - 2, 0.0) * np.minimum(np.abs(x), np.abs(y))
    np.testing.assert_allclose(diamond, np.abs(x) + np.abs(y) + straight, rtol=1e-4, atol=1e-5)


def test_the_error_of_edges_stays_under_refinement():
    """Finer grids do not help Dijkstra; the wave front is exact on each."""
    worst = []
    for cells in (20, 40, 80):
        mesh = zoo.grid(cells=cells, size=1.0)
        geometry = MeshGeometry(mesh.vertices, mesh.faces)
        solver = DijkstraSolver(topology=geometry.topology, edge_lengths=geometry.edge_lengths)
        corner = cells  # where the diagonals lead nowhere
        distances = np.linalg.norm(mesh.vertices - mesh.vertices[corner], axis=1)
        far = distances > 0.5
        rows = (
            solver.solve(corner).potential,
            WaveFrontSolver.of(geometry).solve(corner).potential,
        )
        worst.append([np.abs(row[far] / distances[far] - 1.0).max() for row in rows])
    worst = np.array(worst)
    np.testing.assert_allclose(worst[:, 0], np.sqrt(2.0) - 1.0, rtol=1e-3)
    assert (worst[:, 1] < 1e-5).all()
