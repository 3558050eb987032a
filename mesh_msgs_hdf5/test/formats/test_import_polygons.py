"""Polygons that are not convex: each becomes triangles that cover it once and nothing else."""
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_writers import dae, image_bytes, obj, ply, xyz

from mesh_msgs_hdf5.formats.base.polygons import triangulate
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.model.errors import MapFileError

U = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]
HOLE = [(1, 1), (1, 3), (3, 3), (3, 1)]  # the other way round
CROSSING = "1 faces of more than three corners cross themselves"
BENT = "1 faces of more than three corners are not planar"


@pytest.fixture
def read(tmp_path):
    """Read the bytes of a file of that name: (mesh, report)."""

    def read(name, data):
        (tmp_path / name).write_bytes(data if isinstance(data, bytes) else data.encode())
        return read_mesh(tmp_path / name)

    return read


def flat(polygon):
    return np.column_stack([np.asarray(polygon, float), np.zeros(len(polygon))])


def shoelace(polygon):
    x, y = np.asarray(polygon, float).T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def plane(seed):
    """A rotation of determinant 1, and a place."""
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return turn * np.linalg.det(turn), rng.normal(size=3) * 10


def cut(points):
    """(faces, notes) of one polygon of these points (N, 3)."""
    report = ImportReport("a", "PLY")
    triangles = triangulate(
        np.array([len(points)]), np.arange(len(points)), np.asarray(points, float), report
    )
    assert triangles.faces.tolist() == triangles.places.tolist()
    return triangles.faces.astype(np.int64), report.notes


def areas(points, faces, normal):
    """(F,) signed, as seen along the normal."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a) @ normal / 2


def assert_cut_along(faces, count):
    """Triangles of the polygon's own corners in its sense of rotation, each edge of it once."""
    assert faces.shape == (count - 2, 3)
    steps = (np.roll(faces, -1, axis=1) - faces) % count
    assert (steps.sum(axis=1) == count).all()  # once around: the orientation is kept
    assert np.count_nonzero(steps == 1) == count


def assert_covered(polygon, seed=None):
    """The polygon (N, 2), counterclockwise and simple, is covered once; also in a random plane.

    Triangles in the polygon's sense of rotation add up to how often it goes round a point, which
    is once or not at all: so they neither overlap nor lie outside if none is turned over.
    """
    turn, place = (np.eye(3), np.zeros(3)) if seed is None else plane(seed)
    points = flat(polygon) @ turn.T + place
    faces, notes = cut(points)
    assert_cut_along(faces, len(points))
    found = areas(points, faces, turn[:, 2])
    total = shoelace(polygon)
    assert found.min() >= -1e-12 * total
    assert np.abs(found).sum() == pytest.approx(total, rel=1e-9)
    assert not any("cross themselves" in note or "planar" in note for note in notes)
    return faces


def star(radii, angles):
    angles = np.sort(angles)
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])


def spiral(corners):
    turns = np.linspace(0.5, 40 * np.pi, corners // 2)
    way = np.column_stack([np.cos(turns), np.sin(turns)])
    return np.concatenate([way * turns[:, None], (way * (turns + 2)[:, None])[::-1]])[::-1]


def area(mesh):
    """(signed, absolute): both are the same for a sound surface in a plane."""
    corners = mesh.vertices[mesh.faces].astype(float)
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    return np.linalg.norm(crosses.sum(axis=0)), np.linalg.norm(crosses, axis=1).sum()


@pytest.mark.parametrize("name", ["a.ply", "a.obj", "a.dae"])
def test_the_notch_of_a_u_is_no_floor(read, name):
    polygons = [range(8)]
    data = {
        "a.ply": lambda: ply(xyz(flat(U)), polygons),
        "a.obj": lambda: obj(flat(U), polygons),
        "a.dae": lambda: dae(flat(U), polygons),
    }[name]()
    mesh, report = read(name, data)
    assert len(mesh.faces) == 6
    assert area(mesh) == pytest.approx((7, 7))
    if name != "a.dae":  # which assimp cuts
        assert report.notes == [
            "1 faces of more than three corners were cut into triangles "
            "(fans, but for 1 concave ones)"
        ]


@settings(max_examples=300)
@given(
    radii=st.lists(st.floats(0.05, 1), min_size=4, max_size=60),
    seed=st.integers(0, 2**32 - 1),
)
def test_random_stars_in_random_planes(radii, seed):
    rng = np.random.default_rng(seed)
    n = len(radii)
    angles = (np.arange(n) + rng.random(n) * 0.9) / n * 2 * np.pi
    assert_covered(star(np.array(radii), angles), seed)


def untangled(points):
    """A simple polygon through random points: crossing edges are exchanged until none cross."""
    order = list(range(len(points)))

    def crossing(i, j):
        a, b = points[order[i]], points[order[i + 1]]
        c, d = points[order[j]], points[order[(j + 1) % len(order)]]

        def left(p, q, r):
            return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) > 0

        return left(a, b, c) != left(a, b, d) and left(c, d, a) != left(c, d, b)

    again = True
    while again:
        again = False
        for i in range(len(order) - 1):
            for j in range(i + 2, len(order) - (i == 0)):
                if crossing(i, j):
                    order[i + 1 : j + 1] = order[i + 1 : j + 1][::-1]
                    again = True
    found = points[order]
    return found if shoelace(found) > 0 else found[::-1]


