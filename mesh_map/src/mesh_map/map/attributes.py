"""Named attributes of vertices and faces, and costs of the one for the other."""

from typing import Any, Callable, Dict, Iterable, Iterator, Mapping, Optional

import numpy as np
from mesh_msgs.text import one_line

from mesh_map.base.array_checks import read_only
from mesh_map.base.errors import MeshMapError
from mesh_map.base.query_arguments import choice, one_each
from mesh_map.geometry.topology import Topology

MAX, MEAN = "max", "mean"


class Attributes(Mapping[str, np.ndarray]):
    """Arrays with a name and one row for each vertex, or for each face; read-only.

    Those of a source are read when they are first asked for. Any thread may read while one writes.
    """

    def __init__(
        self,
        count: int,
        of_what: str,
        stored: Iterable[str] = (),
        read: Optional[Callable[[str], Any]] = None,
    ) -> None:
        """Args:
        count: rows of each array.
        of_what: "vertices" or "faces", for errors.
        stored: names of the source.
        read: gives the array of such a name.
        """
        self.count = count
        self.of_what = of_what
        self._read = read
        self._arrays: Dict[str, Optional[np.ndarray]] = {name: None for name in stored}

    def __getitem__(self, name: str) -> np.ndarray:
        """The array.

        Raises:
            KeyError: there is none of this name.
            MeshMapError: that of the source does not fit.
        """
        array = self._arrays[name]
        if array is None:
            assert self._read is not None
            array = self._checked(name, self._read(name))
            self._arrays[name] = array
        return array

    def __setitem__(self, name: str, values: Any) -> None:
        """Adds or replaces an attribute; the values are copied.

        Args:
            name: any text of printable characters but "/".
            values: (N,) or (N, K) numbers or bools, one row for each vertex or face.
        Raises:
            MeshMapError: another name, shape or type.
        """
        if not isinstance(name, str) or not name.strip() or one_line(name) != name or "/" in name:
            raise MeshMapError(
                "%r is no name for an attribute" % (name,), "printable characters but /"
            )
        self._arrays[name] = self._checked(name, values)

    def __delitem__(self, name: str) -> None:
        del self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(list(self._arrays))

    def __len__(self) -> int:
        return len(self._arrays)

    def _checked(self, name: str, values: Any) -> np.ndarray:
        try:
            array = np.array(values)
        except ValueError as error:  # rows of different lengths
            raise MeshMapError("attribute %s: %s" % (name, one_line(str(error)))) from error
        if array.dtype.kind not in "biuf":
            raise MeshMapError("attribute %s is of %s, not of numbers" % (name, array.dtype))
        if array.ndim not in (1, 2) or len(array) != self.count:
            raise MeshMapError(
                "attribute %s has the shape %s" % (name, array.shape),
                "one row is needed for each of the %d %s" % (self.count, self.of_what),
            )
        return read_only(array)


class MeshAttributes:
    """The attributes of a mesh.

    Attributes:
        vertices, faces: Attributes of each.
    """

    def __init__(self, vertex_count: int, face_count: int, contents: Optional[Any] = None) -> None:
        """Args:
        vertex_count, face_count: of the mesh.
        contents: a MapFile, whose stored layers and face attributes are there from the start;
            None for no attributes.
        """
        if contents is None:
            self.vertices = Attributes(vertex_count, "vertices")
            self.faces = Attributes(face_count, "faces")
            return
        self.vertices = Attributes(
            vertex_count, "vertices", contents.layer_names(), contents.vertex_costs
        )
        self.faces = Attributes(
            face_count, "faces", contents.face_attribute_names(), contents.face_attribute
        )


def face_costs(costs: Any, faces: Any, how: str = MAX) -> np.ndarray:
    """Costs of faces, of those of their corners.

    A face is lethal (+inf) if one of its corners is, else unknown (NaN) if one is.

    Args:
        costs: (V,).
        faces: (F, 3) vertex indices.
        how: "max" or "mean" of the corners.
    Returns:
        (F,) float32.
    Raises:
        ValueError: fewer costs than there are vertices, another shape, or another word.
    """
    choice(how, "how", (MAX, MEAN))
    values, triangles = np.asarray(costs, np.float32), np.asarray(faces)
    if values.ndim != 1 or (triangles.size and len(values) <= triangles.max()):
        raise ValueError("costs has the shape %s: one is needed for each vertex" % (values.shape,))
    corners = values[triangles]
    if how == MAX:
        result = corners.max(axis=1)
    else:
        result = (corners.sum(axis=1, dtype=np.float64) / 3.0).astype(np.float32)
    result[np.isinf(corners).any(axis=1)] = np.inf
    return result


def vertex_costs(costs: Any, topology: Topology, how: str = MAX) -> np.ndarray:
    """Costs of vertices, of those of the faces around them.

    A vertex is lethal (+inf) if one of its faces is, else unknown (NaN) if one is, or if there is
    no face.

    Args:
        costs: (F,).
        topology: of the mesh.
        how: "max" or "mean" of the faces.
    Returns:
        (V,) float32.
    Raises:
        ValueError: another number of costs, or another word.
    """
    choice(how, "how", (MAX, MEAN))
    values = one_each(np.asarray(costs, np.float32), "costs", topology.face_count, "face")
    offsets = topology.vertex_face_offsets
    degrees = np.diff(offsets)
    has_face = degrees > 0
    starts, around = offsets[:-1][has_face], values[topology.vertex_faces]
    result = np.full(topology.vertex_count, np.nan, np.float32)
    if len(starts):
        if how == MAX:
            result[has_face] = np.maximum.reduceat(around, starts)
        else:
            with np.errstate(invalid="ignore"):
                sums = np.add.reduceat(around.astype(np.float64), starts)
            result[has_face] = sums / degrees[has_face]
        lethal = np.logical_or.reduceat(np.isinf(around), starts)
        result[np.flatnonzero(has_face)[lethal]] = np.inf
    return result
