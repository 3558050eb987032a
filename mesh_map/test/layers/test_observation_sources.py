"""Sensors that fall silent, and several of them for one layer; the clock is a number."""

import math

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.layers.obstacle import ObstacleLayer
from mesh_map.layers.robot_outline import RobotOutline
from mesh_map.map.mesh_map import MeshMap

NAN = math.nan
EYE = (0.0, 0.0, 1.0)
RIGHT, LEFT = [1.0, 0.0, 0.5], [-1.0, 0.0, 0.5]  # over faces 0 and 1
TWO = {"observation_sources": "laser  camera", "laser": {"clearing": True}, "camera": {}}


def floor_map(heights=(0,)):
    """Floors of ten by ten meters, each of two faces: 0 where x > y, and 1."""
    floor = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], np.float32)
    vertices = np.concatenate([floor + [0, 0, height] for height in heights]).astype(np.float32)
    two = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    return MeshMap(vertices, np.concatenate([two + 4 * k for k in range(len(heights))]))


def beyond(point):
    """Far behind a point, as the sensor sees it."""
    return np.array(EYE) + 10.0 * (np.array(point) - EYE)


def test_marks_stay_while_no_cloud_arrives():
    mesh_map, layer = floor_map(), ObstacleLayer("o", {"topic": "points", "decay": 2.0})
    assert "nothing usable came from topic points yet" in layer.silence(50.0)
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 10.0)
    assert layer.silence(11.0) == "" and layer.decay(11.0) == 0
    for now in (11.1, 13.0, 1000.0):
        assert layer.decay(now) == 0 and layer.marked_faces.tolist() == [0]
        assert layer.silence(now)
    text = layer.silence(1000.0)
    for word in ("topic points", "for 990 s", "expected_update_rate is 1 s", "start the sensor"):
        assert word in text
    layer.missed("", "TF has no frame 'laser'")
    assert "TF has no frame 'laser'" in layer.silence(1000.0)
    # When it is back, that time does not count: 1.0 of the 2.0 s are left.
    layer.insert_cloud(mesh_map, [LEFT], EYE, 1000.0)
    assert layer.silence(1001.0) == "" and layer.marked_faces.tolist() == [0, 1]
    layer.insert_cloud(mesh_map, [LEFT], EYE, 1000.9)
    assert layer.decay(1001.0) == 0
    layer.insert_cloud(mesh_map, [LEFT], EYE, 1001.2)
    assert layer.marked_faces.tolist() == [1]


def test_without_an_expected_rate_it_is_as_it_was():
    params = {"topic": "points", "decay": 2.0, "expected_update_rate": 0}
    mesh_map, layer = floor_map(), ObstacleLayer("o", params)
    assert layer.silence(0.0) == ""
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 10.0)
    assert layer.silence(1e6) == "" and layer.decay(12.5) == 1
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 20.0)
    layer.insert_cloud(mesh_map, [LEFT], EYE, 30.0)
    assert layer.marked_faces.tolist() == [1]


def test_what_comes_late_marks_but_is_not_current():
    mesh_map, layer = floor_map(), ObstacleLayer("o", {"topic": "points", "decay": 20.0})
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 10.0, seen=9.5)
    assert layer.silence(10.9) == ""
    for now in range(11, 20):
        layer.insert_cloud(mesh_map, [LEFT], EYE, now, seen=now - 9.0)
        text = "topic points is 9.0 s old by its stamp when it comes (expected_update_rate is 1 s)"
        assert text in layer.silence(now)
    assert layer.marked_faces.tolist() == [0, 1]
    assert layer.decay(31.0) == 0  # silent since 19: the marks are as old as then
    layer.insert_cloud(mesh_map, [LEFT], EYE, 31.0, seen=30.9)
    assert layer.silence(31.0) == ""
    any_age = ObstacleLayer("o", {"topic": "points", "expected_update_rate": 0})
    any_age.insert_cloud(mesh_map, [RIGHT], EYE, 10.0, seen=1.0)
    assert any_age.silence(10.0) == ""


@pytest.mark.parametrize("points", [[], np.zeros((0, 3))])
def test_an_empty_cloud_says_that_nothing_is_there(points):
    mesh_map, layer = floor_map(), ObstacleLayer("o", {"topic": "points", "decay": 2.0})
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 2.0)
    layer.insert_cloud(mesh_map, points, EYE, 2.9)
    assert layer.silence(3.9) == ""
    layer.insert_cloud(mesh_map, points, EYE, 3.9)
    assert layer.decay(4.5) == 1 and layer.silence(4.5) == ""


