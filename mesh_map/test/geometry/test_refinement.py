"""Refined meshes: the surface of the parent, with edges that are short enough."""

import numpy as np
import pytest
from mesh_msgs import zoo
from mesh_msgs.world.solids import box, floor, joined, turned

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.refinement import least_faces, refine

MESHES = [mesh for mesh in zoo.all_meshes() if len(mesh.faces)]
IDS = [mesh.name for mesh in MESHES]


def lengths(vertices, faces):
    points = vertices.astype(np.float64)[faces]
    return np.linalg.norm(points[:, [1, 2, 0]] - points, axis=2)


def areas(vertices, faces):
    a, b, c = vertices.astype(np.float64)[faces].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def angles(vertices, faces):
    sides = lengths(vertices, faces)
    a, b, c = sides.T
    with np.errstate(divide="ignore", invalid="ignore"):
        cosines = [(y * y + z * z - x * x) / (2 * y * z) for x, y, z in ((a, b, c), (b, c, a))]
    first, second = np.arccos(np.clip(cosines, -1, 1))
    return np.stack([first, second, np.pi - first - second], 1)


def edge_counts(faces):
    """Edge -> how many faces it has."""
    counts = {}
    for face in faces.tolist():
        for edge in {frozenset((face[i], face[i - 1])) for i in range(3)}:
            counts[edge] = counts.get(edge, 0) + 1
    return counts


def length_for(mesh):
    steps = float(np.spacing(np.abs(mesh.vertices).max()))
    return max(0.3 * float(np.median(lengths(mesh.vertices, mesh.faces).max(1))), 16 * steps)


def large_floor(size):
    vertices, faces = floor((0.0, 0.0), (size, size), size)
    return vertices.astype(np.float32), faces


@pytest.mark.parametrize("mesh", MESHES, ids=IDS)
def test_edges_are_short_and_the_surface_is_that_of_the_parent(mesh):
    limit = length_for(mesh)
    made = refine(mesh.vertices, mesh.faces, limit)
    assert lengths(made.vertices, made.faces).max() <= limit
    count = len(mesh.vertices)
    assert made.vertices[:count].tobytes() == mesh.vertices.tobytes()
    weights, parents = made.vertex_weights, made.vertex_parents
    exact = np.einsum("ij,ijk->ik", weights, mesh.vertices.astype(np.float64)[parents])
    np.testing.assert_array_equal(made.vertices, exact.astype(np.float32))
    assert (np.diff(made.face_parents.astype(np.int64)) >= 0).all()
    whole = areas(mesh.vertices, mesh.faces)
    parts = np.bincount(made.face_parents, areas(made.vertices, made.faces), len(mesh.faces))
    rounding = np.abs(mesh.vertices).max() * 1e-6 * limit * np.bincount(made.face_parents)
    assert (np.abs(parts - whole) <= 1e-6 * whole + 10 * rounding).all()
    # Each corner of a part lies in its parent.
    of_face = mesh.faces[made.face_parents]
    for corner in made.faces.T:
        used = weights[corner] > 0
        inside = (parents[corner][:, :, None] == of_face[:, None, :]).any(2)
        assert inside[used].all()


@pytest.mark.parametrize("mesh", MESHES, ids=IDS)
def test_no_edge_has_a_t_junction(mesh):
    """Inside a face, edges have two faces; on an edge of the parent as many as that has."""
    made = refine(mesh.vertices, mesh.faces, length_for(mesh))
    before = edge_counts(mesh.faces)
    support = [
        frozenset(parents[weights > 0].tolist())
        for parents, weights in zip(made.vertex_parents, made.vertex_weights)
    ]
    seen = set()
    for edge, count in edge_counts(made.faces).items():
        parents = frozenset().union(*(support[vertex] for vertex in edge))
        if len(parents) == 2 and parents in before:
            assert count == before[parents], edge
            seen.add(parents)
        elif len(parents) == 3:
            faces = np.flatnonzero((np.sort(mesh.faces, 1) == sorted(parents)).all(1))
            assert count == 2 * len(faces), edge
    assert seen == {edge for edge in before if len(edge) == 2}


