"""mesh_tool record-scans: a simulated drive over a mesh, as a bag or a folder of clouds."""

import argparse
import importlib
import math
from typing import List, Optional

import numpy as np
from mesh_msgs_hdf5.commands._common import add_output_options, add_part, say
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.files.save import check_target
from mesh_msgs_hdf5.formats.base.options import NEEDED
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.commands.map_errors import as_map_errors
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.scans.lidar import LidarModel
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.recording import Recording, record_scans, scan_times
from mesh_map.scans.scan_folder import FORMS, check_folder, write_scan_folder
from mesh_map.scans.tour import HEADROOM, MAX_SLOPE, RADIUS, tour

NAME = "record-scans"
HELP = "drive a simulated lidar over a mesh, and record it as a bag or a folder of clouds"
EXAMPLE = "mesh_tool record-scans garden.h5 drive.bag --rings 32 --yaw-drift 0.002 --seed 1"

BAG = ".bag"
POSE_RATE = 50.0  # Hz, of tf, odometry and truth
BEGIN = 1000.0  # s, the time at which a recording begins


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="IN", help="a map file, or any mesh that import reads")
    text = "the bag to make, if its name ends with .bag; else a folder"
    parser.add_argument("output", metavar="OUT", help=text)
    add_part(parser, "IN, if it is a map with several")
    path = parser.add_argument_group("the drive")
    text = "places to drive through, m in the map's frame (default: a tour of --count places)"
    path.add_argument("--waypoints", type=_place, nargs="+", metavar="X,Y,Z", help=text)
    text = "places of a tour that ends where it begins (default: 8)"
    path.add_argument("--count", type=int, default=8, metavar="N", help=text)
    _numbers(path, "--speed", 1.0, "M/S", "of the robot")
    _numbers(path, "--max-slope", MAX_SLOPE, "RAD", "the steepest ground to drive on")
    _numbers(path, "--radius", RADIUS, "M", "how far the robot keeps from all else")
    _numbers(path, "--headroom", HEADROOM, "M", "that the robot needs above the ground")
    text = "of tour, noise, dropouts and odometry; the same seed records the same (default: 0)"
    path.add_argument("--seed", type=int, default=0, metavar="N", help=text)
    lidar = parser.add_argument_group("the lidar")
    _numbers(lidar, "--rate", 10.0, "HZ", "revolutions in a second")
    text = "so many scans, evenly along the drive, instead of --rate"
    lidar.add_argument("--scans", type=int, metavar="N", help=text)
    text = "measure each scan at once from one place: no motion of the robot is in it"
    lidar.add_argument("--still", action="store_true", help=text)
    _numbers(lidar, "--sensor-height", 1.0, "M", "above the ground")
    lidar.add_argument("--rings", type=int, default=32, metavar="N", help="default: 32")
    lidar.add_argument("--columns", type=int, default=1024, metavar="N", help="default: 1024")
    _numbers(lidar, "--lowest", -0.6, "RAD", "elevation of the lowest ring")
    _numbers(lidar, "--highest", 0.26, "RAD", "elevation of the highest ring")
    _numbers(lidar, "--min-range", 0.3, "M", "")
    _numbers(lidar, "--max-range", 30.0, "M", "")
    _numbers(lidar, "--noise", 0.01, "M", "of ranges, standard deviation")
    _numbers(lidar, "--dropout", 0.0, "SHARE", "of the rays without a return, 0 to 1")
    text = "up to where a white surface met upright is seen; dark and grazing ones are lost nearer"
    _numbers(lidar, "--reflect-range", math.inf, "M", text)
    drift = parser.add_argument_group("what odometry counts wrong (the truth is recorded, too)")
    _numbers(drift, "--slip", 0.0, "SHARE", "of the motion that it counts too much")
    _numbers(drift, "--yaw-drift", 0.0, "RAD", "to the left after a meter")
    _numbers(drift, "--height-drift", 0.0, "M", "upwards after a meter")
    _numbers(drift, "--odometry-noise", 0.0, "M", "and rad after a meter, standard deviation")
    text = "of clouds in a folder (default: ply)"
    parser.add_argument("--format", choices=sorted(FORMS), default="ply", help=text)
    parser.add_argument("--force", action="store_true", help="replace a recording that is there")
    add_output_options(parser)


def _numbers(
    group: "argparse._ArgumentGroup", name: str, default: float, unit: str, text: str
) -> None:
    shown = "%s (default: %g)" % (text, default) if text else "default: %g" % default
    group.add_argument(name, type=float, default=default, metavar=unit, help=shown)