@pytest.mark.parametrize("points", [[[NAN, 0, 0]], [[0, math.inf, 0]]])
def test_a_blind_sensor_is_silent(points):
    mesh_map, layer = floor_map(), ObstacleLayer("o", {"topic": "points", "decay": 2.0})
    layer.insert_cloud(mesh_map, points, EYE, 1.0)
    assert layer.silence(1.0)
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 2.0)
    layer.insert_cloud(mesh_map, points, EYE, 9.0)
    assert "for 7 s" in layer.silence(9.0) and layer.marked_faces.tolist() == [0]
    # Free ways alone are one.
    layer.insert_cloud(mesh_map, points, EYE, 9.0, free=[[3.0, 0.0, 1.0]])
    assert layer.silence(9.0) == ""


def test_a_clock_that_is_set_back_or_stands():
    mesh_map, layer = floor_map(), ObstacleLayer("o", {"topic": "points", "decay": 2.0})
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 100.0)
    for _ in range(3):
        assert layer.silence(100.5) == "" and layer.decay(100.5) == 0
    assert layer.silence(5.0) == "" and layer.silence(6.0) == ""
    assert "for 2 s" in layer.silence(7.0)
    assert layer.decay(7.0) == 0 and layer.marked_faces.tolist() == [0]
    layer.insert_cloud(mesh_map, [LEFT], EYE, 7.0)
    assert layer.silence(7.5) == ""


def test_each_source_has_its_own_silence_and_persistence():
    params = dict(TWO, decay=3.0)
    params["camera"] = {"observation_persistence": 1.5, "expected_update_rate": 5.0}
    params["laser"] = {"topic": "/scan", "data_type": "LaserScan"}
    mesh_map, layer = floor_map(), ObstacleLayer("o", params)
    assert layer.warnings == []
    text = layer.silence(0.0)
    assert "source laser (/scan)" in text and "source camera (camera)" in text
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 0.0, source="laser")
    layer.insert_cloud(mesh_map, [LEFT], EYE, 0.0, source="camera")
    assert layer.silence(1.0) == ""
    assert "laser" in layer.silence(2.0) and "camera" not in layer.silence(2.0)
    layer.decay(2.0)  # that of the camera is too old, the laser is silent
    assert layer.marked_faces.tolist() == [0]
    with pytest.raises(ValueError, match="no source 'radar'"):
        layer.insert_cloud(mesh_map, [RIGHT], EYE, 0.0, source="radar")


def test_sources_that_only_mark_or_only_clear():
    params = dict(TWO, decay=0.0)
    params["laser"] = {"marking": False, "clearing": True, "raytrace_range": 3.0}
    mesh_map, layer = floor_map(), ObstacleLayer("o", params)
    layer.insert_cloud(mesh_map, [RIGHT, LEFT], EYE, 0.0, source="laser")
    assert layer.marked_faces.tolist() == []
    layer.insert_cloud(mesh_map, [RIGHT, [-4.0, 0.0, 0.5]], EYE, 0.0, source="camera")
    assert layer.marked_faces.tolist() == [0, 1]
    layer.insert_cloud(mesh_map, [beyond(RIGHT)], EYE, 0.1, source="camera")
    assert layer.marked_faces.tolist() == [0, 1]  # by default a source does not clear
    far = beyond([-4.0, 0.0, 0.5])
    layer.insert_cloud(mesh_map, [beyond(RIGHT), far], EYE, 0.2, source="laser")
    assert layer.marked_faces.tolist() == [1]  # that one is beyond raytrace_range
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 0.3, source="camera")
    layer.insert_cloud(mesh_map, [], EYE, 0.4, source="laser", free=[beyond(RIGHT)])
    assert layer.marked_faces.tolist() == [1]
    assert layer.clear() == 1


def test_each_source_has_its_own_limits():
    params = dict(TWO, robot_height=1.0, max_obstacle_dist=2.0)
    params["camera"] = {"obstacle_range": 4.0, "min_obstacle_height": 0.6}
    mesh_map, layer = floor_map(), ObstacleLayer("o", params)
    low, far, high = RIGHT, [-3.0, 0.0, 0.8], [-1.0, 0.0, 1.3]
    layer.insert_cloud(mesh_map, [low, far, high], EYE, 0.0, source="laser")
    assert layer.marked_faces.tolist() == [0]
    layer.clear()
    layer.insert_cloud(mesh_map, [low, far, high], EYE, 0.0, source="camera")
    assert layer.marked_faces.tolist() == [1]


