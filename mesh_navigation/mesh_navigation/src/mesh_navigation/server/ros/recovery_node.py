"""The action recovery."""

from typing import Any, Callable, Mapping, Optional, Tuple

from mbf_msgs.msg import RecoveryAction, RecoveryResult

from mesh_map.base.parameter import Value

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import RecoveryOutcome
from mesh_navigation.base.robot import Robot
from mesh_navigation.execution.recovery_execution import RecoveryExecution
from mesh_navigation.plugins.plugin_list import PluginList
from mesh_navigation.server.map_gate import MapGate, MapNotReady
from mesh_navigation.server.ros.slot_action_node import SlotActionServer
from mesh_navigation.server.running_goal import RunningGoal

# The action has no outcome of its own for a map that cannot be loaded.
_OUTCOMES = {"MAP_ERROR": "NOT_INITIALIZED"}


class RecoveryServer(SlotActionServer):
    """Serves ``~recovery``."""

    def __init__(
        self,
        behaviors: PluginList,
        gate: MapGate,
        robot: Robot,
        clock: Clock,
        values: Callable[[], Mapping[str, Value]],
    ) -> None:
        """
        Args:
            behaviors: to choose from by name.
            gate: where the map and the behaviors come from.
            robot: to be driven.
            clock: to wait by.
            values: of the parameters, of which recovery_patience is read.
        """
        super().__init__("~recovery", RecoveryAction, RecoveryResult, RecoveryOutcome, "recovery")
        self._behaviors = behaviors
        self._gate = gate
        self._execution = RecoveryExecution(robot, clock, values)

    def _chosen(self, goal: Any) -> Tuple[Optional[str], str]:
        return self._behaviors.choose(goal.behavior), self._behaviors.why_not(goal.behavior)

    def _rejected_result(self, goal: Any, why_not: str) -> RecoveryResult:
        result = self._result("INVALID_PLUGIN", why_not)
        result.used_plugin = goal.behavior
        return result

    def _execute(
        self, running: RunningGoal, name: str, cancellation: Cancellation
    ) -> RecoveryResult:
        try:
            ready = self._gate.wait(cancellation)
        except MapNotReady as error:
            outcome = RecoveryOutcome[_OUTCOMES.get(error.kind, error.kind)]
            return RecoveryResult(int(outcome), error.message, name)
        fault = ready.behaviors.fault(name)
        if fault:
            return RecoveryResult(int(RecoveryOutcome.NOT_INITIALIZED), fault, name)
        gone = self._gate.replaced(ready)
        found = self._execution.run(ready.behaviors[name], cancellation, gone)
        return RecoveryResult(int(found.outcome), f"{name}: {found.message}", name)

    def _stopped_result(self, running: RunningGoal, result: Any, message: str) -> RecoveryResult:
        return RecoveryResult(int(RecoveryOutcome.STOPPED), message, running.name)
