"""Planning without ROS from Python: maps, places, planners by name."""

import signal
import threading
import time

import numpy as np
import pytest
import yaml

from mesh_map.base.errors import MeshMapError
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution import planning
from mesh_navigation.plugins import plugin_list
from mesh_navigation.execution.planning import (
    SHORT_NAMES,
    ends,
    make_planner,
    plan,
    plan_interruptibly,
    surface_heights,
)
from mesh_navigation.plugins.planner import MeshPlanner, PlanFailure, PlanResult
from mesh_navigation.surface.map_loading import load_map

GRID = zoo.grid()
STEPS = {"layers": [{"name": "steps", "type": "mesh_layers/HeightDiffLayer"}]}
STOREYS = zoo.two_storeys()


def map_of(mesh):
    return MeshMap(mesh.vertices, mesh.faces)


def length_of(result):
    return np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1).sum()


@pytest.fixture
def grid_file(tmp_path):
    path = tmp_path / "grid.h5"
    MapFile.write(str(path), Mesh(GRID.vertices, GRID.faces, frame_id="hall"))
    return path


@pytest.mark.parametrize("planner", SHORT_NAMES)
def test_three_lines(planner, grid_file):
    result = plan(grid_file, start=(1.2, 2.1), goal=(8.3, 7.4, 0.1), planner=planner)
    assert result.outcome == GetPathOutcome.SUCCESS, result.message
    np.testing.assert_allclose(result.poses[0, :3], [1.2, 2.1, 0], atol=1e-6)
    np.testing.assert_allclose(result.poses[-1, :3], [8.3, 7.4, 0], atol=1e-6)
    straight = np.hypot(7.1, 5.3)
    bound = 1.1 if planner == "dijkstra" else 1 + 1e-5
    assert straight - 1e-5 <= length_of(result) <= straight * bound
    assert result.cost == pytest.approx(length_of(result), rel=1e-4)
    yaw = 2 * np.arctan2(*result.poses[-1, [5, 6]])
    assert yaw == pytest.approx(np.arctan2(5.3, 7.1))


def test_wave_front_is_the_default_and_types_are_names_too(grid_file):
    ends_of_all = (1.2, 2.1), (8.3, 7.4)
    given = plan(grid_file, *ends_of_all)
    for planner in ("wave_front", "wave_front_planner/WaveFrontPlanner"):
        np.testing.assert_array_equal(plan(grid_file, *ends_of_all, planner).poses, given.poses)


def test_one_planner_for_many_plans():
    mesh_map = map_of(GRID)
    planner = make_planner(mesh_map, "dijkstra", {"cost_limit": 0.5})
    assert planner.values["cost_limit"] == 0.5
    for x in (2, 3, 4):
        result = plan(mesh_map, (x, 1), (8, 8), planner)
        assert result.poses[0, 0] == x and result.succeeded
    with pytest.raises(MeshMapError, match="set_parameters"):
        plan(mesh_map, (1, 1), (8, 8), planner, {"cost_limit": 1})
    with pytest.raises(MeshMapError, match="compute_layers"):
        plan(mesh_map, (1, 1), (8, 8), planner, layers=STEPS)


def test_no_path_is_a_result():
    result = plan(map_of(GRID), (1, 1, 0), (8, 8, 5), "dijkstra")
    assert result.outcome == GetPathOutcome.INVALID_GOAL and "5.00 m from the map" in result.message


def test_tolerance():
    mesh_map = map_of(zoo.two_components())
    right = float(mesh_map.vertices[:, 0].max())
    without = plan(mesh_map, (1, 1, 0), (right - 4.9, 2, 0), "dijkstra")
    assert without.outcome == GetPathOutcome.NO_PATH_FOUND, without.message
    assert plan(mesh_map, (1, 1, 0), (right - 4.9, 2, 0), "dijkstra", tolerance=3).succeeded


