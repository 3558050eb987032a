"""Parameters of the node mesh_localization."""

import math
from typing import Any, Dict, List, Mapping, NamedTuple, Optional

import numpy as np
from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter, checked_values

from mesh_localization.node.start_pose import Start
from mesh_localization.sensing.sensor_scan import RangeLimits
from mesh_localization.tracking.localizer import TrackingOptions
from mesh_localization.tracking.odometry_model import OdometryModel

MAP_TOPIC = "/move_base_flex/mesh_map/mesh"
POINT_CLOUD, LASER_SCAN = "PointCloud2", "LaserScan"

_OPTIONS, _ODOMETRY = TrackingOptions(), OdometryModel()

SOURCE_PARAMETERS = (
    Parameter("topic", "cloud", description="of the sensor's clouds or scans"),
    Parameter(
        "data_type", POINT_CLOUD, description="of sensor_msgs", choices=(POINT_CLOUD, LASER_SCAN)
    ),
)
"""Of the one sensor, or below the name of each in observation_sources."""

DYNAMIC_PARAMETERS = (
    # What is used of scans.
    Parameter("laser_min_range", -1.0, -1.0, 1000.0, "m; nearer points are not used; -1: all are"),
    Parameter("laser_max_range", -1.0, -1.0, 10000.0, "m; the same of farther ones; -1: all are"),
    Parameter("laser_max_beams", 2000, 40, 1000000, "rays of one scan that are used"),
    Parameter("update_min_d", 0.0, 0.0, 100.0, "m that the robot has to drive, ..."),
    Parameter("update_min_a", 0.0, 0.0, 7.0, "... or rad to turn, until the next scan is used"),
    Parameter(
        "relocalization_radius",
        10.0,
        0.5,
        10000.0,
        "m around the last known pose, in which relocalize_nearby looks for the robot",
    ),
    # Transforms.
    Parameter("transform_tolerance", 0.1, 0.0, 10.0, "s that map to odom is stamped ahead"),
    Parameter("transform_rate", 20.0, 0.1, 1000.0, "Hz at which it is repeated between scans"),
    Parameter("tf_timeout", 0.3, 0.0, 10.0, "s that a scan waits for its transforms"),
    Parameter("tf_broadcast", True, description="publish map to odom"),
    # What odometry is off.
    Parameter(
        "odom_alpha1",
        _ODOMETRY.rotation_by_rotation,
        0.0,
        10.0,
        "rad^2 that odometry is off for each rad^2 turned",
    ),
    Parameter("odom_alpha2", _ODOMETRY.rotation_by_translation, 0.0, 10.0, "rad^2 for each m^2"),
    Parameter("odom_alpha3", _ODOMETRY.translation_by_translation, 0.0, 10.0, "m^2 for each m^2"),
    Parameter("odom_alpha4", _ODOMETRY.translation_by_rotation, 0.0, 10.0, "m^2 for each rad^2"),
    # When a pose is believed.
    Parameter("tolerance", _OPTIONS.tolerance, 0.001, 10.0, "m that points may be off the map"),
    Parameter("ok_share", _OPTIONS.ok_share, 0.0, 1.0, "of the rays, that the map has to explain"),
    Parameter("sure_share", _OPTIONS.sure_share, 0.0, 1.0, "the same, of who was put or was lost"),
    Parameter("lost_share", _OPTIONS.lost_share, 0.0, 1.0, "with less the robot is lost"),
    Parameter(
        "confirmations", _OPTIONS.confirmations, 1, 1000, "scans in turn that have to agree for OK"
    ),
    Parameter("lost_scans", _OPTIONS.lost_scans, 1, 1000, "scans in turn that do not fit for LOST"),
    Parameter(
        "unbelieved_scans",
        _OPTIONS.unbelieved_scans,
        1,
        1000,
        "scans in turn that are not believed, of a view that is not hidden, for LOST",
    ),
    Parameter(
        "ok_position_deviation", _OPTIONS.ok_deviation[0], 0.0, 1000.0, "m; with more: UNCERTAIN"
    ),
    Parameter(
        "ok_rotation_deviation", _OPTIONS.ok_deviation[1], 0.0, math.pi, "rad; with more: UNCERTAIN"
    ),
    Parameter(
        "lost_position_deviation", _OPTIONS.lost_deviation[0], 0.0, 1000.0, "m; with more: LOST"
    ),
    Parameter(
        "lost_rotation_deviation", _OPTIONS.lost_deviation[1], 0.0, math.pi, "rad; with more: LOST"
    ),
    Parameter("scan_timeout", _OPTIONS.silence, 0.0, 100.0, "s without a scan until UNCERTAIN"),
    Parameter(
        "lost_timeout",
        _OPTIONS.lost_silence,
        0.0,
        100.0,
        "s without a scan until LOST; older scans are not used",
    ),
)
"""These change while the node runs, by dynamic_reconfigure, too."""

