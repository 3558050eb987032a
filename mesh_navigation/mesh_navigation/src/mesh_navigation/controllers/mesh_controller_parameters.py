"""Parameters of the mesh controller."""

from mesh_map.parameter import Parameter

FIELD, PATH = "field", "path"

PARAMETERS = (
    Parameter("max_lin_velocity", 1.0, 0.0, 5.0, "fastest (m/s)"),
    Parameter("max_ang_velocity", 0.5, 0.0, 2.0, "fastest turn, to either side (rad/s)"),
    Parameter("max_lin_acceleration", 1.0, 0.05, 20.0, "to drive and to brake (m/s^2)"),
    Parameter("max_ang_acceleration", 2.0, 0.05, 50.0, "of turns (rad/s^2)"),
    Parameter("min_lin_velocity", 0.05, 0.0, 1.0, "slowest on arrival (m/s)"),
    Parameter("arrival_fading", 0.5, 0.0, 5.0, "slows down over this way to the goal (m)"),
    Parameter("ang_vel_factor", 1.0, 0.1, 10.0, "multiplies turns, within their limit"),
    Parameter("lin_vel_factor", 1.0, 0.1, 10.0, "multiplies speeds, within their limit"),
    Parameter("max_angle", 20.0, 1.0, 180.0, "to the carrot; beyond, turns on the spot (deg)"),
    Parameter("lookahead_distance", 0.6, 0.05, 5.0, "how far ahead it looks (m)"),
    Parameter("blocked_distance", 0.3, 0.0, 5.0, "stops this far before blocked surface (m)"),
    Parameter("side_clearance", 0.1, 0.0, 1.0, "room beside it, where there is any (m)"),
    Parameter("max_path_distance", 1.0, 0.05, 10.0, "from the path that it follows (m)"),
    Parameter("max_search_radius", 0.4, 0.01, 2.0, "around where it was, for the surface (m)"),
    Parameter("max_search_distance", 0.4, 0.01, 2.0, "from the surface, still on the map (m)"),
    Parameter("turn_to_goal_heading", True, description="turns to the goal's heading at the end"),
    Parameter(
        "stuck_timeout", 4.0, 0.0, 60.0, "told to move, but not moving (s), 0: not looked at"
    ),
    Parameter("follow", FIELD, description="of the plan: field or path", choices=(FIELD, PATH)),
)
