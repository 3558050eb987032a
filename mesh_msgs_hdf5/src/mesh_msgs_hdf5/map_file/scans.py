"""Sensor data with the map: scans with poses and images, as LVR2 has them below /raw.

scan_contents.py says how they are stored. Nobody reads them who is not asked for them; all other
changes of a map carry them over as they are stored. Points go in and out block by block.
"""
import hashlib
import os
import re
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple

import h5py
import numpy as np

from mesh_msgs_hdf5.files.probe import read_file, read_head
from mesh_msgs_hdf5.files.save import check_target, stamp
from mesh_msgs_hdf5.formats.clouds.cloud import BLOCK_ROWS, POINTS, Cloud
from mesh_msgs_hdf5.formats.clouds.pcd_cloud import read_pcd_cloud
from mesh_msgs_hdf5.formats.clouds.ply_cloud import read_ply_cloud
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, check_rigid, read_poses
from mesh_msgs_hdf5.map_file.hdf5.chunks import CHUNK_ROWS
from mesh_msgs_hdf5.map_file.hdf5.hdf5_files import reading
from mesh_msgs_hdf5.map_file.reading.layouts import find_parts
from mesh_msgs_hdf5.map_file.scan_contents import (
    BOX,
    FINAL,
    IMAGE,
    INITIAL,
    INTRINSICS,
    PHOTO,
    PHOTOS,
    SCANS,
    TIMES,
    check_there,
    dataset_at,
    image_of,
    image_suffix,
    root_of,
    scan_names,
    summary_of,
)
from mesh_msgs_hdf5.map_file.writing.hdf5_stream import Stream, building, reading_stream
from mesh_msgs_hdf5.map_file.writing.map_saving import save_built
from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter, not_the_same
from mesh_msgs_hdf5.map_file.writing.raw_compare import RawComparison
from mesh_msgs_hdf5.map_file.writing.raw_copy import copy_everything
from mesh_msgs_hdf5.map_file.writing.references import carry_references
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_LVR2 = {"IO": "ScanIO", "CLASS": "Scan"}


class ScanFile:
    """The scans of a map file, read when they are asked for. All raise MapFileError."""

    def __init__(self, path: PathLike) -> None:
        self.path = os.fsdecode(path)
        self.names()

    def names(self) -> List[str]:
        """position_00000, ..., sorted."""
        with reading(self.path) as file:
            return scan_names(root_of(self.path, file))

    def summary(self, name: str) -> Dict[str, Any]:
        """What there is of a scan, see scan_summaries."""
        with reading(self.path) as file:
            return summary_of(root_of(self.path, file), name)

    def channel(
        self, name: str, channel: str = POINTS, start: int = 0, stop: Optional[int] = None
    ) -> np.ndarray:
        """(N, C) of the points from start to stop; nothing else is read."""
        with reading(self.path) as file:
            return dataset_at(root_of(self.path, file), "%s/%s/%s" % (SCANS, name, channel))[
                start:stop
            ]

    def image(self, name: str, photo: str) -> bytes:
        """The bytes of an image file."""
        with reading(self.path) as file:
            return image_of(root_of(self.path, file), name, photo)[0]

    def add(self, clouds: Sequence[str], **more: Any) -> List[str]:
        """See add_scans; returns the names."""
        return add_scans(self.path, clouds, **more)["names"]

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
        root = root_of(path, file)
        for name in scan_names(root):
            try:
                found.append(summary_of(root, name))
            except MapFileError as error:
                found.append({"name": name, "problem": error.message})
    return found


def scan_rows(path: PathLike, name: str, start: int, stop: int) -> Dict[str, np.ndarray]:
    """Channel -> (n,) or (n, C) of the points of a scan from start to before stop: points, and all
    others that summaries name. Raises MapFileError."""
    with reading(path) as file:
        root = root_of(path, file)
        channels = summary_of(root, name)["channels"]
        place = "%s/%s/" % (SCANS, name)
        return {channel: dataset_at(root, place + channel)[start:stop] for channel in channels}


def check_scans(path: PathLike) -> List[Tuple[str, str, str]]:
    """(code, scan, message) of all that is wrong with scans; every array is read, in blocks."""
    wrong: List[Tuple[str, str, str]] = []
    with reading(path) as file:
        root = root_of(path, file)
        for name in scan_names(root):
            try:
                summary = summary_of(root, name)
                bad = _not_finite(root, name, summary)
                if bad:
                    text = "%d of its points are not finite, first %d" % bad
                    wrong.append(("not_finite", name, text))
                for photo in summary["images"]:
                    image_of(root, name, photo["name"])
            except MapFileError as error:
                wrong.append((error.code, name, error.message))
    return wrong