def test_what_the_layer_says_as_in_costmap_2d_holds_for_its_sources():
    """Ranges are those of sources that say none; max_obstacle_height bounds all of them."""
    params = dict(TWO, obstacle_range=2.5, raytrace_range=3.0, max_obstacle_height=1.0)
    params["camera"] = {"obstacle_range": 8.0, "raytrace_range": 9.0, "max_obstacle_height": 0.4}
    layer = ObstacleLayer("o", params)
    laser, camera = layer.sources
    assert (laser.obstacle_range, laser.raytrace_range, laser.max_obstacle_height) == (2.5, 3, 1)
    assert (camera.obstacle_range, camera.raytrace_range) == (8.0, 9.0)
    assert camera.max_obstacle_height == 0.4 and layer.warnings == []
    params["camera"] = {"max_obstacle_height": 2.0}
    assert [s.max_obstacle_height for s in ObstacleLayer("o", params).sources] == [1.0, 1.0]
    # Beside the layer's own names for the same, the nearer and the lower bound hold.
    params.update(max_obstacle_dist=2.0, robot_height=0.7)
    laser, camera = ObstacleLayer("o", params).sources
    assert (laser.obstacle_range, laser.max_obstacle_height) == (2.0, 0.7)
    assert camera.max_obstacle_height == 1.0
    mesh_map = floor_map()
    near, far, high = [1.0, 0.0, 0.5], [3.0, 0.0, 0.5], [-1.0, 0.0, 1.2]
    layer.insert_cloud(mesh_map, [far, high], EYE, 0.0, source="laser")
    assert layer.marked_faces.tolist() == []
    layer.insert_cloud(mesh_map, [near], EYE, 0.0, source="laser")
    assert layer.marked_faces.tolist() == [0]


def test_what_the_layer_says_for_sources_says_nothing_where_there_are_none():
    names = {"obstacle_range": 1.0, "raytrace_range": 1.0, "max_obstacle_height": 0.1}
    layer = ObstacleLayer("o", {"topic": "points", **names})
    for name in names:
        text = "%s says nothing here without observation_sources" % name
        assert [text in line for line in layer.warnings].count(True) == 1
    assert layer.sources == ObstacleLayer("o", {"topic": "points"}).sources


@pytest.mark.parametrize("lowest", [-0.2, -10.0])
def test_a_negative_height_marks_what_is_below_noisy_ground(lowest):
    """As with costmap_2d: from there up to max_obstacle_height."""
    params = dict(TWO, decay=0.0, robot_height=1.0)
    params["laser"], params["camera"] = {"min_obstacle_height": lowest}, {}
    mesh_map, layer = floor_map(), ObstacleLayer("o", params)
    below, above = [1.0, 0.0, -0.15], [-1.0, 0.0, 0.1]
    layer.insert_cloud(mesh_map, [below, above], EYE, 0.0, source="camera")
    assert layer.marked_faces.tolist() == [1]
    layer.insert_cloud(mesh_map, [below, [-1.0, 0.0, 0.0]], EYE, 0.1, source="laser")
    assert layer.marked_faces.tolist() == [0, 1] and layer.last_cloud.ground == 0
    layer = ObstacleLayer("o", {"min_obstacle_height": lowest, "robot_height": 1.0})
    assert layer.warnings == []
    layer.insert_cloud(mesh_map, [below, [1.0, 0.0, lowest - 0.1]], EYE, 0.0)
    assert layer.marked_faces.tolist() == [0] and layer.last_cloud.obstacles == 1


def test_sources_may_change_while_the_map_is_in_use():
    mesh_map = floor_map()
    params = {"topic": "points", "decay": 0.0}
    mesh_map.compute_layers([{"name": "o", "type": "mesh_layers/ObstacleLayer", "params": params}])
    layer = mesh_map.layers["o"]
    mesh_map.watch_data("o", lambda: layer.silence(1.0))
    layer.insert_cloud(mesh_map, [RIGHT], EYE, 1.0)
    assert mesh_map.fault == ""
    mesh_map.set_layer_parameters("o", {"observation_sources": "b", "b": {"topic": "other"}})
    assert [source.topic for source in layer.sources] == ["other"]
    assert "source b (other) yet" in mesh_map.gap
    mesh_map.set_layer_parameters("o", {"expected_update_rate": 0.0})
    assert mesh_map.gap == "" and layer.marked_faces.tolist() == [0]


