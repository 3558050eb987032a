"""Walks over surfaces."""

import numpy as np
import pytest
from mesh_map.geometry.topology import Topology
from mesh_map.geometry.walk import SurfaceWalker, WalkEnd
from mesh_map.spatial.hits import NO_FACE, SurfacePoint, SurfacePoints
from mesh_msgs import zoo
from meshes import data_mesh, real, renumbered, small, terrain
from walk_oracle import oracle_walk


def walker_of(mesh):
    topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
    return SurfaceWalker(vertices=mesh.vertices, faces=mesh.faces, topology=topology)


def point_of(mesh, face, weights):
    weights = np.asarray(weights, np.float64) / np.sum(weights)
    position = weights @ mesh.vertices[mesh.faces[face]].astype(np.float64)
    return SurfacePoint(int(face), position, weights, 0.0)


def random_starts(mesh, count, seed=0):
    """(point, direction, length) within faces."""
    random = np.random.default_rng(seed)
    size = np.ptp(mesh.vertices, axis=0).max()
    for _ in range(count):
        face = random.integers(len(mesh.faces))
        point = point_of(mesh, face, random.dirichlet((2, 2, 2)))
        yield point, random.normal(size=3), random.uniform(0, size)


CURVED = [terrain(15), zoo.sphere(), zoo.torus(), zoo.tetrahedron(), zoo.far_sphere()]


@pytest.mark.parametrize("mesh", CURVED, ids=lambda mesh: mesh.name)
def test_a_walk_is_what_turning_about_each_edge_gives(mesh):
    walker = walker_of(mesh)
    compared = 0
    for point, direction, length in random_starts(mesh, 60):
        walk = walker.walk(start=point, direction=direction, length=length)
        face, position, way, walked, event = oracle_walk(
            mesh.vertices, mesh.faces, point.face, point.position, direction, length
        )
        if event == "vertex":
            continue
        compared += 1
        scale = 1 + np.abs(mesh.vertices).max()
        assert walk.face == face
        assert np.linalg.norm(walk.position - position) < 1e-9 * scale
        assert np.linalg.norm(walk.direction - way) < 1e-7
        assert abs(walk.length - walked) < 1e-9 * scale
        assert walk.end == (WalkEnd.BORDER if event else WalkEnd.ARRIVED)
    assert compared > 50


@pytest.mark.parametrize("mesh", CURVED, ids=lambda mesh: mesh.name)
def test_forth_and_back_and_in_pieces(mesh):
    """Backwards leads to the start, looking as before; stops on the way change nothing."""
    walker = walker_of(mesh)
    scale = 1 + np.abs(mesh.vertices).max()
    arrived = 0
    for point, direction, length in random_starts(mesh, 60, seed=1):
        start = walker.walk(start=point, direction=direction, length=0)
        there = walker.walk(start=start, length=length)
        back = walker.walk(start=there, length=-there.length)
        assert back.end == WalkEnd.ARRIVED
        assert np.linalg.norm(back.position - start.position) < 1e-9 * scale
        assert np.linalg.norm(back.direction - start.direction) < 1e-8
        assert np.linalg.norm(back.normal - start.normal) < 1e-8
        if there.end != WalkEnd.ARRIVED:
            continue
        arrived += 1
        assert there.length == length
        pieces = start
        for _ in range(7):
            pieces = walker.walk(start=pieces, length=length / 7)
        assert np.linalg.norm(pieces.position - there.position) < 1e-9 * scale
        assert np.linalg.norm(pieces.direction - there.direction) < 1e-8
    assert arrived > 20


PLANES = [
    zoo.jittered_plane(),
    zoo.flipped_face(),
    zoo.duplicate_face(),
    zoo.isolated_vertex(),
    zoo.zero_area_face(),
    zoo.grid(),
]


