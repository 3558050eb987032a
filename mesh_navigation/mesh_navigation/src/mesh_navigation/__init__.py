"""Navigation on layered mesh maps: planners, controllers, recovery behaviors, and their server."""

from typing import Any

from mesh_msgs.module_aliases import alias_modules


def __getattr__(name: str) -> Any:
    # What speaks ROS is loaded when it is asked for: this package is imported without it, too.
    if name == "MeshNavigator":
        from mesh_navigation.client.navigator_node import MeshNavigator

        return MeshNavigator
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


# Names from before the rooms: those of the README, and what plugins of others use beside these.
alias_modules(
    {
        "mesh_navigation.cancellation": "mesh_navigation.base.cancellation",
        "mesh_navigation.clock": "mesh_navigation.base.clock",
        "mesh_navigation.controller": "mesh_navigation.plugins.controller",
        "mesh_navigation.outcomes": "mesh_navigation.base.outcomes",
        "mesh_navigation.planner": "mesh_navigation.plugins.planner",
        "mesh_navigation.planning": "mesh_navigation.execution.planning",
        "mesh_navigation.pose": "mesh_navigation.base.pose",
        "mesh_navigation.recovery": "mesh_navigation.plugins.recovery",
        "mesh_navigation.robot": "mesh_navigation.base.robot",
    }
)
