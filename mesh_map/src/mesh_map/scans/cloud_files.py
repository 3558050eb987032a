"""Scans in files of point clouds, PLY, PCD, LAS or LAZ, and in folders of them."""

import os
import re
from typing import Any, Iterator, List, Optional, Sequence, Tuple

import numpy as np
from mesh_msgs_hdf5.files.probe import check_regular
from mesh_msgs_hdf5.formats.clouds.cloud import BLOCK_ROWS, Cloud
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose
from mesh_msgs_hdf5.map_file.scans import read_cloud
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.scans import las_cloud
from mesh_map.scans.cloud_values import CloudValues, cloud_values, usable
from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.scan import Scan
from mesh_map.scans.scan_source import ScanSource, Step, no_scans

SUFFIXES = (".ply", ".pcd", *las_cloud.SUFFIXES)
# A larger cloud is several scans of the same pose, so that it is never in memory as a whole; in
# multiples of what readers give at once
SCAN_POINTS = 8 * BLOCK_ROWS


def cloud_paths(folder: str) -> List[str]:
    """The clouds in a folder, in the order of the numbers in their names.

    Raises:
        MapFileError: there are none, or it cannot be read.
    """
    try:
        names = os.listdir(folder)
    except OSError as error:
        text = "the folder cannot be read: %s" % error.strerror
        raise MapFileError("permission", folder, text, "check its permissions") from error
    found = [name for name in names if name.lower().endswith(SUFFIXES) and name[0] != "."]
    if not found:
        text = "no file in this folder ends with %s" % " or ".join(SUFFIXES)
        raise no_scans(folder, text, "name the clouds, a bag or a map file")
    return [os.path.join(folder, name) for name in sorted(found, key=_numbered)]


def _numbered(name: str) -> Tuple[Any, ...]:
    parts = re.split(r"(\d+)", name)
    return tuple((0, int(part), "") if part.isdigit() else (1, 0, part) for part in parts), name


def open_cloud(path: str) -> Cloud:
    """A cloud in a file of one of SUFFIXES; points are not read yet.

    Raises:
        MapFileError: it is none.
    """
    check_regular(path)
    if path.lower().endswith(las_cloud.SUFFIXES):
        return las_cloud.read_las_cloud(path)
    cloud = read_cloud(path)
    cloud.channels()  # that it has x, y and z
    return cloud