@pytest.mark.parametrize("mesh", PLANES, ids=lambda mesh: mesh.name)
def test_on_a_plane_a_walk_is_straight(mesh):
    """Also through vertices, along edges, and where faces are flipped, duplicate, or without area.

    It ends at the bounds of the (convex) plane, and nowhere before.
    """
    random = np.random.default_rng(2)
    walker = walker_of(mesh)
    vertices = mesh.vertices.astype(np.float64)
    assert np.ptp(vertices[mesh.faces][:, :, 2]) == 0
    low, high = vertices[mesh.faces].min((0, 1)), vertices[mesh.faces].max((0, 1))
    for _ in range(300):
        face = random.integers(len(mesh.faces))
        weights = np.array([(1, 0, 0), (1, 1, 0), random.dirichlet((1, 1, 1))][random.integers(3)])
        point = point_of(mesh, face, random.permutation(weights))
        other = vertices[random.choice(mesh.faces.ravel())]
        direction = [other - point.position, random.normal(size=3)][random.integers(2)]
        direction[2] = 0
        if not np.linalg.norm(direction) > 1e-6:
            continue
        direction /= np.linalg.norm(direction)
        length = random.uniform(0, np.ptp(high))
        walk = walker.walk(start=point, direction=direction, length=length, up=(0, 0, 1))
        if walk.end == WalkEnd.NOWHERE:
            without = np.cross(*(vertices[mesh.faces[face, 1:]] - vertices[mesh.faces[face, 0]]))
            assert not without.any()
            continue
        goal = point.position + length * direction
        assert np.linalg.norm(walk.position - point.position - walk.length * direction) < 1e-9
        assert np.abs(walk.direction - direction).max() < 1e-9
        assert walk.normal.tolist() == [0, 0, 1]
        if mesh.name in ("zero_area_face",):  # no rectangle
            continue
        if walk.end == WalkEnd.ARRIVED:
            assert walk.length == length
        else:
            assert walk.end == WalkEnd.BORDER
            assert (goal < low).any() or (goal > high).any()
            gaps = np.minimum(walk.position - low, high - walk.position)[:2]
            assert gaps.min() < 1e-9
            assert (np.sign(goal - (low + high) / 2) * direction)[:2][gaps < 1e-9].max() > 0


def test_far_from_the_origin_nothing_changes():
    near = zoo.sphere()
    step = 2.0**-3  # which floats still tell apart there
    vertices = np.round(near.vertices * 10 / step) * step
    meshes = [
        near._replace(vertices=(vertices + shift).astype(np.float32)) for shift in (0, 2**20)
    ]
    walkers = [walker_of(mesh) for mesh in meshes]
    for point, direction, _ in random_starts(meshes[0], 20):
        walks = [
            walker.walk(start=point, direction=direction, length=40, path=True)
            for walker in walkers
        ]
        assert walks[0].face == walks[1].face
        assert np.array_equal(walks[0].barycentric, walks[1].barycentric)
        assert np.abs(walks[1].position - walks[0].position - 2**20).max() < 1e-9
        assert np.array_equal(walks[0].path.faces, walks[1].path.faces)


@small
def test_every_mesh_can_be_walked_on(mesh):
    check_walks(mesh, 60)


@real
def test_real_meshes_can_be_walked_on(name):
    check_walks(data_mesh(name), 200)


def check_walks(mesh, count):
    """From faces, edges and vertices: what is told of the end, and of the way, fits; a batch tells
    the same; flipped faces and another order of vertices make no difference to the place.
    """
    random = np.random.default_rng(3)
    walker = walker_of(mesh)
    flipped = mesh.faces.copy()
    chosen = random.random(len(flipped)) < 0.5
    flipped[chosen] = flipped[chosen][:, [0, 2, 1]]
    other = walker_of(mesh._replace(faces=flipped))
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0))
    tolerance = 1e-9 * (1 + np.abs(corners).max())
    faces = random.integers(0, len(mesh.faces), count)
    weights = random.dirichlet((1, 1, 1), count)
    weights[::4] = np.eye(3)[random.integers(0, 3, len(weights[::4]))]
    weights[1::4, 0] = 0
    weights /= weights.sum(1, keepdims=True)
    starts = SurfacePoints(faces, np.zeros((count, 3)), weights, np.zeros(count))
    directions = random.normal(size=(count, 3))
    lengths = random.normal(0, size, count)
    lengths[::9] = np.inf
    many = walker.walk_batch(
        starts=starts, lengths=lengths, directions=directions, max_steps=500, paths=True
    )
    for i in range(count):
        one, walk = many.walk(i), many.walk(i)
        start = SurfacePoint(faces[i], weights[i] @ corners[faces[i]], weights[i], 0.0)
        one = walker.walk(
            start=start, length=lengths[i], direction=directions[i], max_steps=500, path=True
        )
        assert one.end == walk.end and one.face == walk.face and one.length == walk.length
        assert all(np.array_equal(a, b) for a, b in zip(one[1:5], walk[1:5]))
        assert all(np.array_equal(a, b) for a, b in zip(one.path, walk.path))
        if walk.end == WalkEnd.NOWHERE:
            assert walk.length == 0 and len(walk.path.faces) == 0
            edges = corners[faces[i]] - np.roll(corners[faces[i]], 1, 0)
            longest = np.square(edges).sum(1).max()
            assert np.linalg.norm(normals[faces[i]]) <= 2e-14 * longest
            continue
        assert 0 <= walk.length <= abs(lengths[i])
        assert (walk.length == abs(lengths[i])) == (walk.end == WalkEnd.ARRIVED)
        assert walk.barycentric.min() >= 0 and abs(walk.barycentric.sum() - 1) < 1e-12
        assert np.abs(walk.barycentric @ corners[walk.face] - walk.position).max() < tolerance
        unit = normals[walk.face] / np.linalg.norm(normals[walk.face])
        assert min(np.abs(walk.normal - unit).max(), np.abs(walk.normal + unit).max()) < 1e-9
        assert abs(np.linalg.norm(walk.direction) - 1) < 1e-9
        assert abs(walk.direction @ walk.normal) < 1e-9
        points = walk.path.points
        if walk.length < np.inf:
            steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
            assert abs(steps.sum() - walk.length) < 10 * tolerance * (1 + len(steps))
        assert np.abs(points[0] - start.position).max() < tolerance
        assert np.abs(points[-1] - walk.position).max() < tolerance
        assert len(walk.path.faces) <= 502
        reference = walker.walk(start=start, length=0, direction=directions[i])
        turned = other.walk(
            start=start,
            length=lengths[i],
            direction=directions[i],
            up=reference.normal,
            max_steps=500,
        )
        if chosen[faces[i]]:
            continue  # the weights of the start belong to another corner
        if len(walk.path.faces) < 100:  # rounding grows on long ways
            assert np.abs(turned.position - walk.position).max() < 1e-6 * (1 + size)


