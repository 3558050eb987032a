"""Outcomes are those of mbf_msgs."""

from mbf_msgs.msg import GetPathResult

from mesh_navigation.outcomes import GetPathOutcome, is_success, may_change_by_itself


def test_values_are_those_of_the_message():
    constants = {name: getattr(GetPathResult, name) for name in vars(GetPathResult)}
    expected = {name: value for name, value in constants.items() if name.isupper()}
    assert {outcome.name: outcome.value for outcome in GetPathOutcome} == expected


def test_success_ends_at_ten():
    assert [outcome for outcome in range(64) if is_success(outcome)] == list(range(10))


def test_what_is_worth_another_attempt():
    worth = [outcome for outcome in range(100) if may_change_by_itself(outcome)]
    assert worth == [50, 57, 58, *range(71, 100)]
