"""Neighborhoods, values at points, and costs along paths."""

import tracemalloc

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap
from mesh_map.map.queries import SurfaceQueries
from mesh_map.spatial.hits import NO_FACE, SurfacePoints
from mesh_msgs import zoo
from meshes import TestMesh, data_mesh, real, small, terrain


def queries_of(mesh):
    return SurfaceQueries(MeshGeometry(mesh.vertices, mesh.faces))


@small
def test_neighborhoods_equal_loops(mesh):
    queries = queries_of(mesh)
    faces = [tuple(int(v) for v in face) for face in mesh.faces]
    edges = {frozenset((f[k], f[k - 1])) for f in faces for k in range(3) if f[k] != f[k - 1]}
    around = {v: {w for e in edges if v in e for w in e} - {v} for v in range(len(mesh.vertices))}
    random = np.random.default_rng(0)
    for vertex in random.integers(0, len(mesh.vertices), 8):
        assert queries.neighbors_of_vertex(vertex).tolist() == sorted(around[vertex])
        own = [i for i, face in enumerate(faces) if vertex in face]
        assert queries.faces_of_vertex(vertex).tolist() == own
        ring = {int(vertex)}
        for k in range(4):
            assert queries.k_ring(vertex, k).tolist() == sorted(ring)
            ring |= set().union(*(around[v] for v in ring))
        gaps = np.linalg.norm(mesh.vertices.astype(np.float64) - mesh.vertices[vertex], axis=1)
        radius = 0.4 * gaps.max() + 1e-3
        found, last = {int(vertex)}, set()
        while found != last:
            last = set(found)
            found |= {w for v in last for w in around[v] if gaps[w] < radius}
        assert queries.radius_neighborhood(vertex, radius).tolist() == sorted(found)
    regular = [len(set(face)) == 3 for face in faces]
    for i in random.integers(0, len(faces), 8):
        sides = [frozenset(pair) for pair in zip(faces[i], faces[i][1:] + faces[i][:1])]
        beside = [
            j
            for j, other in enumerate(faces)
            if j != i and regular[i] and regular[j] and any(side <= set(other) for side in sides)
        ]
        assert queries.neighbors_of_face(i).tolist() == beside
        ring = [j for j, other in enumerate(faces) if j != i and set(other) & set(faces[i])]
        assert queries.ring_of_face(i).tolist() == ring
    for edge in random.integers(0, queries.topology.edge_count, 8):
        ends = {int(v) for v in queries.topology.edges[edge]}
        at_edge = [i for i, face in enumerate(faces) if regular[i] and ends <= set(face)]
        assert queries.faces_of_edge(edge).tolist() == at_edge


def test_neighborhoods_of_what_is_not_there_are_refused():
    queries = queries_of(terrain(4))
    for ask in (queries.neighbors_of_vertex, queries.faces_of_vertex, queries.neighbors_of_face):
        for index in (-1, 10**9, 0.5, None):
            with pytest.raises(IndexError, match="there is no"):
                ask(index)
    with pytest.raises(ValueError, match="k has to be"):
        queries.k_ring(0, -1)
    for radius in (0, np.nan, -1):
        with pytest.raises(ValueError, match="radius has to be above 0"):
            queries.radius_neighborhood(0, radius)


def test_values_and_directions_equal_equations_3_and_4():
    mesh = terrain(10)
    queries = queries_of(mesh)
    random = np.random.default_rng(1)
    points = queries.carry(random.uniform(0.1, 0.8, (300, 3)), max_distance=2)
    values = random.normal(size=len(mesh.vertices))
    vectors = random.normal(size=(len(mesh.vertices), 3))
    corners = mesh.faces[points.faces]
    np.testing.assert_allclose(
        queries.values_at(points, values), np.sum(points.barycentric * values[corners], 1)
    )
    sums = np.einsum("nk,nkd->nd", points.barycentric, vectors[corners])
    np.testing.assert_allclose(queries.values_at(points, vectors), sums, atol=1e-12)
    sums /= np.linalg.norm(sums, axis=1, keepdims=True)
    np.testing.assert_allclose(queries.directions_at(points, vectors), sums, atol=1e-12)
    vectors[corners[:, 0]] = np.nan
    vectors[corners[:, 1]] = 0
    rest = np.where(np.isfinite(vectors), vectors, 0)[corners]
    sums = np.einsum("nk,nkd->nd", points.barycentric, rest)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    expected = np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1), 0)
    np.testing.assert_allclose(queries.directions_at(points, vectors), expected, atol=1e-12)


