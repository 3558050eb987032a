"""What a user may ask of an import, and where the mesh is put: float32 near an origin."""
from dataclasses import dataclass, replace
from typing import Any, Callable, Dict, Optional, Tuple, Union

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.checks.exact import narrowed
from mesh_msgs_hdf5.formats.base.movement import Y_TO_Z_UP, matrix_fault, moved_positions
from mesh_msgs_hdf5.formats.base.report import ImportReport, is_noticed, note_rounding
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Color

Origin = Tuple[float, float, float]
AUTO, NEEDED = "auto", "needed"
_LARGEST_PART = 0.1  # of the median edge, that rounding may be where an origin is not needed


@dataclass(frozen=True)
class Options:
    """What is not the default is remembered in the source of the mesh.

    origin: None keeps the coordinates as they are in the file; "auto" subtracts the center of the
        bounding box, rounded to whole meters; "needed" does so where float32 would round the
        coordinates of the file by more than a tenth of the median edge; (x, y, z) subtracts that.
        What is subtracted becomes Mesh.origin.
    split_seams: whether vertices that have several texture coordinates get a copy for each further
        one; False leaves the coordinates, and so the textures, out where that is necessary. None
        does so where the mesh has textures: coordinates alone show nothing.
    merge_vertices: None, or the distance in meters up to which vertices become one (0: exactly the
        same position).
    repair: drop or mend what makes trouble (see repair.py).
    up: "y" or "z", the axis that points up in the file; "" what its format says, else z.
    scale: what the file's unit is in meters, where its format does not say it; above 0.
    transform: None, or 4 x 4 numbers row by row, which move the mesh after all that.
    labels_from: names of what labels are made of: the property of faces or vertices with their
        class, and perhaps that with their instance; of OBJ "groups", "objects" or "materials".
    label_names, label_texts, label_colors: (number, name) of classes in such a property; (number,
        text) and (number, (red, green, blue)) of labels in that with the instance.
    """

    origin: Union[None, str, Origin] = None
    split_seams: Optional[bool] = None
    merge_vertices: Optional[float] = None
    repair: bool = False
    up: str = ""
    scale: float = 1.0
    transform: Optional[Tuple[float, ...]] = None
    labels_from: Tuple[str, ...] = ()
    label_names: Tuple[Tuple[int, str], ...] = ()
    label_texts: Tuple[Tuple[int, str], ...] = ()
    label_colors: Tuple[Tuple[int, Color], ...] = ()

    @property
    def matrix(self) -> Optional[np.ndarray]:
        """(4, 4) by which coordinates are moved, with z up where the format says it; or None."""
        if self.up != "y" and self.scale == 1 and self.transform is None:
            return None
        matrix = np.diag([self.scale, self.scale, self.scale, 1.0])
        if self.up == "y":
            matrix = matrix @ Y_TO_Z_UP
        if self.transform is not None:
            matrix = np.reshape(self.transform, (4, 4)) @ matrix
        return matrix

    def recorded(self) -> Dict[str, Any]:
        """Those that are not the default."""
        names = ("origin", "split_seams", "merge_vertices", "repair")
        values = {name: getattr(self, name) for name in names}
        defaults = Options()
        left_alone = {name: (getattr(defaults, name), NEEDED) for name in names}
        found = {k: v for k, v in values.items() if not any(v is d for d in left_alone[k])}
        for name, usual in (
            *(("up", ""), ("scale", 1.0), ("transform", None)),
            *(("labels_from", ()), ("label_names", ())),
        ):
            if getattr(self, name) != usual:
                found[name] = getattr(self, name)
        return found


def checked_options(path: PathLike, **values: Any) -> Options:
    """Options of these values; MapFileError value says which one is none."""
    origin, tolerance = values.get("origin"), values.get("merge_vertices")
    if isinstance(origin, str):
        wrong = origin not in (AUTO, NEEDED)
        origin = NEEDED if origin == NEEDED else origin  # the very one that recorded() knows
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
    split = values.get("split_seams")
    return Options(
        origin,
        None if split is None else bool(split),
        tolerance,
        bool(values.get("repair", False)),
        *_checked_movement(path, values),
        *_checked_labels(path, values),
    )


def _checked_labels(path, values):
    """labels_from, and what its numbers mean."""
    sources = values.get("labels_from") or ()
    sources = (sources,) if isinstance(sources, str) else tuple(sources)
    if len(sources) > 2 or not all(isinstance(source, str) and source for source in sources):
        text = "labels_from is %s" % one_line(repr(sources))[:80]
        raise MapFileError("value", path, text, "one name, or two: of the class and the instance")
    names = ("label_names", "label_texts", "label_colors")
    tables = (dict(values.get(name) or {}) for name in names)
    return (sources, *(tuple(sorted(table.items())) for table in tables))


