#!/usr/bin/python3
"""What all actions share, with a server in this process whose goals do what the test says."""

import itertools
import random
import threading
import unittest
from collections import Counter

import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatus
from mbf_msgs.msg import (
    ExePathAction,
    ExePathActionResult,
    ExePathFeedback,
    ExePathGoal,
    ExePathResult,
)

from mesh_msgs.testing import wait_until
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import TAKEN_OVER, ExePathOutcome
from mesh_navigation.server.ros.action_server_node import KEPT
from mesh_navigation.server.ros.slot_action_node import SlotActionServer

OTHERS = itertools.count()
CANCELED = int(ExePathOutcome.CANCELED)
INTERNAL = int(ExePathOutcome.INTERNAL_ERROR)


class Scripted(SlotActionServer):
    """A goal's controller says what happens; "hold" waits until canceled, or until released."""

    def __init__(self):
        name = f"~scripted{next(OTHERS)}"
        super().__init__(name, ExePathAction, ExePathResult, ExePathOutcome, "driving")
        self.path = rospy.resolve_name(name)
        self.released = threading.Event()
        self.began, self.ended, self.answers = Counter(), [], Counter()
        self.outdated = 0
        publish = self._server.publish_result

        def count(status, result):
            self.answers[status.goal_id.id] += 1
            publish(status, result)

        self._server.publish_result = count
        self.start()

    def _chosen(self, goal):
        if goal.controller == "odd":
            raise KeyError("odd")
        known = goal.controller not in ("", "unknown")
        return (goal.controller, "") if known else (None, f"there is no '{goal.controller}'")

    def _taken_over(self, running, handle, name):
        return name == "joining"

    def _is_outdated(self, running):
        self.outdated -= 1
        return self.outdated >= 0

    def _execute(self, running, name, cancellation):
        self.began[running.key] += 1
        if name == "throw":
            raise ZeroDivisionError("by\nzero")
        if name == "unprintable":
            raise OSError("no file caf\udce9")  # a file's name that is no UTF-8
        if name == "exit":
            raise SystemExit("enough")
        if name == "none":
            return None
        if name == "feedback":
            for outcome in (1, 2, 3):
                running.publish_feedback(ExePathFeedback(outcome=outcome))
        if name in ("hold", "joining"):
            while not self.released.is_set() and not cancellation.wait(0.005):
                pass
        if name == "lines":
            return ExePathResult(outcome=100, message="caf\udce9\nis closed")
        outcome = int(name) if name.isdigit() else 0
        return ExePathResult(outcome=outcome, message=f"{running.name} is done")

    def _ended(self, running, result):
        self.ended.append((running.key, result.outcome))
        if running.name == "1":
            raise ValueError("after the answer")


def answer(goal):
    given = goal.wait(timeout=60)
    assert given is not None, "no answer"
    return given.state, given.outcome, given.message