def test_vertices_renumbered_give_the_same_walks():
    mesh = terrain(15)
    other, _ = renumbered(mesh)
    walkers = walker_of(mesh), walker_of(other)
    for point, direction, length in random_starts(mesh, 30, seed=5):
        one, two = (w.walk(start=point, direction=direction, length=length) for w in walkers)
        assert np.array_equal(one.position, two.position) and one.face == two.face


def test_a_walk_round_a_moebius_strip_ends_on_the_other_side():
    """The side of the walker is that which he walked on, whatever side faces call theirs."""
    mesh = zoo.moebius_strip()
    walker = walker_of(mesh)
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    middle = corners.mean(1)
    face = int(
        np.argmin(
            np.abs(
                np.linalg.norm(middle[:, :2], axis=1)
                - np.median(np.linalg.norm(middle[:, :2], axis=1))
            )
        )
    )
    start = walker.walk(
        start=point_of(mesh, face, (1, 1, 1)),
        direction=np.cross((0, 0, 1), middle[face]),
        length=0,
    )
    sides = []
    walk = start
    for _ in range(4000):
        before = walk
        # steer along the circle in the middle of the strip
        ahead = np.cross((0, 0, 1), walk.position)
        walk = walker.walk(start=walk, direction=ahead, length=0.01)
        assert walk.end == WalkEnd.ARRIVED
        assert walk.normal @ before.normal > 0
        angle = np.arctan2(walk.position[1], walk.position[0])
        if (
            angle
            >= np.arctan2(start.position[1], start.position[0])
            > np.arctan2(before.position[1], before.position[0])
        ):
            sides.append(walk.normal @ start.normal)
            if len(sides) == 2:
                break
    assert sides[0] < -0.9 and sides[1] > 0.9


def test_at_more_than_two_faces_it_goes_on_in_the_one_that_bends_least():
    vertices = [[0, 0, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0.2], [1, 1, -0.9], [0, 0, 1]]
    for order in ([0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 3, 1]):
        faces = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4], [0, 1, 5]])[order]
        mesh = zoo.grid()._replace(vertices=np.array(vertices, np.float32), faces=faces)
        start = point_of(mesh, order.index(0), (1, 1, 1))
        walk = walker_of(mesh).walk(start=start, direction=(1, 0, 0), length=0.5)
        assert walk.end == WalkEnd.ARRIVED and walk.face == order.index(1)


def test_duplicates_do_not_hide_a_border():
    mesh = zoo.grid()._replace(
        vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32),
        faces=np.array([[0, 1, 2], [0, 1, 2], [2, 1, 0]]),
    )
    for face in range(3):
        start = point_of(mesh, face, (1, 1, 1))
        walk = walker_of(mesh).walk(start=start, direction=(1, 1, 0), length=2)
        assert walk.end == WalkEnd.BORDER and abs(walk.position[:2].sum() - 1) < 1e-12


