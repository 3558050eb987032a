"""Scans with poses in a map file."""

from typing import Any, Dict, Iterator

import numpy as np
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.scans.cloud_files import SCAN_POINTS, as_scan
from mesh_map.scans.cloud_values import ORIGINS, CloudValues, usable
from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.scan_source import ScanSource, Step, no_scans

_COLORS, _INTENSITIES = "colors", ("intensity", "intensities", "reflectivity", "reflectance")


class MapScans(ScanSource):
    """The scans below /raw of a map file, each where its final pose (else its initial one) says.

    Args:
        path: of the map file.
        left_out: for counts.
    Attributes:
        frame: of the map; "" if it has no mesh.
    Raises:
        MapFileError: there are no scans, or the file cannot be read.
    """

    kind = "map"

    def __init__(self, path: str, left_out: LeftOutCounts) -> None:
        super().__init__(path, left_out)
        self._summaries = isolated("scans", path)
        if not self._summaries:
            hint = "mesh_tool scans add puts scans into it; name bags or clouds"
            raise no_scans(path, "this map file has no scans", hint)
        self.frame, self._origin = "", np.zeros(3)
        try:
            file = IsolatedMapFile(path)
            self.frame, self._origin = file.frame_id, np.array(file.origin, np.float64)
        except MapFileError:  # scans alone
            pass

    def steps(self, start: int = 0) -> Iterator[Step]:
        position = 0
        for i, summary in enumerate(self._summaries):
            count = int(summary.get("points", 0))
            pieces = max(1, -(-count // SCAN_POINTS))
            for piece in range(pieces):
                position += 1
                self.part = (i + piece / pieces) / len(self._summaries)
                if position > start:
                    yield Step(position, self._scan(summary, piece, pieces))
        self.part = 1.0

    def _scan(self, summary: Dict[str, Any], piece: int, pieces: int) -> Any:
        name = "%s, %s" % (self.path, summary["name"])
        name += "" if pieces == 1 else ", piece %d" % piece
        if summary["problem"]:
            self.left_out.add("unreadable", name, reason=summary["problem"])
            return None
        pose = summary["final_pose"]
        pose = summary["initial_pose"] if pose is None else pose
        if pose is None:
            self.left_out.add("no_pose", name, reason="the map file has none for it")
            return None
        begin = piece * SCAN_POINTS
        try:
            rows = isolated("scan_rows", self.path, summary["name"], begin, begin + SCAN_POINTS)
        except MapFileError as error:
            self.left_out.add("unreadable", name, reason=error.message)
            return None
        values = usable(_values(rows), self.left_out, name)
        if not len(values):
            self.left_out.add("empty", name)
            return None
        placed = np.array(pose)
        placed[:3, 3] += self._origin
        return as_scan(values, placed, summary["time"], name)


def _values(rows: Dict[str, np.ndarray]) -> CloudValues:
    colors, origins = rows.get(_COLORS), rows.get(ORIGINS)
    intensities = next((rows[name] for name in _INTENSITIES if name in rows), None)
    if intensities is not None:
        intensities = np.nan_to_num(intensities.reshape(len(rows["points"]), -1)[:, 0])
        intensities = intensities.astype(np.float32)
    if colors is not None:
        usable_colors = colors.ndim == 2 and colors.shape[1] >= 3 and colors.dtype == np.uint8
        colors = np.ascontiguousarray(colors[:, :3]) if usable_colors else None
    if origins is not None and (origins.shape != rows["points"].shape or origins.dtype.kind != "f"):
        origins = None
    return CloudValues(
        rows["points"].astype(np.float64),
        colors,
        intensities,
        None,
        None if origins is None else origins.astype(np.float64),
    )
