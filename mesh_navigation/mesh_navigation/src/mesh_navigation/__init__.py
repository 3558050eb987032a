"""Navigation on layered mesh maps: planners, controllers, recovery behaviors, and their server."""

from typing import Any


def __getattr__(name: str) -> Any:
    # What speaks ROS is loaded when it is asked for: this package is imported without it, too.
    if name == "MeshNavigator":
        from mesh_navigation.navigator_node import MeshNavigator

        return MeshNavigator
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
