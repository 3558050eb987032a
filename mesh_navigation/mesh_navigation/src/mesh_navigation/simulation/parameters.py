"""Parameters of the node surface_robot."""

from typing import Any, Mapping

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter

MAP_TOPIC = "/move_base_flex/mesh_map/mesh"

SCAN_PARAMETERS = (
    Parameter("scan_rate", 5.0, 0.0, 100.0, "clouds in a second (Hz); 0: none"),
    Parameter("scan_rings", 16, 1, 1024, "rays above each other"),
    Parameter("scan_columns", 360, 1, 36000, "rays around"),
    Parameter("scan_lowest", -0.6, -1.5707, 1.5707, "elevation of the lowest ring (rad)"),
    Parameter("scan_highest", 0.26, -1.5707, 1.5707, "elevation of the highest ring (rad)"),
    Parameter("scan_min_range", 0.3, 0.0, 1000.0, "m"),
    Parameter("scan_max_range", 30.0, 0.1, 10000.0, "m"),
    Parameter("scan_noise", 0.0, 0.0, 10.0, "of ranges (m, standard deviation)"),
    Parameter("scan_dropout", 0.0, 0.0, 1.0, "share of the rays without a return, at random"),
    Parameter(
        "scan_reflect_range",
        0.0,
        0.0,
        10000.0,
        "m at which a white surface met upright is just seen, others nearer: at grazing incidence"
        " no return; 0: all are seen",
    ),
    Parameter(
        "scan_duration",
        0.0,
        0.0,
        10.0,
        "s of a revolution, column after column while the robot moves, at most the time between"
        " two clouds; 0: all at once",
    ),
)
"""Of the lidar."""

ODOMETRY_PARAMETERS = (
    Parameter("slip", 0.0, 0.0, 1.0, "share of what the wheels turn that does not move it"),
    Parameter(
        "odometry_yaw_drift", 0.0, -3.2, 3.2, "heading that the odometry gains on a meter (rad)"
    ),
)
"""Of what is wrong with the odometry."""

CHANGING_PARAMETERS = SCAN_PARAMETERS + ODOMETRY_PARAMETERS
"""Those that change while the node runs, by dynamic_reconfigure, too."""

PARAMETERS = (
    # The map.
    Parameter("mesh_file", "", description="map or mesh; empty: the map comes from mesh_topic"),
    Parameter("mesh_part", "", description="group of the map file; empty: mesh, or the only one"),
    Parameter("origin", (), description="x, y, z (m): subtracted from coordinates of mesh_file"),
    Parameter("mesh_topic", MAP_TOPIC, description="mesh_msgs/MeshGeometryStamped"),
    Parameter("costs_topic", "", description="of the costs that the robot waits for to begin"),
    # Time.
    Parameter("rate", 50.0, 1.0, 1000.0, "steps of the simulation in a second of it (Hz)"),
    Parameter("publish_clock", False, description="time is simulated and published on /clock"),
    Parameter("real_time_factor", 1.0, 0.0, 1000.0, "with publish_clock; 0: as fast as possible"),
    # The robot.
    Parameter("initial_pose", (), description="x, y, z (m), yaw (rad); empty: on free ground"),
    Parameter("max_speed", 1.5, 0.0, 100.0, "ahead and back (m/s)"),
    Parameter("max_side_speed", 0.0, 0.0, 100.0, "to the sides (m/s)"),
    Parameter("max_turn_speed", 3.0, 0.0, 100.0, "rad/s"),
    Parameter("max_acceleration", 2.5, 0.01, 1000.0, "m/s^2"),
    Parameter("max_turn_acceleration", 6.0, 0.01, 1000.0, "rad/s^2"),
    Parameter("max_slope", 1.0, 0.0, 3.2, "steeper faces stop the robot (rad)"),
    Parameter("max_step", 0.2, 0.0, 10.0, "but sides of steps do not that are not higher (m)"),
    Parameter("cmd_vel_timeout", 0.5, 0.0, 100.0, "it stops without a command for so long (s)"),
    *ODOMETRY_PARAMETERS,
    Parameter("motion_noise", 0.0, 0.0, 1.0, "m after 1 m, rad after 1 rad (standard deviation)"),
    Parameter("odometry_noise", 0.0, 0.0, 1.0, "the same, of what the odometry counts"),
    Parameter("seed", 0, 0, None, "of all noise"),
    # Frames.
    Parameter("odom_frame", "odom", description="frame of the odometry"),
    Parameter("footprint_frame", "base_footprint", description="the robot, on the surface"),
    Parameter("base_frame", "base_link", description="the robot, base_height above it"),
    Parameter("sensor_frame", "laser", description="sensor_height above base_frame"),
    Parameter("base_height", 0.0, 0.0, 100.0, "m"),
    Parameter("sensor_height", 0.8, 0.0, 100.0, "m"),
    Parameter("localization", True, description="publish where odom is in the map, exactly"),
    *SCAN_PARAMETERS,
)
"""All but obstacles, see `mesh_navigation.simulation.obstacles.read_obstacles`."""


def check_frames(values: Mapping[str, Any], map_frame: str = "") -> None:
    """Refuse frames between which there is no chain of transforms.

    Args:
        values: of all parameters.
        map_frame: that of the map, where it is known.

    Raises:
        MeshMapError: one is empty, or the same as another that it is not fixed to.
    """
    names = {key: values[key].strip("/") for key in _CHAIN}
    fixed = [pair for pair in zip(_CHAIN[1:], _CHAIN[2:]) if names[pair[0]] == names[pair[1]]]
    chain = [names[key] for key in _CHAIN if key not in [child for _, child in fixed]]
    if map_frame and values["localization"]:
        chain.insert(0, map_frame)
    if not all(chain) or len(set(chain)) < len(chain):
        told = ", ".join(f"{key} '{name}'" for key, name in names.items())
        told += f" and the map's '{map_frame}'" if map_frame else ""
        raise MeshMapError(f"the frames make no chain: {told}", "give them different names")


_CHAIN = ("odom_frame", "footprint_frame", "base_frame", "sensor_frame")
