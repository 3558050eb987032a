"""Meshes that are split along seams: what belongs to the parent is carried to them, and back."""

import numpy as np
import pytest

from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs.split_mesh import SplitMesh, copies_fault
from mesh_msgs.zoo import all_meshes

INF, NAN = float("inf"), float("nan")


def split(mesh, seed):
    """A mesh of the zoo in which corners took copies of their vertices at random."""
    rng = np.random.default_rng(seed)
    faces, count = np.array(mesh.faces, np.int64), len(mesh.vertices)
    key = faces * 3 + rng.integers(0, 3, faces.shape) * (rng.random(faces.shape) < 0.5)
    others = np.unique(key[key % 3 > 0])
    moved = np.where(key % 3 > 0, count + np.searchsorted(others, key), faces)
    vertices = np.concatenate([mesh.vertices, np.asarray(mesh.vertices)[others // 3]])
    return SplitMesh("s", "p", vertices, moved, others // 3)


@pytest.mark.parametrize("seed", range(3))
def test_it_is_a_derived_mesh_of_its_parent(seed):
    """Whatever the mesh: what the general class says of the same parents and weights."""
    seen = 0
    for mesh in all_meshes():
        if not len(mesh.faces):
            continue
        try:
            made = split(mesh, seed)
        except ValueError:  # no corner took a copy
            continue
        seen += len(made.originals)
        np.testing.assert_array_equal(made.parent_faces, mesh.faces)
        np.testing.assert_array_equal(made.parent_vertices, np.float32(mesh.vertices))
        general = DerivedMesh(
            *("s", "p", made.vertices, made.faces),
            face_parents=made.face_parents,
            vertex_parents=made.vertex_parents,
            vertex_weights=made.vertex_weights,
            parent_vertex_count=made.parent_vertex_count,
            parent_face_count=made.parent_face_count,
        )
        rng = np.random.default_rng(seed)
        values = rng.random(made.parent_vertex_count).astype(np.float32)
        values[rng.random(len(values)) < 0.1] = INF
        values[rng.random(len(values)) < 0.1] = NAN
        for parents in (values, np.uint8([[1, 2]]) * np.uint8(9 * values[:, None] > 3)):
            found = made.vertex_values(parents)
            assert found.dtype == parents.dtype
            np.testing.assert_array_equal(found, general.vertex_values(parents))
            np.testing.assert_array_equal(made.parent_vertex_values(found), parents)
        edited = made.vertex_values(values)
        edited[rng.random(len(edited)) < 0.3] = 0.5
        edited[rng.random(len(edited)) < 0.1] = NAN
        np.testing.assert_array_equal(
            made.parent_vertex_values(edited), general.parent_vertex_values(edited)
        )
        changed = np.flatnonzero(rng.random(made.parent_vertex_count) < 0.3)
        whole = np.isin(made.vertex_parents[:, 0], changed)
        found, rows = made.with_copies(changed)
        assert sorted(found.tolist()) == np.flatnonzero(whole).tolist()
        assert found[: len(changed)].tolist() == changed.tolist()
        assert np.array_equal(made.vertex_parents[found, 0], changed[rows])
    assert seen > 100


def test_what_is_closed_on_one_side_of_a_seam_is_closed():
    vertices = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0]])
    made = SplitMesh("s", "p", vertices, [[0, 1, 2], [0, 3, 4]], [1, 2])
    found = made.parent_vertex_values(np.float32([0, 1, INF, INF, 3]))
    assert found.tolist() == [0, INF, INF]
    found = made.parent_vertex_values(np.float32([0, 1, NAN, NAN, INF]))
    assert np.isnan(found).tolist() == [False, True, True]


def test_tables_that_do_not_fit_are_refused():
    vertices = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]])
    assert copies_fault(vertices, np.array([1])) is None
    for originals, words in (
        ([0], "copy 0 is not where vertex 0 is, one of the first 3 .1 such"),
        ([3], "copy 0 is one of vertex 3, which is not among the first 3"),
        ([-1], "copy 0 is one of vertex -1"),
        ([], r"\[0\] are not copies"),
        ([0, 0, 0, 0], r"\[4\] are not copies"),
        ([[1]], "are not copies"),
    ):
        with pytest.raises(ValueError, match=words):
            SplitMesh("s", "p", vertices, [[0, 1, 2]], np.array(originals))