@pytest.mark.parametrize("mesh", MESHES, ids=IDS)
def test_parts_are_turned_as_their_parents_and_not_much_thinner(mesh):
    made = refine(mesh.vertices, mesh.faces, length_for(mesh))

    def normals(vertices, faces):
        a, b, c = vertices.astype(np.float64)[faces].transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    smallest = angles(mesh.vertices, mesh.faces).min(1)
    good = (smallest > 0.1) & (np.abs(mesh.vertices).max() < 1e4)
    good = np.broadcast_to(good, smallest.shape)[made.face_parents]
    ours, theirs = (
        normals(made.vertices, made.faces)[good],
        normals(mesh.vertices, mesh.faces)[made.face_parents][good],
    )
    cosines = (ours * theirs).sum(1) / np.linalg.norm(ours, axis=1)
    assert (cosines >= (1 - 1e-4) * np.linalg.norm(theirs, axis=1)).all()
    found = angles(made.vertices, made.faces).min(1)
    assert (found >= 0.5 * smallest[made.face_parents] - 1e-3)[good].all()


def test_flat_faces_stay_flat_and_straight_edges_straight():
    vertices, faces = floor((-3.3, 1.9), (34.1, 23.7), 50.0, level=1.1)
    made = refine(vertices, faces, 0.4)
    assert set(made.vertices[:, 2].tolist()) == {np.float32(1.1)}
    x, y = made.vertices[:, 0], made.vertices[:, 1]
    outline = (x == x.min()) | (x == x.max()) | (y == y.min()) | (y == y.max())
    border = {edge for edge, count in edge_counts(made.faces).items() if count == 1}
    assert len(border) == 2 * (128 + 64)
    assert outline[sorted(set().union(*border))].all()


def test_copies_of_an_edge_are_halved_at_the_same_places():
    """A box turned in space, whole and as twelve separate faces."""
    vertices, faces = turned(box((1.3, -2.0, 0.7), (8.4, 1.3, 3.6)), 0.5, 0, (0.0, 0.0, 0.0))
    vertices = vertices.astype(np.float32)
    whole = refine(vertices, faces, 0.5)
    apart = refine(vertices[faces].reshape(-1, 3), np.arange(36).reshape(12, 3), 0.5)
    assert len(apart.vertices) > len(whole.vertices)

    def triangles(made):
        return {frozenset(map(tuple, face)) for face in made.vertices[made.faces].tolist()}

    assert triangles(apart) == triangles(whole)
    assert len(apart.faces) == len(whole.faces) == len(triangles(whole))


def test_the_result_and_its_uuid_depend_on_the_arguments_alone():
    mesh = joined(floor((0.0, 0.0), (9.0, 7.0), 9.0), box((2.0, 3.0, 0.0), (3.0, 4.5, 1.0)))
    one, other = (refine(*mesh, 0.5, parent_uuid="of a map") for _ in range(2))
    assert one.uuid == other.uuid == "82e63f2d-ea01-5844-b511-eb94880fda27"
    assert one.vertices.tobytes() == other.vertices.tobytes()
    assert one.faces.tobytes() == other.faces.tobytes()
    finer = refine(*mesh, 0.25, parent_uuid="of a map")
    stranger = refine(*mesh, 0.5, parent_uuid="of another one")
    assert len({one.uuid, finer.uuid, stranger.uuid}) == 3
    assert one.parent_uuid == "of a map"


def test_nothing_is_made_where_edges_are_short():
    mesh = zoo.grid(cells=4, size=4.0)
    assert refine(mesh.vertices, mesh.faces, 1.5) is None
    longest = float(lengths(mesh.vertices, mesh.faces).max())
    assert refine(mesh.vertices, mesh.faces, longest) is None
    assert refine(mesh.vertices, mesh.faces, np.nextafter(longest, 0.0)) is not None