def test_a_walk_along_a_border_goes_on_only_where_it_is_straight():
    bent = [[0, 0, 0], [1, 0, 0], [2, -0.5, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]]
    faces = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]
    for sink, expected in ((0.0, WalkEnd.ARRIVED), (-0.5, WalkEnd.ARRIVED), (0.5, WalkEnd.BORDER)):
        vertices = np.array(bent, np.float32)
        vertices[2, 1] = sink
        mesh = zoo.grid()._replace(vertices=vertices, faces=np.array(faces))
        start = point_of(mesh, 0, (1, 1, 0))
        walk = walker_of(mesh).walk(start=start, direction=(1, 0, 0), length=1)
        assert walk.end == expected
        assert (
            np.abs(walk.position - (1.5 if expected == WalkEnd.ARRIVED else 1.0, 0, 0)).max() < 1e-9
        )


def test_masks_block_and_steps_end():
    mesh = zoo.grid(10, 10.0)
    walker = walker_of(mesh)
    middle = mesh.vertices[mesh.faces].mean(1)
    mask = middle[:, 0] < 7
    start = point_of(mesh, int(np.argmin(np.abs(middle - (2, 4.6, 0)).sum(1))), (1, 2, 3))
    walk = walker.walk(start=start, direction=(1, 0.01, 0), length=9, mask=mask)
    assert walk.end == WalkEnd.BLOCKED and abs(walk.position[0] - 7) < 1e-12 and mask[walk.face]
    line = walker.line(start=start, target=(9, 5, 0), mask=mask)
    assert line.end == WalkEnd.BLOCKED and abs(line.position[0] - 7) < 1e-12
    out = walker.walk(start=walk, direction=(-1, 0, 0), length=1, mask=~mask)
    assert out.end == WalkEnd.BLOCKED  # may leave its face, but the next one does not count
    for steps in (0, 1, 5):
        walk = walker.walk(
            start=start, direction=(1, 0.01, 0), length=9, max_steps=steps, path=True
        )
        assert walk.end == WalkEnd.STEPS and len(walk.path.faces) == steps
    mask[:] = True
    assert walker.walk(start=start, direction=(1, 0, 0), length=3, mask=mask).end == WalkEnd.ARRIVED


def test_turning_and_matrices():
    mesh = terrain(15)
    walker = walker_of(mesh)
    for point, direction, _ in random_starts(mesh, 10):
        walk = walker.walk(start=point, direction=direction, length=0.1, up=(0, 0, 1))
        matrix = walk.turned(0.3).matrix()
        assert np.abs(matrix[:3, :3] @ matrix[:3, :3].T - np.eye(3)).max() < 1e-9
        assert np.linalg.det(matrix[:3, :3]) > 0 and matrix[2, 2] > 0
        assert abs(matrix[:3, 0] @ walk.direction - np.cos(0.3)) < 1e-9
        assert matrix[:3, 1] @ walk.direction < 0  # to the left
        assert np.abs(walk.turned(np.pi).direction + walk.direction).max() < 1e-12


def test_lines_are_cuts_of_the_surface():
    """On a height field: as long as the sum over all faces of their cut with the plane, in the
    plane, on the surface, and to the target.
    """
    mesh = terrain(15)
    walker = walker_of(mesh)
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    random = np.random.default_rng(6)
    for _ in range(30):
        start, goal = (
            point_of(mesh, random.integers(len(mesh.faces)), random.dirichlet((1, 1, 1)))
            for _ in range(2)
        )
        line = walker.line(start=start, target=goal.position, up=(0, 0, 1), path=True)
        assert line.end == WalkEnd.ARRIVED
        assert np.abs(line.position - goal.position).max() < 1e-6
        way = (goal.position - start.position)[:2]
        reach = np.linalg.norm(way)
        ahead = way / reach
        across = np.array([-ahead[1], ahead[0]])
        x = (corners[:, :, :2] - start.position[:2]) @ ahead
        y = (corners[:, :, :2] - start.position[:2]) @ across
        total = 0.0
        for face in range(len(corners)):
            cut = []
            for i, j in ((0, 1), (1, 2), (2, 0)):
                if (y[face, i] < 0) != (y[face, j] < 0):
                    t = y[face, i] / (y[face, i] - y[face, j])
                    height = corners[face, i, 2] + t * (corners[face, j, 2] - corners[face, i, 2])
                    cut.append((x[face, i] + t * (x[face, j] - x[face, i]), height))
            if cut:
                (a, low), (b, high) = sorted(cut)
                share = (min(b, reach) - max(a, 0)) / (b - a) if b > a else 0
                total += max(0, share) * np.hypot(b - a, high - low)
        assert abs(line.length - total) < 1e-6
        assert np.abs((line.path.points[:, :2] - start.position[:2]) @ across).max() < 1e-7
        assert np.all(np.diff((line.path.points[:, :2] - start.position[:2]) @ ahead) >= 0)


