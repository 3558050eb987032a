"""Paths pulled taut: what they are on meshes whose shortest paths are known, and on any mesh."""

import itertools
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from geodesic_paths import check_path, check_taut, edge_way, path_of, random_way
from geodesic_samples import samples
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.distance.exact_geodesic import ExactGeodesic
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_msgs import zoo
from meshes import TestMesh, renumbered, small, terrain


def geometry_of(mesh):
    return MeshGeometry(mesh.vertices, mesh.faces)


def shorten(geometry, path, **options):
    return ExactGeodesic.of(geometry).shorten(path, **options)


def box(size, cells):
    """The surface of a box with a corner at the origin, welded."""
    parts, faces, count = [], [], 0
    for axis, end in itertools.product(range(3), (0, 1)):
        mesh = zoo.grid(cells, 1.0)
        points = np.zeros((len(mesh.vertices), 3))
        points[:, axis] = end
        points[:, (axis + 1) % 3] = mesh.vertices[:, 0]
        points[:, (axis + 2) % 3] = mesh.vertices[:, 1]
        parts.append(points)
        faces.append(mesh.faces + count)
        count += len(points)
    vertices, where = np.unique(np.concatenate(parts).round(6), axis=0, return_inverse=True)
    faces = where.reshape(-1)[np.concatenate(faces)]
    return TestMesh("box", (vertices * size).round(3).astype(np.float32), faces)


def at(geometry, *place):
    return int(np.argmin(np.linalg.norm(geometry.vertices - np.array(place), axis=1)))


@pytest.mark.parametrize("cells", [1, 7, 30])
def test_straight_on_a_plane(cells):
    geometry = geometry_of(zoo.jittered_plane(cells))
    random = np.random.default_rng(cells)
    for _ in range(20):
        given = random_way(geometry, random, random.integers(1, 30))
        path = shorten(geometry, given)
        check_path(geometry, given, path)
        straight = np.linalg.norm(given.points[-1] - given.points[0])
        # a way around the border may have to stay there
        assert path.length >= straight * (1 - 1e-12)
        assert check_taut(geometry, path) > 0 or path.length == pytest.approx(straight, rel=1e-12)


def sweep(points, center):
    """The angle by which a way goes around a place in the plane."""
    x, y = (points - center)[:, :2].T
    return np.diff(np.unwrap(np.arctan2(y, x)))[:].sum()


def hull_way(start, goal, corners, left):
    """The length of the shortest way around a convex obstacle, on its left or right side."""
    best = np.inf
    for count in range(len(corners) + 1):
        for chosen in itertools.permutations(corners, count):
            way = np.array([start, *chosen, goal])
            steps = np.diff(way, axis=0)
            length = np.linalg.norm(steps, axis=1).sum()
            clear = all(
                not passes_through(a, b, corners.min(axis=0), corners.max(axis=0))
                for a, b in zip(way, way[1:])
            )
            turn = sweep(np.array(way), corners.mean(axis=0))
            if clear and (turn < 0) == left:
                best = min(best, length)
    return best


def passes_through(a, b, low, high):
    """Whether a segment meets the inside of a rectangle."""
    shares = np.linspace(0, 1, 2001)[:, None]
    points = a + shares * (b - a)
    margin = 1e-9
    return ((points > low + margin) & (points < high - margin)).all(axis=1).any()


@pytest.mark.parametrize("masked", [False, True])
def test_around_a_hole(masked):
    """On the side on which the given way is, as short as a string around its corners."""
    cells = 18
    mesh = zoo.grid(cells, 9.0) if masked else zoo.hole(cells, 9.0)
    geometry = geometry_of(mesh)
    mask = None
    if masked:
        x, y = mesh.vertices[mesh.faces].mean(axis=1)[:, :2].T
        mask = (np.abs(x - 4.5) > 1.5) | (np.abs(y - 4.5) > 1.5)
    corners = np.array([[3, 3], [6, 3], [6, 6], [3, 6]], np.float64)
    sides = set()
    for start, *stops, goal in [
        ((1, 4.5), (4.5, 1), (8, 4.5)),
        ((1, 4.5), (4.5, 8), (8, 4.5)),
        ((1, 4), (1, 8), (7.5, 8)),
        ((2.5, 1), (8, 1), (7, 8.5)),
        ((2.5, 1), (1, 8), (7, 8.5)),
        ((4.5, 2.5), (8, 2.5), (8, 8.5), (4, 8.5)),
    ]:
        places = (start, *stops, goal)
        given = edge_way(geometry, *(at(geometry, *place, 0) for place in places))
        path = shorten(geometry, given, mask=mask)
        check_path(geometry, given, path, mask)
        check_taut(geometry, path, mask)
        left = sweep(given.points[:, :2], corners.mean(axis=0)) < 0
        sides.add(left)
        expected = hull_way(np.array(start, float), np.array(goal, float), corners, left)
        assert path.length == pytest.approx(expected, rel=1e-12)
    assert len(sides) == 2


