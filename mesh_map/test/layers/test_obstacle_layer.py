"""The layer of obstacles: whole stories against plain Python, and what it promises besides."""

import math
import threading

import numpy as np
import pytest
from mesh_map.costs.layer import LayerResult, checked
from mesh_map.layers.obstacle import CloudSummary, ObstacleLayer
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.hits import NO_FACE
from meshes import small, terrain
from obstacle_oracles import SlowObstacles, faces_below

INF, NAN = math.inf, math.nan
FLOOR = np.array([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], np.float32)
TWO_FACES = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


def floor_map():
    """Ten by ten meters of two faces: face 0 where x > y."""
    return MeshMap(FLOOR, TWO_FACES)


def cloud_over(mesh, random, count, reach=1.2):
    low, high = mesh.vertices.min(axis=0) - 0.1, mesh.vertices.max(axis=0) + 0.1
    points = random.uniform(low, high, (count, 3))
    points[:, 2] += random.uniform(-0.2, reach, count)
    points[random.random(count) < 0.05] = NAN
    return points


STORIES = [
    {},
    {"decay": 0.0, "clearing_angle": 8.0},
    {"decay": 2.0, "clearing": False},
    {"decay": -1.0},
    {"min_obstacle_height": 0.2, "robot_height": 0.7, "clearing_angle": 6.0, "decay": 3.0},
    {"max_obstacle_dist": 1.5, "min_obstacle_dist": 0.4, "clearing_margin": 0.0, "decay": 0.0},
]


@pytest.mark.parametrize("params", STORIES)
@pytest.mark.parametrize("down", [None, (0.2, -0.1, -1.0)])
def test_stories_equal_plain_python(params, down):
    random = np.random.default_rng(11)
    mesh = terrain(16)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    layer = ObstacleLayer("obstacles", params)
    slow = SlowObstacles(mesh.vertices, mesh.faces, layer.params)
    before, removed, changes = [], 0, 0
    result = layer.evaluate(mesh_map, {})
    assert not result.costs.any()
    for step in range(12):
        stamp = 0.5 * step - (3.0 if step > 9 else 0.0)  # the clock is set back once
        if step % 4 == 3:
            changed = layer.decay(stamp)
            slow.decay(stamp)
        else:
            points = cloud_over(mesh, random, 150)
            origin = np.array([0.7, 0.9, 0.8]) + random.normal(0, 0.1, 3)
            changed = layer.insert_cloud(mesh_map, points, origin, stamp, down=down)
            slow.insert_cloud(points, origin, stamp, down or (0, 0, -1))
            removed += layer.last_cloud.removed_marks
        assert layer.marked_faces.tolist() == slow.marked_faces
        assert changed == len(set(before) ^ set(slow.marked_faces))
        before, changes = slow.marked_faces, changes + changed
        costs = np.zeros(len(mesh.vertices), np.float32)
        costs[mesh.faces[before].ravel()] = INF
        result = checked(
            layer.update(mesh_map, {}, np.zeros(0, np.uint32), result), len(mesh.vertices)
        )
        np.testing.assert_array_equal(result.costs, costs)
        np.testing.assert_array_equal(result.lethal, costs == INF)
        np.testing.assert_array_equal(layer.evaluate(mesh_map, {}).costs, costs)
    assert slow.undecided == 0 and changes > 100 and removed > 5


@small
def test_replacing_clouds_as_released(mesh):
    """decay -1: the corners of all faces that the last cloud met, whatever was before."""
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    layer = ObstacleLayer("o", {"decay": -1, "robot_height": 0.9, "max_obstacle_dist": 2.0})
    random, down = np.random.default_rng(2), np.array([0, 0, -1.0])
    for step in range(2):
        points, origin = cloud_over(mesh, random, 40), mesh.vertices.mean(axis=0) + [0, 0, 0.5]
        layer.insert_cloud(mesh_map, points, origin, step)
    certain, possible = set(), set()
    below = zip(*faces_below(mesh.vertices, mesh.faces, points, down, 0.9))
    for point, (face, _, close) in zip(points, below):
        if math.dist(point, origin) <= 2.0:
            (possible if close else certain).add(face)
    marked = set(layer.marked_faces.tolist())
    assert certain - {NO_FACE} <= marked
    assert len(marked - certain) <= sum(layer.last_cloud[2:5]) + len(possible)
    if not possible:
        assert marked == certain - {NO_FACE}


