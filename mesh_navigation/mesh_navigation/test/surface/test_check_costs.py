"""What the map says about points, poses and paths."""

import numpy as np
import pytest
from navigation_test_maps import BY_NAME, PASSABLE, MapWithCosts, random_pairs, vertex_at

from mesh_map.base.errors import MeshMapError
from mesh_msgs import zoo
from mesh_navigation.base.pose import Pose, multiply, quaternions_from_axes
from mesh_navigation.surface import check_costs
from mesh_navigation.surface.face_points import find_face_point
from mesh_navigation.surface.check_costs import Check, CostChecks, PathCheck
from mesh_navigation.surface.cost_scale import Factors, State, scaled, states_of, total
from mesh_navigation.body.robot_shape import RobotShape

GRID = zoo.grid(cells=40, size=10.0)  # a vertex every 0.25 m
MIDDLE = vertex_at(GRID, (5, 5, 0))
SQUARE = RobotShape([[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]])
CLASSES = np.float32([0, 0.25, 1, 1.01, np.inf, np.nan])


def checks(costs=None, shape=RobotShape(), mesh=GRID, cost_limit=1.0):
    return CostChecks(MapWithCosts(mesh, costs), shape, cost_limit)


def grid_costs(places):
    """Zeros, but for these positions (x, y)."""
    costs = np.zeros(len(GRID.vertices), np.float32)
    for position, cost in places.items():
        costs[vertex_at(GRID, (*position, 0))] = cost
    return costs


def row(x, y, yaw=0.0, z=0.0):
    return np.concatenate(Pose.at((x, y, z), yaw))


def line(*xs, y=5.0):
    return np.array([row(x, y) for x in xs])


# Scale


def test_costs_are_scaled_as_those_of_a_costmap():
    assert scaled(CLASSES, 1.0).tolist() == [0, 63, 252, 253, 254, 255]
    assert states_of(CLASSES, 1.0).tolist() == [0, 0, 0, 1, 2, 3]
    assert scaled(CLASSES[:4], 0.5).tolist() == [0, 126, 253, 253]
    assert scaled(CLASSES[:2], 0.0).tolist() == [0, 253]


def test_factors_count_for_their_states():
    assert total(CLASSES, 1.0, Factors()) == 63 + 252 + 253 + 254 + 255
    assert total(CLASSES, 1.0, Factors(2, 3, 0.5)) == 63 + 252 + 3 * 253 + 2 * 254 + 128
    assert total(CLASSES, 1.0, Factors(lethal=1e9)) == 2**32 - 1
    assert Factors(0, 2, 0).checked() == (1, 2, 1)
    for wrong in (Factors(-1), Factors(1, np.nan), Factors(1, 1, np.inf)):
        with pytest.raises(MeshMapError, match="the factor for .* costs is .*, not 0 or more"):
            wrong.checked()


# Points


@pytest.mark.parametrize("mesh", PASSABLE, **BY_NAME)
def test_points_are_what_planners_take_them_for(mesh):
    random = np.random.default_rng(5)
    costs = random.choice(CLASSES, len(mesh.vertices))
    asked = checks(costs, mesh=mesh)
    for pair in random_pairs(mesh, 20, seed=6):
        for _, point in pair:
            face_point = find_face_point(MapWithCosts(mesh), point, "start", 52)
            distances = np.sort(face_point.distances)
            if distances[1] - distances[0] < 1e-4:
                continue  # either of two corners
            cost = costs[face_point.corners[:1]]
            expected = Check(states_of(cost, 1.0)[0], scaled(cost, 1.0)[0])
            assert asked.point(point) == expected


def test_points_off_the_map():
    asked = checks()
    assert asked.point(np.array([5, 5, 0.39])) == (State.FREE, 0)
    assert asked.point(np.array([5, 5, 0.41])) == (State.OUTSIDE, 0)
    assert asked.point(np.array([-0.5, 5, 0])) == (State.OUTSIDE, 0)
    with pytest.raises(MeshMapError, match="the point .*nan.* is not finite"):
        asked.point(np.array([5, np.nan, 0]))


# Poses


@pytest.mark.parametrize("cost, state, number", [(1.5, 1, 253), (np.inf, 2, 254), (np.nan, 3, 255)])
def test_a_robot_is_on_the_worst_that_it_touches(cost, state, number):
    asked = checks(grid_costs({(5, 5): cost, (5.25, 5): 0.5}), SQUARE)
    # Under it are vertices 0.25 m apart to 0.425 m ahead and 0.325 m aside: 3 x 3 at (5, 5).
    assert asked.pose(row(5, 5)) == (state, number + 126)
    assert asked.pose(row(5.5, 5)) == (State.FREE, 126)
    assert asked.pose(row(5.5, 5), distance=0.1) == (state, number + 126)
    assert asked.pose(row(5.5, 5, yaw=np.pi / 2)) == (State.FREE, 126)
    assert asked.pose(row(5.6, 5, yaw=np.pi / 2)) == (State.FREE, 0)
    three = Factors(lethal=3, inscribed=3, unknown=3)
    assert asked.pose(row(5, 5), factors=three) == (state, 3 * number + 126)


