"""Sensor data with the map: scans with poses and images, as LVR2 has them below /raw.

raw/scans/position_00000: points [N,3] and other channels [N,C], initialPose and finalPose [4,4],
column after column; raw/photos/position_00000/photo_00000: image (the bytes of a PNG or JPEG file),
intrinsics [3,3]. Nobody reads them who is not asked for them; all other changes of a map carry them
over as they are stored. Points go in and out block by block.
"""
import hashlib
import os
import re
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

import h5py
import numpy as np

from mesh_msgs_hdf5.files.probe import read_file, read_head
from mesh_msgs_hdf5.files.save import check_target, save_file, stamp
from mesh_msgs_hdf5.formats.base.images import png
from mesh_msgs_hdf5.formats.clouds.cloud import BLOCK_ROWS, GROUPED, POINTS, Cloud, checked_dtype
from mesh_msgs_hdf5.formats.clouds.pcd_cloud import read_pcd_cloud, write_pcd_cloud
from mesh_msgs_hdf5.formats.clouds.ply_cloud import read_ply_cloud, write_ply_cloud
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, check_rigid, pose_lines, read_poses
from mesh_msgs_hdf5.map_file.hdf5.chunks import CHUNK_ROWS
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import GuardedGroup
from mesh_msgs_hdf5.map_file.hdf5.hdf5_files import reading
from mesh_msgs_hdf5.map_file.writing.hdf5_stream import Stream, building, reading_stream
from mesh_msgs_hdf5.map_file.writing.map_saving import save_built
from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter, not_the_same
from mesh_msgs_hdf5.map_file.writing.raw_compare import RawComparison
from mesh_msgs_hdf5.map_file.writing.raw_copy import copy_everything
from mesh_msgs_hdf5.map_file.writing.references import carry_references
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

SCANS, PHOTOS = "raw/scans", "raw/photos"
_SCAN, _PHOTO = re.compile("position_[0-9]{1,9}"), re.compile("photo_[0-9]{1,9}")
_INITIAL, _FINAL = ("initialPose", "poseEstimation"), ("finalPose", "registration")  # ours first
_TIMES, _BOX, _IMAGE, _INTRINSICS = "timestamps", "boundingBox", "image", "intrinsics"
_NO_CHANNELS = {*_INITIAL, *_FINAL, _TIMES, _BOX, "fov", "resolution", "theta", "phi", "preview"}
_LVR2 = {"IO": "ScanIO", "CLASS": "Scan"}
_IMAGES = {b"\x89PNG\r\n\x1a\n": ".png", b"\xff\xd8\xff": ".jpg"}
_WRITERS: Dict[str, Callable] = {"pcd": write_pcd_cloud, "ply": write_ply_cloud}


class ScanFile:
    """The scans of a map file, read when they are asked for. All raise MapFileError."""

    def __init__(self, path: PathLike) -> None:
        self.path = os.fsdecode(path)
        self.names()

    def names(self) -> List[str]:
        """position_00000, ..., sorted."""
        with reading(self.path) as file:
            return _names(_root(self.path, file))

    def summary(self, name: str) -> Dict[str, Any]:
        """What there is of a scan, see scan_summaries."""
        with reading(self.path) as file:
            return _summary(_root(self.path, file), name)

    def channel(
        self, name: str, channel: str = POINTS, start: int = 0, stop: Optional[int] = None
    ) -> np.ndarray:
        """(N, C) of the points from start to stop; nothing else is read."""
        with reading(self.path) as file:
            return _dataset(_root(self.path, file), "%s/%s/%s" % (SCANS, name, channel))[start:stop]

    def image(self, name: str, photo: str) -> bytes:
        """The bytes of an image file."""
        with reading(self.path) as file:
            return _image(_root(self.path, file), name, photo)[0]

    def add(self, clouds: Sequence[str], **more: Any) -> List[str]:
        """See add_scans."""
        return add_scans(self.path, clouds, **more)

    def delete(self, names: Sequence[str]) -> None:
        """See delete_scans."""
        delete_scans(self.path, names)


def read_cloud(path: PathLike) -> Cloud:
    """A point cloud in a PLY or PCD file. Raises MapFileError."""
    head = read_head(path)
    if head[:4] in (b"ply\n", b"ply\r"):
        return read_ply_cloud(path)
    if re.search(rb"^(VERSION|FIELDS)\s", head, re.MULTILINE):
        return read_pcd_cloud(path)
    raise MapFileError("format", path, "it is neither a PLY nor a PCD file", "convert the cloud")


