"""A recording as a folder: a cloud for each scan, and its poses, odometry's and true ones."""

import os
import re
import secrets
import shutil
from typing import Callable, Iterator, List, Tuple

import numpy as np
from mesh_msgs_hdf5.files.save import save_file
from mesh_msgs_hdf5.formats.clouds.pcd_cloud import write_pcd_cloud
from mesh_msgs_hdf5.formats.clouds.ply_cloud import write_ply_cloud
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, pose_lines
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.scans.recording import RecordedScan, Recording

FORMS = {"ply": write_ply_cloud, "pcd": write_pcd_cloud}
POSES, TRUTH = "poses.txt", "truth.txt"
_OURS = re.compile(r"\d{6}\.(ply|pcd)|poses\.txt|truth\.txt")
_SHOWN = 3  # names of files of others

Progress = Callable[[int], None]
"""Called with the number of scans that are written."""


def check_folder(path: str, overwrite: bool) -> None:
    """Refuse early a folder that write_scan_folder would refuse. Raises MapFileError."""
    folder = os.path.abspath(path)
    if not os.path.isdir(os.path.dirname(folder)):
        text = "the folder %s does not exist" % os.path.dirname(folder)
        raise MapFileError("save", path, text, "make it first")
    if not os.path.lexists(folder):
        return
    if not os.path.isdir(folder) or os.path.islink(folder):
        raise MapFileError(
            "exists", path, "it exists already, and is no folder", "name another one"
        )
    names = sorted(os.listdir(folder))
    others = [name for name in names if not _OURS.fullmatch(name)]
    if others:
        text = "the folder has %d other files than those of a recording: %s"
        shown = ", ".join(others[:_SHOWN]) + (", ..." if len(others) > _SHOWN else "")
        raise MapFileError("exists", path, text % (len(others), shown), "name another one")
    if names and not overwrite:
        text = "the folder has a recording of %d files already" % len(names)
        raise MapFileError("exists", path, text, "use --force to replace it")


def write_scan_folder(
    path: str,
    recording: Recording,
    form: str = "ply",
    overwrite: bool = False,
    tell: Progress = lambda count: None,
) -> int:
    """Write clouds 000000.ply and so on, poses.txt and truth.txt (TUM: time x y z qx qy qz qw of
    the lidar in the map's frame, a line for each cloud), and return the number of points.

    Points have x, y, z (m) in the lidar's frame at the time of the scan, with the motion undone as
    odometry knows it, intensity (0 to 255), ring and time (s after that of the scan), of a mesh
    with colors red, green and blue. All of it is written into a folder beside, which takes the
    place of `path` when it is complete.

    Args:
        path: made; a recording that is there is replaced if `overwrite`.
        recording: its scans are gone through.
        form: ply or pcd.
        overwrite: see path.
        tell: called after each scan.

    Raises:
        MapFileError: exists (a folder that has, or may not get, this), save (the disk).
    """
    check_folder(path, overwrite)
    folder = os.path.abspath(path)
    temporary = "%s.%s.tmp" % (folder, secrets.token_hex(4))
    try:
        os.mkdir(temporary)
        try:
            points = _fill(temporary, recording, form, tell)
            check_folder(path, overwrite)  # it took a while
            _replace(temporary, folder)
        except BaseException:  # also an interrupt: leave nothing behind
            shutil.rmtree(temporary, ignore_errors=True)
            raise
    except MapFileError as error:  # of a file in a folder that is gone again
        raise MapFileError(error.code, path, error.message, error.hint) from error
    except OSError as error:
        text = "the folder cannot be written: %s" % error.strerror
        raise MapFileError("save", path, text, "make room, or name another place") from error
    return points


def _replace(temporary: str, folder: str) -> None:
    if not os.path.isdir(folder):
        os.rename(temporary, folder)
        return
    before = "%s.%s.tmp" % (folder, secrets.token_hex(4))
    os.rename(folder, before)
    try:
        os.rename(temporary, folder)
    except BaseException:
        os.rename(before, folder)
        raise
    for name in os.listdir(before):  # those of a recording alone, see check_folder
        os.unlink(os.path.join(before, name))
    os.rmdir(before)


def _fill(folder: str, recording: Recording, form: str, tell: Progress) -> int:
    poses: List[ScanPose] = []
    truths: List[ScanPose] = []
    points = 0
    for number, recorded in enumerate(recording.scans):
        rows = _rows(recorded)
        target = os.path.join(folder, "%06d.%s" % (number, form))

        def write(descriptor: int, target: str = target, rows: np.ndarray = rows) -> None:
            with os.fdopen(os.dup(descriptor), "wb") as stream:
                blocks: Iterator[np.ndarray] = iter([rows])
                FORMS[form](target, stream, len(rows), rows.dtype, blocks)

        save_file(target, write)
        poses.append(ScanPose(recorded.scan.pose, recorded.scan.time))
        truths.append(ScanPose(recorded.truth, recorded.scan.time))
        points += len(rows)
        tell(number + 1)
    for name, lines in ((POSES, poses), (TRUTH, truths)):
        save_file(os.path.join(folder, name), pose_lines(lines, "tum").encode("ascii"))
    return points


def _rows(recorded: RecordedScan) -> np.ndarray:
    """The points of a cloud, a record each."""
    scan, measured = recorded.scan, recorded.measured
    columns: List[Tuple[str, np.ndarray]] = list(zip("xyz", scan.points.T))
    columns += [("intensity", measured.intensities), ("ring", measured.rings)]
    columns += [("time", measured.times)]
    if scan.colors is not None:
        columns += list(zip(("red", "green", "blue"), scan.colors.T))
    rows = np.zeros(len(scan.points), [(name, values.dtype.str) for name, values in columns])
    for name, values in columns:
        rows[name] = values
    return rows