def test_a_robot_without_a_shape_is_a_point():
    asked = checks(grid_costs({(5, 5): np.inf}))
    assert asked.pose(row(5.1, 5)) == (State.LETHAL, 254)
    assert asked.pose(row(5.2, 5)) == (State.FREE, 0)
    assert asked.pose(row(5.2, 5), distance=0.1) == (State.LETHAL, 254)


def test_a_robot_beyond_the_border_is_outside():
    asked = checks(np.full(len(GRID.vertices), 0.5), SQUARE)
    assert asked.pose(row(0.31, 5)).state == State.FREE
    assert asked.pose(row(0.29, 5)).state == State.OUTSIDE
    assert asked.pose(row(0.29, 5)).cost > 0
    assert asked.pose(row(0.29, 5, yaw=np.pi / 2)).state == State.FREE
    assert asked.pose(row(-3, 5)) == (State.OUTSIDE, 0)
    assert asked.pose(row(5, 5, z=0.6)) == (State.OUTSIDE, 0)


def test_roll_and_pitch_make_no_difference():
    asked = checks(grid_costs({(5.5, 5): np.inf}), SQUARE)
    for yaw, state in ((0.0, State.LETHAL), (np.pi / 2, State.FREE)):
        upright = row(5.1, 5, yaw)
        for axis in np.eye(3)[:2]:
            turned = multiply(upright[3:], np.append(axis * np.sin(0.3), np.cos(0.3)))
            assert asked.pose(np.concatenate([upright[:3], 5 * turned])).state == state
        upside_down = multiply(upright[3:], np.array([1.0, 0, 0, 0]))
        assert asked.pose(np.concatenate([upright[:3], upside_down])).state == state
    # x looks straight down; y, to the left, is along -x: the robot heads along y.
    axes = np.array([[0, 0, -1], [-1, 0, 0], [0, 1, 0]], float)[:, None]
    steep = np.concatenate([[5.1, 5, 0], quaternions_from_axes(*axes)[0]])
    assert asked.pose(steep).state == State.FREE


def test_storeys_do_not_see_each_other():
    mesh = zoo.two_storeys(height=1.0)
    top = mesh.vertices[:, 2].max()
    costs = np.where(mesh.vertices[:, 2] == top, np.inf, 0.0)
    corner = mesh.vertices[mesh.vertices[:, 2] == top].mean(axis=0)
    asked = checks(costs, SQUARE, mesh)
    assert asked.pose(np.array([*corner[:2], top, 0, 0, 0, 1.0])).state == State.LETHAL
    assert asked.point(np.array([*corner[:2], top - 0.5])).state == State.OUTSIDE


# Paths


def test_a_path():
    asked = checks(grid_costs({(4, 5): 0.5, (5, 5): 2.0, (6, 5): np.inf, (7, 5): np.nan}))
    path = line(3, 4, 5, 6, 7, 8)
    everything = 126 + 253 + 254 + 255
    assert asked.path(path) == PathCheck(5, State.UNKNOWN, everything)
    for return_on, last, cost in ((1, 2, 379), (2, 3, 633), (3, 4, everything), (4, 5, everything)):
        worst = min(return_on, State.UNKNOWN)
        assert asked.path(path, return_on=return_on) == PathCheck(last, worst, cost)
    assert asked.path(path, skip_poses=1) == PathCheck(4, State.UNKNOWN, 253 + 255)
    assert asked.path(path, skip_poses=2) == PathCheck(3, State.LETHAL, 254)
    assert asked.path(path, skip_poses=255) == PathCheck(0, State.FREE, 0)
    assert asked.path(path, factors=Factors(lethal=2)).cost == everything + 254
    there_and_back = np.concatenate([path, path[::-1]])
    assert asked.path(there_and_back) == PathCheck(11, State.UNKNOWN, everything)


def test_a_path_with_a_shape_equals_its_poses():
    random = np.random.default_rng(0)
    costs = random.choice(np.float32([0, 0, 0, 0, 0, 0, 0, 0.3, 1.2, np.inf]), len(GRID.vertices))
    asked = checks(costs, SQUARE)
    path = np.array([row(*random.uniform(-1, 11, 2), random.uniform(-3, 3)) for _ in range(100)])
    poses = [asked.pose(pose) for pose in path]
    found = asked.path(path)
    assert found.state == max(pose.state for pose in poses) == State.OUTSIDE
    assert max(pose.cost for pose in poses) < found.cost < sum(pose.cost for pose in poses)
    for return_on in (1, 2, 4):
        last = next(i for i, pose in enumerate(poses) if pose.state >= return_on)
        found = asked.path(path, return_on=return_on)
        assert (found.last_checked, found.state) == (last, poses[last].state)
        assert found == asked.path(path[: last + 1])