def scan_summaries(path: PathLike) -> List[Dict[str, Any]]:
    """Of each scan: name, points (how many), channels (name -> type), initial_pose and final_pose
    ((4, 4) float64 or None), time (s or None), images (name, bytes, intrinsics or None) and problem
    ("" or what is wrong with it). No points are read. Raises MapFileError.
    """
    found = []
    with reading(path) as file:
        root = _root(path, file)
        for name in _names(root):
            try:
                found.append(_summary(root, name))
            except MapFileError as error:
                found.append({"name": name, "problem": error.message})
    return found


def check_scans(path: PathLike) -> List[Tuple[str, str, str]]:
    """(code, scan, message) of all that is wrong with scans; every array is read, in blocks."""
    wrong: List[Tuple[str, str, str]] = []
    with reading(path) as file:
        root = _root(path, file)
        for name in _names(root):
            try:
                summary = _summary(root, name)
                bad = _not_finite(root, name, summary)
                if bad:
                    text = "%d of its points are not finite, first %d" % bad
                    wrong.append(("not_finite", name, text))
                for photo in summary["images"]:
                    _image(root, name, photo["name"])
            except MapFileError as error:
                wrong.append((error.code, name, error.message))
    return wrong


def _not_finite(root, name, summary):
    """(how many, the first)."""
    count, first = 0, -1
    for channel in summary["channels"]:
        dataset = _dataset(root, "%s/%s/%s" % (SCANS, name, channel))
        for start in range(0, len(dataset), BLOCK_ROWS):  # reading is a check, of each
            values = dataset[start : start + BLOCK_ROWS]
            if channel == POINTS:
                bad = ~np.isfinite(values).all(axis=1)
                if bad.any():
                    first = start + int(bad.argmax()) if first < 0 else first
                    count += int(np.count_nonzero(bad))
    return (count, first) if count else None


def add_scans(
    path: PathLike,
    clouds: Sequence[str],
    poses: Optional[str] = None,
    images: Sequence[str] = (),
    intrinsics: Optional[Sequence[float]] = None,
    scan: Optional[str] = None,
) -> List[str]:
    """Add scans to a map file, in one step; returns their names.

    clouds: PLY or PCD files, one for each scan. poses: a file with a pose for each, in KITTI's or
    TUM's format; without it they are where the map is. images: PNG or JPEG files of the only cloud,
    or of a scan that is there; intrinsics: fx, fy, cx, cy of all of them. Raises MapFileError.
    """
    check_target(path, overwrite=True)
    expected = stamp(path)
    read = [read_cloud(cloud) for cloud in clouds]
    for cloud in read:
        cloud.channels()
    found = read_poses(poses) if poses else [ScanPose(np.eye(4))] * len(read)
    if len(found) != len(read):
        text = "it has %d poses for %d clouds" % (len(found), len(read))
        raise MapFileError("value", poses or path, text, "a line for each, in the same order")
    pictures = [_picture(image) for image in images]
    if pictures and (len(read) + (scan is not None) != 1) or not (read or pictures):
        text = "%d images for %d scans" % (len(pictures), len(read) + (scan is not None))
        raise MapFileError("value", path, text, "one cloud or one scan, and its images")
    camera = _camera(path, intrinsics)
    with reading(path) as source:
        present = _names(_root(path, source))
        if scan is not None:
            _check_there(path, present, [scan])
        names = _new_names(present, len(read))

        def build(stream: Stream) -> None:
            writer, digests = ObjectWriter(path), {}
            with building(stream, path, source) as file:
                copy_everything(path, source, file)
                for name, cloud, pose in zip(names, read, found):
                    group = _group(writer, file, "%s/%s" % (SCANS, name))
                    digests.update(_write_scan(writer, group, cloud, pose))
                if pictures:
                    _write_images(writer, file, scan or names[0], pictures, camera)
                carry_references(source, file, writer.moved, path)
            _verify(path, stream, writer, source, digests)

        room = source.id.get_filesize() + sum(2 * len(data) for data in pictures)
        room += sum(2 * cloud.count * cloud.dtype.itemsize + (1 << 20) for cloud in read)
        save_built(path, build, room, expected=expected)
    return names or [str(scan)]


def delete_scans(path: PathLike, names: Iterable[str]) -> None:
    """Remove scans with their images. Raises MapFileError (scan: there is none of that name)."""
    names = list(names)
    check_target(path, overwrite=True)
    expected = stamp(path)
    with reading(path) as source:
        _check_there(path, _names(_root(path, source)), names)

        def build(stream: Stream) -> None:
            writer = ObjectWriter(path)
            with building(stream, path, source) as file:
                copy_everything(path, source, file)
                for group in (SCANS, PHOTOS):
                    for name in names if group in file else ():
                        writer.remove(file[group], name)
                carry_references(source, file, {}, path)
            _verify(path, stream, writer, source, {})

        save_built(path, build, source.id.get_filesize(), expected=expected, compact=True)


