"""Scans of a map file written into a folder, as clouds, images and poses for other programs."""
import contextlib
import os
from typing import Callable, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from mesh_msgs_hdf5.files.save import save_file
from mesh_msgs_hdf5.formats.clouds.cloud import BLOCK_ROWS, GROUPED, checked_dtype
from mesh_msgs_hdf5.formats.clouds.pcd_cloud import write_pcd_cloud
from mesh_msgs_hdf5.formats.clouds.ply_cloud import write_ply_cloud
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, pose_lines
from mesh_msgs_hdf5.map_file.hdf5.hdf5_files import reading
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import HDF5_ERRORS, translated
from mesh_msgs_hdf5.map_file.scan_contents import (
    SCANS,
    check_there,
    dataset_at,
    image_of,
    root_of,
    scan_names,
    summary_of,
)
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_SHOWN = 5  # names of scans
_WRITERS: Dict[str, Callable] = {"pcd": write_pcd_cloud, "ply": write_ply_cloud}


def extract_scans(
    path: PathLike,
    folder: str,
    names: Sequence[str] = (),
    form: str = "pcd",
    pose_form: str = "kitti",
    overwrite: bool = False,
) -> Dict[str, List[str]]:
    """Write scans (all, or those named) into a folder: a cloud and images for each, and poses.txt
    with the final ones, a line for each cloud in the order of their names.

    form: pcd or ply; pose_form: kitti, tum, or none for no poses.txt. Returns the paths of `files`,
    `notes`, and `unreadable`: a text for each scan that cannot be read, which is left out. Raises
    MapFileError (value: some have no pose, or no time for tum, which nobody may invent).
    """
    files: List[str] = []
    notes: List[str] = []
    unreadable: List[str] = []
    summaries, poses = [], []
    with reading(path) as file:
        root = root_of(path, file)
        present = scan_names(root)
        check_there(path, present, names)
        for name in dict.fromkeys(names or present):
            with _named(path, name, unreadable):
                summaries.append(summary_of(root, name))
        with_poses = pose_form != "none" and _check_poses(path, summaries, pose_form, notes)
        _make_folder(folder)
        for summary in summaries:
            name = summary["name"]
            with _named(path, name, unreadable):
                target = os.path.join(folder, "%s.%s" % (name, form))
                _write_cloud(path, root, summary, target, form, overwrite)
                files.append(target)
                if with_poses:
                    poses.append(ScanPose(_pose(summary), summary["time"]))
                for photo in summary["images"]:
                    data, suffix = image_of(root, name, photo["name"])
                    target = os.path.join(folder, "%s_%s%s" % (name, photo["name"], suffix))
                    save_file(target, data, overwrite=overwrite)
                    files.append(target)
    if poses:
        files.append(os.path.join(folder, "poses.txt"))
        save_file(files[-1], pose_lines(poses, pose_form).encode("ascii"), overwrite=overwrite)
    return {"files": files, "notes": notes, "unreadable": unreadable}


@contextlib.contextmanager
def _named(path, name, unreadable):
    """What is wrong with a scan is noted; what is wrong with the folder is not its fault."""
    try:
        yield
    except MapFileError as error:
        if error.path != os.fsdecode(path):
            raise
        unreadable.append("%s: %s" % (name, error.message))


def _pose(summary) -> Optional[np.ndarray]:
    final = summary["final_pose"]
    return summary["initial_pose"] if final is None else final


def _check_poses(path, summaries, form, notes) -> bool:
    """Whether there are poses; refuses where some scans lack what a line of poses.txt needs."""
    lacking = [summary["name"] for summary in summaries if _pose(summary) is None]
    if lacking and len(lacking) == len(summaries):
        notes.append("no scan has a pose: there is no poses.txt (%s)" % _list(lacking))
        return False
    what = "pose"
    if not lacking and form == "tum":
        what = "time, which TUM's format wants"
        lacking = [summary["name"] for summary in summaries if summary["time"] is None]
    if lacking:
        text = "%d of %d scans have no %s: %s"
        text %= len(lacking), len(summaries), what, _list(lacking)
        kitti = "--poses kitti wants none, " if form == "tum" and what != "pose" else ""
        hint = kitti + "--poses none writes clouds and images alone, or name the other scans"
        raise MapFileError("value", path, text, hint)
    return True


def _list(names):
    return ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")


def _make_folder(folder):
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        text = "the folder cannot be made: %s" % error.strerror
        raise MapFileError("save", folder, text, "name another one") from error


def _write_cloud(path, root, summary, target, form, overwrite):
    place = "%s/%s/" % (SCANS, summary["name"])
    arrays = {name: dataset_at(root, place + name) for name in summary["channels"]}
    fields: List[Tuple] = []
    groups: Dict[str, Tuple[str, ...]] = {}
    for name, array in arrays.items():
        columns = 1 if array.ndim == 1 else array.shape[1]
        kind = array.dtype.newbyteorder("<").str
        groups[name] = GROUPED[name] if columns == len(GROUPED.get(name, ())) else (name,)
        if len(groups[name]) > 1:
            fields += [(field, kind) for field in groups[name]]
        else:
            fields.append((name, kind) + (((columns,),) if columns > 1 else ()))
    dtype = checked_dtype(path, fields)

    def blocks() -> Iterator[np.ndarray]:
        for start in range(0, summary["points"], BLOCK_ROWS):
            rows = min(BLOCK_ROWS, summary["points"] - start)
            block = np.zeros(rows, dtype)
            for name, array in arrays.items():
                try:
                    values = array[start : start + rows].reshape(rows, -1)
                except HDF5_ERRORS as error:  # else it would be one of the file that is written
                    raise translated(path, error) from error
                if len(groups[name]) > 1:
                    for field, column in zip(groups[name], values.T):
                        block[field] = column
                else:
                    block[name] = values if values.shape[1] > 1 else values[:, 0]
            yield block

    def fill(descriptor: int) -> None:
        with os.fdopen(os.dup(descriptor), "wb") as stream:
            _WRITERS[form](target, stream, summary["points"], dtype, blocks())

    save_file(target, fill, overwrite=overwrite)