@pytest.mark.parametrize("cells", [1, 6])
def test_the_spider_and_the_fly(cells):
    """In a room of 12 x 12 x 30, over 5, 4 or 3 walls, by where the way is at first."""
    geometry = geometry_of(box(np.array([30.0, 12.0, 12.0]), max(cells, 2) * 6))
    # a grid of 12 x 12 cells a side has its lines 1 m apart across; starts 1 m below the ceiling
    spider, fly = at(geometry, 0, 6, 11), at(geometry, 30, 6, 1)
    stops = {
        40.0: [(5, 6, 12), (12, 12, 10), (18, 12, 4), (26, 6, 0)],
        np.hypot(37, 17): [(5, 6, 12), (12, 11, 12), (18, 12, 6)],
        42.0: [(10, 6, 12), (20, 6, 12)],
    }
    for expected, places in stops.items():
        way = [spider, *(at(geometry, *place) for place in places), fly]
        given = edge_way(geometry, *way)
        path = shorten(geometry, given)
        check_path(geometry, given, path)
        check_taut(geometry, path)
        assert path.length == pytest.approx(expected, rel=1e-7)


def test_around_a_tube():
    """A prism is flat when it is unrolled: ways around it are straight, on either side."""
    around, along = 24, 30
    phi = np.arange(around) * 2 * np.pi / around
    z = np.linspace(0, 4, along + 1)
    points = [(np.cos(a), np.sin(a), h) for a in phi for h in z]
    index = np.arange(around * (along + 1)).reshape(around, along + 1)
    a, b = index[:, :-1].ravel(), np.roll(index, -1, axis=0)[:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)])
    geometry = MeshGeometry(np.array(points, np.float32), faces.astype(np.uint32))
    width = 2 * np.sin(np.pi / around)
    for steps in range(1, around):
        stops = [index[k, 3 + (24 * k) // steps] for k in range(0, steps + 1)]
        given = edge_way(geometry, *(int(v) for v in stops))
        path = shorten(geometry, given)
        check_path(geometry, given, path)
        rise = z[27] - z[3]
        assert path.length == pytest.approx(np.hypot(steps * width, rise), rel=1e-6)
        assert check_taut(geometry, path) == 0 or path.length < given.length


def test_on_a_sphere():
    geometry = geometry_of(zoo.sphere(4))
    random = np.random.default_rng(2)
    for _ in range(20):
        a, b = (int(v) for v in random.choice(len(geometry.vertices), 2, replace=False))
        given = edge_way(geometry, a, b)
        path = shorten(geometry, given)
        check_path(geometry, given, path)
        check_taut(geometry, path)
        arc = np.arccos(np.clip(geometry.vertices[a] @ geometry.vertices[b], -1, 1))
        assert 0.997 < path.length / arc < 1.001


@small
def test_any_way_on_any_mesh(mesh):
    """Random ways, with all faces and some: valid, not longer, taut, and the same when repeated."""
    geometry = geometry_of(mesh)
    random = np.random.default_rng(5)
    for trial in range(8):
        mask = random.random(len(mesh.faces)) < 0.8 if trial % 2 else None
        counting = ~geometry.topology.degenerate_faces
        if not (counting if mask is None else counting & mask).any():
            continue
        given = random_way(geometry, random, int(random.integers(0, 25)), mask)
        path = shorten(geometry, given, mask=mask)
        check_path(geometry, given, path, mask)
        check_taut(geometry, path, mask)
        again = shorten(geometry, path, mask=mask)
        assert again.length == pytest.approx(path.length, rel=1e-9)
        check_path(geometry, path, again, mask)
        over = shorten(geometry, given, mask=mask, over_hills=True)
        check_path(geometry, path_of(path.points, path.faces), over, mask)
        check_taut(geometry, over, mask)


def test_rough_ground():
    """Long ways along edges become taut, the same on the mesh renumbered and partly turned over."""
    mesh = terrain(60)
    geometry = geometry_of(mesh)
    other, new = renumbered(mesh)
    faces = other.faces.copy()
    faces[::3] = faces[::3, ::-1]
    twin = MeshGeometry(other.vertices, faces)
    random = np.random.default_rng(0)
    for _ in range(10):
        a, b = (int(v) for v in random.choice(len(mesh.vertices), 2, replace=False))
        given = edge_way(geometry, a, b)
        path = shorten(geometry, given)
        check_path(geometry, given, path)
        check_taut(geometry, path)
        assert path.length < 0.99 * given.length
        same = shorten(twin, given)
        assert same.length == pytest.approx(path.length, rel=1e-12)
        assert abs(len(same.points) - len(path.points)) <= 2


def test_no_way_that_is_tried_is_shorter():
    """Moving any crossing along its edge makes the path longer."""
    geometry = geometry_of(terrain(25))
    path = shorten(geometry, edge_way(geometry, 0, 624))
    assert len(path.points) > 20
    vertices = geometry.vertices.astype(np.float64)
    moved = 0
    for i in range(1, len(path.points) - 1):
        f, g = geometry.faces[path.faces[i - 1]], geometry.faces[path.faces[i]]
        common = [v for v in f if v in g]
        if len(common) != 2:
            continue
        side = vertices[common[1]] - vertices[common[0]]
        for step in (-1e-3, 1e-3):
            points = path.points.copy()
            points[i] += step * side
            assert path_of(points, path.faces).length > path.length
            moved += 1
    assert moved > 30


def test_over_a_hill():
    """A cone has a taut path on both sides; the shorter one is found from either."""
    phi = np.arange(40) * np.pi / 20
    ring = np.stack([np.cos(phi), np.sin(phi), np.zeros(40)], 1)
    corner = np.arange(40)
    faces = np.stack([0 * corner, corner + 1, (corner + 1) % 40 + 1], 1)
    vertices = np.concatenate([[(0.0, 0.0, 1.0)], ring])
    geometry = MeshGeometry(vertices.astype(np.float32), faces.astype(np.uint32))
    near, far = edge_way(geometry, 1, 16), edge_way(geometry, 1, 31, 16)
    corner_angle = 2 * np.arcsin(np.linalg.norm(ring[1] - ring[0]) / np.sqrt(8))
    lengths = [np.sqrt(8) * np.sin(steps * corner_angle / 2) for steps in (15, 25)]
    assert shorten(geometry, near).length == pytest.approx(lengths[0], rel=1e-6)
    assert shorten(geometry, far).length == pytest.approx(lengths[1], rel=1e-6)
    over = shorten(geometry, far, over_hills=True)
    check_path(geometry, far, over)
    assert over.length == pytest.approx(lengths[0], rel=1e-6)
    assert shorten(geometry, near, over_hills=True).length == shorten(geometry, near).length


@pytest.mark.parametrize("name, share", [("hills", 0.4), ("two_storeys", 0.9), ("sphere", 0.1)])
def test_against_exact_distances(name, share):
    """Never shorter, and often the same, although it starts from ways along edges."""
    kept = samples(name)
    geometry = geometry_of(kept.mesh)
    found, over, exact = [], [], []
    for vertex in np.random.default_rng(1).permutation(len(kept.vertices))[:40]:
        source, goal = int(kept.sources[0]), int(kept.vertices[vertex])
        if source == goal:
            continue
        given = edge_way(geometry, source, goal)
        exact.append(kept.distances[0, vertex])
        found.append(shorten(geometry, given).length)
        over.append(shorten(geometry, given, over_hills=True).length)
    found, over, exact = np.array([found, over, exact], np.float64)
    assert (over > exact * (1 - 1e-6)).all() and (found > exact * (1 - 1e-6)).all()
    assert (over <= found * (1 + 1e-12)).all()
    assert np.mean(over < exact * (1 + 1e-4)) >= share


def test_starts_and_goals_anywhere():
    """In faces, on edges, at vertices; in the same face, in the next, at the same place."""
    geometry = geometry_of(zoo.grid(4, 4.0))
    face, beside = 10, 11
    assert len(set(geometry.faces[face]) & set(geometry.faces[beside])) == 2
    a, b, c = geometry.vertices[geometry.faces[face]].astype(np.float64)
    for start, goal in itertools.product(
        (a, b, c, (a + b) / 2, (b + c) / 2, (a + b + c) / 3), repeat=2
    ):
        through = path_of([start, 0.3 * a + 0.3 * b + 0.4 * c, goal], [face, face])
        path = shorten(geometry, through)
        np.testing.assert_allclose(path.length, np.linalg.norm(goal - start), atol=1e-15)
        if (start != goal).any():
            check_path(geometry, through, path)
            assert len(path.faces) == 1
        else:
            assert len(path.points) == 1 and len(path.faces) == 0 and path.potentials == [0.0]
    single = path_of([a], [])
    np.testing.assert_array_equal(shorten(geometry, single).points, [a])


def test_through_a_vertex_that_faces_only_share():
    geometry = geometry_of(zoo.bow_tie())
    random = np.random.default_rng(0)
    corners = geometry.vertices.astype(np.float64)[geometry.faces]
    (shared,) = set(geometry.faces[0]) & set(geometry.faces[1])
    start, goal = (random.dirichlet((1, 1, 1)) @ corners[k] for k in (0, 1))
    middle = geometry.vertices[shared].astype(np.float64)
    given = path_of([start, (start + middle) / 2 + 0.0, middle, goal], [0, 0, 1])
    path = shorten(geometry, given)
    np.testing.assert_allclose(path.points, [start, middle, goal], atol=1e-12)


def test_parts_in_faces_that_do_not_count_stay():
    """Such as along an edge between two of them, which is open."""
    geometry = geometry_of(zoo.grid(6, 6.0))
    way = [at(geometry, *place, 0) for place in [(0, 3), (2, 3), (2, 4), (4, 4), (4, 3), (6, 3)]]
    given = edge_way(geometry, *way)
    middle = geometry.vertices[geometry.faces].mean(axis=1)
    mask = np.abs(middle[:, 0] - 3.0) > 1.0
    path = shorten(geometry, given, mask=mask)
    # the part along y = 4 from x = 2 to 4 has no face that counts beside it
    length = 2 * np.hypot(2, 1) + 2
    assert path.length == pytest.approx(length, rel=1e-12)
    inner = [p for p in path.points if 2 < p[0] < 4]
    assert all(p[1] == 4.0 for p in inner)
    np.testing.assert_array_equal(path.points[0], given.points[0])
    np.testing.assert_array_equal(path.points[-1], given.points[-1])


def test_many_at_once_are_the_same():
    geometry = geometry_of(terrain(40))
    ways = [edge_way(geometry, k, 1599 - k) for k in range(8)]
    alone = [shorten(geometry, way) for way in ways]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda way: shorten(geometry, way), ways * 3))
    for k, path in enumerate(together):
        np.testing.assert_array_equal(path.points, alone[k % 8].points)
        np.testing.assert_array_equal(path.faces, alone[k % 8].faces)