def test_heading_of_a_pose():
    result = plan(map_of(GRID), (1, 1), Pose.at([8, 8, 0], yaw=-1.0), "dijkstra")
    assert 2 * np.arctan2(*result.poses[-1, [5, 6]]) == pytest.approx(-1.0)


@pytest.mark.parametrize(
    "start, goal, words",
    [
        ((1, 1), (8, 8, 0, 0), "goal .* is no x, y, z, but 4 numbers"),
        ((1,), (8, 8), "start .* is no x, y, z, but 1 numbers"),
        ("here", (8, 8), "start 'here' is no x, y, z"),
        (
            (1, 1),
            (80, 8),
            "at x = 80, y = 8 .the map has x from 0 to [0-9.]+, y from 0 to [0-9.]+ m",
        ),
        ((1, 1), (8, np.nan), "goal: there is no surface"),
    ],
)
def test_places_that_are_none(start, goal, words):
    with pytest.raises(MeshMapError, match=words) as caught:
        plan(map_of(GRID), start, goal, "dijkstra")
    assert "\n" not in str(caught.value)


def test_a_hole_in_the_map_is_told_from_what_is_outside():
    faces = GRID.faces[~(GRID.faces == GRID.faces[len(GRID.faces) // 2, 0]).any(axis=1)]
    hole = GRID.vertices[GRID.faces[len(GRID.faces) // 2, 0]]
    mesh_map = MeshMap(GRID.vertices, faces)
    with pytest.raises(MeshMapError, match="the map has a hole there") as caught:
        plan(mesh_map, (1, 1), (hole[0] + 0.01, hole[1] + 0.01), "dijkstra")
    assert "give z" not in str(caught.value)


def test_a_pose_without_z_is_an_invalid_one():
    result = plan(map_of(GRID), Pose.at([1, 1]), (8, 8), "dijkstra")
    assert result.outcome == GetPathOutcome.INVALID_START
    assert "start: position and orientation have shapes (2,)" in result.message


def test_two_storeys_need_z():
    mesh_map = map_of(STOREYS)
    assert surface_heights(mesh_map, 3.2, 4.1) == pytest.approx([3.0, 0.0], abs=1e-6)
    assert surface_heights(mesh_map, -3.2, 4.1) == []
    with pytest.raises(MeshMapError, match=r"start: at x = 3.2, y = 4.1 .* at z = 3.00, 0.00"):
        plan(mesh_map, (3.2, 4.1), (8, 8, 3), "dijkstra")
    both = ends(mesh_map, (3.2, 4.1, 0), Pose.at([8, 8, 3]))
    assert [pose.position[2] for pose in both] == [0, 3]


def test_surfaces_closer_than_a_robot_is_high_are_one():
    mesh = zoo.grid()
    heights = (0.0, 0.1, 0.3, 0.3, 2.0)
    vertices = np.concatenate([mesh.vertices + np.float32([0, 0, z]) for z in heights])
    faces = np.concatenate([mesh.faces + i * len(mesh.vertices) for i in range(len(heights))])
    found = surface_heights(MeshMap(vertices, faces), 5.0, 5.0)
    assert found == pytest.approx([2.0, 0.3])


@pytest.mark.parametrize(
    "planner, parameters, words",
    [
        ("disk", {}, "there is no planner 'disk' .known: dijkstra, wave_front, cvp, exact"),
        ("odd/Nobody", {}, "odd/Nobody"),
        ("dijkstra", {"cost": 1}, "planner dijkstra has no parameter 'cost' .it has: cost_limit"),
        ("dijkstra", {"cost_limit": "x"}, "cost_limit is 'x'"),
        ("dijkstra", {"cost_limit": 11}, "cost_limit is 11, outside of"),
    ],
)
def test_planners_and_parameters_that_are_none(planner, parameters, words):
    with pytest.raises(MeshMapError, match=words) as caught:
        plan(map_of(GRID), (1, 1), (8, 8), planner, parameters)
    assert "\n" not in str(caught.value)


def test_layers_of_a_file(tmp_path, grid_file):
    mesh = zoo.grid(cells=20)
    vertices = mesh.vertices.copy()
    wall = (vertices[:, 0] == 5) & (vertices[:, 1] < 7)
    vertices[wall, 2] = 0.6
    path = tmp_path / "wall.h5"
    MapFile.write(str(path), Mesh(vertices, mesh.faces))
    layers = tmp_path / "layers.yaml"
    steps = {"threshold": 0.5, "radius": 1.0}
    layers.write_text(yaml.safe_dump(dict(STEPS, steps=steps, edge_cost_factor=2.0)))
    mesh_map = load_map(path, layers)
    assert list(mesh_map.layers) == ["steps"] and mesh_map.settings.edge_cost_factor == 2.0
    np.testing.assert_array_equal(np.isinf(mesh_map.costs), mesh_map.layers["steps"].result.lethal)
    ends_of_all = (1, 1, 0), (9, 1, 0)
    free = plan(path, *ends_of_all, "dijkstra")
    given = [
        plan(path, *ends_of_all, "dijkstra", layers=one)
        for one in (layers, dict(STEPS, steps=steps))
    ]
    assert free.succeeded and length_of(free) < 9
    for result in given:
        assert result.succeeded and length_of(result) > 14, result.message
    assert load_map(grid_file).layers == {} and load_map(grid_file).frame_id == "hall"


UTM = (500000.3, 5800000.3, 100.3)


@pytest.fixture
def utm_file(tmp_path):
    """The grid as a mesh in coordinates that float32 cannot hold."""
    lines = ["ply", "format ascii 1.0", f"element vertex {len(GRID.vertices)}"]
    lines += [f"property double {axis}" for axis in "xyz"] + [f"element face {len(GRID.faces)}"]
    lines += ["property list uchar int vertex_indices", "end_header"]
    lines += ["%r %r %r" % tuple(row) for row in (GRID.vertices + np.array(UTM)).tolist()]
    lines += ["3 %d %d %d" % tuple(face) for face in GRID.faces.tolist()]
    path = tmp_path / "utm.ply"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_an_origin(utm_file, grid_file):
    """Places are in the map's frame, which begins there."""
    expected = plan(grid_file, (1, 1), (8, 8), "exact")
    found = plan(utm_file, (1, 1), (8, 8), "exact", origin=UTM)
    np.testing.assert_array_equal(found.poses, expected.poses)
    with pytest.raises(MeshMapError, match="give an origin near to it"):
        plan(utm_file, (1, 1), (8, 8))
    # It comes before that of the layers' file.
    mesh_map = load_map(utm_file, {"layers": [], "origin": [0.0, 0.0, 0.0]}, origin=list(UTM))
    assert mesh_map.origin.tolist() == list(UTM)
    for origin in ((1, 2), "here", (np.nan, 0, 0)):
        with pytest.raises(MeshMapError, match="origin is .* x, y, z in meters"):
            load_map(utm_file, origin=origin)
    with pytest.raises(MeshMapError, match="origin is .*for a map from a file"):
        plan(load_map(grid_file), (1, 1), (8, 8), origin=UTM)


def test_layers_that_the_released_programs_stored(grid_file):
    marked = np.linspace(0, 0.1, len(GRID.vertices)).astype(np.float32)
    MapFile(str(grid_file)).write_layers({"height_diff": (marked, None)})
    found = load_map(grid_file, STEPS).layers["steps"].result.costs
    np.testing.assert_array_equal(found, marked)
    computed = load_map(grid_file, dict(STEPS, require_provenance=True)).layers["steps"].result
    assert not computed.costs.any()  # the grid is flat


@pytest.mark.parametrize("planner", ["dijkstra", "wave_front", "exact"])
def test_the_plan_of_a_robot(tmp_path, planner):
    """It keeps its radius from what is lethal, as that of a server with that robot does."""
    mesh = zoo.grid(cells=40)
    vertices = mesh.vertices.copy()
    inside = np.hypot(vertices[:, 0] - 5.0, vertices[:, 1] - 5.0) < 1.0
    vertices[inside, 2] = 0.25
    path = tmp_path / "pillar.h5"
    MapFile.write(str(path), Mesh(vertices, mesh.faces))
    layers = {**STEPS, "steps": {"radius": 0.5}}
    mesh_map = load_map(path, layers)
    lethal = vertices[np.isposinf(mesh_map.costs)]
    ends = (1.0, 4.9, 0.0), (9.0, 4.9, 0.0)

    def room(result):
        assert result.succeeded, result.message
        away = np.linalg.norm(result.poses[:, None, :2] - lethal[None, :, :2], axis=2)
        return away.min()

    robot = plan(path, *ends, planner, layers=layers, robot_radius=0.7)
    assert room(plan(path, *ends, planner, layers=layers)) < 0.5 < 0.69 < room(robot)
    body = Body(mesh_map.geometry, RobotShape(radius=0.7))
    on_robot = make_planner(mesh_map, planner, body=body)
    served = on_robot.make_plan(*(Pose.at(end) for end in ends))
    np.testing.assert_array_equal(served.poses[:, :3], robot.poses[:, :3])


def test_a_radius_that_is_none(tmp_path, grid_file):
    """It is said before a map is read."""
    for radius in (-0.1, 101.0, "wide", np.nan):
        with pytest.raises(MeshMapError, match="robot_radius is"):
            plan(tmp_path / "no.h5", (1, 1), (8, 8), robot_radius=radius)
    mesh_map = load_map(grid_file)
    with pytest.raises(MeshMapError, match="robot_radius is for a planner by name"):
        plan(mesh_map, (1, 1), (8, 8), make_planner(mesh_map), robot_radius=0.3)


def test_the_longest_edge_of_a_map(tmp_path, caplog):
    """As an argument, or as a parameter among those of the layers."""
    path = tmp_path / "square.h5"
    square = zoo.grid(cells=1, size=6.0)
    MapFile.write(str(path), Mesh(square.vertices, square.faces))
    longest = [
        float(load_map(path, layers, max_edge_length=length).geometry.edge_lengths.max())
        for layers, length in (
            (None, None),
            ({"layers": [], "max_edge_length": 0.5}, None),
            ({"layers": [], "max_edge_length": 0.5}, 0.2),
            ({"layers": [], "max_edge_length": 0.5}, 0.0),
        )
    ]
    assert longest[0] == longest[3] > 8.0 and 0.25 < longest[1] <= 0.5 and longest[2] <= 0.2
    assert not caplog.records
    assert plan(path, (1, 1), (5, 4), robot_radius=0.3, max_edge_length=0.3).succeeded
    assert not caplog.records
    assert plan(path, (1, 1), (5, 4), robot_radius=0.3).succeeded
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    assert (
        "the robot's radius, 0.3 m" in caplog.text and "max_edge_length: 0.15, half" in caplog.text
    )
    with pytest.raises(MeshMapError, match="max_edge_length is for a map from a file"):
        plan(load_map(path), (1, 1), (5, 4), max_edge_length=0.3)


def test_progress_and_parts(grid_file):
    told = []
    load_map(grid_file, STEPS, "mesh", lambda share, what: told.append((share, what)))
    assert told[0] == (0.0, f"reading {grid_file}") and told[-1][0] == 1.0
    with pytest.raises(MeshMapError, match="attic"):
        load_map(grid_file, part="attic")


@pytest.mark.parametrize(
    "content, words",
    [
        (None, "layers.yaml: No such file"),
        ("layers: [", "layers.yaml is no YAML"),
        ("- a", "layers.yaml has no list of layers"),
        ("costs: 1", "layers.yaml has no list of layers"),
        ("layers: 3", "the list of layers is a int"),
        ("layers: [{name: a, type: no/Layer}]", "a: .*no/Layer"),
        ("{layers: [], edge_cost_factor: many}", "edge_cost_factor is 'many'"),
        (b"layers: \xff", "layers.yaml is no YAML"),
    ],
)
def test_layers_that_cannot_be_used(tmp_path, grid_file, content, words):
    path = tmp_path / "layers.yaml"
    if content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(MeshMapError, match=words) as caught:
        plan(grid_file, (1, 1), (8, 8), "dijkstra", layers=path)
    assert "\n" not in str(caught.value)


class Stubborn(MeshPlanner):
    """Presses Ctrl+C, and works until it is told to stop."""

    ended = False

    def plan(self, start, goal, tolerance, cancellation):
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        assert cancellation.wait(30)
        time.sleep(0.1)
        self.ended = True
        raise PlanFailure(GetPathOutcome.CANCELED, cancellation.reason)


@pytest.fixture
def interruptible():
    """As in a terminal: what runs in the background may ignore Ctrl+C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_ends_the_plan(interruptible):
    planner = Stubborn()
    planner.initialize("stubborn", map_of(GRID))
    with pytest.raises(KeyboardInterrupt):
        plan_interruptibly(planner, Pose.at([1, 1, 0]), Pose.at([2, 2, 0]))
    assert planner.ended


class Hanging(MeshPlanner):
    """Presses Ctrl+C, and does not listen."""

    def __init__(self):
        self.released, self.thread = threading.Event(), None

    def plan(self, start, goal, tolerance, cancellation):
        self.thread = threading.current_thread()
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        self.released.wait()


def test_an_interrupt_of_a_planner_that_hangs(interruptible, monkeypatch):
    """Nobody waits for it for long, and it does not keep Python from its end."""
    monkeypatch.setattr(planning, "GRACE", 0.1)
    planner = Hanging()
    planner.initialize("hanging", map_of(GRID))
    with pytest.raises(KeyboardInterrupt):
        plan_interruptibly(planner, Pose.at([1, 1, 0]), Pose.at([2, 2, 0]))
    assert planner.thread.is_alive() and planner.thread.daemon
    planner.released.set()
    planner.thread.join(60)


@pytest.mark.parametrize(
    "planner, parameters, words",
    [
        ("odd/Nobody", {}, "odd/Nobody"),
        ("dijkstra", {"cost": 1}, "no parameter 'cost'"),
        ("dijkstra", {"cost_limit": 11}, "cost_limit is 11, outside of"),
    ],
)
def test_a_planner_is_checked_before_a_map_is_read(tmp_path, planner, parameters, words):
    with pytest.raises(MeshMapError, match=words):
        plan(tmp_path / "no.h5", (1, 1), (8, 8), planner, parameters)


def test_a_layer_that_is_not_required(grid_file):
    entry = {"name": "typo", "type": "no/Layer", "required": False}
    result = plan(grid_file, (1, 1), (8, 8), "dijkstra", layers={"layers": [entry]})
    assert result.succeeded
    off = {"layers": [{"name": "typo", "type": "no/Layer"}], "typo": {"enabled": False}}
    assert plan(grid_file, (1, 1), (8, 8), "dijkstra", layers=off).succeeded


def map_with(planner):
    """A map with steps, and the planner, initialized on it."""
    mesh_map = map_of(GRID)
    mesh_map.compute_layers(STEPS["layers"])
    planner.initialize("test", mesh_map)
    return mesh_map, planner


class Breaking(MeshPlanner):
    """While it plans, a layer fails."""

    def plan(self, start, goal, tolerance, cancellation):
        self.map.set_without_data("steps", "no topic")
        return PlanResult(0, "there is a path", np.array([[1, 1, 0, 0, 0, 0, 1.0]] * 2))


def test_a_map_that_is_not_whole():
    mesh_map, breaking = map_with(Breaking())
    for planner in (breaking, "dijkstra"):
        result = plan(mesh_map, (1, 1), (8, 8), planner)
        assert (result.outcome, result.message) == (
            GetPathOutcome.MAP_ERROR,
            "layer steps: no topic",
        )
    mesh_map.set_without_data("steps", "")
    assert plan(mesh_map, (1, 1), (8, 8), "dijkstra").succeeded


class Silencing(MeshPlanner):
    """While it plans, a sensor falls silent."""

    def plan(self, start, goal, tolerance, cancellation):
        self.map.watch_data("steps", lambda: "no cloud")
        return PlanResult(0, "there is a path", np.array([[1, 1, 0, 0, 0, 0, 1.0]] * 2))


def test_a_map_that_is_not_current():
    mesh_map, silencing = map_with(Silencing())
    assert plan(mesh_map, (1, 1), (8, 8), silencing).succeeded  # of the costs before
    result = plan(mesh_map, (1, 1), (8, 8), silencing)
    assert (result.outcome, result.message) == (
        GetPathOutcome.MAP_ERROR,
        "layer steps: no cloud",
    )


def test_without_a_sensor_a_layer_is_empty_and_that_is_said_once(grid_file, caplog):
    layers = {"layers": [{"name": "cups", "type": "mesh_layers/ObstacleLayer"}]}
    layers["layers"] += STEPS["layers"]
    assert plan(grid_file, (1, 1), (8, 8), "dijkstra", layers=layers).succeeded
    assert _said_of_layers(caplog) == ["layer cups is empty: there is no sensor here"]
    layers["cups"] = {"enabled": False}
    plan(grid_file, (1, 1), (8, 8), "dijkstra", layers=layers)
    assert len(_said_of_layers(caplog)) == 1


def _said_of_layers(caplog):
    said = [record.getMessage() for record in caplog.records]
    return [text for text in said if "edges longer than radius of layer steps" not in text]


def test_layers_that_are_neither_a_file_nor_a_mapping(grid_file):
    with pytest.raises(MeshMapError, match="layers is \\[.*, neither a file nor a mapping"):
        load_map(grid_file, STEPS["layers"])


class Choosy(MeshPlanner):
    """Checks more than the ranges of its parameters."""

    def initialize(self, name, mesh_map, given={}):
        return super().initialize(name, mesh_map, given) + ["cost_limit is too low: 1 is used"]


def test_complaints_of_a_planner(monkeypatch):
    monkeypatch.setattr(plugin_list, "find_plugin", lambda kind, name: Choosy())
    with pytest.raises(MeshMapError, match="planner odd/Choosy: cost_limit is too low"):
        make_planner(map_of(GRID), "odd/Choosy")


class Faulty(MeshPlanner):
    def plan(self, start, goal, tolerance, cancellation):
        if tolerance:
            raise ZeroDivisionError("by zero")
        return PlanResult(0, "well", np.full((2, 7), np.nan))


def test_faults_of_a_planner():
    planner = Faulty()
    planner.initialize("faulty", map_of(GRID))
    result = plan(map_of(GRID), (1, 1), (2, 2), planner)
    assert result.outcome == GetPathOutcome.INTERNAL_ERROR and "not finite" in result.message
    with pytest.raises(ZeroDivisionError):
        plan(map_of(GRID), (1, 1), (2, 2), planner, tolerance=1.0)


def test_the_known_layers_are_named_once(tmp_path, caplog):
    """All types that there are stand in the log line of the layer, not again in the error."""
    MapFile.write(tmp_path / "a.h5", Mesh(GRID.vertices, GRID.faces))
    layers = {"layers": [{"name": "slope", "type": "mesh_layers/NoLayer"}]}
    with pytest.raises(
        MeshMapError, match="layer slope: .* of the type mesh_layers/NoLayer"
    ) as error:
        load_map(tmp_path / "a.h5", layers)
    said = caplog.text + str(error.value)
    assert said.count("mesh_layers/InflationLayer") == 1, said
