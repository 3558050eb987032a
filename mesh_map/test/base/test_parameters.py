"""Parameters: types, limits, and a sentence for each value that is not used as it is."""

import pytest

from mesh_map.base.parameter import Parameter, read_parameters


SPEED = Parameter("speed", 1.5, 0.0, 10.0)
COUNT = Parameter("count", -1, -1, 1000)
FLAG = Parameter("flag", False)


def test_good_values_are_used_as_they_are():
    given = {"speed": 2, "flag": True, "stranger": 3}
    values, complaints = read_parameters((SPEED, COUNT, FLAG), given)
    assert values == {"speed": 2.0, "count": -1, "flag": True} and complaints == []
    assert type(values["speed"]) is float


@pytest.mark.parametrize(
    "given, value, words",
    [
        ({"speed": -1.0}, 0.0, "speed is -1.0, outside of [0.0, 10.0]: 0.0 is used"),
        ({"speed": 99}, 10.0, "10.0 is used"),
        ({"speed": "fast"}, 1.5, "speed is 'fast', but it has to be a number: the default 1.5"),
        ({"speed": float("nan")}, 1.5, "the default 1.5 is used"),
        ({"speed": None}, 1.5, "the default 1.5 is used"),
    ],
)
def test_other_values_are_replaced_and_named(given, value, words):
    values, complaints = read_parameters((SPEED, COUNT), given)
    assert values == {"speed": value, "count": -1}
    assert len(complaints) == 1 and words in complaints[0]


@pytest.mark.parametrize(
    "given, speed, words",
    [
        ({"speed": 3}, 3.0, None),
        ({"stranger": 3}, 2.5, None),
        ({"speed": 99}, 10.0, "10.0 is used"),
        ({"speed": "fast"}, 2.5, "it stays 2.5"),
        ({"speed": float("nan")}, 2.5, "it stays 2.5"),
    ],
)
def test_changed_parameters(given, speed, words):
    present = {"speed": 2.5, "count": 7}
    values, complaints = read_parameters((SPEED, COUNT), given, present)
    assert values == {"speed": speed, "count": 7} and present["speed"] == 2.5
    assert [words in complaint for complaint in complaints] == ([True] if words else [])