class SlotActionsTest(unittest.TestCase):
    def setUp(self):
        self.server = Scripted()
        self.addCleanup(self.server._server.stop)

    def send(self, controller, slot=0, **fields):
        goal = ExePathGoal(controller=controller, concurrency_slot=slot)
        return self.server.send(goal, **fields)

    def test_states_of_outcomes(self):
        for outcome, state in ((0, 3), (1, 3), (9, 3), (10, 4), (100, 4), (149, 4), (101, 2)):
            given = answer(self.send(str(outcome)))
            self.assertEqual(given, (state, outcome, f"{outcome} is done"))
        wait_until(lambda: len(self.server.ended) == 7, "the ends")

    def test_what_is_raised_is_answered(self):
        self.assertEqual(answer(self.send("throw")), (4, INTERNAL, "ZeroDivisionError: by zero"))
        self.assertEqual(answer(self.send("exit")), (4, INTERNAL, "SystemExit: enough"))
        heard = set()
        rospy.Subscriber(
            f"{self.server.path}/result",
            ExePathActionResult,
            lambda message: heard.add(message.result.message),
        )
        given = answer(self.send("unprintable"))
        self.assertEqual(given, (4, INTERNAL, "OSError: no file caf\\udce9"))
        self.assertEqual(answer(self.send("lines")), (4, 100, "caf\\udce9 is closed"))
        expected = {"OSError: no file caf\\udce9", "caf\\udce9 is closed"}
        wait_until(lambda: heard >= expected, "the answers on the topic")
        given = answer(self.send("none"))
        self.assertEqual(given, (4, INTERNAL, "TypeError: the result is a NoneType"))

    def test_rejected(self):
        invalid = int(ExePathOutcome.INVALID_PLUGIN)
        self.assertEqual(answer(self.send("unknown")), (5, invalid, "there is no 'unknown'"))
        self.assertEqual(answer(self.send("odd")), (5, invalid, "KeyError: 'odd'"))
        self.assertEqual(self.server.began, {})

    def test_feedback_of_a_local_goal(self):
        found = []
        goal = self.send("feedback", on_feedback=found.append, owner="somebody")
        self.assertEqual(answer(goal)[0], 3)
        self.assertEqual([feedback.outcome for feedback in found], [1, 2, 3])
        self.assertTrue(goal.goal_id.startswith("somebody-"))

    def test_a_newer_goal_replaces_the_one_of_its_slot(self):
        old, other = self.send("hold"), self.send("hold", slot=7)
        wait_until(lambda: len(self.server.began) == 2, "two goals")
        new = self.send("0")
        self.assertEqual(answer(old), (2, CANCELED, "driving stopped: a newer goal took slot 0"))
        self.assertEqual(answer(new)[:2], (3, 0))
        self.assertIsNone(other.wait(timeout=0.01))
        other.cancel("for a test")
        self.assertEqual(answer(other), (2, CANCELED, "driving stopped: for a test"))

    def test_take_over(self):
        first = self.send("hold")
        wait_until(lambda: self.server.began, "the start")
        found = []
        second = self.send("joining", on_feedback=found.append)
        self.assertEqual(answer(first), (2, CANCELED, TAKEN_OVER))
        third = self.send("joining")
        self.assertEqual(answer(second), (2, CANCELED, TAKEN_OVER))
        first.cancel("too late")
        second.cancel("too late")
        self.assertIsNone(third.wait(timeout=0.05))
        self.server.released.set()
        self.assertEqual(answer(third), (3, 0, "joining is done"))
        self.assertEqual(len(self.server.began), 1)
        # Nothing runs: this one is executed itself.
        self.server.released.clear()
        last = self.send("joining")
        wait_until(lambda: len(self.server.began) == 2, "the start")
        last.cancel("for a test")
        self.assertEqual(answer(last)[:2], (2, CANCELED))

    def test_a_result_of_an_older_goal_is_no_answer(self):
        self.server.outdated = 2
        goal = self.send("0")
        self.assertEqual(answer(goal)[:2], (3, 0))
        self.assertEqual(self.server.began[goal.goal_id], 3)

    def test_results_are_not_kept(self):
        """Paths are large, and nobody connects so late."""
        for _ in range(10):
            answer(self.send("0"))
        recent = self.server._server._recent
        self.assertEqual(len(recent), 10)
        for index, kept in enumerate(recent):
            recent[index] = (kept[0] - KEPT, *kept[1:])
        self.server._server.publish_status()
        self.assertEqual(len(recent), 0)

    def test_waiting_can_be_canceled(self):
        goal, cancellation = self.send("hold"), Cancellation()
        threading.Timer(0.05, cancellation.cancel).start()
        self.assertIsNone(goal.wait(cancellation))
        goal.cancel("enough")
        self.assertEqual(answer(goal)[:2], (2, CANCELED))
        self.assertIsNotNone(goal.wait(cancellation))

    def test_a_cancel_of_all_goals_reaches_local_ones(self):
        goals = [self.send("hold", slot=slot) for slot in range(3)]
        self.server._server.internal_cancel_callback(GoalID())
        for goal in goals:
            self.assertEqual(
                answer(goal), (2, CANCELED, "driving stopped: a client canceled the goal")
            )

    def test_storm(self):
        """From several threads, with cancels at random times: each goal has one answer."""
        goals, lock = [], threading.Lock()
        names = ["hold", "joining", "0", "throw", "100", "unknown"]

        def storm(seed):
            choose = random.Random(seed)
            for _ in range(60):
                goal = self.send(choose.choice(names), slot=choose.randrange(2))
                with lock:
                    goals.append(goal)
                if choose.random() < 0.5:
                    rospy.rostime.wallsleep(choose.uniform(0, 0.004))
                    goal.cancel(f"storm {seed}")

        threads = [threading.Thread(target=storm, args=(seed,)) for seed in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for slot in range(2):
            answer(self.send("0", slot=slot))
        found = Counter(answer(goal)[0] for goal in goals)
        self.assertEqual(sum(found.values()), 240)
        self.assertLessEqual(set(found), {2, 3, 4, 5, 8})
        self.assertEqual({self.server.answers[goal.goal_id] for goal in goals}, {1})
        self.assertEqual(self.server._server.local, {})

        def nothing_is_left():
            return not (self.server._running or self.server._in_slot)

        wait_until(nothing_is_left, "the end of all")

    def test_stop(self):
        goals = [self.send("hold", slot=slot) for slot in range(3)]
        queued = self.send("hold")
        self.server.stop("the end")
        self.server.join(30)
        stopped = int(ExePathOutcome.STOPPED)
        for goal in goals[1:] + [queued, self.send("0")]:
            self.assertEqual(answer(goal), (4, stopped, "the end"))
        self.assertEqual(answer(goals[0])[0], 2 if answer(goals[0])[1] == CANCELED else 4)


if __name__ == "__main__":
    rospy.init_node("slot_actions_test")
    assert GoalStatus.PREEMPTED == 2
    rostest.rosrun("mesh_navigation", "slot_actions", SlotActionsTest)
