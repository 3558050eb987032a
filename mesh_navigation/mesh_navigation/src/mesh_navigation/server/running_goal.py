"""A goal of an action while it is executed."""

from typing import Any, Optional

from actionlib_msgs.msg import GoalID

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.server.local_goal import LocalGoal


class RunningGoal:
    """A goal from when it is accepted to its answer, for the hooks of `SlotActionServer`.

    It has the methods of actionlib's handle that a hook needs. When another goal takes over what is
    running, it is that one from then on.
    """

    def __init__(self, handle: Any, name: str, local: Optional[LocalGoal]) -> None:
        self.handle = handle
        self.name = name
        """Of the plugin."""
        self.cancellation = Cancellation()
        self.answered = False
        self.data: Any = None
        """For the hooks: what ``_execute`` leaves for ``_ended`` and ``_taken_over``."""
        self.local = local

    @property
    def key(self) -> str:
        """The goal's id."""
        return str(self.handle.get_goal_id().id)

    def get_goal(self) -> Any:
        """The goal itself."""
        return self.handle.get_goal()

    def get_goal_id(self) -> GoalID:
        """Id and stamp of the goal."""
        return self.handle.get_goal_id()

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback, to who is in this process too; nothing after the answer."""
        local = self.local
        with self.handle.action_server.lock:
            if self.answered:
                return
            self.handle.publish_feedback(feedback)
        if local is not None and local.on_feedback is not None:
            local.on_feedback(feedback)
