"""The services that tell what the map says about a robot, and the one that clears layers."""

from typing import Any, Callable, Mapping

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from mbf_msgs.srv import (
    CheckPath,
    CheckPathResponse,
    CheckPoint,
    CheckPointResponse,
    CheckPose,
    CheckPoseResponse,
)
from nav_msgs.msg import Path
from std_srvs.srv import Empty, EmptyResponse

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter, read_parameters
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.messages import bare_pose, poses_from_path
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution.path_check import transformed_path
from mesh_navigation.server.ros.slot_action_node import Parts
from mesh_navigation.surface.check_costs import CostChecks
from mesh_navigation.surface.cost_scale import Factors

COST_LIMIT = Parameter("cost_limit", 1.0, 0.0, 10.0, "vertices of a higher cost are INSCRIBED")


class CheckServices:
    """Serves ``~check_point_cost``, ``~check_pose_cost``, ``~check_path_cost``, ``~clear_mesh``.

    They never wait for the map. A call that cannot be answered fails, with the reason for the
    client; so does one for costs while a required layer does not stand. What is asked about is
    looked for in the only map, whichever ``costmap`` is asked for.
    """

    def __init__(self, parts: Parts, given: Mapping[str, Any], shape: RobotShape) -> None:
        """
        Args:
            parts: what it works with.
            given: the node's parameters, of which cost_limit is read.
            shape: of the robot.
        """
        self._gate = parts.gate
        self._transforms = parts.transforms
        self._shape = shape
        values, complaints = read_parameters((COST_LIMIT,), given)
        self._cost_limit = float(values[COST_LIMIT.name])  # type: ignore[arg-type]
        for complaint in complaints:
            rospy.logwarn("parameter ~%s", complaint)
        self._stopped = Cancellation()
        self._services = [
            _service("~check_point_cost", CheckPoint, self._check_point),
            _service("~check_pose_cost", CheckPose, self._check_pose),
            _service("~check_path_cost", CheckPath, self._check_path),
            _service("~clear_mesh", Empty, self._clear_mesh),
        ]

    def stop(self, reason: str) -> None:
        """Nobody waits for a transform any longer."""
        self._stopped.cancel(reason)

    def _checks(self, mesh_map: MeshMap) -> CostChecks:
        return CostChecks(mesh_map, self._shape, self._cost_limit)

    def _check_point(self, request: Any) -> CheckPointResponse:
        mesh_map, point = self._gate.now().map, request.point.point
        upright = bare_pose(Pose.at((point.x, point.y, point.z)))
        pose = self._in_map(mesh_map, PoseStamped(request.point.header, upright), "requested")
        found = self._checks(mesh_map).point(pose.position)
        return CheckPointResponse(state=found.state, cost=found.cost)

    def _check_pose(self, request: Any) -> CheckPoseResponse:
        mesh_map = self._gate.now().map
        if request.current_pose:
            pose = self._transforms.robot_pose(mesh_map.frame_id, self._stopped, patient=False)
        else:
            pose = self._in_map(mesh_map, request.pose, "requested")
        row = np.concatenate(pose)
        found = self._checks(mesh_map).pose(row, request.safety_dist, _factors(request))
        return CheckPoseResponse(state=found.state, cost=found.cost)

    def _check_path(self, request: Any) -> CheckPathResponse:
        mesh_map = self._gate.now().map
        rows = poses_from_path(request.path)
        header = _header_of(request.path)
        if len(rows) and header.frame_id.lstrip("/") != mesh_map.frame_id:
            origin = PoseStamped(header, bare_pose(Pose.at((0.0, 0.0, 0.0))))
            rows = transformed_path(rows, self._in_map(mesh_map, origin, "path"))
        found = self._checks(mesh_map).path(
            rows,
            request.safety_dist,
            _factors(request),
            request.return_on,
            request.skip_poses,
            request.path_cells_only,
        )
        return CheckPathResponse(
            last_checked=found.last_checked, state=found.state, cost=found.cost
        )

    def _in_map(self, mesh_map: MeshMap, pose: PoseStamped, what: str) -> Pose:
        frame = mesh_map.frame_id
        return self._transforms.pose_in(frame, pose, what, self._stopped, patient=False)

    def _clear_mesh(self, _request: Any) -> EmptyResponse:
        counts = self._gate.now(whole=False).map.clear_layers()
        told = ", ".join(f"{count} in layer {name}" for name, count in counts.items())
        rospy.loginfo("clear_mesh: cleared %s", told or "nothing: no layer can be cleared")
        return EmptyResponse()


def _service(name: str, kind: Any, handler: Callable[[Any], Any]) -> rospy.Service:
    """What rospy sends to the client where it fails, and logs, is the message alone."""

    def answer(request: Any) -> Any:
        try:
            return handler(request)
        except (NotReady, MeshMapError) as error:
            raise rospy.ServiceException(str(error)) from error
        except Exception as error:  # A layer of a stranger may raise anything.
            text = f"{type(error).__name__}: {error}"
            rospy.logerr("%s: %s", name.lstrip("~"), text)
            raise rospy.ServiceException(text) from error

    return rospy.Service(name, kind, answer)


def _factors(request: Any) -> Factors:
    return Factors(request.lethal_cost_mult, request.inscrib_cost_mult, request.unknown_cost_mult)


def _header_of(path: Path) -> Any:
    """That of the path, or of its poses where it has no frame.

    Raises:
        MeshMapError: they are in several frames.
    """
    headers = [path.header] + [pose.header for pose in path.poses]
    named = [header for header in headers if header.frame_id]
    frames = sorted({header.frame_id.lstrip("/") for header in named})
    if len(frames) > 1:
        raise MeshMapError(f"the path is in {len(frames)} frames, but one is needed: {frames}")
    return named[0] if named else path.header
