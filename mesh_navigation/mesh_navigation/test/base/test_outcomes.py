"""Outcomes: their numbers, and what follows from them."""

import pytest

from mesh_navigation.base.outcomes import (
    ExePathOutcome,
    GetPathOutcome,
    MoveBaseOutcome,
    RecoveryOutcome,
    is_success,
    may_change_by_itself,
)


@pytest.mark.parametrize(
    "outcomes, first, last, count",
    [
        (GetPathOutcome, {"FAILURE": 50, "CANCELED": 51}, {"MAP_ERROR": 62, "STOPPED": 63}, 15),
        (ExePathOutcome, {"FAILURE": 100, "CANCELED": 101}, {"MAP_ERROR": 116, "STOPPED": 117}, 19),
        (
            RecoveryOutcome,
            {"FAILURE": 150, "CANCELED": 151},
            {"STOPPED": 157, "IMPASSABLE": 158},
            10,
        ),
        (MoveBaseOutcome, {"FAILURE": 10, "CANCELED": 11}, {"CTRL_FAILURE": 100}, 11),
    ],
)
def test_values_are_those_that_clients_know(outcomes, first, last, count):
    values = {outcome.name: outcome.value for outcome in outcomes}
    assert {"SUCCESS": 0, **first, **last}.items() <= values.items() and len(values) == count


def test_success_ends_at_ten():
    assert [outcome for outcome in range(64) if is_success(outcome)] == list(range(10))


def test_what_is_worth_another_attempt():
    worth = [outcome for outcome in range(100) if may_change_by_itself(outcome)]
    assert worth == [50, 57, 58, *range(71, 100)]
