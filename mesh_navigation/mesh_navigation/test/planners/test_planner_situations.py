"""Odd situations: every planner gives the same outcome, and numbers that help."""

import numpy as np
import pytest

from mesh_msgs import zoo
from navigation_test_maps import ALL_PLANNERS, MapWithCosts, planner_on

from mesh_map.base.plugins import find_class
from mesh_navigation.base.outcomes import GetPathOutcome as Outcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.plugins.plugin_list import PLANNERS

GRID, HOLE, STOREYS = zoo.grid(), zoo.hole(), zoo.two_storeys()
X, Y = GRID.vertices[:, 0], GRID.vertices[:, 1]
ZERO = np.zeros(len(GRID.vertices))
HERE, THERE = [2.1, 2.1, 0], [8.1, 8.1, 0]
EACH_PLANNER = pytest.mark.parametrize("cls", ALL_PLANNERS, ids=lambda cls: cls.__name__)


def at(point, distance):
    """A point above another one."""
    return [point[0], point[1], point[2] + distance]


SITUATIONS = {
    # name: mesh, costs, start, goal, outcome, words of the message
    "1 cm above": (GRID, ZERO, at(HERE, 0.01), at(THERE, 0.01), Outcome.SUCCESS, "path of"),
    "1 cm below": (GRID, ZERO, at(HERE, -0.01), at(THERE, -0.01), Outcome.SUCCESS, "path of"),
    "start 1 m off": (GRID, ZERO, at(HERE, 1), THERE, Outcome.INVALID_START, "is 1.00 m from the"),
    "goal 1 m off": (GRID, ZERO, HERE, at(THERE, -1), Outcome.INVALID_GOAL, "goal (8.10, 8.10"),
    "goal 100 m off": (GRID, ZERO, HERE, [110, 5, 0], Outcome.INVALID_GOAL, "is 100.00 m from the"),
    "goal far away": (GRID, ZERO, HERE, [1e30, 0, 0], Outcome.INVALID_GOAL, "goal"),
    "start over a hole": (HOLE, None, [4.5, 4.5, 0], HERE, Outcome.INVALID_START, "1.50 m from"),
    "goal over a hole": (HOLE, None, HERE, [4.5, 4.5, 0], Outcome.INVALID_GOAL, "at ("),
    "beside the hole": (HOLE, None, HERE, [3.3, 4.4, 0], Outcome.SUCCESS, "path of"),
    "between storeys": (STOREYS, None, [6, 6, 1.5], [6, 6, 3], Outcome.INVALID_START, "1.50 m"),
    "upper storey": (STOREYS, None, [6, 6, 2.7], [2, 2, 3.3], Outcome.SUCCESS, "path of 5.66 m"),
    "everything lethal": (GRID, ZERO + np.inf, HERE, THERE, Outcome.INVALID_START, "lethal"),
    "nothing known": (GRID, ZERO + np.nan, HERE, THERE, Outcome.INVALID_START, "unknown (NaN)"),
    "all over the limit": (GRID, ZERO + 2, HERE, THERE, Outcome.INVALID_START, "of cost 2, over"),
    "goal unknown": (GRID, np.where(X > 7, np.nan, 0), HERE, THERE, Outcome.INVALID_GOAL, "(NaN)"),
    "strip unknown": (GRID, np.where(X == 5, np.nan, 0), HERE, THERE, Outcome.NO_PATH_FOUND, "11"),
    "negative costs": (GRID, ZERO - 3, HERE, THERE, Outcome.SUCCESS, "path of"),
    "start is goal": (GRID, ZERO, HERE, HERE, Outcome.SUCCESS, "path of 0.00 m with 2 poses"),
    "one corner lethal, start is goal": (
        GRID,
        np.where((X == 3) & (Y == 3), np.inf, 0),
        HERE,
        HERE,
        Outcome.SUCCESS,
        "path of 0.00 m with 2 poses",
    ),
    "one corner lethal, within the face": (
        GRID,
        np.where((X == 3) & (Y == 3), np.inf, 0),
        [2.2, 2.1, 0],
        [2.3, 2.2, 0],
        Outcome.SUCCESS,
        "path of 0.14 m with 2 poses",
    ),
    "at an edge of lethal faces": (
        GRID,
        np.where((Y == 5) | (X < 3.5), 0, np.inf),
        [2, 2, 0],
        [8.5, 5, 0],
        Outcome.SUCCESS,
        "path of",
    ),
}


