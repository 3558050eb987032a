"""How a layer gets data from ROS topics, without the layer knowing of ROS."""

import abc
from mesh_map.costs.layer import Layer
from mesh_map.map.mesh_map import MeshMap
from typing import Callable


class RosAdapter(abc.ABC):
    """Base of the class that a layer names in ROS_ADAPTER, as "module.Class".

    The mesh map server imports and constructs it when the layer has its first result, and shuts it
    down with the map. A typical one subscribes to a topic, and in the callback hands the data to a
    method of the layer and calls refresh().

    Attributes:
        namespace: of the layer's parameters and topics, such as /move_base_flex/mesh_map/obstacles.
        mesh_map, layer: for which it works.
        refresh: evaluates the layer again; what has changed is published. Returns when that is in
            the costs, and does not wait for layers that read it: they follow in another thread
            (`mesh_map.catch_up()` waits for them). May be called from any thread.
    """

    def __init__(
        self, namespace: str, mesh_map: MeshMap, layer: Layer, refresh: Callable[[], None]
    ) -> None:
        self.namespace = namespace
        self.mesh_map = mesh_map
        self.layer = layer
        self.refresh = refresh

    @abc.abstractmethod
    def shutdown(self) -> None:
        """Ends subscriptions and threads; refresh() must not be called afterwards."""
