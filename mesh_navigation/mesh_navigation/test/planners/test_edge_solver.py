"""Plans follow the edge weights of the map, and take what belongs together."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from mesh_msgs import zoo
from navigation_test_maps import MapWithCosts, planner_on

from mesh_map.costs.settings import MapSettings
from mesh_navigation.base.pose import Pose
from mesh_navigation.planners.dijkstra import EdgeSolvers
from mesh_navigation.surface.face_points import find_face_point

START, GOAL = Pose.at([0, 5, 0]), Pose.at([10, 5, 0])
GRID = zoo.grid()


def hill(height):
    """Costs that are high in the middle between start and goal."""
    return height * np.exp(-((GRID.vertices[:, :2] - 5) ** 2).sum(axis=1) / 4)


def weighted(costs, **settings):
    return MapWithCosts(GRID, costs, settings=MapSettings(**settings))


@pytest.mark.parametrize(
    "settings",
    [
        {"edge_weight": "mean", "edge_cost_factor": 5.0},
        {"edge_weight": "difference", "layer_factor": 3.0},
    ],
)
def test_the_path_is_the_cheapest_one(settings):
    mesh_map = weighted(hill(0.9), **settings)
    result = planner_on(mesh_map, goal_dist_offset=1e9).make_plan(START, GOAL)
    weights = mesh_map.planning_costs().edge_weights.astype(np.float64)
    edges, count = mesh_map.topology.edges, len(GRID.vertices)
    graph = coo_matrix((weights, (edges[:, 0], edges[:, 1])), shape=(count, count))
    start, goal = (find_face_point(mesh_map, pose.position, "end", 0) for pose in (START, GOAL))
    from_corners = dijkstra(graph, directed=False, indices=goal.corners)
    distances = (from_corners + goal.distances[:, None]).min(axis=0)
    np.testing.assert_allclose(result.potential, distances, rtol=1e-5)
    expected = (distances[start.corners] + start.distances).min()
    assert result.cost == pytest.approx(expected, rel=1e-5)
    assert np.abs(result.poses[:, 1] - 5).max() > 0.9  # around the hill
    length = np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1).sum()
    assert f"path of {length:.2f} m" in result.message and result.cost > length


def test_without_a_factor_the_path_is_the_shortest():
    result = planner_on(weighted(hill(0.9))).make_plan(START, GOAL)
    assert result.cost == pytest.approx(10.0) and np.allclose(result.poses[:, 1], 5)


def test_obstacles_alone_need_no_new_solver():
    mesh_map = weighted(hill(0.9))
    solvers = EdgeSolvers(mesh_map)
    first = solvers.newest()
    mesh_map.costs = np.where(np.arange(len(GRID.vertices)) % 7 == 0, np.inf, hill(0.9))
    second = solvers.newest()
    assert not first.weighted and second.solver is first.solver
    assert np.isinf(second.costs).any() and not np.isinf(first.costs).any()


def test_weights_are_looked_at_once(monkeypatch):
    for factor in (0.0, 1.0):
        mesh_map = weighted(np.where(hill(0.9) > 0.8, np.inf, hill(0.9)), edge_cost_factor=factor)
        solvers = EdgeSolvers(mesh_map)
        snapshot = mesh_map.planning_costs()
        first = solvers.of(snapshot)
        with monkeypatch.context() as patched:
            patched.setattr("mesh_navigation.planners.dijkstra.is_lengths_or_closed", None)
            again = solvers.of(snapshot)
        assert again.solver is first.solver and again.weighted == first.weighted == bool(factor)


def test_other_weights_need_another_solver_but_not_another_graph(monkeypatch):
    mesh_map = weighted(hill(0.9), edge_cost_factor=1.0)
    solvers = EdgeSolvers(mesh_map)
    snapshot = mesh_map.planning_costs()
    first = solvers.of(snapshot)
    assert first.weighted and solvers.of(snapshot).solver is first.solver
    monkeypatch.setattr("mesh_navigation.planners.dijkstra.DijkstraSolver", None)  # none is built
    for height in (0.5, 0.7):
        mesh_map.costs = hill(height)
        second = solvers.newest()
        assert second.weighted and second.solver is not first.solver
        assert second.costs.max() == mesh_map.costs.max()
        weights = mesh_map.planning_costs().edge_weights
        assert np.array_equal(second.solver.edge_lengths, weights)


def test_weights_and_lengths_may_take_turns():
    """As a factor is set, set back, and set again; a field of each follows to the next."""
    mesh_map = weighted(hill(0.9), edge_cost_factor=0.0)
    solvers = EdgeSolvers(mesh_map)
    plain = solvers.newest()
    field = plain.solver.solve(0, plain.costs)
    for factor in (2.0, 0.0, 5.0):
        mesh_map = weighted(hill(0.9), edge_cost_factor=factor)
        edges = solvers.of(mesh_map.planning_costs())
        assert edges.weighted == bool(factor) and (edges.solver is plain.solver) != edges.weighted
        field.update(edges.costs, solver=edges.solver)
        expected = edges.solver.solve(0, edges.costs).potential
        assert field.potential.tobytes() == expected.tobytes()


def test_the_start_in_the_face_of_the_goal():
    start, goal = Pose.at([5.1, 5.3, 0]), Pose.at([5.2, 5.4, 0])
    result = planner_on(weighted(hill(0.9), edge_cost_factor=5.0)).make_plan(start, goal)
    assert len(result.poses) == 2 and result.cost == pytest.approx(np.hypot(0.1, 0.1))