PARAMETERS = (
    # The map.
    Parameter("mesh_file", "", description="map or mesh; empty: the map comes from mesh_topic"),
    Parameter("mesh_part", "", description="group of the map file; empty: mesh, or the only one"),
    Parameter("origin", (), description="x, y, z (m): subtracted from coordinates of mesh_file"),
    Parameter("mesh_topic", MAP_TOPIC, description="mesh_msgs/MeshGeometryStamped"),
    # Sensors.
    *SOURCE_PARAMETERS,
    Parameter(
        "observation_sources",
        "",
        description="names of several sensors, spaces between them, each with topic and data_type",
    ),
    # Frames.
    Parameter("global_frame_id", "", description="frame of the map; empty: as the map says"),
    Parameter("odom_frame_id", "odom", description="frame of the odometry"),
    Parameter("base_frame_id", "base_link", description="the robot"),
    Parameter("base_height", 0.0, -100.0, 100.0, "m of base_frame_id above the ground"),
    Parameter("on_ground", True, description="the robot stands on the map; false: it flies"),
    # The start.
    Parameter("initial_pose_x", 0.0, -1e9, 1e9, "m, where the robot begins, if any is set"),
    Parameter("initial_pose_y", 0.0, -1e9, 1e9, "m"),
    Parameter("initial_pose_z", 0.0, -1e9, 1e9, "m; the nearest ground counts"),
    Parameter("initial_pose_a", 0.0, -1e9, 1e9, "rad about z"),
    Parameter("initial_cov_xx", 0.25, 1e-6, 1e6, "m^2, of a start that does not say it"),
    Parameter("initial_cov_yy", 0.25, 1e-6, 1e6, "m^2"),
    Parameter("initial_cov_aa", 0.0685, 1e-6, 10.0, "rad^2"),
    *DYNAMIC_PARAMETERS,
)
"""All but those of the sensors in observation_sources."""

_POSE = ("initial_pose_x", "initial_pose_y", "initial_pose_z", "initial_pose_a")


class SensorSource(NamedTuple):
    """A sensor: its name, the topic of its messages, and POINT_CLOUD or LASER_SCAN."""

    name: str
    topic: str
    data_type: str


def sensor_sources(values: Mapping[str, Any], given: Mapping[str, Any]) -> List[SensorSource]:
    """The sensors of a node.

    Args:
        values: checked ones of PARAMETERS.
        given: all parameters of the node, with dictionaries of the sensors.
    Raises:
        MeshMapError: what is no sensor; it is named.
    """
    names = list(dict.fromkeys(values["observation_sources"].replace(",", " ").split()))
    if not names:
        return [SensorSource(values["topic"], values["topic"], values["data_type"])]
    found = []
    for name in names:
        own = given.get(name, {})
        if not isinstance(own, Mapping):
            text = "sensor %s of observation_sources is %r, not a dictionary"
            raise MeshMapError(text % (name, own), "it has topic and data_type")
        try:
            checked, _ = checked_values(SOURCE_PARAMETERS, {"topic": name, **own})
        except MeshMapError as error:
            raise MeshMapError("sensor %s of observation_sources: %s" % (name, error)) from error
        found.append(SensorSource(name, str(checked["topic"]), str(checked["data_type"])))
    return found


def check_frames(values: Mapping[str, Any]) -> None:
    """Refuse frames between which there is no chain of transforms.

    Raises:
        MeshMapError: one is empty, or two are the same.
    """
    names = [values[key].strip("/") for key in ("odom_frame_id", "base_frame_id")]
    chain = [*names, values["global_frame_id"].strip("/") or "the map's"]
    if not all(names) or len(set(chain)) < len(chain):
        text = "odom_frame_id '%s', base_frame_id '%s' and global_frame_id '%s' make no chain"
        raise MeshMapError(text % tuple(chain), "give them different names")


def range_limits(values: Mapping[str, Any]) -> RangeLimits:
    """Which rays are used."""
    return RangeLimits(
        values["laser_min_range"], values["laser_max_range"], values["laser_max_beams"]
    )


def tracking_options(values: Mapping[str, Any]) -> TrackingOptions:
    """When a pose is believed; limits that contradict each other are put in order."""
    return TrackingOptions(
        odometry=OdometryModel(*(values["odom_alpha%d" % number] for number in (1, 2, 3, 4))),
        base_height=values["base_height"] if values["on_ground"] else None,
        tolerance=values["tolerance"],
        ok_share=values["ok_share"],
        sure_share=values["sure_share"],
        lost_share=min(values["lost_share"], values["ok_share"]),
        confirmations=values["confirmations"],
        lost_scans=values["lost_scans"],
        unbelieved_scans=values["unbelieved_scans"],
        ok_deviation=(values["ok_position_deviation"], values["ok_rotation_deviation"]),
        lost_deviation=(values["lost_position_deviation"], values["lost_rotation_deviation"]),
        silence=min(values["scan_timeout"], values["lost_timeout"]),
        lost_silence=values["lost_timeout"],
    )


def start_of(values: Mapping[str, Any], given: Mapping[str, Any]) -> Optional[Start]:
    """Where the robot begins; None where nothing of it is given, or what is no number."""
    told = [given[name] for name in _POSE if name in given]
    if not told or any(not isinstance(one, (int, float)) or not math.isfinite(one) for one in told):
        return None
    x, y, z, angle = (values[name] for name in _POSE)
    pose = np.eye(4)
    pose[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    pose[:3, 3] = x, y, z
    return Start(pose, np.zeros((6, 6)))


def start_variances(values: Mapping[str, Any]) -> Dict[int, float]:
    """Of a start that does not say how sure it is: index of x, y, angle -> m^2, rad^2."""
    return {
        0: values["initial_cov_xx"],
        1: values["initial_cov_yy"],
        5: values["initial_cov_aa"],
    }
