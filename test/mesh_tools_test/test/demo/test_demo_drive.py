"""What the demo says of its robot's drive."""
import numpy as np
import pytest


from mesh_tools_test.demo.driven import HEADER, SPACING, Driven, Track, table, turn_between


def test_a_track_has_the_length_of_the_way():
    track = Track()
    angles = np.linspace(0.0, np.pi, 5001)  # half a circle of 2 m, in steps of a millimeter
    moved = [track.add((2 * np.cos(a), 2 * np.sin(a), 0.0)) for a in angles]
    assert moved[0] and not moved[1]
    assert sum(moved) == len(track.positions) == pytest.approx(2 * np.pi / SPACING, rel=0.03)
    driven = Driven("SUCCESS", True, "", 6.0, track.positions, 10.0, 0.1, 0.2)
    assert driven.length == pytest.approx(2 * np.pi, abs=SPACING)


def test_a_robot_that_stands_still_has_not_driven():
    track = Track()
    assert track.positions.shape == (0, 3)
    assert [track.add((1.0, 2.0, 3.0)) for _ in range(3)] == [True, False, False]
    assert Driven("FAILURE", False, "", 6.0, track.positions, 1.0, 0.0, 0.0).length == 0.0


@pytest.mark.parametrize(
    "heading, other, degrees",
    [
        ((1, 0, 0), (1, 0, 0.5), 0),
        ((0, 1, 0), (1, 0, 0), 90),
        ((-1, -0.01, 0), (-1, 0.01, 0), 1.146),
        ((-1, 0, 0), (1, 0, 0), 180),
    ],
)
def test_headings_are_compared_as_seen_from_above(heading, other, degrees):
    assert np.degrees(turn_between(heading, other)) == pytest.approx(degrees, abs=1e-3)


def test_the_table():
    track = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [3.0, 4.0, 2.0]])
    driven = Driven("SUCCESS", True, "there", 6.5, track, 12.34, 0.0123, np.radians(4.56))
    assert table(driven) == [HEADER, ("SUCCESS", "6.50", "7.00", "12.3", "0.012", "4.6")]
    assert len(HEADER) == len(table(driven)[1])
