"""Derived meshes: a mesh that was made of another one, and what of it came from where.

What belongs to the parent (labels, costs, attributes, colors, texture coordinates) is carried to
the derived mesh, and back. Both have an identity of their own.
"""

import json
import uuid
from typing import Any, Mapping, Optional

import numpy as np

from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices

# Part of the identity of derived meshes: another namespace would give each of them another UUID.
DERIVED_NAMESPACE = uuid.UUID("c0d6c2a5-3d0c-4c0b-8f0e-6a1d5a1f9b27")
# Weights of a vertex may be this far from 1 together.
_SUM_TOLERANCE = 1e-6


def derived_uuid(parent_uuid: str, kind: str, parameters: Mapping[str, Any]) -> str:
    """The version 5 UUID of a derived mesh, the same in every process and after each restart.

    Args:
        parent_uuid: of the mesh that it is made of.
        kind: how it is made, such as "refinement"; another way to make it needs another kind.
        parameters: with which (what json can write).
    """
    name = json.dumps([parent_uuid, kind, dict(parameters)], sort_keys=True)
    return str(uuid.uuid5(DERIVED_NAMESPACE, name))


class DerivedMesh:
    """A mesh made of another one. All arrays are read-only.

    Attributes:
        uuid, parent_uuid: identities, see derived_uuid().
        vertices: (V, 3) float32, meters in the parent's frame.
        faces: (F, 3) uint32.
        face_parents: (F,) uint32, the parent's face that each face is a part of.
        vertex_parents: (V, K) uint32, the parent's vertices that each vertex is between; those of a
            refinement are at most three. A vertex of fewer has weights of 0.
        vertex_weights: (V, K) float64, 0 to 1, 1 together: by linear interpolation.
        parent_vertex_count, parent_face_count: of the parent.
    """

    def __init__(
        self,
        uuid: str,
        parent_uuid: str,
        vertices: Any,
        faces: Any,
        *,
        face_parents: Any,
        vertex_parents: Any,
        vertex_weights: Any,
        parent_vertex_count: int,
        parent_face_count: int,
    ) -> None:
        """Checks what came from where; arrays that fit are not copied.

        Raises:
            ValueError: wrong shapes, a parent that does not exist, or weights that are no weights;
                the first is named.
        """
        self.uuid, self.parent_uuid = uuid, parent_uuid
        self.parent_vertex_count = int(parent_vertex_count)
        self.parent_face_count = int(parent_face_count)
        self.vertices = _read_only(as_vertices(vertices))
        self.faces = _read_only(as_faces(faces))
        self.face_parents = _read_only(
            _indices(face_parents, (len(self.faces),), self.parent_face_count, "face")
        )
        parents = np.asarray(vertex_parents)
        shape = (len(self.vertices), parents.shape[1] if parents.ndim == 2 else 1)
        self.vertex_parents = _read_only(
            _indices(parents, shape, self.parent_vertex_count, "vertex")
        )
        self.vertex_weights = _read_only(_weights(vertex_weights, shape))
        self._part_areas: Optional[np.ndarray] = None

    # From the parent.

    def vertex_values(self, values: Any) -> np.ndarray:
        """What the vertices have of values that the parent's vertices have: interpolated.

        +inf at one of the vertices that it is between makes +inf, else NaN makes NaN: between a
        lethal or unknown vertex and a free one nothing is free. Whole numbers, such as colors, are
        rounded; booleans are true where one is.

        Args:
            values: (V_parent,) or (V_parent, C).
        Returns:
            (V,) or (V, C) of the same dtype.
        Raises:
            ValueError: another number of values.
        """
        values = _rows(values, self.parent_vertex_count, "vertices of the parent")
        kind = values.dtype.kind
        found = np.zeros((len(self.vertices),) + values.shape[1:], np.float64)
        some_inf = np.zeros(found.shape, bool)
        for parents, weights in zip(self.vertex_parents.T, self.vertex_weights.T):
            weights = weights.reshape((-1,) + (1,) * (values.ndim - 1))
            part = values[parents]
            counts = np.broadcast_to(weights > 0.0, part.shape)
            if kind == "f":
                some_inf |= counts & np.isposinf(part)
                part = np.where(np.isposinf(part), 0.0, part)
            found += np.where(counts, weights * part.astype(np.float64), 0.0)
        if kind == "b":
            return found > 0.0
        found[some_inf] = np.inf
        if kind in "iu":
            found = np.rint(found)
        return found.astype(values.dtype)

    def face_values(self, values: Any) -> np.ndarray:
        """What the faces have of values (F_parent,) or (F_parent, C): those of their parents.

        Raises:
            ValueError: another number of values.
        """
        return _rows(values, self.parent_face_count, "faces of the parent")[self.face_parents]

    def faces_of(self, parent_faces: Any) -> np.ndarray:
        """(K,) uint32, ascending: the faces that are parts of these, such as those of a label.

        Raises:
            ValueError: a face that the parent does not have.
        """
        return np.flatnonzero(self._mask_of_parents(parent_faces)[self.face_parents]).astype(
            np.uint32
        )

    # Back to the parent.

    def parent_vertex_values(self, values: Any) -> np.ndarray:
        """What the parent's vertices have of values at the vertices: those at the same place.

        Where several vertices are one vertex of the parent (along a seam), the largest counts, and
        NaN before it. Where none is, nothing is known: NaN, and for whole numbers and booleans 0.

        Args:
            values: (V,) or (V, C).
        Returns:
            (V_parent,) or (V_parent, C) of the same dtype.
        Raises:
            ValueError: another number of values.
        """
        values = _rows(values, len(self.vertices), "vertices")
        rows, columns = np.nonzero(self.vertex_weights == 1.0)
        parents = self.vertex_parents[rows, columns]
        found = np.zeros((self.parent_vertex_count,) + values.shape[1:], values.dtype)
        taken = np.zeros(self.parent_vertex_count, bool)
        first = np.unique(parents, return_index=True)[1]
        found[parents[first]] = values[rows[first]]
        taken[parents] = True
        np.maximum.at(found, parents, values[rows])
        if values.dtype.kind == "f":
            found[~taken] = np.nan
        return found

    def parent_face_values(self, values: Any) -> np.ndarray:
        """What the parent's faces have of values (F,) at the faces, by the areas of their parts.

        Of floats the mean (+inf where one part is, else NaN where one is); of whole numbers and
        booleans the one with the most area, of several the smallest. Faces without parts have NaN,
        or 0.

        Raises:
            ValueError: another number of values, or several for each face.
        """
        values = _rows(values, len(self.faces), "faces")
        if values.ndim != 1:
            raise ValueError("one value is needed for each face, not %s" % (values.shape,))
        areas, parents, count = self._areas(), self.face_parents, self.parent_face_count
        if values.dtype.kind == "f":
            known = np.isfinite(values)
            total = np.bincount(parents, areas, count)
            weighted = np.bincount(parents, areas * np.where(known, values, 0.0), count)
            with np.errstate(invalid="ignore", divide="ignore"):
                mean = weighted / total
            mean[parents[np.isnan(values) | np.isneginf(values)]] = np.nan
            mean[parents[np.isposinf(values)]] = np.inf
            return mean.astype(values.dtype)
        known_values, which = np.unique(values, return_inverse=True)
        found = np.zeros(count, values.dtype)
        best = np.zeros(count)
        for index, value in enumerate(known_values):
            of_it = which == index
            area = np.bincount(parents[of_it], areas[of_it], count)
            more = area > best
            found[more], best[more] = value, area[more]
        return found

    def edited_parent_faces(self, faces: Any, before: Any = ()) -> np.ndarray:
        """The parent's faces of a label whose faces here are to be these.

        A face of the parent is in it as a whole or not at all, so whatever was done to one of its
        parts was done to it: a part that was added adds it, and one that was taken away takes it
        away.

        Args:
            faces: (K,) of this mesh, of the label as it is to be.
            before: (N,) of the parent, of the label as it is; none of a new one.
        Returns:
            (M,) uint32, ascending.
        Raises:
            ValueError: a face that this mesh, or the parent, does not have.
        """
        before = self._mask_of_parents(before)
        chosen = np.zeros(len(self.faces), bool)
        chosen[_indices(faces, None, len(self.faces), "face")] = True
        added = np.zeros(self.parent_face_count, bool)
        added[self.face_parents[chosen]] = True
        taken = np.zeros(self.parent_face_count, bool)
        taken[self.face_parents[~chosen]] = True
        return np.flatnonzero(np.where(before, ~taken, added)).astype(np.uint32)

    def _mask_of_parents(self, parent_faces: Any) -> np.ndarray:
        mask = np.zeros(self.parent_face_count, bool)
        mask[_indices(parent_faces, None, self.parent_face_count, "face")] = True
        return mask

    def _areas(self) -> np.ndarray:
        """(F,) of the faces, of any unit; the same for all parts of a parent without area."""
        if self._part_areas is None:
            a, b, c = self.vertices.astype(np.float64)[self.faces].transpose(1, 0, 2)
            areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
            without = np.bincount(self.face_parents, areas, self.parent_face_count) == 0.0
            areas[without[self.face_parents]] = 1.0
            self._part_areas = areas
        return self._part_areas


