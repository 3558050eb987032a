"""What a plan leaves on the topics of the map: markers, the potential and the directions."""

import threading
from typing import NamedTuple, Optional, Tuple

import numpy as np
import rospy

from mesh_map.map.mesh_map import MeshMap
from mesh_map.ros import MeshMapServer

from mesh_navigation.base.pose import Pose
from mesh_navigation.plugins.planner import PlanResult
from mesh_navigation.server.plan_markers import plan_markers

POTENTIAL = "Potential"
VECTOR_FIELD, FACE_VECTORS = "vector_field", "face_vectors"


class Plan(NamedTuple):
    """What came of a goal, for those who show it."""

    result: PlanResult
    """A potential it does not have is one that is infinite everywhere."""
    map: MeshMap
    """That of the server."""
    ends: Optional[Tuple[Pose, Pose]]
    """Start and goal in the map's frame; None if these are not known."""


class PlanTopics:
    """Shows one plan after the other; what the newest does not have is taken away."""

    def __init__(self, map_server: MeshMapServer) -> None:
        self._server = map_server
        self._waiting: Optional[Plan] = None
        self._showing = threading.Lock()

    def show(self, plan: Plan) -> None:
        """Publish a plan, a failed one too. From any thread, one at a time; of plans that wait for
        their turn (other slots'), only the last is shown."""
        self._waiting = plan
        with self._showing:
            waiting, self._waiting = self._waiting, None
            if waiting is not None:
                self._show(*waiting)

    def _show(
        self, result: PlanResult, mesh_map: MeshMap, ends: Optional[Tuple[Pose, Pose]]
    ) -> None:
        markers = plan_markers(mesh_map, ends, result, rospy.Time.now())
        for namespace, make in markers.items():
            self._server.publish_marker(namespace, make)
        potential = result.potential
        if potential is None:
            potential = np.full(len(mesh_map.vertices), np.inf, np.float32)
        self._server.publish_costs(POTENTIAL, potential, infinity="not reached")
        for namespace, vectors, of_faces in (
            (VECTOR_FIELD, result.vector_field, False),
            (FACE_VECTORS, result.face_vectors, True),
        ):
            if vectors is None:
                self._server.remove_vectors(namespace)
            else:
                self._server.publish_vector_field(namespace, vectors, potential, of_faces)