def test_all_points_are_accounted_for():
    layer = ObstacleLayer(
        "o", {"min_obstacle_height": 0.1, "robot_height": 1.0, "max_obstacle_dist": 4.0}
    )
    points = [
        [NAN, 0, 0], [0, INF, 0], [0, 0, -INF],  # not finite
        [4.5, 0, 0.5], [0, -4.9, 0.5],  # too far
        [1, 0.5, 0.05], [1, 0.5, -0.05],  # ground
        [1, 0.5, 1.2], [2, 0.5, -0.3],  # above the robot, below the floor
        [1, 0.5, 0.5], [1, 0.5, 0.7], [-1, 0.5, 0.5],  # on face 0 twice, and face 1
    ]  # fmt: skip
    assert layer.insert_cloud(floor_map(), points, (0, 0, 0.5), 0.0) == 2
    assert layer.last_cloud == CloudSummary(
        points=12,
        not_finite=3,
        out_of_range=2,
        ground=2,
        elsewhere=2,
        obstacles=3,
        obstacle_faces=2,
        removed_marks=0,
    )


def test_clouds_without_points_do_nothing():
    mesh_map, layer = floor_map(), ObstacleLayer("o", {"decay": 0.0})
    layer.insert_cloud(mesh_map, [[1, 0, 0.5]], (0, 0, 1), 0.0)
    for points in (np.zeros((0, 3)), [], np.full((5, 3), NAN)):
        assert layer.insert_cloud(mesh_map, points, (0, 0, 1), 1.0) == 0
        assert layer.last_cloud.obstacles == 0
    assert layer.insert_cloud(mesh_map, [[1, 0, 0.5]], (NAN, 0, 1), 1.0) == 0
    assert layer.last_cloud.not_finite == 1
    assert layer.marked_faces.tolist() == [0]


def test_one_of_two_obstacles_on_a_large_face_goes():
    """Each keeps the face marked; what is seen past goes when the last has gone."""
    mesh_map, layer = floor_map(), ObstacleLayer("o", {"decay": 0.0, "min_obstacle_height": 0.1})
    eye = (4.0, -4.0, 1.0)
    first, second = [2.0, -3.0, 0.5], [2.0, 0.5, 0.5]
    assert layer.insert_cloud(mesh_map, [first, second], eye, 0.0) == 1

    def behind(point):
        """Off the map, in the same direction."""
        return np.array(eye) + 10.0 * (np.array(point) - eye)

    assert layer.insert_cloud(mesh_map, [behind(first)], eye, 1.0) == 0
    assert layer.last_cloud.removed_marks == 1 and layer.marked_faces.tolist() == [0]
    assert layer.insert_cloud(mesh_map, [behind(second)], eye, 2.0) == 1
    assert layer.last_cloud.removed_marks == 1 and not len(layer.marked_faces)


def test_decay():
    params = {"decay": 2.0, "expected_update_rate": 0}
    mesh_map, layer = floor_map(), ObstacleLayer("o", params)
    layer.insert_cloud(mesh_map, [[1, 0, 0.5]], (0, 0, 1), 10.0)
    layer.insert_cloud(mesh_map, [[-1, 0, 0.5]], (0, 0, 1), 11.0)
    assert layer.decay(12.0) == 0
    assert layer.decay(12.5) == 1 and layer.marked_faces.tolist() == [1]
    assert layer.decay(5.0) == 0  # the clock was set back: seen at 5.0
    assert layer.decay(7.0) == 0 and layer.decay(7.1) == 1
    assert not len(layer.marked_faces)
    layer.insert_cloud(mesh_map, [[1, 0, 0.5]], (0, 0, 1), 10.0)
    layer.insert_cloud(mesh_map, [[-1, 0, 0.5]], (0, 0, 1), 5.0)  # set back by a cloud
    assert layer.decay(7.0) == 0 and layer.decay(7.1) == 2


def test_parameters_take_effect_with_the_next_cloud_or_decay():
    params = {"decay": 0.0, "expected_update_rate": 0}
    mesh_map, layer = floor_map(), ObstacleLayer("o", params)
    layer.insert_cloud(mesh_map, [[1, 0, 0.5]], (0, 0, 1), 0.0)
    assert layer.decay(100.0) == 0
    layer.params["decay"] = 5.0
    assert layer.decay(100.0) == 1
    layer.params["robot_height"] = 0.4
    assert layer.insert_cloud(mesh_map, [[1, 0, 0.5]], (0, 0, 1), 101.0) == 0