def test_only_the_path_itself():
    """The ground between poses counts, that beside them does not."""
    asked = checks(grid_costs({(5, 5): np.inf, (6, 5.25): np.inf}), SQUARE)
    assert asked.path(line(4, 6)).state == State.LETHAL  # beside (6, 5)
    assert asked.path(line(4, 4.5, 6), path_only=True) == PathCheck(2, State.LETHAL, 254)
    assert asked.path(line(4, 4.5, 4.8), path_only=True) == PathCheck(2, State.FREE, 0)
    assert asked.path(line(4, 4.8, 6, 7), path_only=True, return_on=2).last_checked == 2
    # The way that leads to a pose that is left out is left out.
    assert asked.path(line(4, 6, 7), path_only=True, skip_poses=1) == PathCheck(2, State.FREE, 0)


def test_only_the_path_itself_against_points_along_it():
    random = np.random.default_rng(3)
    costs = random.uniform(0, 1, len(GRID.vertices)).astype(np.float32)
    asked = checks(costs)
    path = np.array([row(*random.uniform(1, 9, 2)) for _ in range(20)])
    found = asked.path(path, path_only=True)
    shares = np.linspace(0, 1, 20_000)[:, None]
    points = np.concatenate([a + shares * (b - a) for a, b in zip(path[:, :3], path[1:, :3])])
    carried = asked._map.queries.carry(points)
    corners = GRID.vertices[GRID.faces[carried.faces]]
    nearest = np.argmin(np.linalg.norm(corners - carried.positions[:, None], axis=2), axis=1)
    vertices = np.unique(GRID.faces[carried.faces, nearest])
    assert found.cost == pytest.approx(total(costs[vertices], 1.0, Factors()), rel=2e-3)


def test_a_path_over_a_gap():
    mesh = zoo.two_components()
    ends = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    path = np.array([row(*end[:2]) for end in ends])
    assert checks(mesh=mesh).path(path, path_only=True) == PathCheck(1, State.FREE, 0)


def test_long_paths():
    """Of more poses than are looked at at once."""
    asked = checks(grid_costs({(9.5, 5): np.inf, (5, 5): 0.5}))
    path = line(*np.linspace(1, 9.5, 3000))
    assert asked.path(path) == PathCheck(2999, State.LETHAL, 126 + 254)
    there_and_back = np.concatenate([path, path[::-1]])
    assert asked.path(there_and_back) == PathCheck(5999, State.LETHAL, 126 + 254)
    first = int(np.argmax(path[:, 0] > 9.375))
    assert asked.path(path, return_on=2) == PathCheck(first, State.LETHAL, 126 + 254)
    assert asked.path(path, return_on=2, path_only=True).last_checked == first


def test_large_footprints_are_looked_at_a_few_at_a_time(monkeypatch):
    """A distance to keep is as large as a client likes; the memory for the answer is not."""
    asked = checks(grid_costs({(9.5, 5): np.inf}), SQUARE)
    path = line(*np.linspace(1, 9, 300))
    expected = asked.path(path, 4.0), asked.path(path)
    queries, sizes = asked._map.queries, []

    def recorded(*arguments):
        found = vertices_under(*arguments)
        sizes.append((len(found.offsets) - 1, len(found.vertices)))
        return found

    vertices_under = queries.vertices_under
    monkeypatch.setattr(queries, "vertices_under", recorded)
    monkeypatch.setattr(check_costs, "_VERTICES_AT_ONCE", 10_000)
    assert asked.path(path, 4.0) == expected[0]
    poses, vertices = np.array(sizes).T
    assert poses.sum() == 300 and vertices.max() <= 11_000
    sizes.clear()
    assert asked.path(path) == expected[1]
    assert len(sizes) < 5


def poses_with(index, value):
    poses = line(1, 2, 3)
    poses[index] = value
    return poses


@pytest.mark.parametrize(
    "poses, arguments, words",
    [
        (np.zeros((0, 7)), {}, "the path has no poses"),
        (poses_with((1, 0), np.nan), {}, "1 of 3 poses are not finite, first 1"),
        (poses_with((slice(1, 3), slice(3, 7)), 0), {}, "2 of 3 poses are without an orientation"),
        (poses_with((0, slice(3, 7)), 1e200), {}, "1 of 3 poses are without an orientation"),
        (line(1), {"distance": -0.1}, "the distance to keep is -0.1 m"),
        (line(1), {"distance": np.nan}, "the distance to keep is nan m"),
        (line(1), {"factors": Factors(-1)}, "the factor for lethal costs is -1"),
    ],
)
def test_what_cannot_be_checked(poses, arguments, words):
    with pytest.raises(MeshMapError, match=words):
        checks().path(poses, **arguments)
