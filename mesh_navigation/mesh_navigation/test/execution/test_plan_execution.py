"""Patience, retries, cancels and planners that misbehave."""

import sys
import threading
import time

import numpy as np
import pytest

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.execution import attempt as attempts
from mesh_navigation.execution import plan_execution
from mesh_navigation.execution.plan_execution import PlanExecution
from mesh_navigation.plugins.planner import PlanResult

PATH = np.array([[0, 0, 0, 0, 0, 0, 1.0], [1, 0, 0, 0, 0, 0, 1.0]])
FOREVER = 600.0


@pytest.fixture(autouse=True)
def short_times(monkeypatch):
    monkeypatch.setattr(attempts, "GRACE", 0.05)
    monkeypatch.setattr(plan_execution, "RETRY_PAUSE", 0.001)


def run(plan, patience=0.0, max_retries=0, cancellation=None):
    return PlanExecution(plan, patience, max_retries).run(cancellation or Cancellation())


def good(cancellation):
    return PlanResult(GetPathOutcome.SUCCESS, "fine", PATH, 1.0)


class Failing:
    """Fails with an outcome until its attempts are used up, then succeeds."""

    def __init__(self, outcome, attempts=10**9):
        self.outcome, self.left, self.calls = outcome, attempts, 0

    def __call__(self, cancellation):
        self.calls += 1
        if self.calls > self.left:
            return good(cancellation)
        return PlanResult(self.outcome, f"failure {self.calls}")


class Obedient:
    """Plans until it is canceled."""

    def __init__(self):
        self.begun, self.reason = threading.Event(), None

    def __call__(self, cancellation):
        self.begun.set()
        cancellation.wait(FOREVER)
        self.reason = cancellation.reason
        return PlanResult(GetPathOutcome.CANCELED, "stopped")


def test_success_passes_through():
    result = run(good)
    assert (result.outcome, result.message, result.cost) == (0, "fine", 1.0)
    assert np.array_equal(result.poses, PATH)


def test_success_of_a_planners_own_passes_through():
    assert run(lambda c: PlanResult(7, "well", PATH)).outcome == 7


def test_patience_ends_an_obedient_planner():
    planner = Obedient()
    result = run(planner, patience=0.05)
    assert result.outcome == GetPathOutcome.PAT_EXCEEDED
    assert "0.05 s" in result.message and "did not stop" not in result.message
    assert planner.reason == "out of patience"


def test_patience_ends_a_planner_that_does_not_listen():
    release = threading.Event()
    result = run(lambda cancellation: release.wait(FOREVER), patience=0.05)
    release.set()
    assert result.outcome == GetPathOutcome.PAT_EXCEEDED
    assert "did not stop within" in result.message


def test_cancel_ends_an_obedient_planner():
    planner, cancellation = Obedient(), Cancellation()
    canceler = threading.Thread(
        target=lambda: planner.begun.wait(60) and cancellation.cancel("for a test")
    )
    canceler.start()
    result = run(planner, cancellation=cancellation)
    canceler.join()
    assert (result.outcome, result.message) == (51, "planning stopped: for a test")
    assert planner.reason == "for a test"


def test_cancel_ends_a_planner_that_does_not_listen():
    release, cancellation = threading.Event(), Cancellation()
    threading.Timer(0.02, cancellation.cancel).start()
    result = run(lambda c: release.wait(FOREVER), cancellation=cancellation)
    release.set()
    assert result.outcome == GetPathOutcome.CANCELED
    assert "did not stop within" in result.message


def test_cancel_before_the_start_never_calls_the_planner():
    cancellation = Cancellation()
    cancellation.cancel("before")
    planner = Failing(GetPathOutcome.FAILURE)
    assert run(planner, cancellation=cancellation).outcome == GetPathOutcome.CANCELED
    assert planner.calls == 0


def test_passing_failures_are_retried_as_often_as_said():
    planner = Failing(GetPathOutcome.FAILURE)
    result = run(planner, max_retries=3)
    assert (planner.calls, result.outcome, result.message) == (4, 50, "failure 4")


def test_retries_end_with_success():
    planner = Failing(80, attempts=2)
    assert run(planner, max_retries=-1).outcome == GetPathOutcome.SUCCESS
    assert planner.calls == 3


def test_lasting_failures_are_not_retried():
    for outcome in (52, 53, 54, 56, 59, 60, 61, 62):
        planner = Failing(outcome)
        result = run(planner, max_retries=-1)
        assert (planner.calls, result.outcome) == (1, outcome)


@pytest.mark.parametrize("lasting", [False, True])
@pytest.mark.parametrize("sees", [False, True])
def test_no_path_is_tried_again_while_sensors_may_open_one(sees, lasting):
    """As Move Base Flex does; without a layer that can be cleared, or where that would not help,
    it is final."""
    calls = []

    def plan(cancellation):
        calls.append(None)
        if len(calls) > 3:
            return good(cancellation)
        return PlanResult(GetPathOutcome.NO_PATH_FOUND, "no path", lasting=lasting)

    result = PlanExecution(plan, 0.0, -1, lambda: sees).run(Cancellation())
    if sees and not lasting:
        assert (result.outcome, len(calls)) == (0, 4)
    else:
        assert (result.outcome, result.lasting, len(calls)) == (54, lasting, 1)


