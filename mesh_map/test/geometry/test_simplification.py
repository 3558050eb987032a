"""Simplification: fewer faces within an error, with borders, regions and manifoldness kept."""

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry import simplification
from mesh_map.geometry.components import face_areas
from mesh_map.geometry.normals import face_normals
from mesh_map.geometry.simplification import simplify
from mesh_map.geometry.topology import Topology
from mesh_map.spatial.spatial_index import SpatialIndex
from mesh_msgs import zoo
from meshes import small, soup, terrain

pytestmark = pytest.mark.skipif(
    not simplification._kernels._CAN_SIMPLIFY, reason="mesh_map was built without meshoptimizer"
)


def topology(mesh):
    return Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))


def borders(vertices, faces):
    """The places of both ends of each border edge."""
    found = Topology(faces=faces, vertex_count=len(vertices))
    ends = vertices[found.edges[found.border_edges]]
    return {tuple(sorted(map(tuple, pair))) for pair in ends.tolist()}


@small
@pytest.mark.parametrize("ratio", [0.5, 0.05])
def test_whatever_the_mesh_no_fault_is_made(mesh, ratio):
    before = topology(mesh)
    done = simplify(mesh.vertices, mesh.faces, ratio=ratio)
    if done.derived is None:
        return
    derived, after = done.derived, topology(done.derived)
    assert len(derived.faces) < len(mesh.faces)
    assert borders(derived.vertices, derived.faces) == borders(mesh.vertices, mesh.faces)
    for name in ("non_manifold_edges", "inconsistent_edges"):
        assert getattr(after, name).sum() <= getattr(before, name).sum(), name
    places = mesh.vertices[derived.vertex_parents[:, 0]]
    assert np.array_equal(derived.vertices, places) and (derived.vertex_weights == 1.0).all()
    # whatever belongs to the mesh is carried as it is
    assert np.array_equal(derived.vertex_values(mesh.vertices), derived.vertices)


@pytest.mark.parametrize("options", [{"max_error": 0.02}, {"max_error": 0.08}, {"ratio": 0.3}])
def test_rough_ground(options):
    mesh = terrain(60)
    done = simplify(mesh.vertices, mesh.faces, **options)
    derived = done.derived
    counts = topology(derived).counts()
    assert not counts["non_manifold_edges"] and not counts["non_manifold_vertices"]
    assert not counts["inconsistent_edges"] and not counts["duplicate_faces"]
    assert counts["components"] == 1
    # the error is kept, as looking at every vertex says
    distances = SpatialIndex(derived.vertices, derived.faces).closest_batch(points=mesh.vertices)
    assert np.isclose(distances.distances.max(), done.max_distance)
    assert done.max_distance <= options.get("max_error", 0.2)
    # no face is turned over
    own = face_normals(derived.vertices, derived.faces)[0]
    parents = face_normals(mesh.vertices, mesh.faces)[0][derived.face_parents]
    assert np.einsum("ij,ij->i", own, parents).min() >= 0.0
    if "ratio" in options:
        assert len(derived.faces) <= 0.31 * len(mesh.faces)
    again = simplify(mesh.vertices, mesh.faces, **options).derived
    assert np.array_equal(again.faces, derived.faces) and again.uuid == derived.uuid


def test_a_plane_needs_few_faces():
    mesh = zoo.grid(20, 2.0)
    done = simplify(mesh.vertices, mesh.faces, max_error=1e-4)
    assert len(done.derived.faces) <= 80 + 20  # the 80 vertices of the border stay
    assert np.isclose(face_areas(done.derived.vertices, done.derived.faces).sum(), 4.0)
    assert done.max_distance < 1e-6


def test_regions_keep_their_shape():
    mesh = terrain(40)
    middles = mesh.vertices[mesh.faces].mean(1)
    regions = (np.hypot(middles[:, 0] - 2.0, middles[:, 1] - 2.0) < 1.0).astype(int)
    regions += 2 * (middles[:, 0] > 2.0)
    derived = simplify(mesh.vertices, mesh.faces, ratio=0.2, regions=regions).derived
    of_faces = regions[derived.face_parents]
    for region in range(4):
        own = derived.faces[of_faces == region]
        assert borders(derived.vertices, own) == borders(
            mesh.vertices, mesh.faces[regions == region]
        )
        assert 0 < len(own) < 0.9 * np.count_nonzero(regions == region)
    assert not topology(derived).non_manifold_edges.any()


def test_copies_along_a_seam_stay_together():
    mesh = terrain(30)
    right = mesh.vertices[mesh.faces].mean(1)[:, 0] > 1.5
    seam = np.intersect1d(mesh.faces[right], mesh.faces[~right])
    number = np.arange(len(mesh.vertices))
    originals = np.concatenate([number, seam])
    number[seam] = len(number) + np.arange(len(seam))
    faces = np.where(right[:, None], number[mesh.faces], mesh.faces)
    vertices = mesh.vertices[originals]
    derived = simplify(vertices, faces, ratio=0.3, originals=originals).derived
    kept = originals[derived.vertex_parents[:, 0]]
    assert set(seam) <= set(kept[derived.vertex_parents[:, 0] < len(number)])
    whole = Topology(faces=kept[derived.faces], vertex_count=len(number))
    assert not whole.non_manifold_edges.any()
    outer = Topology(faces=mesh.faces, vertex_count=len(number))
    assert whole.border_edges.sum() == outer.border_edges.sum()


@pytest.mark.parametrize(
    "options,text",
    [
        ({}, "nothing to simplify to"),
        ({"max_error": -1.0}, "max_error"),
        ({"max_error": float("nan")}, "max_error"),
        ({"ratio": 0.0}, "ratio"),
        ({"ratio": 1.5}, "ratio"),
        ({"face_count": 0}, "face_count"),
    ],
)
def test_targets_out_of_range_are_refused(options, text):
    mesh = terrain(5)
    with pytest.raises(MeshMapError, match=text):
        simplify(mesh.vertices, mesh.faces, **options)


def test_other_arrays_are_refused():
    mesh = terrain(5)
    with pytest.raises(ValueError, match="regions"):
        simplify(mesh.vertices, mesh.faces, ratio=0.5, regions=[1, 2])
    with pytest.raises(ValueError, match="originals"):
        simplify(mesh.vertices, mesh.faces, ratio=0.5, originals=[1, 2])
    broken = soup(1)
    broken.vertices[2] = np.inf
    with pytest.raises(MeshMapError, match="no usable mesh"):
        simplify(broken.vertices, broken.faces, ratio=0.5)


def test_a_build_without_meshoptimizer_says_so(monkeypatch):
    class Without:
        _CAN_SIMPLIFY = False

    monkeypatch.setattr(simplification, "_kernels", Without)
    mesh = terrain(5)
    with pytest.raises(MeshMapError, match="built without meshoptimizer"):
        simplify(mesh.vertices, mesh.faces, ratio=0.5)
