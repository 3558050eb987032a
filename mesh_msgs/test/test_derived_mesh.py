"""Derived meshes: what belongs to the parent is carried to them, and back."""

import uuid

import numpy as np
import pytest

from mesh_msgs.derived_mesh import DerivedMesh, derived_uuid

# Two triangles over a square, the first one halved at the middle of the diagonal and the second.
VERTICES = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 0]], np.float32)
FACES = np.array([[0, 1, 4], [4, 1, 2], [0, 4, 3], [4, 2, 3]])
NAN, INF = float("nan"), float("inf")


def halved(**others):
    given = {
        "face_parents": [0, 0, 1, 1],
        "vertex_parents": [[0, 0], [1, 1], [2, 2], [3, 3], [0, 2]],
        "vertex_weights": [[1, 0], [1, 0], [1, 0], [1, 0], [0.25, 0.75]],
        "parent_vertex_count": 4,
        "parent_face_count": 2,
        **others,
    }
    return DerivedMesh("d", "p", VERTICES, FACES, **given)


def test_uuid_follows_from_parent_kind_and_parameters():
    made = derived_uuid("p", "refinement", {"a": 1, "b": 0.5})
    assert made == derived_uuid("p", "refinement", {"b": 0.5, "a": 1})
    assert uuid.UUID(made).version == 5
    others = [("q", "refinement", {"a": 1, "b": 0.5}), ("p", "seams", {"a": 1, "b": 0.5})]
    others.append(("p", "refinement", {"a": 1, "b": 0.25}))
    assert len({made, *(derived_uuid(*other) for other in others)}) == 4


@pytest.mark.parametrize(
    "values, middle",
    [
        ([0.0, 5.0, 4.0, 5.0], 3.0),
        ([0.0, 5.0, INF, 5.0], INF),
        ([INF, 5.0, NAN, 5.0], INF),
        ([0.0, 5.0, NAN, 5.0], NAN),
        ([0.0, INF, 4.0, NAN], 3.0),
    ],
)
def test_costs_are_interpolated_and_closed_where_a_corner_is(values, middle):
    found = halved().vertex_values(np.array(values, np.float32))
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, np.float32(values + [middle]))


def test_colors_coordinates_and_booleans_follow():
    made = halved()
    colors = np.array([[0, 255, 10], [9, 9, 9], [255, 0, 11], [7, 7, 7]], np.uint8)
    found = made.vertex_values(colors)
    assert found.dtype == np.uint8
    assert found.tolist() == colors.tolist() + [[191, 64, 11]]
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    assert made.vertex_values(uv)[4].tolist() == [0.75, 0.75]
    assert made.vertex_values(np.array([True, False, False, False])).tolist()[4] is True
    assert made.face_values(np.array([[1, 2], [3, 4]])).tolist() == [[1, 2]] * 2 + [[3, 4]] * 2


def test_vertices_of_the_parent_get_what_is_at_their_place():
    made = halved()
    values = np.array([0.5, INF, NAN, 2.0, 9.0], np.float32)
    np.testing.assert_array_equal(made.parent_vertex_values(values), values[:4])
    seam = halved(
        vertex_parents=[[0, 0], [1, 1], [1, 1], [3, 3], [0, 2]],
        vertex_weights=[[1, 0], [1, 0], [0, 1], [1, 0], [0.5, 0.5]],
    )
    found = seam.parent_vertex_values(np.float32([0.5, 1.0, 3.0, 2.0, 9.0]))
    np.testing.assert_array_equal(found, np.float32([0.5, 3.0, NAN, 2.0]))
    found = seam.parent_vertex_values(np.float32([0.5, NAN, 3.0, 2.0, 9.0]))
    np.testing.assert_array_equal(found, np.float32([0.5, NAN, NAN, 2.0]))
    assert seam.parent_vertex_values(np.array([4, 5, 6, 7, 8])).tolist() == [4, 6, 0, 7]


def test_faces_of_the_parent_get_what_most_of_their_area_has():
    made = DerivedMesh(
        "d",
        "p",
        np.array([[0, 0, 0], [4, 0, 0], [0, 1, 0], [1, 0, 0]], np.float32),
        [[0, 3, 2], [3, 1, 2]],
        face_parents=[1, 1],
        vertex_parents=[[0], [1], [2], [0]],
        vertex_weights=np.ones((4, 1)),
        parent_vertex_count=3,
        parent_face_count=3,
    )
    assert made.parent_face_values(np.array([5, 2])).tolist() == [0, 2, 0]
    assert made.parent_face_values(np.array([True, False])).tolist() == [False] * 3
    assert made.parent_face_values(np.array([False, True])).tolist() == [False, True, False]
    for values, mean in (((1.0, 5.0), 4.0), ((INF, NAN), INF), ((1.0, NAN), NAN)):
        found = made.parent_face_values(np.float32(values))
        np.testing.assert_array_equal(found, np.float32([NAN, mean, NAN]))


@pytest.mark.parametrize(
    "before, faces, after",
    [
        ([], [], []),
        ([], [2], [1]),
        ([], [0, 3], [0, 1]),
        ([0], [0, 1], [0]),
        ([0], [0], []),
        ([0], [0, 1, 3], [0, 1]),
        ([0, 1], [0, 2, 3], [1]),
        ([1], [0], [0]),
    ],
)
def test_an_edit_of_a_part_is_one_of_its_parent(before, faces, after):
    made = halved()
    found = made.edited_parent_faces(np.array(faces, int), np.array(before, int))
    assert found.dtype == np.uint32 and found.tolist() == after
    shown = made.faces_of(found)
    assert made.edited_parent_faces(shown, found).tolist() == after
    assert set(made.face_parents[shown].tolist()) == set(after)


@pytest.mark.parametrize(
    "wrong, text",
    [
        ({"face_parents": [0, 0, 1, 2]}, "face 2 does not exist (number 3; 1 such in all)"),
        ({"face_parents": [0, 0, 1]}, "(3,)"),
        ({"vertex_parents": [[0, 0], [1, 1], [2, 4], [3, 3], [0, 2]]}, "vertex 4 does not exist"),
        ({"vertex_weights": [[1, 0]] * 4 + [[0.5, 0.4]]}, "the weights of vertex 4 are"),
        ({"vertex_weights": [[1, 0]] * 4 + [[1.5, -0.5]]}, "the weights of vertex 4 are"),
        ({"vertex_weights": [[1, 0]] * 4 + [[NAN, 1.0]]}, "the weights of vertex 4 are"),
        ({"vertex_weights": np.ones((5, 3))}, "weights of the shape (5, 3)"),
    ],
)
def test_what_cannot_be_is_refused(wrong, text):
    with pytest.raises(ValueError) as caught:
        halved(**wrong)
    assert text in str(caught.value)


def test_values_of_another_mesh_are_refused():
    made = halved()
    for carry, count in (
        (made.vertex_values, 5),
        (made.face_values, 4),
        (made.parent_vertex_values, 4),
        (made.parent_face_values, 2),
    ):
        with pytest.raises(ValueError, match="are not those of"):
            carry(np.zeros(count))
    with pytest.raises(ValueError, match="face 2 does not exist"):
        made.faces_of([1, 2])
    with pytest.raises(ValueError, match="face 4 does not exist"):
        made.edited_parent_faces([4])


def test_arrays_are_read_only():
    made = halved()
    for array in (made.vertices, made.faces, made.face_parents, made.vertex_weights):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