@pytest.mark.parametrize("size", [5e-324, 1e-170, 1e-90, 1e90, 1e170, 1.7e308])
def test_directions_and_targets_may_have_any_size(size):
    mesh = terrain(15)
    walker = walker_of(mesh)
    start = point_of(mesh, 200, (1, 1, 1))
    up = np.array([0.1, 0.2, -1.0])
    way = {"start": start, "target": start.position + (0.4, 0.3, 0)}
    found, expected = walker.line(**way, up=size * np.sign(up)), walker.line(**way, up=np.sign(up))
    assert found.end == expected.end == WalkEnd.ARRIVED and expected.length > 0.4
    np.testing.assert_allclose(found.position, expected.position, atol=1e-12)
    np.testing.assert_allclose(found.normal, expected.normal, atol=1e-12)
    if size > 1:
        away = walker.line(start=start, target=(size, 0.5 * size, 0), up=(0, 0, 1))
        near = walker.line(start=start, target=(1e6, 0.5e6, 0), up=(0, 0, 1))
        assert away.end == near.end == WalkEnd.BORDER
        np.testing.assert_allclose(away.position, near.position, atol=1e-5)


def test_weights_of_no_point_of_a_face_are_no_start():
    mesh = terrain(5)
    walker = walker_of(mesh)
    wrong = [(0, 0, 0), (1, 1, 1), (-1, 1, 1), (3, -1, -1), (1e300, 0, 1), (np.nan, 0, 1)]
    rounded = [(1 + 1e-9, -1e-9, 0), (1 / 3, 1 / 3, 0.33333334)]
    weights = np.array(wrong + rounded)
    starts = SurfacePoints(np.zeros(len(weights), int), None, weights, None)
    walks = walker.walk_batch(starts=starts, lengths=0.01, directions=(0.3, 1, 0))
    lines = walker.line_batch(starts=starts, targets=mesh.vertices[6])
    for ends in (walks.ends, lines.ends):
        assert ends.tolist() == [WalkEnd.NOWHERE] * len(wrong) + [WalkEnd.ARRIVED] * len(rounded)


def test_lines_run_along_borders_and_end_at_them():
    mesh = zoo.grid(10, 10.0)
    walker = walker_of(mesh)
    low, high = mesh.vertices[mesh.faces].min((0, 1)), mesh.vertices[mesh.faces].max((0, 1))
    face, corner = (int(i[0]) for i in np.where((mesh.vertices[mesh.faces] == low).all(2)))
    start = point_of(mesh, face, np.eye(3)[corner])
    for target in ((high[0], low[1], 0), (low[0], high[1], 0), high):
        line = walker.line(start=start, target=target)
        assert line.end == WalkEnd.ARRIVED and np.abs(line.position - target).max() < 1e-7
    beyond = walker.line(start=start, target=high + (3, 3, 0))
    assert beyond.end == WalkEnd.BORDER and np.abs(beyond.position - high).max() < 1e-6
    still = walker.line(start=start, target=low + (0, 0, 5))
    assert still.end == WalkEnd.ARRIVED and still.length < 1e-8


def test_lines_stay_on_their_side_of_flipped_faces():
    """Also where the surface overhangs, so that the side is not told by what is up."""
    angles = np.linspace(0, 1.6 * np.pi, 30)  # a roof that rolls over
    rows = [np.stack([np.sin(angles), np.full(30, y), np.cos(angles)], 1) for y in (-1.0, 1.0)]
    vertices = np.concatenate(rows).astype(np.float32)
    faces = [(i, i + 1, 30 + i) for i in range(29)] + [(i + 1, 31 + i, 30 + i) for i in range(29)]
    random = np.random.default_rng(7)
    faces = np.array([face if random.random() < 0.5 else face[::-1] for face in faces])
    mesh = zoo.grid()._replace(vertices=vertices, faces=faces)
    start = point_of(mesh, 0, (1, 1, 1))
    for side in (1, -1):
        up = side * np.array([0.6, 0, 1])
        line = walker_of(mesh).line(start=start, target=(1.2, 0, -0.9), up=up)
        assert line.length > 1.5 and line.normal @ line.position * side > 0.9