def turned(angle, at):
    """From the frame of a robot that stands there, heading left by an angle (rad)."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.array(at, float)


@pytest.mark.parametrize(
    "shape, kept",
    [
        ({"robot_radius": 0.35}, [0, 3, 4]),
        ({"footprint": [[0.5, 0.1], [-0.5, 0.1], [-0.5, -0.1], [0.5, -0.1]]}, [2, 3, 4]),
        ({"robot_radius": 0.35, "footprint_clearing_enabled": False}, [0, 1, 2, 3, 4]),
        ({}, [0, 1, 2, 3, 4]),
    ],
)
def test_what_is_under_the_robot_is_cleared(shape, kept):
    """A robot at (1, -2) that heads along y, on the lower one of two floors."""
    mesh_map, layer = floor_map((0, 3)), ObstacleLayer("o", {**shape, "robot_height": 1.0})
    robot = turned(math.pi / 2, (1.0, -2.0, 0.0))
    points = [[1.0, -1.6, 0.3], [1.0, -2.0, 0.3], [1.2, -2.0, 0.3], [1.4, -2.0, 0.3]]
    points += [[1.0, -2.0, 3.3]]
    layer.insert_cloud(mesh_map, points, EYE, 0.0, robot=robot)
    assert sorted(layer._marks[""].points.tolist()) == sorted(points[index] for index in kept)
    # What the layer does not say, the robot does.
    layer.body = RobotOutline(radius=1.0)
    layer.insert_cloud(mesh_map, points, EYE, 0.1, robot=robot)
    enabled = shape.get("footprint_clearing_enabled", True)
    assert layer.marked_faces.tolist() == ([2] if enabled and not shape else [0, 2])


@pytest.mark.parametrize(
    "params, message",
    [
        ({"observation_sources": "a", "a": 3}, "source a is 3, not a dictionary"),
        ({"observation_sources": "topic"}, "observation_sources: topic is a parameter of the"),
        ({"observation_sources": ["a"]}, "observation_sources is .* a string"),
        ({"observation_sources": "a", "a": {"data_type": "PointCloud"}}, "source a: data_type is"),
        ({"observation_sources": "a", "a": {"marking": 1}}, "source a: marking is 1"),
        ({"observation_sources": "a", "a": {"expected_update_rate": NAN}}, "source a: expected"),
        ({"observation_sources": "a, b", "b": {"topic": "c"}}, "spaces alone are between names"),
        ({"observation_sources": "a", "a": {"expected_update_rate": -1}}, "outside of .0.0, 86400"),
        (
            {"observation_sources": "a", "a": {"obstacle_range": -2}},
            "obstacle_range is -2, outside",
        ),
        ({"observation_sources": "a", "a": {"obstacle_range": 0}}, "obstacle_range is 0"),
        (
            {"observation_sources": "a", "a": {"min_obstacle_height": -10.1}},
            "min_obstacle_height is -10.1, outside of .-10.0, 10.0",
        ),
        ({"observation_sources": "a", "obstacle_range": 0}, "source a marks nothing"),
        ({"observation_sources": "a", "a": {"marking": False}}, "neither marks nor clears"),
        (
            {"observation_sources": "a", "a": {"marking": False, "clearing": True}},
            "none of the sources a marks",
        ),
        (
            {
                "observation_sources": "a",
                "a": {"min_obstacle_height": 1.5, "max_obstacle_height": 0.2},
            },
            "source a marks nothing: min_obstacle_height 1.5 is not below max_obstacle_height 0.2",
        ),
        ({"footprint": [[1, 2], [3, 4]]}, "footprint needs 3"),
        ({"footprint": [1, 2, 3]}, "footprint is"),
    ],
)
def test_what_cannot_be_used_is_refused(params, message):
    with pytest.raises(MeshMapError, match=message):
        ObstacleLayer("o", params)
    with pytest.raises(MeshMapError, match=message):
        ObstacleLayer("o").checked_changes(params)


def test_what_costmap_2d_has_and_this_has_not_is_said_once():
    params = {"observation_sources": "a", "a": {"colour": 1}, "topic": "points"}
    params.update(combination_method=1, track_unknown_space=True, b={"topic": "b"})
    layer = ObstacleLayer("o", params)
    text = "\n".join(layer.warnings)
    for word in ("combination_method says nothing here", "track_unknown_space says nothing"):
        assert word in text
    unknown = "unknown parameters: "
    for word in (unknown + "b (known", "source a: %scolour" % unknown, "topic points is left"):
        assert word in text
    assert len(layer.warnings) == 5
    assert not any("says nothing here" in line for line in layer.checked_changes({})[1])
    assert [source.topic for source in layer.sources] == ["a"]