def _place(text: str) -> List[float]:
    values = [float(value) for value in text.split(",")]
    if len(values) != 3 or not np.isfinite(values).all():
        raise ValueError(text)
    return values


_place.__name__ = "place (X,Y,Z)"  # of the error


def run(arguments: argparse.Namespace) -> int:
    is_bag = arguments.output.endswith(BAG)
    if is_bag:
        check_target(arguments.output, arguments.force)
    else:
        check_folder(arguments.output, arguments.force)
    with ProgressLine(arguments.quiet) as progress, as_map_errors(arguments.input) as notes:
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(arguments.input, arguments.part, origin=NEEDED)
        notes += report.notes
        geometry = MeshGeometry(
            mesh.parent_vertices, mesh.parent_faces, frame_id=mesh.frame_id, orient=True
        )
        colors = mesh.vertex_colors
        if colors is not None:
            colors = colors[: len(geometry.vertices)]
        progress.stage("planning a drive")
        recording = _recording(arguments, geometry, colors)
        progress.stage("recording " + arguments.output)

        def tell(count: int) -> None:
            progress.part(count / recording.count)

        if is_bag:
            # rosbag imports rospy: only who writes a bag needs it.
            written = importlib.import_module("mesh_map.scans.bag_ros").write_bag(
                arguments.output, recording, arguments.force, tell
            )
        else:
            written = write_scan_folder(
                arguments.output, recording, arguments.format, arguments.force, tell
            )
    return _said(arguments, recording, written, notes)


def _recording(
    arguments: argparse.Namespace, geometry: MeshGeometry, colors: Optional[np.ndarray]
) -> Recording:
    drive = tour(
        geometry,
        waypoints=arguments.waypoints,
        count=arguments.count,
        seed=arguments.seed,
        speed=arguments.speed,
        begin=BEGIN,
        max_slope=arguments.max_slope,
        radius=arguments.radius,
        headroom=arguments.headroom,
    ).resampled(POSE_RATE)
    seconds = drive.times[-1] - drive.times[0]
    rate, wanted = arguments.rate, arguments.scans
    duration = 1 / rate if rate > 0 and not arguments.still else 0.0
    if wanted is not None:
        if wanted < 1:
            text = "%d scans are to be recorded" % wanted
            raise MapFileError("value", arguments.output, text, "--scans 1 or more")
        # The last one ends with the drive; a single one is at its beginning.
        rate = (wanted - 1 if wanted > 1 else 0.5) / max(seconds - duration, 1e-3)
    lidar = LidarModel(
        rings=arguments.rings,
        columns=arguments.columns,
        lowest=arguments.lowest,
        highest=arguments.highest,
        min_range=arguments.min_range,
        max_range=arguments.max_range,
        noise=arguments.noise,
        dropout=arguments.dropout,
        reflect_range=arguments.reflect_range,
        duration=duration,
    )
    drift = OdometryDrift(
        slip=arguments.slip,
        yaw=arguments.yaw_drift,
        height=arguments.height_drift,
        noise=arguments.odometry_noise,
    )
    odometry = drift.of(drive, arguments.seed)
    height = arguments.sensor_height
    scans = record_scans(
        geometry,
        drive.above(height),
        lidar=lidar,
        odometry=odometry.above(height),
        rate=rate,
        seed=arguments.seed,
        colors=colors,
    )
    count = len(scan_times(drive, rate, duration))
    return Recording(drive, odometry, height, scans, count, geometry.frame_id)


def _said(
    arguments: argparse.Namespace, recording: Recording, points: int, notes: List[str]
) -> int:
    truth = recording.truth
    seconds = float(truth.times[-1] - truth.times[0])
    apart = np.linalg.norm(recording.odometry.positions[-1] - truth.positions[-1])
    value = {
        "input": arguments.input,
        "output": arguments.output,
        "scans": recording.count,
        "points": points,
        "length": truth.length,
        "seconds": seconds,
        "drift": float(apart),
        "notes": notes,
    }
    text = "%s: %d scans of %d points on a drive of %.1f m in %.1f s"
    line = text % (arguments.output, recording.count, points, truth.length, seconds)
    if apart:
        line += "; odometry ends %.3f m from the truth" % apart
    say(arguments, value, [line, *("  note: " + note for note in notes)])
    return 0
