"""Outcomes are those of mbf_msgs."""

import pytest
from mbf_msgs.msg import ExePathResult, GetPathResult, MoveBaseResult, RecoveryResult

from mesh_navigation.base.outcomes import (
    ExePathOutcome,
    GetPathOutcome,
    MoveBaseOutcome,
    RecoveryOutcome,
    is_success,
    may_change_by_itself,
)


@pytest.mark.parametrize(
    "outcomes, message",
    [
        (GetPathOutcome, GetPathResult),
        (ExePathOutcome, ExePathResult),
        (RecoveryOutcome, RecoveryResult),
        (MoveBaseOutcome, MoveBaseResult),
    ],
)
def test_values_are_those_of_the_message(outcomes, message):
    constants = {name: getattr(message, name) for name in vars(message)}
    expected = {name: value for name, value in constants.items() if name.isupper()}
    assert {outcome.name: outcome.value for outcome in outcomes} == expected


def test_success_ends_at_ten():
    assert [outcome for outcome in range(64) if is_success(outcome)] == list(range(10))


def test_what_is_worth_another_attempt():
    worth = [outcome for outcome in range(100) if may_change_by_itself(outcome)]
    assert worth == [50, 57, 58, *range(71, 100)]
