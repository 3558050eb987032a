"""What the demo makes of the plans: configuration, comparison, colors, and the regular grid."""
import io

import numpy as np
import pytest
import yaml
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.zoo import grid
from mesh_navigation.plugins.plugin_list import PLANNERS as PLANNER_PLUGINS, PluginList

from mesh_tools_test.demo import grid_figure, plans, results
from mesh_tools_test.demo.layers import EDGE_COST_FACTOR
from mesh_tools_test.demo.planners import DIJKSTRA, PLANNERS, WAVE_FRONT, planner_config
from mesh_tools_test.demo.report import Report
from mesh_tools_test.demo.rviz_config import TRACK_TOPIC, rviz_config

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


def test_rviz_draws_every_path_in_a_color_and_at_a_height_of_its_own():
    text = rviz_config(np.zeros(3), np.ones(3), "map", plans.POTENTIAL, (0.0, 9.0), PLANNERS)
    manager = yaml.safe_load(text)["Visualization Manager"]
    lines = [each for each in manager["Displays"] if each["Class"] == "rviz/Path"]
    *paths, track = lines
    assert [each["Topic"] for each in paths] == [
        f"/move_base_flex/{planner.name}/path" for planner in PLANNERS
    ]
    assert len({each["Color"] for each in lines}) == len({each["Name"] for each in lines}) == 4
    heights = [each["Offset"]["Z"] for each in paths]
    assert heights == sorted(set(heights)) and heights[0] > 0.0
    # A band that is seen on both sides of the path, and does not cover it.
    assert track["Topic"] == TRACK_TOPIC and track["Offset"]["Z"] < heights[-1]
    assert track["Line Width"] > 2 * paths[-1]["Line Width"]
    (mesh,) = (each for each in manager["Displays"] if each["Name"] == "Mesh")
    assert mesh["Display Type"]["Vertex Costs Type"] == "Potential"
    assert mesh["Display Type"]["Use Custom limits"]["Vertex Costs Upper Limit"] == 9.0


@pytest.mark.parametrize(
    "start, goal",
    [((0, 0, 0), (30, 40, 2)), ((5, -3, 1), (-20, -3, 1)), ((1, 2, 0), (1, 30, -4))],
)
def test_start_and_goal_are_seen_beside_the_legend(start, goal):
    text = rviz_config(start, goal, "map", plans.POTENTIAL, (0.0, 9.0), PLANNERS)
    manager = yaml.safe_load(text)["Visualization Manager"]
    view = manager["Views"]["Current"]
    (arrow,) = (each for each in manager["Displays"] if each["Name"] == "Goal")
    heading = np.array([goal[0] - start[0], goal[1] - start[1], 0.0])
    heading *= (arrow["Shaft Length"] + arrow["Head Length"]) / np.linalg.norm(heading)
    # As RViz's orbit camera: 45 degrees from top to bottom; the 3D view is about 900 x 870 pixels.
    pitch, yaw = view["Pitch"], view["Yaw"]
    out = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
    right = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
    up = np.cross(out, right)
    for point in (start, goal, goal + heading):
        offset = point - np.array([view["Focal Point"][axis] for axis in "XYZ"])
        half = np.tan(np.pi / 8) * (view["Distance"] - offset @ out)
        column, row = 450 + 435 * (offset @ right) / half, 435 - 435 * (offset @ up) / half
        assert 50 < column < 900 - 135 and 50 < row < 870 - 50  # the legend has up to 125 pixels


@pytest.mark.parametrize(
    "potentials, upper",
    [
        ([[0, 8, np.inf], [0, 7, np.inf]], 10.0),
        ([[0, 3, np.inf], [0, 4, 4]], 5.0),
        ([[np.inf, np.inf]], 1.0),
        ([[0.0, np.inf]], 1.0),
    ],
)
def test_potentials_share_one_scale_whose_red_is_what_cannot_be_reached(potentials, upper):
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


def test_pictures_have_names_of_their_own():
    assert len(set(results.FILES)) == len(results.FILES)
    assert {"rviz.png", "dijkstra.png", "wave_front.png", "grid.png", "report.md"} <= set(
        results.SUCCESS
    )


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