def _not_finite(root, name, summary):
    """(how many, the first)."""
    count, first = 0, -1
    for channel in summary["channels"]:
        dataset = dataset_at(root, "%s/%s/%s" % (SCANS, name, channel))
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
    matrices: Optional[np.ndarray] = None,
    times: Optional[np.ndarray] = None,
) -> Dict[str, List[str]]:
    """Add scans to a map file, in one step; returns their `names`, and `notes`.

    clouds: PLY or PCD files, one for each scan. poses: a file with a pose for each, in KITTI's or
    TUM's format; without it they are where PCD's VIEWPOINT says, else where the map is. images: PNG
    or JPEG files of the only cloud, or of a scan that is there; intrinsics: fx, fy, cx, cy of all
    of them. matrices: (N, 4, 4) instead of a file of poses, and times: (N,) s, NaN for none. Raises
    MapFileError.
    """
    check_target(path, overwrite=True)
    expected = stamp(path)
    read = [read_cloud(cloud) for cloud in clouds]
    for cloud in read:
        cloud.channels()
    notes: List[str] = []
    if matrices is not None:
        found = _given_poses(path, matrices, times)
    else:
        found = read_poses(poses) if poses else [_viewpoint(cloud, notes) for cloud in read]
    unused = [cloud for cloud in read if poses and not _is_identity(cloud.viewpoint)]
    if unused:
        text = "the poses of --poses count, not the VIEWPOINT of %d PCD files, first %s"
        notes.append(text % (len(unused), unused[0].path))
    if len(found) != len(read):
        text = "it has %d poses for %d clouds" % (len(found), len(read))
        raise MapFileError("value", poses or path, text, "a line for each, in the same order")
    pictures = [_picture(image) for image in images]
    if pictures and (len(read) + (scan is not None) != 1) or not (read or pictures):
        text = "%d images for %d scans" % (len(pictures), len(read) + (scan is not None))
        raise MapFileError("value", path, text, "one cloud or one scan, and its images")
    camera = _camera(path, intrinsics)
    with reading(path) as source:
        _check_no_part(path, source)
        present = scan_names(root_of(path, source))
        if scan is not None:
            check_there(path, present, [scan])
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
    return {"names": names or [str(scan)], "notes": notes}


def _given_poses(path, matrices, times):
    """The poses of arrays."""
    found = []
    for i, matrix in enumerate(np.asarray(matrices, np.float64)):
        check_rigid(path, "scan %d" % i, matrix)
        time = np.nan if times is None else float(times[i])
        found.append(ScanPose(matrix, time if np.isfinite(time) else None))
    return found


def _viewpoint(cloud, notes):
    """The pose of a scan of which nobody else says one."""
    if cloud.viewpoint is None:
        text = "the VIEWPOINT of %s is no place and rotation: it is where the map is"
        notes.append(text % cloud.path)
        return ScanPose(np.eye(4))
    if not _is_identity(cloud.viewpoint):
        notes.append("%s is at its VIEWPOINT, %g %g %g m" % (cloud.path, *cloud.viewpoint[:3, 3]))
    return ScanPose(cloud.viewpoint)


def _is_identity(viewpoint):
    return viewpoint is not None and np.array_equal(viewpoint, np.eye(4))


def delete_scans(path: PathLike, names: Iterable[str]) -> None:
    """Remove scans with their images. Raises MapFileError (scan: there is none of that name)."""
    names = list(dict.fromkeys(names))
    check_target(path, overwrite=True)
    expected = stamp(path)
    with reading(path) as source:
        check_there(path, scan_names(root_of(path, source)), names)

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


def _check_no_part(path, source):
    """Refuse a file in which a mesh is where scans are to be."""
    for part in find_parts(source, path):
        if (part + "/").startswith(schema.RAW + "/"):
            text = "part %s of it, a mesh, is where scans would be" % part
            raise MapFileError("part", path, text, "mesh_tool parts rename FILE %s NEW" % part)


def _new_names(present, count):
    number = 1 + max((int(name.partition("_")[2]) for name in present), default=-1)
    return ["position_%05d" % (number + i) for i in range(count)]


def _picture(path):
    data = read_file(path)
    image_suffix(path, "it", data)
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
    writer.array(group, INITIAL[0], matrix)
    writer.array(group, FINAL[0], matrix)
    if pose.time is not None:
        writer.array(group, TIMES, np.full((2, 1), pose.time))
    if np.isfinite(low).all():
        writer.array(group, BOX, np.array([low, high], np.float32))
    return {place: digest.hexdigest() for place, digest in digests.items()}


def _write_images(writer, file, name, pictures, camera):
    group = _group(writer, file, "%s/%s" % (PHOTOS, name))
    numbers = [int(photo.partition("_")[2]) for photo in group if PHOTO.fullmatch(photo)]
    number = 1 + max(numbers, default=-1)
    for i, data in enumerate(pictures):
        photo = writer.group(group, "photo_%05d" % (number + i))
        writer.array(photo, IMAGE, np.frombuffer(data, np.uint8), many=True)
        if camera is not None:
            writer.array(photo, INTRINSICS, camera)


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
