"""The oracle sees what is wrong with drives; trips and statistics are what they say."""

from types import SimpleNamespace

import numpy as np
import pytest
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_navigation.base.pose import Pose
from mesh_navigation.execution.path_execution import Tolerances
from mesh_navigation.execution.planning import make_planner
from mesh_tools_test.driving import oracle, verdicts
from mesh_tools_test.driving.furnished_building import Thing
from mesh_tools_test.driving.trips import Trip, trips
from mesh_tools_test.driving.verdicts import Statistics, Verdict, failures, judged, table
from mesh_tools_test.driving.worlds import DrivingWorld, car_park, connected_open_faces, outdoor


def plane_with_lethal(x=7):
    """A plane of 10 m whose vertices at this x are lethal."""
    mesh = zoo.grid(cells=10, size=10.0)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    costs = np.where(mesh.vertices[:, 0] == x, np.inf, 0.0).astype(np.float32)
    return SimpleNamespace(mesh_map=mesh_map, costs=costs, things=())


@pytest.fixture(scope="module")
def plane():
    return plane_with_lethal()


def poses(points, yaws=0.0):
    """(N,7) poses."""
    points = np.asarray(points, np.float64)
    turns = np.broadcast_to(np.asarray(yaws, np.float64), len(points))
    zeros = np.zeros(len(points))
    return np.column_stack([points, zeros, zeros, np.sin(turns / 2), np.cos(turns / 2)])


def straight(x=(1.0, 5.0), y=2.5, seconds=8.0, yaw=0.0):
    """A drive along x, and its trip, which is driven without any fault."""
    points = [(value, y, 0.0) for value in np.linspace(*x, 81)]
    track = poses(points, yaw)
    trip = Trip(3, Pose.at(points[0], yaw), Pose.at(points[-1], yaw))
    result = SimpleNamespace(outcome=0, message="arrived")
    times = np.linspace(0.0, seconds, len(track))
    length = float(abs(x[1] - x[0]))
    plan = SimpleNamespace(succeeded=True, message="")
    drive = SimpleNamespace(
        plan=plan, track=track, faces=None, times=times, result=result, planned_length=length
    )
    return trip, drive


def judge(plane, trip, drive):
    return judged(trip, drive, plane, plane.costs)


def test_a_good_drive_is_good(plane):
    verdict = judge(plane, *straight())
    assert verdict.fault == "" and verdict.succeeded and verdict.seed == 3
    assert verdict.driven == pytest.approx(4.0) and verdict.seconds == 8.0
    assert verdict.distance == 0.0 and verdict.angle == pytest.approx(0.0, abs=1e-7)
    assert verdict.lethal_distance == pytest.approx(2.0)  # to the edges between lethal vertices


def spoiled(what):
    """The good drive with one fault."""
    trip, drive = straight()
    if what == "outcome":
        drive.result = SimpleNamespace(outcome=108, message="missed")
    elif what == "position":
        trip = trip._replace(goal=Pose.at((5.101, 2.5, 0.0)))
    elif what == "heading":
        trip = trip._replace(goal=Pose.at((5.0, 2.5, 0.0), 0.18))
    elif what == "surface":
        drive.track[40, 2] = 0.002
    elif what == "jump":
        drive.track[:40, 1] += 0.3
    elif what == "nan":
        drive.track[40, 6] = np.nan
    elif what == "none":
        drive.track = np.zeros((0, 7))
    return trip, drive


@pytest.mark.parametrize(
    "what, words",
    [
        ("outcome", "outcome 108: missed"),
        ("position", "0.101 m from the goal"),
        ("heading", "10.3 degrees"),
        ("surface", "leaves the surface by 0.002 m"),
        ("jump", "jumps: 3."),
        ("nan", "not finite"),
        ("none", "never began: arrived"),
    ],
)
def test_each_fault_is_seen(plane, what, words):
    verdict = judge(plane, *spoiled(what))
    assert not verdict.succeeded and words in verdict.fault


@pytest.mark.parametrize("x, blocked", [(6.49, False), (6.51, True), (7.4, True), (7.51, False)])
def test_ground_is_blocked_where_the_nearest_corner_is(plane, x, blocked):
    # Just above a row of vertices the nearest corner is that of the nearest x.
    track = poses([(x, 2.01, 0.0)])
    found = oracle.on_the_map(track, plane.mesh_map, plane.costs)
    assert (len(found.blocked) == 1) == blocked
    assert found.lethal_distance == pytest.approx(abs(7.0 - x), abs=1e-6) and found.nearest == 0


