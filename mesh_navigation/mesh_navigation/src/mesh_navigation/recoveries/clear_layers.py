"""Forget what sensors have seen."""

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import RecoveryOutcome
from mesh_navigation.base.robot import Robot
from mesh_navigation.plugins.recovery import MeshRecovery, RecoveryResult


class ClearLayers(MeshRecovery):
    """Layers forget what sensors have seen: obstacles that went unnoticed block no more.

    What is still there comes back as soon as a sensor sees it.
    """

    parameters = (
        Parameter("layers", (), description="names of layers; empty: all that can be cleared"),
    )

    def run(self, robot: Robot, clock: Clock, cancellation: Cancellation) -> RecoveryResult:
        """Clears them; without any that can be cleared, it fails: there is nothing to hope for."""
        names = self.values["layers"]
        if not all(isinstance(name, str) for name in names):
            text = f"the parameter layers is no list of names but {list(names)!r}"
            return RecoveryResult(RecoveryOutcome.FAILURE, text)
        try:
            counts = self.map.clear_layers(names or None)
        except MeshMapError as error:
            return RecoveryResult(RecoveryOutcome.FAILURE, f"nothing was cleared: {error}")
        if not counts:
            asked = ", ".join(names or self.map.layers) or "none"
            text = f"nothing can be cleared: no layer of this map forgets anything (asked: {asked})"
            return RecoveryResult(RecoveryOutcome.FAILURE, text)
        told = ", ".join(f"{count} in layer {name}" for name, count in counts.items())
        return RecoveryResult(RecoveryOutcome.SUCCESS, f"cleared: {told}")
