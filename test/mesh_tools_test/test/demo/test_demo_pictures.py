"""Pictures of the demo: the whole map, lines with halos, lines of equal cost, robot, key, scale."""
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import yaml
from mesh_msgs.zoo import grid

from mesh_tools_test.demo import isolines, key, orbit_camera, pictures, results, robot_model
from mesh_tools_test.demo import screenshot
from mesh_tools_test.demo.planners import DIJKSTRA, PLANNERS, RADIUS, WAVE_FRONT
from mesh_tools_test.demo.processes import DemoError
from mesh_tools_test.demo.rviz_config import BACKGROUND, VIEW, picture_config, user_config

START, GOAL = np.array([2.0, 5.0, 0.5]), np.array([30.0, 12.0, 1.0])


@pytest.fixture(scope="module")
def hills():
    """A map that is longer than wide, with a tower in a corner."""
    mesh = grid(cells=20, size=40.0)
    vertices = mesh.vertices.astype(float)
    vertices[:, 1] *= 0.5
    vertices[:, 2] = np.sin(vertices[:, 0] / 5)
    vertices[0, 2] = 9.0
    return vertices


@pytest.fixture(scope="module")
def camera(hills):
    return orbit_camera.whole_map(hills, START, GOAL, VIEW)


def displays(text):
    return yaml.safe_load(text)["Visualization Manager"]["Displays"]


@pytest.mark.parametrize("yaw", [-2.0, 0.3, 1.5, 3.0])
@pytest.mark.parametrize("size", [(1248, 869), (700, 900)])
def test_the_whole_map_is_in_the_view_as_large_as_it_gets(hills, yaw, size):
    view = orbit_camera.fitted(hills, yaw, size).view()
    # As RViz: the eye looks at the focal point, 45 degrees from top to bottom.
    cos, sin = np.cos(view["Pitch"]), np.sin(view["Pitch"])
    out = np.array([np.cos(view["Yaw"]) * cos, np.sin(view["Yaw"]) * cos, sin])
    right = np.array([-np.sin(view["Yaw"]), np.cos(view["Yaw"]), 0.0])
    eye = np.array([view["Focal Point"][axis] for axis in "XYZ"]) + view["Distance"] * out
    seen = (hills - eye) @ np.array([right, np.cross(out, right), -out]).T
    assert seen[:, 2].min() > view["Near Clip Distance"]
    scale = size[1] / 2 / np.tan(np.pi / 8)
    column = size[0] / 2 + scale * seen[:, 0] / seen[:, 2]
    row = size[1] / 2 - scale * seen[:, 1] / seen[:, 2]
    room = np.array([size[0] - orbit_camera.LEFT - orbit_camera.RIGHT])
    room = np.append(room, size[1] - orbit_camera.TOP - orbit_camera.BOTTOM)
    assert column.min() >= orbit_camera.LEFT - 1e-6
    assert column.max() <= size[0] - orbit_camera.RIGHT + 1e-6
    assert row.min() >= orbit_camera.TOP - 1e-6
    assert row.max() <= size[1] - orbit_camera.BOTTOM + 1e-6
    assert max(np.array([np.ptp(column), np.ptp(row)]) / room) == pytest.approx(1)
    pixels = orbit_camera.fitted(hills, yaw, size).pixels(hills)
    assert pixels == pytest.approx(np.column_stack([column, row]))


def test_the_camera_stands_beside_the_way(hills, camera):
    start, goal = camera.pixels([START, GOAL])
    assert goal[0] - start[0] > 1.5 * abs(goal[1] - start[1])
    square = np.arctan2(*(GOAL - START)[1::-1]) - np.pi / 2
    assert abs(camera.yaw - square) <= orbit_camera.ASIDE.max() + 1e-9
    assert camera.distance <= orbit_camera.fitted(hills, square, VIEW).distance


def test_meters_of_a_pixel_are_those_between_two_points(camera):
    ends = np.array([GOAL, GOAL + 2.0 * camera.axes[0]])
    pixels = camera.pixels(ends)
    assert np.linalg.norm(pixels[1] - pixels[0]) == pytest.approx(2 / camera.meters([GOAL])[0])
    assert camera.pixel == pytest.approx(camera.meters([camera.focal_point])[0])