def extract_scans(
    path: PathLike,
    folder: str,
    names: Sequence[str] = (),
    form: str = "pcd",
    pose_form: str = "kitti",
    overwrite: bool = False,
) -> List[str]:
    """Write scans (all, or those named) into a folder: a cloud and images for each, and poses.txt
    with the final ones; returns the paths. form: pcd or ply. Raises MapFileError.
    """
    written, poses = [], []
    with reading(path) as file:
        root = _root(path, file)
        present = _names(root)
        _check_there(path, present, names)
        summaries = [_summary(root, name) for name in names or present]
        _make_folder(folder)
        for summary in summaries:
            name = summary["name"]
            target = os.path.join(folder, "%s.%s" % (name, form))
            _write_cloud(path, root, summary, target, form, overwrite)
            written.append(target)
            matrix = summary["final_pose"]
            matrix = summary["initial_pose"] if matrix is None else matrix
            poses.append(ScanPose(np.eye(4) if matrix is None else matrix, summary["time"]))
            for photo in summary["images"]:
                data, suffix = _image(root, name, photo["name"])
                target = os.path.join(folder, "%s_%s%s" % (name, photo["name"], suffix))
                save_file(target, data, overwrite=overwrite)
                written.append(target)
    if poses:
        written.append(os.path.join(folder, "poses.txt"))
        save_file(written[-1], pose_lines(poses, pose_form).encode("ascii"), overwrite=overwrite)
    return written


def _make_folder(folder):
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        text = "the folder cannot be made: %s" % error.strerror
        raise MapFileError("save", folder, text, "name another one") from error


def _root(path, file) -> GuardedGroup:
    return GuardedGroup(path, file["/"])


def _names(root: GuardedGroup) -> List[str]:
    return sorted(
        (name for name in root.names(SCANS) if _SCAN.fullmatch(name)),
        key=lambda name: (int(name.partition("_")[2]), name),
    )


def _new_names(present, count):
    number = 1 + max((int(name.partition("_")[2]) for name in present), default=-1)
    return ["position_%05d" % (number + i) for i in range(count)]


def _check_there(path, present, names):
    for name in names:
        if name not in present:
            known = ", ".join(present[:10]) + (", ..." if len(present) > 10 else "")
            text = "there is no scan %r" % name[:80]
            raise MapFileError("scan", path, text, "scans of this file: %s" % (known or "none"))


def _dataset(root: GuardedGroup, place: str) -> h5py.Dataset:
    found = root.dataset(place)
    if found is None:
        text = "there is no %s" % place[:200]
        raise MapFileError("scan", root.path, text, "mesh_tool scans list")
    return found


def _summary(root: GuardedGroup, name: str) -> Dict[str, Any]:
    _check_there(root.path, _names(root), [name])
    place = "%s/%s" % (SCANS, name)
    points = _dataset(root, place + "/" + POINTS)
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind != "f":
        text = "%s has the shape %s and type %s" % (points.name, list(points.shape), points.dtype)
        raise MapFileError("shape", root.path, text, "[N,3] floats")
    channels = {POINTS: "%s x 3" % points.dtype.name}
    for other in root.dataset_names(place):
        if other != POINTS and other not in _NO_CHANNELS:
            found = _dataset(root, place + "/" + other)
            if found.ndim in (1, 2) and len(found) == len(points) and other.isprintable():
                columns = 1 if found.ndim == 1 else found.shape[1]
                channels[other] = found.dtype.name + ("" if columns == 1 else " x %d" % columns)
    times = root.first_dataset(["%s/%s" % (place, _TIMES)])
    time = None
    if times is not None and 0 < times.size <= 2:
        time = float(root.values(times).reshape(-1)[0])
    return {
        "name": name,
        "points": len(points),
        "channels": channels,
        "initial_pose": _pose(root, place, _INITIAL),
        "final_pose": _pose(root, place, _FINAL),
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
        if not _PHOTO.fullmatch(photo):
            continue
        inside = "%s/%s/" % (place, photo)
        image, camera = _dataset(root, inside + _IMAGE), root.first_dataset([inside + _INTRINSICS])
        if camera is not None and camera.shape != (3, 3):
            text = "%s has the shape %s" % (camera.name, list(camera.shape))
            raise MapFileError("shape", root.path, text, "[3,3]")
        size = int(image.size) * image.dtype.itemsize
        values = None if camera is None else root.values(camera).astype(np.float64)
        found.append({"name": photo, "bytes": size, "intrinsics": values})
    return found


def _image(root, name, photo) -> Tuple[bytes, str]:
    """(bytes of an image file, its suffix); one that LVR2 has stored as pixels becomes a PNG."""
    found = _dataset(root, "%s/%s/%s/%s" % (PHOTOS, name, photo, _IMAGE))
    values = root.values(found)
    if values.dtype == np.uint8 and values.ndim == 3 and values.shape[2] in (3, 4) and values.size:
        return png(values), ".png"
    data = values.tobytes() if values.dtype == np.uint8 and values.ndim == 1 else b""
    return data, _suffix(root.path, found.name, data)


def _suffix(path, what, data):
    for head, suffix in _IMAGES.items():
        if data.startswith(head):
            return suffix
    raise MapFileError("format", path, "%s is neither a PNG nor a JPEG file" % what, "convert it")


def _picture(path):
    data = read_file(path)
    _suffix(path, "it", data)
    return data


def _camera(path, intrinsics):
    if intrinsics is None:
        return None
    values = np.asarray(intrinsics, np.float64)
    if values.shape != (4,) or not np.isfinite(values).all() or (values[:2] <= 0).any():
        raise MapFileError(
            "value",
            path,
            "intrinsics are fx, fy, cx and cy in pixels",
            "--intrinsics 600,600,320,240",
        )
    fx, fy, cx, cy = values
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])


