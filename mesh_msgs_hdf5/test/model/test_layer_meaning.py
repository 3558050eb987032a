"""What the values of stored layers mean, also in files that lie."""
import math

import numpy as np
import pytest

from mesh_msgs_hdf5.model.layer_meaning import (
    ABOVE,
    AT_LEAST,
    KEY,
    NONE,
    OTHER,
    LayerMeaning,
    computed_with,
    meaning_of,
)

COSTS = np.float32([0, 0.3, np.nextafter(np.float32(0.3), np.float32(1)), np.inf, np.nan, -1])


@pytest.mark.parametrize(
    "comparison, threshold, lethal, text",
    [
        (NONE, math.nan, [3], ""),
        (ABOVE, 0.3, [2, 3], "above 0.3 rad"),  # compared as float32
        (AT_LEAST, 0.3, [1, 2, 3], "from 0.3 rad"),
        (OTHER, math.nan, [3], "not by their values alone"),
    ],
)
def test_it_comes_back_as_it_was_stored(comparison, threshold, lethal, text):
    meaning = LayerMeaning("mesh_layers/X", "rad", comparison, threshold).counted(COSTS)
    assert np.flatnonzero(meaning.lethal_in(COSTS)).tolist() == lethal
    assert (meaning.lethal, meaning.unknown) == (len(lethal), 1)
    assert meaning.rule_text() == text
    parameters = {"type": "mesh_layers/X", "radius": 0.3, KEY: meaning.stored()}
    found = meaning_of(parameters)
    assert repr(found) == repr(meaning)  # NaN is not equal to itself
    assert computed_with(parameters) == {"type": "mesh_layers/X", "radius": 0.3}


def test_of_a_rule_of_its_own_the_stored_number_counts():
    assert LayerMeaning("", "", OTHER, math.nan, 40).count_lethal(COSTS) == 40
    assert LayerMeaning("", "", ABOVE, 0.0, 40).count_lethal(COSTS) == 3


@pytest.mark.parametrize(
    "value",
    [
        None,
        [],
        "above",
        {},
        {"comparison": "below", "threshold": 1},
        {"comparison": ["above"], "threshold": 1},
        {"comparison": "above"},
        {"comparison": "above", "threshold": "0.3"},
        {"comparison": "above", "threshold": True},
        {"comparison": "above", "threshold": math.inf},
        {"comparison": "above", "threshold": math.nan},
        {"comparison": "at_least", "threshold": 1e60},
        {"comparison": "at_least", "threshold": 10**400},
    ],
)
def test_what_says_nothing_usable_says_nothing(value):
    assert meaning_of({KEY: value}) is None


def test_odd_members_are_left_out():
    value = {"comparison": "none", "unit": "a\nb", "lethal": -1, "unknown": 1.5, "threshold": 3}
    meaning = meaning_of({KEY: value, "type": 7})
    assert (meaning.layer_type, meaning.unit) == ("", "")
    assert (meaning.lethal, meaning.unknown) == (None, None) and math.isnan(meaning.threshold)
    long = meaning_of({KEY: {"comparison": "none", "unit": "x" * 5000}})
    assert len(long.unit) == 100
