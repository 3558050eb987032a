"""What a map file says of its scans: names, shapes, poses, times and images; no points are read.

raw/scans/position_00000: points [N,3] and other channels [N,C], initialPose and finalPose [4,4],
column after column; raw/photos/position_00000/photo_00000: image (the bytes of a PNG or JPEG file),
intrinsics [3,3].
"""
import re
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple

import h5py
import numpy as np

from mesh_msgs_hdf5.formats.base.images import png
from mesh_msgs_hdf5.formats.clouds.cloud import POINTS
from mesh_msgs_hdf5.formats.clouds.poses import check_rigid
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import GuardedGroup
from mesh_msgs_hdf5.map_file.hdf5.hdf5_files import reading
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import is_group_of_this_file
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

SCANS, PHOTOS = "raw/scans", "raw/photos"
SCAN, PHOTO = re.compile("position_[0-9]{1,9}"), re.compile("photo_[0-9]{1,9}")
INITIAL, FINAL = ("initialPose", "poseEstimation"), ("finalPose", "registration")  # ours first
TIMES, BOX, IMAGE, INTRINSICS = "timestamps", "boundingBox", "image", "intrinsics"
_NO_CHANNELS = {*INITIAL, *FINAL, TIMES, BOX, "fov", "resolution", "theta", "phi", "preview"}
_IMAGES = {b"\x89PNG\r\n\x1a\n": ".png", b"\xff\xd8\xff": ".jpg"}


def root_of(path: PathLike, file: h5py.File) -> GuardedGroup:
    """What finds scans in an open file."""
    return GuardedGroup(path, file["/"])


def scan_names(root: GuardedGroup) -> List[str]:
    """position_00000, ..., sorted by their numbers."""
    return sorted(
        (name for name in root.names(SCANS) if SCAN.fullmatch(name)),
        key=lambda name: (int(name.partition("_")[2]), name),
    )


def other_groups(path: PathLike) -> List[str]:
    """The names of groups beside the scans, which are none by their names. Raises MapFileError."""
    with reading(path) as file:
        root = root_of(path, file)
        group = root.subgroup(SCANS)
        others = [name for name in root.names(SCANS) if not SCAN.fullmatch(name)]
        return [name for name in others if is_group_of_this_file(group, name)]


def check_there(path: PathLike, present: Sequence[str], names: Iterable[str]) -> None:
    """Refuse names of scans that are not there (MapFileError scan)."""
    for name in names:
        if name not in present:
            known = ", ".join(present[:10]) + (", ..." if len(present) > 10 else "")
            text = "there is no scan %r" % name[:80]
            raise MapFileError("scan", path, text, "scans of this file: %s" % (known or "none"))


def dataset_at(root: GuardedGroup, place: str) -> h5py.Dataset:
    """The array at a place. Raises MapFileError (scan: there is none)."""
    found = root.dataset(place)
    if found is None:
        text = "there is no %s" % place[:200]
        raise MapFileError("scan", root.path, text, "mesh_tool scans list")
    return found


def summary_of(root: GuardedGroup, name: str) -> Dict[str, Any]:
    """What there is of a scan, see scans.scan_summaries. Raises MapFileError."""
    check_there(root.path, scan_names(root), [name])
    place = "%s/%s" % (SCANS, name)
    points = dataset_at(root, place + "/" + POINTS)
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind != "f":
        text = "%s has the shape %s and type %s" % (points.name, list(points.shape), points.dtype)
        raise MapFileError("shape", root.path, text, "[N,3] floats")
    channels = {POINTS: "%s x 3" % points.dtype.name}
    for other in root.dataset_names(place):
        if other != POINTS and other not in _NO_CHANNELS:
            found = dataset_at(root, place + "/" + other)
            if found.ndim in (1, 2) and len(found) == len(points) and other.isprintable():
                columns = 1 if found.ndim == 1 else found.shape[1]
                channels[other] = found.dtype.name + ("" if columns == 1 else " x %d" % columns)
    times = root.first_dataset(["%s/%s" % (place, TIMES)])
    time = None
    if times is not None and 0 < times.size <= 2:
        time = float(root.values(times).reshape(-1)[0])
    return {
        "name": name,
        "points": len(points),
        "channels": channels,
        "initial_pose": _pose(root, place, INITIAL),
        "final_pose": _pose(root, place, FINAL),
        "time": time if time is not None and np.isfinite(time) else None,
        "images": _photos(root, name),
        "problem": "",
    }


def _pose(root, place, names) -> Optional[np.ndarray]:
    found = root.first_dataset(["%s/%s" % (place, name) for name in names])
    if found is None:
        return None
    if found.size != 16:
        text = "%s has the shape %s" % (found.name, list(found.shape))
        raise MapFileError("shape", root.path, text, "[4,4]")
    stored = root.values(found).reshape(4, 4).astype(np.float64)
    by_rows = (stored[3] == (0, 0, 0, 1)).all() and not (stored[:3, 3] == 0).all()
    matrix = stored if by_rows else np.ascontiguousarray(stored.T)  # LVR2: column after column
    check_rigid(root.path, place, matrix)
    return matrix


def _photos(root, name):
    found = []
    place = "%s/%s" % (PHOTOS, name)
    for photo in root.names(place):
        if not PHOTO.fullmatch(photo):
            continue
        inside = "%s/%s/" % (place, photo)
        image, camera = dataset_at(root, inside + IMAGE), root.first_dataset([inside + INTRINSICS])
        if camera is not None and camera.shape != (3, 3):
            text = "%s has the shape %s" % (camera.name, list(camera.shape))
            raise MapFileError("shape", root.path, text, "[3,3]")
        size = int(image.size) * image.dtype.itemsize
        values = None if camera is None else root.values(camera).astype(np.float64)
        found.append({"name": photo, "bytes": size, "intrinsics": values})
    return found


def image_of(root, name, photo) -> Tuple[bytes, str]:
    """(bytes of an image file, its suffix); one that LVR2 has stored as pixels becomes a PNG."""
    found = dataset_at(root, "%s/%s/%s/%s" % (PHOTOS, name, photo, IMAGE))
    values = root.values(found)
    if values.dtype == np.uint8 and values.ndim == 3 and values.shape[2] in (3, 4) and values.size:
        return png(values), ".png"
    data = values.tobytes() if values.dtype == np.uint8 and values.ndim == 1 else b""
    return data, image_suffix(root.path, found.name, data)


def image_suffix(path: PathLike, what: str, data: bytes) -> str:
    """.png or .jpg, by the bytes of an image. Raises MapFileError (format: it is neither)."""
    for head, suffix in _IMAGES.items():
        if data.startswith(head):
            return suffix
    raise MapFileError("format", path, "%s is neither a PNG nor a JPEG file" % what, "convert it")