@pytest.mark.parametrize("picture", pictures.ALL)
def test_a_picture_shows_one_thing_and_the_robot(picture, camera):
    shown = displays(picture_config(picture, (0.0, 9.0), camera, "map"))
    (mesh,) = (each for each in shown if each["Name"] == "Mesh")
    assert mesh["Display Type"]["Vertex Costs Type"] == picture.layer
    assert mesh["Display Type"]["Use Custom limits"]["Vertex Costs Upper Limit"] == 9.0
    assert [each["Class"] for each in shown].count("rviz/RobotModel") == 1
    topics = {each["Topic"] for each in shown if each["Class"] == "rviz/Path"} - {"/track"}
    assert len(topics) == (picture.planner is not None)
    markers = [each["Marker Topic"] for each in shown if each["Class"] == "rviz/Marker"]
    assert markers == ([isolines.TOPIC] if picture in pictures.POTENTIALS else [])


def test_a_path_is_a_dark_line_on_a_light_one_and_the_track_is_a_narrow_one_on_it(camera):
    shown = displays(picture_config(pictures.PLAN, (0.0, 1.0), camera, "map"))
    halo, path, track = (each for each in shown if each["Class"] == "rviz/Path")
    assert halo["Topic"] == path["Topic"] == "/move_base_flex/wave_front_planner/path"
    assert track["Topic"] == "/track"
    assert halo["Line Width"] > 1.5 * path["Line Width"] > 4 * track["Line Width"]
    assert 0 < halo["Offset"]["Z"] < path["Offset"]["Z"] < track["Offset"]["Z"]
    # Lines face the camera: the lower edge of a lower one would be in the ground.
    assert halo["Offset"]["Z"] > 0.5 * halo["Line Width"]
    light = [sum(map(int, each["Color"].split(";"))) for each in (halo, path, track)]
    assert min(light[0], light[2]) - light[1] > 200
    assert len({planner.color for planner in PLANNERS}) == len(PLANNERS)


def test_the_user_gets_every_path_and_the_goal_in_the_tree(hills):
    text = user_config(pictures.PLAN, hills, START, GOAL, "map")
    lines = [each for each in displays(text) if each["Class"] == "rviz/Path"]
    topics = {f"/move_base_flex/{planner.name}/path" for planner in PLANNERS}
    assert {each["Topic"] for each in lines} == topics | {"/track"}
    enabled = {each["Topic"] for each in lines if each["Enabled"]}
    assert enabled == {f"/move_base_flex/{WAVE_FRONT.name}/path", "/track"}
    assert "rviz/Pose" in {each["Class"] for each in displays(text)}
    assert [each["Class"] for each in yaml.safe_load(text)["Panels"]] == ["rviz/Displays"]
    assert (
        yaml.safe_load(picture_config(pictures.PLAN, (0, 1), camera_of(hills), "map"))["Panels"]
        == []
    )


def camera_of(vertices):
    return orbit_camera.whole_map(vertices, START, GOAL, VIEW)


def test_the_view_is_what_the_background_frames():
    window = np.full((60, 80, 3), 239, np.uint8)
    window[10:50, 5:70] = BACKGROUND
    window[20:40, 20:60] = (200, 20, 90)
    view = screenshot.view_of(window, BACKGROUND)
    assert view.shape == (40, 65, 3) and (view[10:30, 15:55] == (200, 20, 90)).all()
    with pytest.raises(DemoError, match="no background"):
        screenshot.view_of(np.zeros((9, 9, 3), np.uint8), BACKGROUND)