def test_no_path_is_tried_again_until_the_patience_or_the_retries_end():
    planner = Failing(GetPathOutcome.NO_PATH_FOUND)
    result = PlanExecution(planner, 0.1, -1, lambda: True).run(Cancellation())
    assert result.outcome == GetPathOutcome.PAT_EXCEEDED
    assert planner.calls > 1 and f"failure {planner.calls}" in result.message
    planner = Failing(GetPathOutcome.NO_PATH_FOUND)
    result = PlanExecution(planner, 0.0, 2, lambda: True).run(Cancellation())
    assert (planner.calls, result.outcome, result.message) == (3, 54, "failure 3")


def test_what_failed_before_the_patience_ended_an_attempt_is_said():
    """The cause is in earlier answers, not in the last attempt, which had no time for one."""
    failing, obedient = Failing(GetPathOutcome.TF_ERROR), Obedient()
    result = run(lambda c: (failing if failing.calls < 2 else obedient)(c), 0.3, -1)
    assert result.outcome == GetPathOutcome.PAT_EXCEEDED
    said = "and the planner was stopped after 2 attempts, the last of which: failure 2"
    assert result.message.endswith(said)


def test_sensors_are_asked_after_each_attempt():
    """An obstacle layer whose data are not current any more opens nothing."""
    planner, current = Failing(GetPathOutcome.NO_PATH_FOUND), [True, True, False]
    result = PlanExecution(planner, 0.0, -1, lambda: current.pop(0)).run(Cancellation())
    assert (planner.calls, result.outcome) == (3, 54)
    other = Failing(GetPathOutcome.INVALID_GOAL)
    assert PlanExecution(other, 0.0, -1, lambda: True).run(Cancellation()).outcome == 53
    assert other.calls == 1


def test_retries_without_number_end_with_the_patience():
    planner = Failing(GetPathOutcome.TF_ERROR)
    result = run(planner, patience=0.1, max_retries=-1)
    assert result.outcome == GetPathOutcome.PAT_EXCEEDED
    assert planner.calls > 1 and f"failure {planner.calls}" in result.message


def test_cancel_between_retries():
    cancellation = Cancellation()
    planner = Failing(GetPathOutcome.FAILURE)
    threading.Timer(0.05, cancellation.cancel).start()
    assert run(planner, max_retries=-1, cancellation=cancellation).outcome == 51


def raise_error(cancellation):
    raise KeyError("broken\nsecond line")


@pytest.mark.parametrize(
    "plan, outcome, words",
    [
        (raise_error, 60, "KeyError"),
        (lambda c: sys.exit("enough"), 60, "SystemExit: enough"),
        (lambda c: None, 60, "NoneType instead of a PlanResult"),
        (lambda c: PlanResult(-1, "well", PATH), 60, "its outcome is -1"),
        (lambda c: PlanResult(None, "well", PATH), 60, "its outcome is None"),
        (lambda c: PlanResult(50, None, PATH), 50, "None"),
        (lambda c: PlanResult(71, "no way", PATH, None), 71, "no way"),
        (lambda c: PlanResult(71, "no way", PATH, np.nan), 71, "no way"),
        (lambda c: PlanResult(71, "no way\nat all"), 71, "no way at all"),
        (lambda c: PlanResult(71, "no \udcff way"), 71, "way"),
        (lambda c: PlanResult(0, "well"), 56, "without a pose: well"),
        (lambda c: PlanResult(0, "well", None), 60, "shape ()"),
        (lambda c: PlanResult(0, "well", "path"), 60, "no numbers"),
        (lambda c: PlanResult(0, "well", np.zeros((4, 3))), 60, "shape (4, 3)"),
        (lambda c: PlanResult(0, "well", PATH * [[1], [np.nan]]), 60, "1 of 2 poses are not fin"),
        (
            lambda c: PlanResult(0, "well", PATH * [[1], [0]]),
            60,
            "no unit quaternion, first pose 1",
        ),
        (lambda c: PlanResult(0, "well", PATH, np.inf), 60, "its cost is inf"),
        (lambda c: PlanResult(0, "well", PATH, None), 60, "no numbers"),
    ],
)
def test_faults_of_planners(plan, outcome, words):
    result = run(plan)
    assert result.outcome == outcome
    assert words in result.message and "\n" not in result.message
    assert len(result.poses) == 0 and result.cost == 0.0
    result.message.encode()  # a message of ROS can carry it


def test_fifty_cancels_at_random_times():
    """Whenever the cancel comes, the answer is CANCELED or the finished plan, and it comes."""
    rng = np.random.default_rng(0)
    for _ in range(50):
        cancellation = Cancellation()

        def slow(attempt):
            return good(attempt) if not attempt.wait(0.002) else PlanResult(51, "stopped")

        timer = threading.Timer(rng.uniform(0, 0.004), cancellation.cancel)
        timer.start()
        result = run(slow, cancellation=cancellation)
        before_answer = cancellation.canceled
        timer.join()
        assert result.outcome in (0, 51)
        assert result.outcome == 0 or before_answer


def test_nothing_runs_on_after_an_obedient_planner():
    before = threading.active_count()
    run(Obedient(), patience=0.01)
    deadline = time.monotonic() + 10
    while threading.active_count() > before and time.monotonic() < deadline:
        time.sleep(0.01)
    assert threading.active_count() == before
