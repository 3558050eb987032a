"""What a user may ask of an import, and where the mesh is put: float32 near an origin."""
from dataclasses import dataclass
from typing import Any, Dict, Optional, Tuple, Union

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.checks.exact import narrowed
from mesh_msgs_hdf5.formats.base.report import ImportReport, is_noticed, note_rounding
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

Origin = Tuple[float, float, float]


@dataclass(frozen=True)
class Options:
    """What is not the default is remembered in the source of the mesh.

    origin: None keeps the coordinates as they are in the file; "auto" subtracts the center of the
        bounding box, rounded to whole meters; (x, y, z) subtracts that. What is subtracted becomes
        Mesh.origin.
    split_seams: vertices that have several texture coordinates are split, else texture coordinates
        are left out where that would be necessary.
    merge_vertices: None, or the distance in meters up to which vertices become one (0: exactly the
        same position).
    repair: drop or mend what makes trouble (see repair.py).
    """

    origin: Union[None, str, Origin] = None
    split_seams: bool = False
    merge_vertices: Optional[float] = None
    repair: bool = False

    def recorded(self) -> Dict[str, Any]:
        """Those that are not the default."""
        names = ("origin", "split_seams", "merge_vertices", "repair")
        values = {name: getattr(self, name) for name in names}
        return {k: v for k, v in values.items() if v is not None and v is not False}


def checked_options(path: PathLike, **values: Any) -> Options:
    """Options of these values; MapFileError value says which one is none."""
    origin, tolerance = values.get("origin"), values.get("merge_vertices")
    if isinstance(origin, str):
        wrong = origin != "auto"
    elif origin is not None:
        try:
            origin = tuple(float(value) for value in origin)
        except (TypeError, ValueError):
            origin = ()
        wrong = len(origin) != 3 or not np.isfinite(origin).all()
    else:
        wrong = False
    if wrong:
        text = one_line(repr(values["origin"]))[:80]
        raise MapFileError(
            "value", path, "origin %s is no place" % text, 'x, y, z in meters, or "auto"'
        )
    if tolerance is not None:
        try:
            tolerance = float(tolerance)
        except (TypeError, ValueError):
            tolerance = -1.0
        if not 0 <= tolerance < np.inf:
            text = one_line(repr(values["merge_vertices"]))[:80]
            raise MapFileError(
                "value", path, "merge_vertices %s is no distance" % text, "in meters, 0 or more"
            )
    return Options(
        origin,
        bool(values.get("split_seams", False)),
        tolerance,
        bool(values.get("repair", False)),
    )


def placed(
    path: PathLike,
    positions: np.ndarray,
    what: str,
    options: Options,
    report: ImportReport,
    offset: Origin = (0.0, 0.0, 0.0),
) -> Tuple[np.ndarray, Origin]:
    """(float32 (N, 3) positions, origin) of positions (N, 3) of any float type.

    offset: the origin that the file itself names. what: "vertex" or "corner", for the error
    not_finite; with repair, what is not finite stays and is dropped later.
    """
    origin = _origin(positions, options.origin, offset)
    if origin != offset:
        with np.errstate(invalid="ignore", over="ignore"):
            positions = positions.astype(np.float64) + (np.subtract(offset, origin))
        report.note("origin %r was subtracted from the coordinates", origin)
    if options.repair:
        finite = positions[np.isfinite(positions).all(axis=1)]
        with np.errstate(over="ignore", invalid="ignore"):
            vertices = np.ascontiguousarray(positions, dtype=np.float32)
            change = np.abs(finite.astype(np.float32) - finite.astype(np.float64))
        change = float(change[np.isfinite(change)].max(initial=0))
    else:
        vertices, change = narrowed(positions, path, what)
    if is_noticed(change):
        change = _change(positions, vertices)
    note_rounding(report, change)
    return vertices, origin


def _change(positions: np.ndarray, vertices: np.ndarray) -> float:
    """The most that a coordinate changed, but for those that were float32 when they were written.

    Nine digits tell a float32 exactly, though they are not its value: 16777.2168, 16777.216796875.
    """
    with np.errstate(invalid="ignore"):
        change = np.abs(vertices.astype(np.float64) - positions).reshape(-1)
    change[~np.isfinite(change)] = 0
    order = np.argsort(-change)
    for start in range(0, len(order), 4096):
        at = order[start : start + 4096]
        nine = [float("%.9g" % value) for value in vertices.reshape(-1)[at].tolist()]
        wider = at[np.array(nine) != positions.reshape(-1)[at]]
        if len(wider):
            return float(change[wider[0]])
    return 0.0


def _origin(positions, wanted, offset):
    if wanted is None:
        return offset
    if wanted != "auto":
        return wanted
    finite = positions[np.isfinite(positions).all(axis=1)]
    if not len(finite):
        return offset
    low, high = finite.min(axis=0).astype(np.float64), finite.max(axis=0).astype(np.float64)
    center = np.rint(low / 2 + high / 2 + offset) + 0.0  # no -0.0
    return tuple(float(value) for value in center)