def test_where_two_surfaces_are_that_counts_on_which_the_robot_was():
    """The lethal bottom of a thing lies on the floor."""
    bottom, floor = zoo.grid(cells=2, size=2.0), zoo.grid(cells=10, size=10.0)
    count = len(bottom.vertices)
    vertices = np.concatenate([bottom.vertices + np.float32([4.0, 4.0, 0.0]), floor.vertices])
    mesh_map = MeshMap(vertices, np.concatenate([bottom.faces, floor.faces + count]))
    costs = np.where(np.arange(len(vertices)) < count, np.inf, 0.0).astype(np.float32)
    track = poses([(5.3, 5.2, 0.0), (5.3, 5.1, 0.0)])
    assert len(oracle.on_the_map(track, mesh_map, costs).blocked) == 2
    on_floor = mesh_map.spatial_index.closest_batch(
        points=track[:, :3], mask=np.arange(len(mesh_map.faces)) >= len(bottom.faces)
    ).faces
    found = oracle.on_the_map(track, mesh_map, costs, on_floor)
    assert len(found.blocked) == 0 and found.lethal_distance >= 0.5
    elsewhere = np.zeros(2, np.int64)  # a face where it is not
    assert len(oracle.on_the_map(track, mesh_map, costs, elsewhere).blocked) == 2


def test_a_body_may_come_two_centimeters_nearer_than_its_radius(plane):
    least = judge(plane, *straight()).lethal_distance
    assert judged(*straight(), plane, plane.costs, least + 0.019).succeeded
    verdict = judged(*straight(), plane, plane.costs, least + 0.021)
    assert "it comes within %.3f m of lethal ground" % least in verdict.fault


def test_walls_count_whatever_the_map_knows_of_them(plane):
    """A thing that stands there is no nearer than the radius; what is lower or higher is passed."""
    places = (((2.0, 2.74, 3.0, 3.0), 0.0, 2.0), ((2.0, 2.4, 3.0, 2.6), 0.0, 0.15))
    wall, step = (Thing(*each) for each in places)
    beam = Thing(step.place, 1.1, 1.3)
    for things, fault in (((step, beam), ""), ((step, wall), "within 0.240 m of a thing, at (2.0")):
        world = SimpleNamespace(mesh_map=plane.mesh_map, things=things)
        assert judged(*straight(), world, plane.costs, 0.25).fault == ""
        found = judged(*straight(), world, plane.costs, 0.27)
        assert fault in found.fault and bool(fault) == bool(found.fault)


def test_without_a_plan_nothing_has_failed(plane):
    trip, drive = straight()
    drive.plan = SimpleNamespace(succeeded=False, message="there is no path")
    verdict = judge(plane, trip, drive)
    assert verdict.fault == "no plan: there is no path"
    assert not (verdict.succeeded or verdict.failed or verdict.planned_at_all)
    assert Statistics("sea", [verdict]).failed == [] == Statistics("sea", [verdict]).planned


def test_tolerances_are_those_of_the_server(plane):
    trip, drive = spoiled("position")
    assert judged(trip, drive, plane, plane.costs, tolerances=Tolerances(0.102, 0.1)).succeeded


def test_unknown_ground_is_blocked(plane):
    unknown = np.where(np.isposinf(plane.costs), np.nan, plane.costs)
    verdict = judged(*straight(x=(1.0, 9.0)), plane, unknown)
    assert "poses on blocked ground, first (6.60" in verdict.fault


def test_headings_count_within_the_ground():
    mesh = zoo.grid(cells=4, size=4.0)
    vertices = mesh.vertices.copy()
    vertices[:, 2] = vertices[:, 0] * 0.5
    mesh_map = MeshMap(vertices, mesh.faces)
    end = np.array([1.1, 1.2, 0.55, 0.0, 0.0, 0.0, 1.0])
    # Looking level along x and looking up the slope are one heading; the other way is the opposite.
    up = Pose(end[:3], np.array([0.0, -np.sin(0.23), 0.0, np.cos(0.23)]))
    assert oracle.arrival(end, up, mesh_map).angle == pytest.approx(0.0, abs=1e-7)
    back = Pose.at(end[:3], np.pi)
    assert oracle.arrival(end, back, mesh_map).angle == pytest.approx(np.pi, abs=1e-6)
    aside = Pose.at(end[:3] + [0.0, 0.3, 0.0], np.pi / 2)
    found = oracle.arrival(end, aside, mesh_map)
    assert found.angle == pytest.approx(np.pi / 2) and found.distance == pytest.approx(0.3)


