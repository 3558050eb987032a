"""Planning without ROS.

In three lines::

    from mesh_navigation.execution.planning import plan
    result = plan("garden.h5", start=(1, 2, 0), goal=(8, 9, 0.5))
    print(result.message, result.cost, result.poses)
"""

import os
from typing import Any, List, Mapping, Optional, Sequence, Union

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import POINT, Body
from mesh_navigation.body.robot_shape import MAX_DISTANCE, RobotShape
from mesh_navigation.execution.attempt import Attempt
from mesh_navigation.execution.plan_execution import checked_result
from mesh_navigation.plugins.planner import MeshPlanner, PlanResult
from mesh_navigation.plugins.plugin_list import PLANNERS, checked_plugin, ready_plugin
from mesh_navigation.surface.map_loading import load_map

SHORT_NAMES = {
    "dijkstra": "dijkstra_mesh_planner/DijkstraMeshPlanner",
    "wave_front": "wave_front_planner/WaveFrontPlanner",
    "cvp": "cvp_mesh_planner/CVPMeshPlanner",
    "exact": "mmp_planner/MMPPlanner",
}
"""Types of planners by the names under which they are asked for here."""

# s that a planner may take to stop after Ctrl+C; less than `END_SECONDS`, by which a command ends.
GRACE = 2.0

Place = Union[Pose, Sequence[float]]


def plan(
    map_or_file: Union[MeshMap, str, "os.PathLike[str]"],
    start: Place,
    goal: Place,
    planner: Union[str, MeshPlanner] = "wave_front",
    parameters: Mapping[str, Any] = {},
    tolerance: float = 0.0,
    layers: Any = None,
    origin: Optional[Sequence[float]] = None,
    robot_radius: float = 0.0,
    max_edge_length: Optional[float] = None,
) -> PlanResult:
    """A path over a map. Ctrl+C ends it.

    Args:
        map_or_file: a map; or a file, which is read for this one plan (`load_map` reads it once).
        start, goal: x, y and z (m); x and y where there is only one surface; or a `Pose`. Without
            a pose, the path ends with the heading of the straight line from start to goal.
        planner: one of `SHORT_NAMES`, the type of any plugin, or what `make_planner` returned.
        parameters: of the planner, those that differ from their defaults.
        tolerance: where the goal cannot be reached, the path may end this far from it (m).
        layers: of a map from a file, see `load_map`; None: every vertex is free.
        origin: of a map from a file, see `load_map`; start and goal are in the map's frame.
        robot_radius: that its middle keeps from what is lethal or unknown (m), as the parameter of
            the server; 0: a point.
        max_edge_length: of a map from a file, see `load_map`.

    Returns:
        The result; that there is no path is a result too.

    Raises:
        MeshMapError: a file, layer, planner, parameter or place that cannot be used.
    """
    shape = round_shape(robot_radius)
    if isinstance(planner, str):
        check_planner(planner, parameters)  # before a map is read
    if not isinstance(map_or_file, MeshMap):
        map_or_file = load_map(
            map_or_file,
            layers,
            origin=origin,
            robot_radius=robot_radius,
            max_edge_length=max_edge_length,
        )
    elif layers is not None:
        raise MeshMapError("layers are for a map from a file", "map.compute_layers() has others")
    elif origin is not None:
        raise MeshMapError("origin is for a map from a file", "MeshMap() takes one")
    elif max_edge_length is not None:
        raise MeshMapError("max_edge_length is for a map from a file", "load_map() takes one")
    first, last = ends(map_or_file, start, goal)
    if isinstance(planner, str):
        planner = make_planner(map_or_file, planner, parameters, body_on(map_or_file, shape))
    elif parameters:
        raise MeshMapError("parameters are for a planner by name", "planner.set_parameters()")
    elif not shape.is_point:
        raise MeshMapError("robot_radius is for a planner by name", "make_planner() takes a body")
    return plan_interruptibly(planner, first, last, tolerance)


def round_shape(robot_radius: float) -> RobotShape:
    """The shape of a robot with a radius (m); 0: a point.

    Raises:
        MeshMapError: none from 0 to 100 m.
    """
    return RobotShape.of_parameters({"robot_radius": robot_radius})


def body_on(mesh_map: MeshMap, shape: RobotShape) -> Body:
    """The body of a robot of that shape on a map, for `make_planner`."""
    return POINT if shape.is_point else Body(mesh_map.geometry, shape)


