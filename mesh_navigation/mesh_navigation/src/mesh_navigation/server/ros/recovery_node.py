"""The action recovery."""

from typing import Any, Optional, Tuple

from mbf_msgs.msg import RecoveryAction, RecoveryResult

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import NotReady, RecoveryOutcome
from mesh_navigation.execution.recovery_execution import RecoveryExecution
from mesh_navigation.server.ros.slot_action_node import Parts, RunningGoal, SlotActionServer


class RecoveryServer(SlotActionServer):
    """Serves ``~recovery``."""

    def __init__(self, parts: Parts) -> None:
        super().__init__("~recovery", RecoveryAction, RecoveryResult, RecoveryOutcome, "recovery")
        self._behaviors = parts.behaviors
        self._parts = parts

    def _chosen(self, goal: Any) -> Tuple[Optional[str], str]:
        return self._behaviors.choose(goal.behavior), self._behaviors.why_not(goal.behavior)

    def _rejected_result(self, goal: Any, why_not: str) -> RecoveryResult:
        result = self._result("INVALID_PLUGIN", why_not)
        result.used_plugin = goal.behavior
        return result

    def _execute(
        self, running: RunningGoal, name: str, cancellation: Cancellation
    ) -> RecoveryResult:
        parts = self._parts
        try:
            ready = parts.gate.wait(cancellation, whole=False)  # what drives is refused that
            behavior = ready.behaviors[name]
            with parts.robot.driven(cancellation) as robot:
                execution = RecoveryExecution(robot, parts.clock, lambda: parts.values)
                found = execution.run(
                    behavior,
                    cancellation,
                    parts.gate.replaced(ready),
                    lambda: ready.map.lasting_fault,
                    lambda: ready.map.gap,
                )
        except NotReady as error:
            return RecoveryResult(self._outcome(error.kind), error.message, name)
        return RecoveryResult(int(found.outcome), f"{name}: {found.message}", name)

    def _outcome(self, name: str) -> int:
        # The action has no outcome of its own for a map that cannot be loaded.
        return super()._outcome("NOT_INITIALIZED" if name == "MAP_ERROR" else name)

    def _other_result(self, running: RunningGoal, result: Any, outcome: str, message: str) -> Any:
        return RecoveryResult(self._outcome(outcome), message, running.name)