def test_what_corners_without_a_number_make_of_a_value():
    """Lethal beats unknown; a corner without weight does not count; off the map is unknown."""
    queries = queries_of(TestMesh("one", np.eye(3, dtype=np.float32), np.array([[0, 1, 2]])))
    weights = np.array([[0.2, 0.3, 0.5], [0.5, 0.5, 0], [0, 0, 1], [0.5, 1e-7, 0.5], [0, 0, 0]])
    faces = np.array([0, 0, 0, 0, NO_FACE], np.uint32)
    points = SurfacePoints(faces, np.zeros((5, 3)), weights, np.zeros(5))
    nan, inf = np.nan, np.inf
    for values, expected in (
        ([1, 2, 3], [2.3, 1.5, 3, 2, nan]),
        ([1, 2, inf], [inf, 1.5, inf, inf, nan]),
        ([1, nan, 3], [nan, nan, 3, 2, nan]),
        ([inf, nan, 3], [inf, inf, 3, inf, nan]),
        ([nan, inf, inf], [inf, inf, inf, inf, nan]),
    ):
        np.testing.assert_allclose(queries.values_at(points, values), expected, atol=1e-6)
    assert queries.directions_at(points, np.ones((3, 3)))[-1].tolist() == [0, 0, 0]
    for wrong in (np.zeros(4), np.zeros((3, 1, 1))):
        with pytest.raises(ValueError, match="one row is needed for each of the 3 vertices"):
            queries.values_at(points, wrong)
    with pytest.raises(ValueError, match=r"shape \(V, 3\)"):
        queries.directions_at(points, np.zeros((3, 2)))


def test_points_are_carried_on_the_storey_of_the_hint_and_not_from_too_far():
    mesh = zoo.two_storeys()
    queries = queries_of(mesh)
    low, high = mesh.vertices.min(0), mesh.vertices.max(0)
    point = (low + high) / 2
    for height, storey in (
        (low[2] + 0.3, low[2]),
        (low[2] - 0.3, low[2]),
        (high[2] + 0.3, high[2]),
    ):
        place = np.array([point[0] + 0.3, point[1] + 0.2, height])
        found = queries.carrying_face(place)
        assert found is None or abs(found.position[2] - storey) < 1e-6
        assert queries.carrying_face(place, max_distance=0.2) is None or abs(height - storey) <= 0.2
    many = queries.carry(np.array([place, place + 100]), normal=(0, 0, 1), max_angle=0.5)
    assert many.faces[1] == NO_FACE and many.distances[1] == np.inf


def test_faces_without_area_carry_nothing():
    mesh = zoo.zero_area_face()
    queries = queries_of(mesh)
    flat = np.flatnonzero(queries.geometry.faces_without_area)
    assert len(flat)
    points = mesh.vertices[mesh.faces[flat]].astype(np.float64).reshape(-1, 3)
    assert not np.isin(queries.carry(points).faces, flat).any()
    assert all(queries.carrying_face(point).face not in flat for point in points)


def field(points):
    return (2 + points[:, 0] - 0.5 * points[:, 1]).astype(np.float32)


def test_along_a_path_on_a_plane_the_integral_is_exact():
    mesh = zoo.jittered_plane()
    queries = queries_of(mesh)
    costs = np.abs(field(mesh.vertices)) + 10
    slope = field(mesh.vertices) + 20
    random = np.random.default_rng(3)
    low, high = mesh.vertices.min(0) + 0.5, mesh.vertices.max(0) - 0.5
    for _ in range(20):
        path = np.concatenate([random.uniform(low[:2], high[:2], (6, 2)), np.zeros((6, 1))], 1)
        found = queries.path_cost(path, costs=slope)
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        at = field(path).astype(np.float64) + 20
        assert abs(found.length - steps.sum()) < 1e-6
        assert abs(found.integral - (steps * (at[1:] + at[:-1]) / 2).sum()) < 1e-4
        assert abs(found.maximum - at.max()) < 1e-4
        assert abs(found.mean - found.integral / found.length) < 1e-12
        assert not (found.lethal or found.unknown or found.off_map)
        assert found.cost == found.integral and len(found.point_costs) == 6
        np.testing.assert_allclose(found.point_costs, at, atol=1e-4)
        rough = queries.path_cost(path, costs=costs)
        dense = queries.path_cost(path, costs=costs, step=1e-3)
        assert abs(rough.integral - dense.integral) < 1e-3 * rough.integral