def test_clear():
    mesh_map, layer = floor_map(), ObstacleLayer("o")
    assert layer.clear() == 0
    layer.insert_cloud(mesh_map, [[1, 0, 0.5], [-1, 0, 0.5]], (0, 0, 1), 0.0)
    assert layer.clear() == 2 and not layer.evaluate(mesh_map, {}).lethal.any()


def test_down_is_where_the_map_says():
    """A map of a wall that is walked on: up is x."""
    vertices = FLOOR[:, [2, 0, 1]]
    layer = ObstacleLayer("o", {"robot_height": 1.0})
    mesh_map = MeshMap(vertices, TWO_FACES)
    cloud = [[0.5, 1, 0]]
    assert layer.insert_cloud(mesh_map, cloud, (1, 0, 0), 0.0) == 0
    assert layer.insert_cloud(mesh_map, cloud, (1, 0, 0), 0.0, down=(-7, 0, 0)) == 1
    mesh_map.geometry.up = np.array([1.0, 0.0, 0.0])
    assert ObstacleLayer("p").insert_cloud(mesh_map, cloud, (1, 0, 0), 0.0) == 1


def test_another_map_begins_without_obstacles():
    layer, first, second = ObstacleLayer("o"), floor_map(), floor_map()
    layer.insert_cloud(first, [[1, 0, 0.5]], (0, 0, 1), 0.0)
    assert layer.evaluate(first, {}).lethal.sum() == 3
    assert not layer.evaluate(second, {}).lethal.any()
    layer.insert_cloud(second, [[-1, 0, 0.5]], (0, 0, 1), 0.0)
    assert layer.marked_faces.tolist() == [1]


def test_layers_of_one_type_do_not_share_obstacles():
    mesh_map, layers = floor_map(), [ObstacleLayer("a"), ObstacleLayer("b")]
    layers[0].insert_cloud(mesh_map, [[1, 0, 0.5]], (0, 0, 1), 0.0)
    assert [len(layer.marked_faces) for layer in layers] == [1, 0]


def test_it_is_never_reused_from_a_file():
    assert ObstacleLayer("o").reuse(np.zeros(4, np.float32), None, {}) is None
    assert not ObstacleLayer.STORABLE


def test_a_map_is_refreshed_by_what_has_changed():
    mesh_map, told = floor_map(), []
    layers = [{"name": name, "type": "mesh_layers/ObstacleLayer"} for name in ("first", "second")]
    mesh_map.compute_layers(layers)
    assert not mesh_map.layer_errors and not mesh_map.costs.any()
    mesh_map.add_listener(told.append)
    layer = mesh_map.layers["second"]
    layer.insert_cloud(mesh_map, [[1, 0, 0.5]], (0, 0, 1), 0.0)
    mesh_map.refresh_layer("second")
    (changes,) = told
    assert [change.name for change in changes] == ["second", "Combined Costs"]
    for change in changes:
        assert change.vertices.tolist() == [0, 1, 2]
        assert change.costs.tolist() == [INF, INF, INF, 0.0]
    layer.insert_cloud(mesh_map, [[1, 1, 0.5]], (0, 0, 1), 1.0)
    mesh_map.refresh_layer("second")
    assert len(told) == 1
    values = mesh_map.set_layer_parameters("second", {"down_axis": [0, 0, -2], "decay": 0})
    assert values["down_axis"] == (0.0, 0.0, -2.0) and layer.params["decay"] == 0.0
    assert mesh_map.costs[:3].tolist() == [INF] * 3


def test_threads():
    """Clouds, decay and results at once: each result is that of some moment."""
    mesh_map, layer = floor_map(), ObstacleLayer("o", {"decay": -1.0})
    sides = [[[1, 0, 0.5]], [[-1, 0, 0.5]]]
    possible = {tuple(sorted(TWO_FACES[face])) for face in (0, 1)} | {(), (0, 1, 2, 3)}
    stop, failures = threading.Event(), []

    def insert(number):
        while not stop.is_set():
            layer.insert_cloud(mesh_map, sides[number], (0, 0, 1), 1.0)
            layer.decay(1.0)

    threads = [threading.Thread(target=insert, args=(number,)) for number in (0, 1)]
    for thread in threads:
        thread.start()
    for _ in range(300):
        result = layer.compute(mesh_map, {})
        assert isinstance(result, LayerResult)
        if tuple(np.flatnonzero(result.lethal)) not in possible:
            failures.append(result)
    stop.set()
    for thread in threads:
        thread.join()
    assert not failures and len(layer.marked_faces) == 1
