"""What the demo makes of the plans: configuration, comparison, limits, and the regular grid."""
import io

import numpy as np
import pytest
import yaml
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.zoo import grid
from mesh_navigation.plugins.plugin_list import PLANNERS as PLANNER_PLUGINS, PluginList

from mesh_tools_test.demo import grid_figure, plans
from mesh_tools_test.demo.layers import EDGE_COST_FACTOR
from mesh_tools_test.demo.planners import DIJKSTRA, PLANNERS, WAVE_FRONT, planner_config
from mesh_tools_test.demo.report import Report

NOWHERE = np.full(3, np.inf, np.float32)


def plan_of(positions, seconds=0.0):
    return plans.Plan(np.array(positions, float), 0.0, "", seconds, NOWHERE)


def test_the_server_finds_every_planner_and_takes_every_parameter():
    config = yaml.safe_load(planner_config())
    found = PluginList(PLANNER_PLUGINS, config["planners"])
    assert found.complaints == [] and found.names == [each.name for each in PLANNERS]
    mesh = grid(cells=2)
    prepared = found.prepared(MeshMap(mesh.vertices, mesh.faces), config)
    assert prepared.complaints == []
    for name in found.names:
        assert config.get(name, {}).items() <= dict(prepared[name].values).items()


def test_both_planners_with_costs_weigh_them_alike():
    assert WAVE_FRONT.params["cost_factor"] == EDGE_COST_FACTOR
    assert DIJKSTRA.params["goal_dist_offset"] == WAVE_FRONT.params["goal_dist_offset"]


@pytest.mark.parametrize(
    "potentials, upper",
    [
        ([[0, 8, np.inf], [0, 7, np.inf]], 8.0),
        ([[0, 3, np.inf], [0, 4, 4]], 4.0),
        ([[np.inf, np.inf]], 1.0),
        ([[0.0, np.inf]], 1.0),
    ],
)
def test_potentials_share_one_scale_up_to_the_highest_that_is_known(potentials, upper):
    limits = plans.color_limits([np.float32(each) for each in potentials])
    assert limits == pytest.approx((0.0, upper))


def test_paths_are_compared_by_one_measure():
    mesh = grid(cells=10, size=10.0)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    mesh_map.compute_layers(
        [{"name": "border", "type": "mesh_layers/BorderLayer", "params": {"border_cost": 0.25}}]
    )
    straight = plan_of([[0.0, 5.0, 0.0], [10.0, 5.0, 0.0]], 0.5)
    around = plan_of([[0.0, 5.0, 0.0], [0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 5.0, 0.0]], 0.25)
    first = plans.compared("Straight", straight, plan_of([]), mesh_map)
    # Costs fall from 0.25 to 0 in the outermost row of triangles, at both ends.
    assert first.length == pytest.approx(10.0)
    assert first.with_costs == pytest.approx(10.0 + EDGE_COST_FACTOR * 0.25)
    second = plans.compared("Around", around, plan_of([], 0.0625), mesh_map)
    assert second.with_costs == pytest.approx(20.0 * (1 + EDGE_COST_FACTOR * 0.25))
    assert plans.table([first, second])[1:] == [
        ("Straight", "10.00", "10.50", "500", "0"),
        ("Around", "20.00", "30.00", "250", "62"),
    ]


def test_tables_are_printed_and_follow_the_steps_in_the_report():
    stream = io.StringIO()
    report = Report(stream)
    with report.step("plan") as notes:
        notes.append("found")
    report.table([("planner", "path [m]"), ("Dijkstra", "7.25"), ("Wave front", "6.5")])
    assert stream.getvalue().splitlines()[1:] == [
        "    planner      path [m]",
        "    Dijkstra         7.25",
        "    Wave front        6.5",
    ]
    lines = report.markdown().splitlines()
    assert lines[-4:] == [
        "| planner | path [m] |",
        "|---|---:|",
        "| Dijkstra | 7.25 |",
        "| Wave front | 6.5 |",
    ]
    assert lines[-5] == "" and lines[2].startswith("| plan |")


@pytest.fixture(scope="module")
def flat():
    return grid_figure.grid_map()


@pytest.fixture(scope="module")
def on_grid(flat):
    return grid_figure.plans_on_grid(flat)


def test_dijkstra_makes_a_diamond_and_the_wave_front_a_circle(on_grid):
    dijkstra, front = on_grid
    assert dijkstra.largest > 0.15 and dijkstra.mean > 0.1
    assert front.largest < 1e-3
    for found, inside in ((dijkstra, False), (front, True)):
        reached = np.isfinite(found.result.potential)
        assert reached[found.distances == 0.0].all() and not reached.all()
        assert found.result.potential[reached].max() == pytest.approx(
            grid_figure.REACH, abs=0.15
        )  # an edge
        circle = found.distances < 0.95 * grid_figure.REACH
        assert reached[circle].all() == inside
        assert not reached[found.distances > 1.05 * grid_figure.REACH].any()


def test_only_the_path_across_faces_is_straight(on_grid):
    start, goal = (pose.position for pose in grid_figure.ENDS)
    straight = np.linalg.norm(goal - start)
    dijkstra, front = (found.result.poses[:, :3] for found in on_grid)
    assert plan_of(front).length == pytest.approx(straight, rel=1e-4)
    assert 1.05 * straight < plan_of(dijkstra).length < 1.42 * straight


def test_the_figure_shows_both_side_by_side(flat, on_grid):
    picture = np.asarray(grid_figure.grid_figure(flat, on_grid)).astype(int)
    width, height = grid_figure.PICTURE
    assert picture.shape == (height, 2 * width, 3)
    left, right = picture[:, :width], picture[:, width:]
    assert (np.abs(left - right).max(axis=2) > 60).mean() > 0.1
    for half in (left, right):
        assert 0.2 < (np.ptp(half, axis=2) > 100).mean() < 0.8  # the rainbow, and the rest
