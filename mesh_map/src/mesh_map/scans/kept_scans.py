"""Scans kept on the disk while a map is made, and then put into it."""

import os
import tempfile
from typing import Any, Iterator, List, Tuple

import numpy as np
from mesh_msgs_hdf5.formats.clouds.pcd_cloud import write_pcd_cloud
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.scans.cloud_values import ORIGINS
from mesh_map.scans.scan import Scan

_COLORS = ("red", "green", "blue")
_LEAST_SECONDS, _BYTES_PER_SECOND = 600.0, 1 << 20


class KeptScans:
    """A folder beside a map file with scans that are to be in it; a context manager, which removes
    the folder.

    Args:
        map_path: of the map file that will be there.
    Raises:
        MapFileError: the folder cannot be made.
    """

    def __init__(self, map_path: str) -> None:
        self._map_path = map_path
        place, name = os.path.split(os.path.abspath(map_path))
        try:
            self._folder = tempfile.TemporaryDirectory(prefix=".%s.scans." % name[:100], dir=place)
        except OSError as error:
            raise self._failed(error) from error
        self._files: List[str] = []
        self._poses: List[np.ndarray] = []
        self._times: List[float] = []
        self._bytes = 0

    def __enter__(self) -> "KeptScans":
        return self

    def __exit__(self, *_: Any) -> None:
        self._folder.cleanup()

    def __len__(self) -> int:
        return len(self._files)

    def keep(self, scan: Scan) -> None:
        """Keep a scan as it is, with its pose.

        Raises:
            MapFileError: it cannot be written (a full disk); those before are kept.
        """
        path = os.path.join(self._folder.name, "%09d.pcd" % len(self._files))
        rows = _records(scan)
        blocks: Iterator[np.ndarray] = iter([rows])
        try:
            with open(path, "wb") as stream:
                write_pcd_cloud(path, stream, len(rows), rows.dtype, blocks)
        except OSError as error:
            raise self._failed(error) from error
        self._files.append(path)
        self._poses.append(np.array(scan.pose, np.float64))
        self._times.append(np.nan if scan.time is None else float(scan.time))
        self._bytes += rows.nbytes

    def put(self, map_path: str) -> List[str]:
        """Put all of them into a map file, in one step; returns their names in it.

        Raises:
            MapFileError: they cannot be put there; the map file is as it was.
        """
        added = isolated(
            "add_scans",
            map_path,
            self._files,
            matrices=np.array(self._poses),
            times=np.array(self._times),
            timeout=_LEAST_SECONDS + 4 * self._bytes / _BYTES_PER_SECOND,
        )
        return list(added["names"])

    def _failed(self, error: OSError) -> MapFileError:
        text = "scans cannot be kept beside it: %s" % error.strerror
        return MapFileError("save", self._map_path, text, "make room on the disk")


def _records(scan: Scan) -> np.ndarray:
    """(N,) of the points as `cloud_values` reads them again."""
    fields: List[Tuple[Any, ...]] = [(name, "<f4") for name in "xyz"]
    fields += [(name, "u1") for name in _COLORS if scan.colors is not None]
    fields += [("intensity", "<f4")] if scan.intensities is not None else []
    fields += [(ORIGINS, "<f4", (3,))] if scan.origins is not None else []
    rows = np.zeros(len(scan.points), np.dtype(fields))
    for column, name in enumerate("xyz"):
        rows[name] = scan.points[:, column]
    if scan.colors is not None:
        for column, name in enumerate(_COLORS):
            rows[name] = scan.colors[:, column]
    if scan.intensities is not None:
        rows["intensity"] = scan.intensities
    if scan.origins is not None:
        rows[ORIGINS] = scan.origins
    return rows