@EACH_PLANNER
@pytest.mark.parametrize("name", SITUATIONS)
def test_situation(cls, name):
    mesh, costs, start, goal, outcome, words = SITUATIONS[name]
    for faces in (mesh.faces, mesh.faces[:, ::-1]):
        planner = planner_on(MapWithCosts(mesh._replace(faces=faces), costs), cls)
        for turn in ([0, 0, 0, 1.0], [1.0, 0, 0, 0]):  # upright, and upside down
            result = planner.make_plan(
                *(Pose(np.float64(p), np.array(turn)) for p in (start, goal))
            )
            assert result.outcome == outcome, result.message
            assert words in result.message
            if result.succeeded:
                assert np.isfinite(result.poses).all() and len(result.poses) >= 2
                ends = result.poses[[0, -1], :2] - [start[:2], goal[:2]]
                assert np.abs(ends).max() <= (0.31 if name == "beside the hole" else 1e-6)
                length = np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1).sum()
                assert result.cost == pytest.approx(length, rel=0.02, abs=1e-6)


@EACH_PLANNER
@pytest.mark.parametrize("side", [1, -1])
def test_ends_where_faces_are_lethal_on_one_side(cls, side):
    """At an edge or a vertex it counts what may be crossed there, not which face is named."""
    costs = np.where(side * (X - 5) > 0, np.inf, 0)
    planner = planner_on(MapWithCosts(GRID, costs), cls, step_width=1.0)
    inside = [5 - 0.4 * side, 4.4, 0]
    for point in ([5, 5, 0], [5, 4.7, 0], [5, 5.2, 0]):
        for ends in ((point, inside), (inside, point)):
            result = planner.make_plan(*map(Pose.at, ends))
            assert result.succeeded, result.message
            if cls is not ALL_PLANNERS[0]:
                straight = np.linalg.norm(np.subtract(*ends))
                assert result.cost == pytest.approx(straight, rel=1e-5)


@EACH_PLANNER
@pytest.mark.parametrize("seed", range(3))
def test_any_soup_of_triangles(cls, seed):
    """Degenerate, duplicate and flipped faces, edges of many: an outcome, and poses on success."""
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(40, 3)).astype(np.float32)
    faces = rng.integers(0, 40, (90, 3)).astype(np.uint32)
    mesh = GRID._replace(vertices=vertices, faces=faces)
    planner, edges = planner_on(MapWithCosts(mesh), cls), planner_on(MapWithCosts(mesh))
    for _ in range(15):
        ends = [Pose.at(vertices[faces[face]].mean(axis=0)) for face in rng.integers(90, size=2)]
        result, along_edges = planner.make_plan(*ends), edges.make_plan(*ends)
        assert result.outcome == along_edges.outcome
        if result.succeeded:
            assert np.isfinite(result.poses).all()
            assert result.cost <= along_edges.cost * (1 + 1e-5)


NAMES = {
    # as configurations in the field have them
    "dijkstra_mesh_planner/DijkstraMeshPlanner": "DijkstraMeshPlanner",
    "wave_front_planner/WaveFrontPlanner": "WaveFrontPlanner",
    "cvp_mesh_planner/CVPMeshPlanner": "CVPMeshPlanner",
    "mmp_planner/MMPPlanner": "MMPPlanner",
}
COMMON = {
    "cost_limit": (1.0, 0.0, 10.0),
    "goal_dist_offset": (0.3, 0.0, None),
    "publish_vector_field": (False, None, None),
    "publish_face_vectors": (False, None, None),
}
STEP = {"step_width": (0.4, 0.01, 1.0)}
MMP = {
    "min_vertex_angle": (0.01, 0.0, 0.1),
    "min_edge_length": (0.04, 0.0, 1.0),
    "export_filtered_mesh": (False, None, None),
}
PARAMETERS = {
    "DijkstraMeshPlanner": COMMON,
    "WaveFrontPlanner": {**COMMON, **STEP, "cost_factor": (1.0, 0.0, 100.0)},
    "CVPMeshPlanner": {**COMMON, **STEP, "cost_factor": (0.0, 0.0, 100.0)},
    "MMPPlanner": {**COMMON, **STEP, **MMP},
}


@pytest.mark.parametrize("plugin", NAMES)
def test_names_and_parameters(plugin):
    cls = find_class("mesh_navigation", PLANNERS.base_class_type, plugin)
    assert cls.__name__ == NAMES[plugin]
    found = {p.name: (p.default, p.minimum, p.maximum) for p in cls.parameters}
    assert found == PARAMETERS[cls.__name__]
    assert all(parameter.description for parameter in cls.parameters)
