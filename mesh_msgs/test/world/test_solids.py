"""The parts of which maps with things on floors are made."""

import numpy as np
import pytest
from mesh_msgs.world import solids


def volume(part):
    """Of what a closed part is around; below 0 where its faces look inwards."""
    vertices, faces = part
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def area(part):
    """Of a part, seen from above; below 0 where its faces look down."""
    vertices, faces = part
    a, b, c = (vertices[faces[:, k], :2] for k in range(3))
    return np.cross(b - a, c - a).sum() / 2


@pytest.mark.parametrize("separate, count", [(False, 8), (True, 24)])
def test_a_box(separate, count):
    part = solids.box((1, 2, 3), (2, 4, 6), separate)
    assert len(part[0]) == count and len(part[1]) == 12
    assert volume(part) == pytest.approx(6) and volume(solids.flipped(part)) == pytest.approx(-6)
    turned = solids.turned(part, 0.7, 2, (5, 5, 5))
    assert volume(turned) == pytest.approx(6)
    np.testing.assert_allclose(turned[0][:, 2], part[0][:, 2])
    assert len(solids.welded(part)[0]) == 8 and len(solids.as_soup(part)[0]) == 36
    assert volume(solids.as_soup(part)) == pytest.approx(6)


def test_a_quarter_turn_is_to_the_left():
    point = np.array([[2.0, 1.0, 0.0]]), np.zeros((0, 3), int)
    np.testing.assert_allclose(solids.turned(point, np.pi / 2, 2, (1, 1, 0))[0], [[1, 2, 0]])


def test_floors_sheets_and_stairs():
    ground = solids.floor((0, 1), (4, 3), 0.5, level=2.0)
    assert len(ground[0]) == 9 * 5 and area(ground) == pytest.approx(8)
    assert (ground[0][:, 2] == 2).all()
    upright = solids.sheet((0, 0), (3, 4), 1.0, 2.0)
    assert area(upright) == 0 and np.ptp(upright[0], axis=0).tolist() == [3, 4, 1]
    steps = solids.stairs((1, 2, 3), 2.0, 0.3, 0.2, 5, 0.1)
    assert area(steps) == pytest.approx(5 * 0.3 * 2)
    assert np.ptp(steps[0], axis=0) == pytest.approx([1.5, 2, 1])
    np.testing.assert_allclose(steps[0].min(axis=0), [1, 2, 3])


def test_parts_joined_keep_their_faces():
    one, other = solids.box((0, 0, 0), (1, 1, 1)), solids.box((1, 0, 0), (2, 1, 1))
    both = solids.joined(one, other)
    assert len(both[0]) == 16 and volume(both) == pytest.approx(2)
    np.testing.assert_array_equal(both[0][both[1][12:]], other[0][other[1]])
    assert len(solids.welded(both)[0]) == 12