def test_a_line_round_a_leaning_peak_ends_as_a_loop():
    """The plane cuts off the peak, which lies beyond all that is around it."""
    angles = np.arange(6) * np.pi / 3
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(6)], 1)
    vertices = np.concatenate([[[0, 3, 1]], ring]).astype(np.float32)
    faces = np.array([[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    mesh = zoo.grid()._replace(vertices=vertices, faces=faces)
    for face in range(6):
        start = point_of(mesh, face, (0.9, 0.05, 0.05))
        target = start.position + (5, 0, 0)
        line = walker_of(mesh).line(start=start, target=target, up=(0, 0, 1))
        assert line.end == WalkEnd.LOOP
        batch = walker_of(mesh).line_batch(
            starts=SurfacePoints(np.array([face]), None, start.barycentric[None], None),
            targets=target,
            ups=(0, 0, 1),
        )
        assert batch.ends.tolist() == [WalkEnd.LOOP]


def test_batches_take_one_for_all():
    mesh = terrain(10)
    walker = walker_of(mesh)
    starts = SurfacePoints(np.array([3, 4, NO_FACE]), None, np.full((3, 3), 1 / 3), None)
    walks = walker.walk_batch(starts=starts, lengths=0.2, directions=(1, 0, 0), ups=(0, 0, -1))
    assert walks.ends.tolist() == [0, 0, WalkEnd.NOWHERE] and (walks.normals[:2, 2] < 0).all()
    onward = walker.walk_batch(starts=walks, lengths=[0.1, 0.2, 0.3])
    assert onward.lengths.tolist() == [0.1, 0.2, 0]
    assert (onward.normals[:2, 2] < 0).all()
    lines = walker.line_batch(starts=starts, targets=(0.5, 0.5, 0))
    assert lines.ends.tolist() == [0, 0, WalkEnd.NOWHERE]
    none = SurfacePoints(np.zeros(0, int), None, np.zeros((0, 3)), None)
    assert len(walker.walk_batch(starts=none, lengths=1, directions=(1, 0, 0)).faces) == 0


def test_bad_arguments_are_refused():
    mesh = terrain(5)
    walker = walker_of(mesh)
    point = point_of(mesh, 0, (1, 1, 1))
    for arguments, match in (
        ({}, "direction is needed: the start does not look anywhere"),
        ({"direction": (1, 0)}, "direction has to"),
        ({"direction": (1, 0, 0), "up": "x"}, "up has to"),
        ({"direction": (1, 0, 0), "length": "far"}, "length has to be a number"),
        ({"direction": (1, 0, 0), "mask": [True]}, "mask has to have the shape"),
        ({"direction": (1, 0, 0), "max_steps": -1}, "max_steps has to be a whole number"),
    ):
        with pytest.raises(ValueError, match=match):
            walker.walk(start=point, **{"length": 1.0, **arguments})
    starts = SurfacePoints(np.array([0.5]), None, np.full((1, 3), 1 / 3), None)
    with pytest.raises(ValueError, match="directions is needed"):
        walker.walk_batch(starts=starts, lengths=1)
    with pytest.raises(ValueError, match="row of whole numbers"):
        walker.walk_batch(starts=starts, lengths=1, directions=(1, 0, 0))
    with pytest.raises(ValueError, match=r"lengths has to have the shape \(1\)"):
        walker.walk_batch(
            starts=starts._replace(faces=np.array([1])), lengths=[1, 2], directions=(1, 0, 0)
        )
    with pytest.raises(ValueError, match="but only"):
        SurfaceWalker(
            vertices=mesh.vertices[:3],
            faces=mesh.faces,
            topology=Topology(faces=mesh.faces, vertex_count=len(mesh.vertices)),
        )
    fewer = Topology(faces=mesh.faces[:-1], vertex_count=len(mesh.vertices))
    moved = Topology(faces=mesh.faces[::-1], vertex_count=len(mesh.vertices))
    for topology in (fewer, moved):
        with pytest.raises(ValueError, match="shape|topology is not that of the faces"):
            SurfaceWalker(vertices=mesh.vertices, faces=mesh.faces, topology=topology)