def _checked_movement(path, values):
    """up, scale and transform."""
    up, scale, transform = values.get("up") or "", values.get("scale"), values.get("transform")
    if up not in ("", "y", "z"):
        raise MapFileError("value", path, "up is %s" % one_line(repr(up))[:80], "y or z")
    scale = 1.0 if scale is None else scale
    if not (isinstance(scale, (int, float)) and 0 < scale < np.inf):
        text = "scale %s is none" % one_line(repr(scale))[:80]
        raise MapFileError("value", path, text, "above 0, such as 0.001 for millimeters")
    if transform is not None:
        matrix = np.asarray(transform, np.float64)
        if matrix.size != 16:
            text = "transform has %d numbers, not 16" % matrix.size
            raise MapFileError("value", path, text, "4 rows of 4 numbers")
        fault, hint = matrix_fault(matrix.reshape(4, 4))
        if fault:
            raise MapFileError("value", path, "transform cannot be used: " + fault, hint)
        transform = tuple(matrix.reshape(-1).tolist())
    return up, float(scale), transform


def told_up(path: PathLike, options: Options, stated: str, format: str) -> Options:
    """The options where a format itself says which axis is up (stated; "" if it does not).

    Its reader has applied that. Raises MapFileError where the user says otherwise.
    """
    if not stated or not options.up or options.up == stated:
        return replace(options, up="") if stated else options
    text = "%s says that %s is up, which is applied" % (format, stated)
    raise MapFileError("value", path, text, "leave out --up, or turn it by --transform")


def placed(
    path: PathLike,
    positions: np.ndarray,
    what: str,
    options: Options,
    report: ImportReport,
    offset: Origin = (0.0, 0.0, 0.0),
    edges: Optional[Callable[[], np.ndarray]] = None,
) -> Tuple[np.ndarray, Origin]:
    """(float32 (N, 3) positions, origin) of positions (N, 3) of any float type.

    offset: the origin that the file itself names. what: "vertex" or "corner", for the error
    not_finite; with repair, what is not finite stays and is dropped later. edges: makes (E, 2)
    places in positions, for the origin that is needed.
    """
    wanted, matrix = options.origin, options.matrix
    if matrix is not None:
        positions, offset = moved_positions(positions, offset, matrix)
    if wanted == NEEDED:
        vertices, change = _rounded(path, positions, what, options)
        wanted = None
        if edges is None or not is_noticed(change):
            note_rounding(report, change)
            return vertices, offset
        length = _median_length(positions, edges())
        if change > _LARGEST_PART * length:
            wanted = AUTO
    origin = _origin(positions, wanted, offset)
    if origin != offset:
        with np.errstate(invalid="ignore", over="ignore"):
            positions = positions.astype(np.float64) + (np.subtract(offset, origin))
        why = "from the coordinates"
        if options.origin == NEEDED:
            why = (
                "from the coordinates: float32 would have rounded them by up to %.3g m, more than a"
                " tenth of the median edge of %.3g m; --origin 0,0,0 leaves them as they are"
            ) % (change, length)
        report.note("origin %r was subtracted %s", origin, why)
    vertices, change = _rounded(path, positions, what, options)
    note_rounding(report, change)
    return vertices, origin


def _median_length(positions: np.ndarray, edges: np.ndarray) -> float:
    """Meters, of the edges that have a finite length above 0; 0 if there is none."""
    with np.errstate(invalid="ignore", over="ignore"):
        ends = positions.astype(np.float64)[edges]
        lengths = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    lengths = lengths[np.isfinite(lengths) & (lengths > 0)]
    return float(np.median(lengths)) if len(lengths) else 0.0


def _rounded(path, positions, what, options):
    """(float32 positions, the most that a coordinate changed in meters)."""
    if options.repair:
        finite = positions[np.isfinite(positions).all(axis=1)]
        with np.errstate(over="ignore", invalid="ignore"):
            vertices = np.ascontiguousarray(positions, dtype=np.float32)
            change = np.abs(finite.astype(np.float32) - finite.astype(np.float64))
        change = float(change[np.isfinite(change)].max(initial=0))
    else:
        vertices, change = narrowed(positions, path, what)
    return vertices, _change(positions, vertices) if is_noticed(change) else change


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
    if wanted != AUTO:
        return wanted
    finite = positions[np.isfinite(positions).all(axis=1)]
    if not len(finite):
        return offset
    low, high = finite.min(axis=0).astype(np.float64), finite.max(axis=0).astype(np.float64)
    center = np.rint(low / 2 + high / 2 + offset) + 0.0  # no -0.0
    return tuple(float(value) for value in center)
