"""Parameters of the Move Base Flex server itself."""

import math

from mesh_map.base.parameter import Parameter

RESTORE_DEFAULTS = "restore_defaults"
# For several drives: the newest has the robot, no other one begins, or it ends the others.
NEWEST, REFUSE, PREEMPT = "newest", "refuse", "preempt"

DYNAMIC_PARAMETERS = (
    Parameter("planner_frequency", 0.0, 0.0, 100.0, "new plans while driving (Hz), 0: none"),
    Parameter("planner_patience", 5.0, 0.0, 100.0, "longest time for a plan (s), 0: no limit"),
    Parameter("planner_max_retries", -1, -1, 1000, "retries of a failed plan, -1: no limit"),
    Parameter("controller_frequency", 20.0, 0.0, 100.0, "commands per second (Hz)"),
    Parameter("controller_patience", 5.0, 0.0, 100.0, "without a command (s), 0: no limit"),
    Parameter("controller_max_retries", -1, -1, 1000, "cycles without a command, -1: no limit"),
    Parameter("recovery_enabled", True, description="move_base tries recovery behaviors"),
    Parameter("recovery_patience", 15.0, 0.0, 100.0, "longest time for one (s), 0: no limit"),
    Parameter("oscillation_timeout", 0.0, 0.0, 60.0, "without getting on (s), 0: no limit"),
    Parameter("oscillation_distance", 0.5, 0.0, 10.0, "what counts as getting on (m)"),
    Parameter("oscillation_angle", 3.14, 0.0, 6.28, "what counts as getting on, too (rad)"),
    Parameter(RESTORE_DEFAULTS, False, description="set all of these to their defaults"),
)
"""Those that dynamic_reconfigure may change, at once also for goals that are executed."""
STATIC_PARAMETERS = (
    Parameter("robot_frame", "base_link", description="the robot's frame in TF"),
    Parameter("odom_frame", "odom", description="up to here TF is odometry, beyond a localizer"),
    Parameter("odom_timeout", 0.3, 0.0, None, "greatest age of transforms of odometry (s)"),
    Parameter("map_timeout", 2.0, 0.0, None, "greatest age of transforms of a localizer (s)"),
    Parameter("tf_timeout", 3.0, 0.0, None, "wait for a transform (s)"),
    Parameter("tf_cache_time", 10.0, 0.1, None, "how far TF is remembered (s)"),
    Parameter("localization_topic", "", description="mesh_msgs/LocalizationState; empty: none"),
    Parameter("localization_timeout", 1.0, 0.1, None, "it is lost when silent for longer (s)"),
    Parameter("localization_patience", 60.0, 0.0, None, "wait for it (s), 0: no limit"),
    Parameter("odom_topic", "odom", description="nav_msgs/Odometry for the velocity; empty: none"),
    Parameter("dist_tolerance", 0.1, 0.0, None, "how near to the goal is there (m)"),
    Parameter("angle_tolerance", math.pi / 18, 0.0, None, "how well its heading is met (rad)"),
    Parameter("mbf_tolerance_check", False, description="the server checks tolerances as well"),
    Parameter("cmd_vel_ignored_tolerance", 5.0, None, None, "robot does not obey (s), <= 0: off"),
    Parameter("wait_for_map", True, description="goals wait for the map; false: they fail"),
    Parameter("velocity_guard", True, description="false: straight to the base, unguarded"),
    Parameter("guard", {}, description="the guard's own parameters, see GUARD_PARAMETERS"),
    Parameter(
        "concurrent_drives",
        NEWEST,
        description="of goals in several slots of exe_path",
        choices=(NEWEST, REFUSE, PREEMPT),
    ),
)
"""Those that are read at the start."""
GUARD_PARAMETERS = (
    Parameter("max_lin_velocity", 5.0, 0.0, None, "fastest (m/s)"),
    Parameter("max_ang_velocity", 5.0, 0.0, None, "fastest turn, to either side (rad/s)"),
    Parameter("max_lin_acceleration", 20.0, 0.05, None, "to gain speed; braking is free (m/s^2)"),
    Parameter("max_ang_acceleration", 50.0, 0.05, None, "the same of turns (rad/s^2)"),
    Parameter("zone_topic", "", description="sensor_msgs/PointCloud2 for the zone; empty: none"),
    Parameter("zone_box", (), description="x, y, z: their least and greatest (m, robot's frame)"),
    Parameter("zone_min_points", 3, 1, None, "in the box, from which on the robot stands"),
    Parameter("zone_timeout", 0.5, 0.01, None, "how old a cloud may be (s)"),
)
"""Those of the guard, read at the start below guard: no plugin here can be set to more."""
PARAMETERS = DYNAMIC_PARAMETERS + STATIC_PARAMETERS
"""Names, defaults and limits of Move Base Flex, where it has them."""