@settings(max_examples=150)
@given(count=st.integers(4, 40), seed=st.integers(0, 2**32 - 1))
def test_random_simple_polygons_in_random_planes(count, seed):
    rng = np.random.default_rng(seed)
    assert_covered(untangled(rng.random((count, 2))), seed)


def inside(points, polygon):
    """(P,) how often the polygon goes around each point."""
    around = np.zeros(len(points), int)
    for p, q in zip(polygon, np.roll(polygon, -1, axis=0)):
        left = (q[0] - p[0]) * (points[:, 1] - p[1]) - (q[1] - p[1]) * (points[:, 0] - p[0])
        around += ((p[1] <= points[:, 1]) & (q[1] > points[:, 1]) & (left > 0)).astype(int)
        around -= ((p[1] > points[:, 1]) & (q[1] <= points[:, 1]) & (left < 0)).astype(int)
    return around


@pytest.mark.parametrize("seed", range(20))
def test_points_are_in_one_triangle_or_outside(seed):
    rng = np.random.default_rng(seed)
    polygon = untangled(rng.random((30, 2)))
    faces = assert_covered(polygon)
    points = rng.random((2000, 2))
    found = sum(inside(points, polygon[face]) for face in faces)
    assert np.array_equal(found, inside(points, polygon))


@pytest.mark.parametrize(
    "polygon",
    [
        SQUARE + SQUARE[:1] + HOLE + HOLE[:1],  # a bridge from corner to corner
        [(0, 0), (4, 0), (4, 4), (0, 4), (0, 2), (1, 2)] + HOLE[1:] + HOLE[:1] + [(1, 2), (0, 2)],
        # two holes
        [(0, 0), (9, 0), (9, 4), (0, 4), (0, 0)]
        + HOLE
        + HOLE[:1]
        + [(0, 0), (6, 1), (6, 3), (8, 3), (8, 1), (6, 1)],
        # a hole that touches the outline in a corner
        [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 2), (2, 2), (2, 1)],
        # corners that come twice, and corners on straight lines
        [p for p in U for _ in range(3)],
        [(0, 0), (1, 0), (2, 0), (4, 0), (4, 2), (4, 4), (2, 4), (2, 2), (1, 2), (0, 2), (0, 1)],
        # there and back again: a spike outside, and one inside
        SQUARE[:2] + [(6, -2)] + SQUARE[1:],
        SQUARE + [(0, 0), (2, 1), (0, 0)],
        SQUARE[:3] + [(2, 4), (2, 2), (2, 4)] + SQUARE[3:],
    ],
)
@pytest.mark.parametrize("shift", [0, 1, 2, 3, 5])
def test_bridges_holes_and_corners_that_come_twice(polygon, shift):
    assert_covered(polygon[shift:] + polygon[:shift])


@pytest.mark.parametrize("count", [1000, 10000])
def test_large_polygons(count):
    assert_covered(spiral(count))
    rng = np.random.default_rng(count)
    assert_covered(star(1 + rng.random(count), rng.random(count) * 2 * np.pi), 3)
    comb = [(i, 9 * (i % 2)) for i in range(count - 1)] + [(count - 1, -1), (0, -1)]
    assert_covered(comb[::-1], 4)


@settings(max_examples=400)
@given(
    st.lists(
        st.tuples(*[st.sampled_from([0.0, 1.0, 2.0, 3.0, np.nan, 1e30])] * 3),
        min_size=4,
        max_size=24,
    )
)
def test_any_polygon_becomes_triangles(points):
    """Crossing, of no area, in no plane, not finite."""
    faces, _ = cut(points)
    assert_cut_along(faces, len(points))