def test_lines_of_equal_cost_are_where_the_values_are():
    mesh = grid(cells=7, size=7.0)
    vertices = mesh.vertices.astype(float)
    slope = np.array([0.3, 0.4, 0.0])
    values = vertices @ slope
    values[0] = np.inf  # a corner, of one or two faces
    segments, of = isolines.isolines(vertices, mesh.faces, values, 0.25)
    assert segments @ slope == pytest.approx(np.column_stack([of, of]))
    # The first one would be beside that corner only; the last one is below 0.7 * 7.
    assert set(np.rint(of / 0.25)) == set(range(2, 20))
    lengths = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    whole = lengths[np.isclose(of, 2.25)].sum()  # from (0, 5.625) to (7, 0.375)
    assert whole == pytest.approx(np.hypot(7.0, 5.25))


def test_lines_of_equal_cost_have_round_values_and_a_color_that_is_seen():
    assert isolines.step(93.0) == 2.0 and isolines.step(7.0) == 0.2
    segments = np.arange(12.0).reshape(2, 2, 3)
    marker = isolines.marker(segments, np.array([True, False]), "map", 0.1, 0.2)
    assert [color.r for color in marker.colors] == [1, 1, 0, 0]
    assert [point.x for point in marker.points] == [0, 3, 6, 9]
    assert (marker.scale.x, marker.pose.position.z) == (0.1, 0.2)


def test_the_robot_is_enlarged_only_where_it_would_be_a_dot():
    assert robot_model.times(2 * RADIUS / 15) == robot_model.times(2 * RADIUS / 200) == 1
    assert robot_model.times(2 * RADIUS / 14) == 2
    assert robot_model.times(2 * RADIUS / 5) == 3


def test_an_enlarged_robot_is_the_shipped_one_with_all_parts_in_place():
    shipped = robot_model.shipped()
    big = ElementTree.fromstring(robot_model.enlarged(shipped, 3))
    small = ElementTree.fromstring(shipped)
    for name, axis in (("radius", "base_link"), ("length", "laser")):
        pair = [robot.find(f"link[@name='{axis}']//cylinder").get(name) for robot in (big, small)]
        assert float(pair[0]) == pytest.approx(3 * float(pair[1]))
    # The laser's frame is at a height of 0.8 m, as TF has it; it is drawn at three times that.
    assert big.find("joint[@name='laser_joint']/origin").get("xyz") == "0 0 0.8"
    assert big.find("link[@name='laser']/visual/origin").get("xyz") == "0 0 1.6"
    same = ElementTree.fromstring(robot_model.enlarged(shipped, 1))
    assert same.find("link[@name='laser']/visual/origin").get("xyz") == "0 0 0"
    assert "3 times its size" in key.robot(3).get_label() and key.robot(1).get_label() == "robot"


def test_the_key_names_lines_and_marks_places_and_lengths(hills, camera):
    width, height = VIEW
    view = np.full((height, width, 3), BACKGROUND, np.uint8)
    handles = [key.robot(3), key.path(DIJKSTRA), key.track(WAVE_FRONT), key.isoline(2)]
    places = {"start": START, "goal": GOAL}
    image = np.asarray(key.with_key(view, camera, "Title", handles, places)).astype(int)
    assert image.shape == (height + key.TITLE + key.STRIP, width, 3)
    for column, row in camera.pixels([START, GOAL]):  # white on the ring, in black
        ring = image[int(row + key.TITLE), int(column + key.RING / 2) - 4 :][:8]
        assert ring.min() < 60 and ring.max() > 240
    below = image[height + key.TITLE :]
    (dark,) = np.nonzero((below[:, width // 2 + 200 :] < 40).all(axis=2)[int(0.7 * key.STRIP)])
    meters = np.ptp(dark) * camera.meters([(START + GOAL) / 2])[0]
    assert meters == pytest.approx(5.0, abs=0.15)  # as its text says
    # Nothing of the key is at the edges, and there is a gap before the bar's text.
    columns = np.nonzero((below < 120).all(axis=2).any(axis=0))[0]
    assert columns.min() > 5 and columns.max() < width - 5
    assert np.diff(columns).max() > 25


def test_pictures_have_names_of_their_own():
    assert len(set(results.FILES)) == len(results.FILES)
    assert {"rviz.png", "dijkstra.png", "wave_front.png", "grid.png", "report.md"} <= set(
        results.SUCCESS
    )
