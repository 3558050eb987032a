"""The costs of a map, as its node publishes them, for a robot that looks for free ground."""

from typing import Callable, Optional, Tuple

import numpy as np
import rospy
from mesh_msgs import arrays

from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.map.mesh_map import MeshMap


class StartCosts:
    """The combined costs that came last."""

    def __init__(self, topic: str, on_costs: Callable[[], None]) -> None:
        """
        Args:
            topic: of mesh_msgs/MeshVertexCostsStamped.
            on_costs: called in other threads, whenever some have come.
        """
        self.topic = rospy.resolve_name(topic)
        self._on_costs = on_costs
        self._newest: Tuple[str, Optional[np.ndarray]] = "", None
        kind = arrays.MeshVertexCostsStamped
        self._subscriber = rospy.Subscriber(self.topic, kind, self._receive)

    def of(self, mesh_map: MeshMap) -> Optional[np.ndarray]:
        """(V,) of this map; None as long as they have not come."""
        uuid, costs = self._newest
        known = uuid == mesh_map.uuid and costs is not None
        return costs if known and len(costs) == len(mesh_map.vertices) else None

    def close(self) -> None:
        """Listens no more."""
        self._subscriber.unregister()

    def _receive(self, message: arrays.MeshVertexCostsStamped) -> None:
        if message.type == COMBINED_COSTS:
            self._newest = message.uuid, message.mesh_vertex_costs.costs
            self._on_costs()