def test_open_faces_are_those_between_which_there_is_a_way():
    # The lethal column divides the plane in 6 and 2 columns of open cells.
    plane = plane_with_lethal()
    given = SimpleNamespace(
        costs=plane.costs,
        faces=plane.mesh_map.faces,
        geometry=plane.mesh_map.geometry,
        topology=plane.mesh_map.topology,
    )
    open_faces = connected_open_faces(given)
    x = plane.mesh_map.vertices[plane.mesh_map.faces[open_faces]][:, :, 0]
    assert len(open_faces) == 2 * 6 * 10 and x.max() == 6.0
    given.costs = np.where(np.isinf(plane.costs), np.float32(1.01), plane.costs)
    np.testing.assert_array_equal(connected_open_faces(given), open_faces)
    given.costs = np.where(np.isinf(plane.costs), np.float32(1.0), plane.costs)
    assert len(connected_open_faces(given)) == 200


@pytest.fixture(scope="module")
def park():
    return car_park(12.0)


def test_trips_are_the_same_for_a_seed_and_can_be_planned(park):
    garden = outdoor(12_000)
    for world in (park, garden):
        planner = make_planner(world.mesh_map)
        made = trips(world, 10, first_seed=5)
        again = trips(world, 10, first_seed=5)
        assert [trip.seed for trip in made] == list(range(5, 15))
        for trip, same in zip(made, again):
            np.testing.assert_array_equal(np.concatenate(trip.start), np.concatenate(same.start))
            np.testing.assert_array_equal(np.concatenate(trip.goal), np.concatenate(same.goal))
            result = planner.make_plan(trip.start, trip.goal)
            assert result.succeeded, result.message
        ends = np.array([(trip.start.position, trip.goal.position) for trip in made])
        assert world is park or np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min() > 2.0
        yaws = [np.arctan2(trip.goal.heading[1], trip.goal.heading[0]) for trip in made]
        assert np.ptp(yaws) > 3.0


def test_trips_of_the_car_park_change_the_storey(park):
    heights = np.array([(trip.start.position[2], trip.goal.position[2]) for trip in trips(park, 6)])
    np.testing.assert_allclose(np.abs(np.diff(heights, axis=1)), 1.5, atol=1e-6)
    assert set(np.round(heights[:, 0], 6)) == {0.0, 1.5}


def test_ends_of_trips_are_spread_over_the_area(plane):
    world = DrivingWorld("plane", MeshMap(plane.mesh_map.vertices, plane.mesh_map.faces))
    points = np.array([trip.goal.position[:2] for trip in trips(world, 400)])
    counts = np.histogram2d(points[:, 0], points[:, 1], bins=2, range=[[0, 10]] * 2)[0]
    assert counts.min() > 60  # of 100; the standard deviation is 9


def test_tables_tell_what_was_driven():
    good = Verdict(0, "", 10.0, 12.0, 20.0, 0.05, 0.1, 0.4)
    bad = Verdict(7, "outcome 108: lost", 10.0, 1.0, 2.0, 9.0, 0.1, 0.1, 3)
    none = Verdict(8, "no plan: it is blocked", *[0.0] * 3, *[np.inf] * 3, planned_at_all=False)
    some = [Statistics("hills", [good, bad, none]), Statistics("sea", [bad, none])]
    lines = table(some).splitlines()
    told = "hills 2 of 3 1 of 2 3 0.100 - 1.200 1.200 12.0 20.0 0.60 0.050 5.7"
    assert lines[2].split() == told.split()
    assert lines[3].split() == "sea 1 of 2 0 of 1 3 0.100 -".split()
    assert len({len(lines[0]), len(lines[1]), len(lines[2])}) == 1
    assert failures(some).splitlines() == [
        "hills, seed 7: outcome 108: lost",
        "hills, seed 8: no plan: it is blocked",
        "sea, seed 7: outcome 108: lost",
        "sea, seed 8: no plan: it is blocked",
    ]
    assert verdicts.Statistics("none", [good]).failed == []
    assert [each.seed for each in some[0].failed] == [7]