@real
def test_along_a_path_over_a_real_mesh_dense_samples_tell_the_same(name):
    """Both ways of a walk: its points at each edge, and its ends alone, are the same path."""
    mesh = data_mesh(name)
    queries = queries_of(mesh)
    random = np.random.default_rng(4)
    costs = random.uniform(0, 1, len(mesh.vertices)).astype(np.float32)
    compared = 0
    for face in random.integers(0, len(mesh.faces), 60):
        start = queries.carrying_face(mesh.vertices[mesh.faces[face]].mean(0))
        target = start.position + random.normal(0, 0.5, 3)
        line = queries.walker.line(start=start, target=target, path=True)
        if line.end or not line.length > 0.1:
            continue
        compared += 1
        points = line.path.points
        found = queries.path_cost(points, costs=costs)
        assert abs(found.length - line.length) < 1e-6 * (1 + line.length)
        parts = [
            np.linspace(a, b, 200, endpoint=False) + (b - a) / 400
            for a, b in zip(points[:-1], points[1:])
        ]
        samples = np.concatenate(parts)
        at = queries.cost_at(samples, costs=costs).costs
        lengths = np.repeat(np.linalg.norm(np.diff(points, axis=0), axis=1) / 200, 200)
        assert abs((at * lengths).sum() - found.integral) < 1e-4 * (1 + found.integral)
        assert found.maximum >= at.max() - 1e-9
    assert compared > 10


def test_lethal_unknown_and_missing_parts_are_told():
    mesh = zoo.grid(10, 10.0)
    queries = queries_of(mesh)
    vertices = mesh.vertices.astype(np.float64)
    low = vertices.min(0)
    x = vertices[:, 0] - low[0]
    path = low + np.array([(0.25, 4.4, 0), (9.75, 4.4, 0)])
    costs = np.ones(len(vertices), np.float32)
    assert queries.path_cost(path, costs=costs).integral == pytest.approx(9.5)
    costs[x == 5] = np.inf
    costs[x == 8] = np.nan
    found = queries.path_cost(path, costs=costs)
    assert found.lethal and found.unknown and not found.off_map and found.cost == np.inf
    assert found.lethal_length == pytest.approx(2) and found.unknown_length == pytest.approx(2)
    assert found.integral == pytest.approx(5.5) and found.mean == pytest.approx(1)
    along = low + np.array([(4, 2, 0), (4, 3, 0), (4, 7, 0)])  # edges beside lethal vertices
    assert queries.path_cost(along, costs=costs).cost == pytest.approx(5)
    beyond = low + np.array([(1.5, 4.4, 0), (-1.5, 4.4, 0), (-3, 4.4, 0)])
    found = queries.path_cost(beyond, costs=costs, max_distance=0.5)
    assert found.off_map and np.isnan(found.cost) and not found.lethal
    assert found.off_map_length == pytest.approx(2.5, abs=0.06) and found.length == pytest.approx(
        4.5
    )
    assert found.point_faces[1:].tolist() == [NO_FACE] * 2 and np.isnan(found.point_costs[1:]).all()
    for point, cost in ((low + (1.5, 1.2, 0), 1), (low + (5, 5, 0), np.inf), (low - 5, np.nan)):
        single = queries.path_cost([point], costs=costs)
        assert np.array_equal(single.point_costs, [cost], equal_nan=True) and single.length == 0
        assert single.lethal == (cost == np.inf) and single.off_map == bool(np.isnan(cost))