def test_cancel_and_turns():
    geometry = geometry_of(terrain(40))
    given = edge_way(geometry, 0, 1599)
    cancel = CancelFlag()
    cancel.set()
    with pytest.raises(Canceled):
        shorten(geometry, given, cancel=cancel)
    few = shorten(geometry, given, max_turns=3)
    check_path(geometry, given, few)
    assert given.length > few.length > shorten(geometry, given).length


@pytest.mark.parametrize(
    "points, faces, options, said",
    [
        ([[0, 0, 0], [9, 9, 0]], [0], {}, "point 1 of the path is 1"),
        ([[0, 0, 0], [0.1, 0, np.nan]], [0], {}, "point 1 of the path is not finite"),
        ([[0, 0, 0], [0.1, 0, 0]], [99], {}, "face 0 of the path is 99, but there are only 32"),
        ([[0, 0, 0]], [0], {}, "one point more than faces"),
        ([[0, 0], [1, 1]], [0], {}, "the points of a path"),
        ([[0, 0, 0], [0.1, 0, 0]], [-1], {}, "indices of faces"),
        ([[0, 0, 0], [0.1, 0, 0]], [0.5], {}, "whole numbers"),
        ([[0, 0, 0], [0.1, 0, 0]], [0], {"mask": np.ones(3, bool)}, "mask has to have"),
        ([[0, 0, 0], [0.1, 0, 0]], [0], {"cancel": 1}, "cancel has to be"),
        (
            [[0, 0, 0], [0.1, 0, 0]],
            [0],
            {"max_turns": -1},
            "max_turns has to be a whole number, 0 to",
        ),
        (
            [[0, 0, 0], [0.1, 0, 0]],
            [0],
            {"max_turns": 1 << 63},
            "max_turns has to be a whole number, 0 to",
        ),
    ],
)
def test_what_is_refused(points, faces, options, said):
    geometry = geometry_of(zoo.grid(4, 4.0))

    class Path:
        pass

    path = Path()
    path.points, path.faces = np.array(points, float), np.array(faces)
    with pytest.raises(ValueError, match=said):
        shorten(geometry, path, **options)