@settings(max_examples=100)
@given(st.data())
def test_what_crosses_itself_is_named_and_what_does_not_is_not(data):
    """On a grid, against every pair of edges looked at one by one."""
    count = data.draw(st.integers(4, 9))
    cells = data.draw(st.permutations(range(25)))[:count]
    points = np.array([(c % 5, c // 5) for c in cells])

    def side(p, q, r):
        return np.sign((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    crossing = False
    for i in range(count):
        for j in range(i):
            a, b, c, d = (points[k % count] for k in (i, i + 1, j, j + 1))
            crossing |= side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
    _, notes = cut(flat(points))
    named = any(note.startswith(CROSSING) for note in notes)
    assert named or not crossing
    if not named:
        faces, _ = cut(flat(points))
        signed = areas(flat(points), faces, np.array([0, 0, 1]))
        assert (signed * np.sign(shoelace(points)) >= 0).all()


@pytest.mark.parametrize("name", ["a.ply", "a.obj"])
def test_crossing_and_bent_polygons_are_named_and_kept(read, name):
    bow_tie, bent = [(0, 0, 0), (2, 2, 0), (2, 0, 0), (0, 1, 0)], flat(SQUARE)
    bent[2, 2] = 1
    vertices = np.concatenate([flat(U)[:3], bow_tie, bent])
    polygons = [(0, 1, 2), (3, 4, 5, 6), (7, 8, 9, 10)]
    write = {"a.ply": lambda v, p: ply(xyz(v), p), "a.obj": obj}[name]
    mesh, report = read(name, write(vertices, polygons))
    assert len(mesh.faces) == 5
    told = "%s, and were cut %s, first face %d"
    assert report.notes == [
        "2 faces of more than three corners were cut into triangles (fans)",
        told % (CROSSING + ", have no area or too many corners", "as well as can be", 1),
        told % (BENT, "as seen along their normal", 2),
    ]


def test_a_quad_is_cut_at_the_diagonal_within_it(read):
    dart = [(0, 2), (2, 1), (0, 4), (-2, 1)]
    for shift in range(4):
        polygon = dart[shift:] + dart[:shift]
        mesh, _ = read("a.obj", obj(flat(polygon), [range(4)]))
        assert area(mesh) == pytest.approx((abs(shoelace(dart)),) * 2)


def test_many_polygons_are_cut_as_each_alone():
    rng = np.random.default_rng(5)
    parts = [untangled(rng.random((n, 2))) for n in rng.integers(3, 12, 300)]
    counts = np.array([len(part) for part in parts])
    points = np.concatenate([flat(part) @ plane(i)[0].T for i, part in enumerate(parts)])
    starts = np.cumsum(counts) - counts
    triangles = triangulate(counts, np.arange(len(points)), points, ImportReport("a", "PLY"))
    alone = [
        cut(points[start : start + n])[0] + start if n > 3 else np.arange(start, start + 3)[None]
        for n, start in zip(counts, starts)
    ]
    assert np.array_equal(triangles.faces, np.concatenate(alone))
    assert np.array_equal(triangles.polygons, np.repeat(np.arange(300), counts - 2))


def test_what_belongs_to_faces_and_corners_follows(tmp_path, read):
    """Each corner's texture coordinates are its position: they are so in the triangles too."""
    points = np.concatenate([flat(U), flat(U) + [5, 0, 0], [[9, 9, 0], [10, 9, 0], [9, 10, 0]]])
    polygons = [range(8), range(8, 16), range(16, 19)]
    kinds = [("kind", "i", [7, 8, 9])]
    mesh, _ = read("a.ply", ply(xyz(points), polygons, after=kinds))
    assert mesh.face_attributes["kind"].tolist() == [7] * 6 + [8] * 6 + [9]
    for name in ("red", "blue"):
        (tmp_path / (name + ".png")).write_bytes(image_bytes(np.zeros((2, 2, 3))))
    (tmp_path / "a.mtl").write_text(
        "newmtl r\nmap_Kd red.png\nKd 1 0 0\nnewmtl b\nmap_Kd blue.png\nKd 0 0 1\n"
    )
    order = np.random.default_rng(2).permutation(len(points))  # so that vt has numbers of its own
    number = np.argsort(order) + 1
    text = ["mtllib a.mtl"] + ["v %g %g %g" % tuple(p) for p in points]
    text += ["vt %g %g" % tuple(points[i][:2]) for i in order]
    text += ["vn %g 0 1" % points[i][0] for i in order]
    for polygon, material in zip(polygons, "rbr"):
        corners = " ".join("%d/%d/%d" % (i + 1, number[i], number[i]) for i in polygon)
        text += ["usemtl " + material, "f " + corners]
    mesh, _ = read("a.obj", "\n".join(text) + "\n")
    assert np.array_equal(mesh.texture_coordinates, points[:, :2].astype(np.float32))
    assert np.array_equal(mesh.vertex_normals[:, 0], points[:, 0].astype(np.float32))
    assert mesh.materials.face_materials.tolist() == [0] * 6 + [1] * 6 + [0]
    assert area(mesh) == pytest.approx((14.5, 14.5))


def test_holes_of_collada_are_refused_with_the_way_out(read):
    text = dae(flat(SQUARE + HOLE), [range(4)])
    start, end = text.index("<polylist"), text.index("</polylist>") + len("</polylist>")
    polygons = (
        '<polygons count="1"><input semantic="VERTEX" source="#v" offset="0"/>'
        "<ph><p>0 1 2 3</p><h>4 5 6 7</h></ph></polygons>"
    )
    with pytest.raises(MapFileError, match="polygons with holes.*as triangles"):
        read("a.dae", text[:start] + polygons + text[end:])