@pytest.mark.parametrize("tilt", [0.0, 0.3])
@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-9])
def test_a_path_over_a_face_without_area_is_as_known_as_its_ground(tilt, gap):
    """A T-junction that such a face closes, as simplification leaves them."""
    flat = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0], [1 + gap, 1, 0], [2, 0, 0], [2, 2, 0]]
    )
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    faces = [[0, 1, 2], [0, 2, 3], [1, 4, 2], [1, 5, 4], [5, 6, 4], [4, 6, 2]]
    queries = queries_of(TestMesh("t_junction", flat @ turn.T, faces))
    costs = 2.0 + flat[:, 1]  # linear over all of it
    random = np.random.default_rng(3)
    for _ in range(100):
        ends = np.zeros((2, 3))
        ends[:, :2] = random.uniform((0, 0), (1, 2)), random.uniform((1, 0), (2, 2))
        found = queries.path_cost(ends @ turn.T, costs=costs)
        assert not found.unknown and not found.off_map and not found.lethal
        assert found.length == pytest.approx(np.linalg.norm(ends[1] - ends[0]), rel=1e-5)
        assert found.cost == pytest.approx((2.0 + ends[:, 1].mean()) * found.length, rel=1e-5)
        assert found.maximum == pytest.approx(2.0 + ends[:, 1].max(), rel=1e-5)


def test_a_path_over_a_gap_or_to_another_storey_is_sampled():
    mesh = zoo.hole()
    queries = queries_of(mesh)
    costs = np.ones(len(mesh.vertices), np.float32)
    low, high = mesh.vertices.min(0), mesh.vertices.max(0)
    middle = (low + high) / 2
    path = [(low[0] + 0.5, middle[1] + 0.1, 0), (high[0] - 0.5, middle[1] + 0.1, 0)]
    found = queries.path_cost(path, costs=costs, max_distance=0.01)
    assert found.off_map_length > 0.5
    assert found.length == pytest.approx(high[0] - low[0] - 1)
    assert found.integral + found.off_map_length == pytest.approx(found.length)


def test_a_long_path_off_the_map_takes_little_memory():
    """NumPy tells tracemalloc of its arrays: 103 MB, when all samples were looked at together."""
    queries, costs = queries_of(zoo.grid()), np.zeros(len(zoo.grid().vertices), np.float32)
    path = np.random.default_rng(0).uniform(2000.0, 2150.0, (400, 3))
    tracemalloc.start()
    try:
        found = queries.path_cost(path, costs=costs)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert found.off_map_length == pytest.approx(length) == pytest.approx(found.length)
    assert peak < 20e6


def test_costs_of_the_map_are_those_of_now():
    mesh = terrain(6)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    queries = mesh_map.queries
    assert isinstance(queries, SurfaceQueries) and mesh_map.queries is queries
    point = [mesh.vertices[14]]
    assert queries.cost_at(point).costs.tolist() == [0]
    assert queries.face_costs().max() == 0 and len(queries.face_costs()) == len(mesh.faces)
    given = np.full(len(mesh.vertices), 3, np.float32)
    assert queries.cost_at(point, costs=given).costs.tolist() == [3]
    assert queries.face_costs("mean", given).tolist() == [3] * len(mesh.faces)
    other = SurfaceQueries(MeshMap.of(mesh_map.geometry))
    assert other.walker is queries.walker
    with pytest.raises(MeshMapError, match="has no costs"):
        SurfaceQueries(mesh_map.geometry).cost_at(point)
    assert len(queries.attributes.vertices) == 0


def test_bad_paths_are_refused():
    mesh = terrain(5)
    queries = queries_of(mesh)
    costs = np.zeros(25, np.float32)
    for path, arguments, match in (
        (np.zeros((0, 3)), {}, "at least one point"),
        ([(0, 0, 0), (0, np.nan, 0)], {}, "point 1 is not finite"),
        ([(0, 0)], {}, "shape"),
        ([(0, 0, 0)], {"step": 0}, "step has to be above 0"),
        ([(0, 0, 0)], {"step": np.nan}, "step has to be above 0"),
        ([(0, 0, 0)], {"max_distance": -1}, "maximum distance"),
        ([(0, 0, 0)], {"normal": (0, 0, 1)}, "belong together"),
    ):
        with pytest.raises(ValueError, match=match):
            queries.path_cost(path, costs=costs, **arguments)
    with pytest.raises(ValueError, match="one for each vertex"):
        queries.path_cost([(0, 0, 0)], costs=costs[1:])
    for wrong in ("free", [None] * 25, costs + 0j):
        with pytest.raises(ValueError, match="costs has to be numbers"):
            queries.path_cost([(0, 0, 0)], costs=wrong)
    with pytest.raises(ValueError, match="vectors has to be numbers"):
        queries.directions_at(queries.carry([(0, 0, 0)]), [["x"] * 3] * 25)
    huge = queries.cost_at([mesh.vertices[7]], costs=np.full(25, 1e300)).costs
    assert huge.tolist() == [np.inf]