def _read_only(array: np.ndarray) -> np.ndarray:
    view = array.view()
    view.flags.writeable = False
    return view


def _rows(values: Any, count: int, what: str) -> np.ndarray:
    values = np.asarray(values)
    if values.ndim not in (1, 2) or len(values) != count or values.dtype.kind not in "biuf":
        raise ValueError(
            "values of the shape %s and type %s are not those of %d %s"
            % (values.shape, values.dtype, count, what)
        )
    return values


def _indices(indices: Any, shape: Any, count: int, what: str) -> np.ndarray:
    """uint32; of a shape, or of any number where that is None."""
    indices = np.asarray(indices)
    if shape is None:
        shape = (indices.size,)
    if indices.size == 0:
        indices = indices.astype(np.uint32)
    if indices.shape != shape or indices.dtype.kind not in "iu":
        raise ValueError(
            "%s indices of the shape %s and type %s, but %s whole numbers are needed"
            % (what, indices.shape, indices.dtype, shape)
        )
    wrong = (indices < 0) | (indices >= count)
    if wrong.any():
        first = int(np.argmax(wrong.ravel()))
        raise ValueError(
            "%s %d does not exist (number %d; %d such in all): there are %d"
            % (what, indices.ravel()[first], first, np.count_nonzero(wrong), count)
        )
    return np.ascontiguousarray(indices, np.uint32)


def _weights(weights: Any, shape: Any) -> np.ndarray:
    weights = np.ascontiguousarray(weights, np.float64)
    if weights.shape != shape:
        raise ValueError("weights of the shape %s, not %s" % (weights.shape, shape))
    right = ((weights >= 0.0) & (weights <= 1.0)).all(1)
    right &= np.abs(weights.sum(1) - 1.0) <= _SUM_TOLERANCE
    if not right.all():
        first = int(np.argmin(right))
        raise ValueError(
            "the weights of vertex %d are %s (%d such in all): 0 to 1, 1 together, are needed"
            % (first, weights[first].tolist(), np.count_nonzero(~right))
        )
    return weights