def planner_type(name: str) -> str:
    """The type of a planner by its short name; types of plugins are left as they are.

    Raises:
        MeshMapError: neither of them.
    """
    if name not in SHORT_NAMES and "/" not in name:
        known = ", ".join(SHORT_NAMES)
        raise MeshMapError(f"there is no planner '{name}'", f"known: {known}, types of plugins")
    return SHORT_NAMES.get(name, name)


def make_planner(
    mesh_map: MeshMap,
    planner: str = "wave_front",
    parameters: Mapping[str, Any] = {},
    body: Body = POINT,
) -> MeshPlanner:
    """A planner for many plans on one map, for a robot with a body; other arguments as of `plan`.

    Raises:
        MeshMapError: no such planner, or a name or value that is none of its parameters.
    """
    return ready_plugin(PLANNERS, planner_type(planner), mesh_map, parameters, planner, body)


def check_planner(planner: str, parameters: Mapping[str, Any]) -> MeshPlanner:
    """A planner that has no map yet; arguments of `plan`, errors of `make_planner`."""
    return checked_plugin(PLANNERS, planner_type(planner), parameters, planner)


def ends(mesh_map: MeshMap, start: Place, goal: Place) -> List[Pose]:
    """Start and goal as poses, in the frame of the map; places as for `plan`.

    Raises:
        MeshMapError: no numbers, or two of them where there is none or more than one surface.
    """
    places = [
        place if isinstance(place, Pose) else _position(mesh_map, place, what)
        for place, what in ((start, "start"), (goal, "goal"))
    ]
    points = [place.position if isinstance(place, Pose) else place for place in places]
    along = np.subtract(points[1][:2], points[0][:2])
    yaw = float(np.arctan2(along[1], along[0]))
    return [place if isinstance(place, Pose) else Pose.at(place, yaw) for place in places]


def _position(mesh_map: MeshMap, place: Sequence[float], what: str) -> np.ndarray:
    try:
        point = np.asarray(place, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MeshMapError(f"{what} {place!r} is no x, y, z: {error}") from error
    if point.shape not in ((2,), (3,)):
        raise MeshMapError(f"{what} {place!r} is no x, y, z, but {point.size} numbers")
    if len(point) == 3:
        return point
    heights = surface_heights(mesh_map, *point)
    if len(heights) == 1:
        return np.array([*point, heights[0]])
    there = f"at x = {point[0]:g}, y = {point[1]:g}"
    if heights:
        known = ", ".join(f"{height:.2f}" for height in heights)
        raise MeshMapError(f"{what}: {there} there are surfaces at z = {known}", "give z, too")
    low, high = mesh_map.vertices.min(axis=0), mesh_map.vertices.max(axis=0)
    if ((low[:2] <= point) & (point <= high[:2])).all():
        hint = "the map has a hole there: choose a place on its surface"
    else:
        reach = (f"{axis} from {low[i]:g} to {high[i]:g}" for i, axis in enumerate("xy"))
        hint = f"the map has {', '.join(reach)} m"
    raise MeshMapError(f"{what}: there is no surface {there}", hint)


def surface_heights(mesh_map: MeshMap, x: float, y: float) -> List[float]:
    """Where a vertical line meets the surface: z of each (m), from above.

    What follows within `MAX_DISTANCE` of the one above it is the same surface to a robot.
    """
    heights: List[float] = []
    last = np.inf
    origin = np.array([x, y, float(mesh_map.vertices[:, 2].max()) + 1.0])
    while True:
        hit = mesh_map.spatial_index.cast(origin=origin, direction=(0, 0, -1))
        if hit is None:
            return heights
        z = float(hit.position[2])
        if last - z > MAX_DISTANCE:
            heights.append(z)
        last = z
        origin[2] = min(z, origin[2]) - _STEP * max(1.0, abs(z))


_STEP = 1e-4  # m below a surface, where the next one is looked for


def plan_interruptibly(
    planner: MeshPlanner, start: Pose, goal: Pose, tolerance: float = 0.0
) -> PlanResult:
    """A plan that Ctrl+C ends, in the main thread; the result is checked as a server does it.

    Raises:
        KeyboardInterrupt: after the planner has stopped, or 2 s later if it does not listen.
    """

    def work(cancellation: Cancellation) -> Any:
        try:
            return planner.make_plan(start, goal, tolerance, cancellation)
        except BaseException as error:  # It is raised again where the caller is.
            return error

    attempt = Attempt("plan", work)
    try:
        attempt.start()
        attempt.wake.wait()
    except KeyboardInterrupt:
        attempt.cancellation.cancel("interrupted")
        attempt.wake.wait(GRACE)
        raise
    (answer,) = attempt.results
    if isinstance(answer, BaseException):
        raise answer
    return checked_result(answer)