def _group(writer, file, place):
    group = file["/"]
    for name in place.split("/"):
        group = writer.group(group, name)
    return group


def _write_scan(writer: ObjectWriter, group: h5py.Group, cloud: Cloud, pose: ScanPose):
    """Absolute path of each array of points -> the digest of what was written."""
    for name, text in _LVR2.items():
        writer.attribute(group, name, text)
    channels, arrays, digests = cloud.channels(), {}, {}
    for name, fields in channels.items():
        base = cloud.dtype[fields[0]].base.newbyteorder("<")
        columns = max(len(fields), int(np.prod(cloud.dtype[fields[0]].shape, dtype=int)))
        shape = (cloud.count, columns)
        options: Dict[str, Any] = {}
        if cloud.count:
            rows = max(1, min(CHUNK_ROWS, cloud.count, (1 << 20) // (columns * base.itemsize)))
            options = dict(chunks=(rows, columns), compression="gzip", compression_opts=1)
        arrays[name] = group.create_dataset(name, shape, base, shuffle=bool(options), **options)
        writer.created.add(arrays[name].name)
        digests[arrays[name].name] = hashlib.blake2b()
    low, high, row = np.full(3, np.inf), np.full(3, -np.inf), 0
    for block in cloud.blocks():
        for name, fields in channels.items():
            array = arrays[name]
            parts = [block[field].reshape(len(block), -1) for field in fields]
            values = np.ascontiguousarray(np.concatenate(parts, axis=1), array.dtype)
            array[row : row + len(block)] = values
            digests[array.name].update(values.reshape(-1).view(np.uint8).data)
            if name == POINTS and len(values):
                finite = values[np.isfinite(values).all(axis=1)]
                low = np.minimum(low, finite.min(axis=0, initial=np.inf))
                high = np.maximum(high, finite.max(axis=0, initial=-np.inf))
        row += len(block)
    matrix = np.ascontiguousarray(pose.matrix.T)
    writer.array(group, _INITIAL[0], matrix)
    writer.array(group, _FINAL[0], matrix)
    if pose.time is not None:
        writer.array(group, _TIMES, np.full((2, 1), pose.time))
    if np.isfinite(low).all():
        writer.array(group, _BOX, np.array([low, high], np.float32))
    return {place: digest.hexdigest() for place, digest in digests.items()}


def _write_images(writer, file, name, pictures, camera):
    group = _group(writer, file, "%s/%s" % (PHOTOS, name))
    numbers = [int(photo.partition("_")[2]) for photo in group if _PHOTO.fullmatch(photo)]
    number = 1 + max(numbers, default=-1)
    for i, data in enumerate(pictures):
        photo = writer.group(group, "photo_%05d" % (number + i))
        writer.array(photo, _IMAGE, np.frombuffer(data, np.uint8), many=True)
        if camera is not None:
            writer.array(photo, _INTRINSICS, camera)


def _verify(path, stream, writer, source, digests):
    with reading_stream(stream, path) as file:
        writer.check_written(file)
        written = writer.removed, writer.created, writer.moved, writer.changed
        RawComparison(path, *written).check(source, file)
        for place, digest in digests.items():
            found, dataset = hashlib.blake2b(), file[place]
            for start in range(0, len(dataset), BLOCK_ROWS):
                rows = dataset[start : start + BLOCK_ROWS]
                found.update(np.ascontiguousarray(rows).reshape(-1).view(np.uint8).data)
            if found.hexdigest() != digest:
                raise not_the_same(path, place)


def _write_cloud(path, root, summary, target, form, overwrite):
    place = "%s/%s/" % (SCANS, summary["name"])
    arrays = {name: _dataset(root, place + name) for name in summary["channels"]}
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
                values = array[start : start + rows].reshape(rows, -1)
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