class CloudFiles(ScanSource):
    """A cloud, or those of a folder.

    Args:
        path: what the user named.
        files: of the clouds.
        poses: one for each, or None where there is none; then VIEWPOINT of PCD counts.
        sensor: (3,) m where the sensor was in the frame of a cloud, instead of at its 0.
    Attributes:
        unposed: paths of clouds of which nobody says a pose.
        far: the largest coordinate (m) that a header, or the first block of an unposed cloud, has.
    """

    kind = "clouds"

    def __init__(
        self,
        path: str,
        files: Sequence[str],
        poses: Sequence[Optional[ScanPose]],
        sensor: Optional[np.ndarray],
        left_out: LeftOutCounts,
    ) -> None:
        super().__init__(path, left_out)
        self._files, self._poses, self._sensor = list(files), list(poses), sensor
        self._named = len(files) == 1 and os.path.realpath(files[0]) == os.path.realpath(path)
        self._clouds: List[Optional[Cloud]] = [None] * len(files)
        self._problems: List[str] = [""] * len(files)
        self.unposed: List[str] = []
        for i, file in enumerate(self._files):
            try:
                cloud = open_cloud(file)
            except MapFileError as error:
                if self._named:
                    raise
                self._problems[i] = str(error)
                continue
            self._clouds[i] = cloud
            if cloud.viewpoint is None and self._poses[i] is None:
                text = "the VIEWPOINT of %s is no place and rotation: its sensor is taken to be at"
                self.notes.append((text + " its 0, 0, 0") % file)
            if self._poses[i] is None and _is_identity(cloud.viewpoint):
                self.unposed.append(file)

    @property
    def far(self) -> float:
        """The largest coordinate of the first points of unposed clouds, in m."""
        farthest = 0.0
        for file, cloud in zip(self._files, self._clouds):
            if cloud is None or file not in self.unposed:
                continue
            for block in cloud.blocks():
                points = np.abs(cloud_values(block[:1024]).points)
                farthest = max(farthest, float(points[np.isfinite(points)].max(initial=0.0)))
                break
        return farthest

    def files(self) -> List[str]:
        return self._files

    def steps(self, start: int = 0) -> Iterator[Step]:
        position = 0
        for i, file in enumerate(self._files):
            cloud = self._clouds[i]
            self.part = i / len(self._files)
            if cloud is None:
                position += 1
                if position > start:
                    self.left_out.add("unreadable", file, reason=self._problems[i])
                    yield Step(position, None)
                continue
            pieces = max(1, -(-cloud.count // SCAN_POINTS))
            if position + pieces <= start:
                position += pieces
                continue
            for piece, values in enumerate(self._pieces(cloud, file, start - position)):
                position += 1
                self.part = (i + (piece + 1) / pieces) / len(self._files)
                if position > start:
                    name = file if pieces == 1 else "%s, piece %d" % (file, piece)
                    yield Step(position, self._scan(i, cloud, values, name))
        self.part = 1.0

    def _pieces(self, cloud: Cloud, file: str, skipped: int) -> Iterator[Optional[np.ndarray]]:
        """Records of SCAN_POINTS each; None for those before `skipped`, and what cannot be read."""
        pieces, done = max(1, -(-cloud.count // SCAN_POINTS)), 0
        gathered: List[np.ndarray] = []
        rows = 0
        try:
            for block in cloud.blocks():
                gathered.append(block)
                rows += len(block)
                while rows >= SCAN_POINTS:
                    whole = np.concatenate(gathered)
                    yield None if done < skipped else whole[:SCAN_POINTS]
                    rest = whole[SCAN_POINTS:]
                    gathered, rows, done = [rest], rows - SCAN_POINTS, done + 1
            if done < pieces:
                yield np.concatenate(gathered) if gathered else np.zeros(0, cloud.dtype)
                done += 1
        except MapFileError as error:  # what was there before it counts
            self.left_out.add("unreadable", file, reason=str(error))
            if rows and done >= skipped:
                yield np.concatenate(gathered)
                done += 1
            while done < pieces:
                yield None
                done += 1

    def _scan(self, i: int, cloud: Cloud, rows: Optional[np.ndarray], name: str) -> Optional[Scan]:
        if rows is None:
            return None
        values = usable(cloud_values(rows), self.left_out, name)
        if not len(values):
            self.left_out.add("empty", name)
            return None
        known = self._poses[i]
        pose = cloud.viewpoint if known is None else known.matrix
        pose = np.eye(4) if pose is None else pose
        if self._sensor is not None:
            values = _seen_from(values, self._sensor)
            pose = pose.copy()
            pose[:3, 3] += pose[:3, :3] @ self._sensor
        return as_scan(values, pose, None if known is None else known.time, name)


def _is_identity(viewpoint: Optional[np.ndarray]) -> bool:
    return viewpoint is None or np.array_equal(viewpoint, np.eye(4))


def _seen_from(values: CloudValues, sensor: np.ndarray) -> CloudValues:
    """In a frame at the sensor, along the same axes."""
    origins = None if values.origins is None else values.origins - sensor
    return CloudValues(
        values.points - sensor, values.colors, values.intensities, values.times, origins
    )


def as_scan(values: CloudValues, pose: np.ndarray, time: Optional[float], name: str) -> Scan:
    """The scan of these values, in float32."""
    return Scan(
        points=values.points.astype(np.float32),
        pose=pose,
        origins=None if values.origins is None else values.origins.astype(np.float32),
        colors=values.colors,
        intensities=values.intensities,
        time=time,
        name=name,
    )