def test_only_what_is_too_long_is_halved_and_its_neighbors():
    """One large face beside a fine grid does not refine the grid."""
    grid = zoo.grid(cells=10, size=1.0)
    far = np.array([[5, 0, 0], [9, 0, 0], [5, 4, 0]], np.float32)
    vertices = np.concatenate([grid.vertices, far])
    faces = np.concatenate([grid.faces, [[len(grid.vertices) + i for i in range(3)]]])
    made = refine(vertices, faces, 0.5)
    assert (np.bincount(made.face_parents)[:-1] == 1).all()
    assert np.bincount(made.face_parents)[-1] == 128


def test_long_thin_faces_become_few():
    """As of window frames: 20 m long and 1 mm wide; as many faces as their length needs."""
    vertices = np.array([[0, 0, 0], [20, 0, 0], [20, 0.001, 0], [0, 0.001, 0]], np.float32)
    made = refine(vertices, np.array([[0, 1, 2], [0, 2, 3]]), 0.25)
    assert lengths(made.vertices, made.faces).max() <= 0.25
    assert np.bincount(made.face_parents).tolist() == [2 * 128 - 1] * 2


def test_too_many_faces_are_refused_with_their_number():
    vertices, faces = large_floor(50.0)
    with pytest.raises(MeshMapError) as caught:
        refine(vertices, faces, 0.01, face_limit=100_000)
    least = least_faces(vertices, faces, 0.01)
    assert least >= 2 * 50.0 * 50.0 / 0.01**2
    text = str(caught.value)
    assert f"max_edge_length 0.01 m makes at least {least:,} faces of 2, more than 100,000" in text
    longer = float(text.split("(")[1].split(" m would do")[0])
    assert len(refine(vertices, faces, longer, face_limit=100_000).faces) > 10_000


@pytest.mark.parametrize("seed", range(12))
def test_the_length_that_is_said_to_do_does(seed):
    """Also for soups of odd faces, where its two digits would be rounded down."""
    random = np.random.default_rng(seed)
    vertices = random.normal(size=(60, 3)) * random.uniform(0.1, 20, 3)
    faces = np.arange(60).reshape(20, 3)[: random.integers(3, 20)]
    with pytest.raises(MeshMapError) as caught:
        refine(np.float32(vertices), faces, 0.01, face_limit=5_000)
    longer = float(str(caught.value).split("(")[1].split(" m would do")[0])
    assert len(refine(np.float32(vertices), faces, longer, face_limit=5_000).faces) <= 5_000


def test_what_is_no_mesh_is_refused():
    vertices, faces = large_floor(5.0)
    with pytest.raises(MeshMapError, match="no usable mesh: .*4"):
        refine(vertices, [[0, 1, 4]], 1.0)
    vertices[2, 1] = np.nan
    with pytest.raises(MeshMapError, match="no usable mesh: .*vertex 2"):
        refine(vertices, faces, 1.0)


@pytest.mark.parametrize("length", [0.9, 1.0, 2.0, 3.7])
def test_the_least_number_of_faces_is_not_more_than_there_are(length):
    vertices, faces = large_floor(50.0)
    count = len(refine(vertices, faces, length).faces)
    assert least_faces(vertices, faces, length) <= count
    with pytest.raises(MeshMapError, match="more than"):
        refine(vertices, faces, length, face_limit=count - 1)
    assert len(refine(vertices, faces, length, face_limit=count).faces) == count


def test_no_refinement_beyond_float32():
    vertices, faces = large_floor(8.0)
    with pytest.raises(MeshMapError, match=r"multiples of 0\.062 m"):
        refine(vertices + np.float32(1e6), faces, 0.25)


@pytest.mark.parametrize("length", [0.0, -1.0, float("nan")])
def test_lengths_that_are_none(length):
    with pytest.raises(MeshMapError, match="has to be above 0"):
        refine(*large_floor(8.0), length)
