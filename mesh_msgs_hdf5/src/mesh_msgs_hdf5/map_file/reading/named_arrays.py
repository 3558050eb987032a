"""Reads what a part has under names of its own: cost layers and face attributes."""
from typing import Any, Dict, List, Optional

import h5py
import numpy as np

from mesh_msgs_hdf5.checks.check import checked_costs, checked_face_attribute, from_json
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import GuardedGroup
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import text_attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import exists
from mesh_msgs_hdf5.map_file.reading.layouts import Layout
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError

MAX_ARRAYS = 4096  # names in a group of layers or face attributes
_INDICES = "_idx"  # LVR2 stores a sparse map as <name> and <name>_idx


def _dense(names: List[str]) -> List[str]:
    """The names that are no half of a sparse map."""
    known = set(names)
    return [name for name in names if not name.endswith(_INDICES) and name + _INDICES not in known]


class NamedArrays:
    """One kind of them. what: its name, for errors."""

    what = ""

    def __init__(self, part: GuardedGroup, layout: Layout, count: int) -> None:
        """count: of the vertices or faces that the arrays belong to."""
        self._part = part
        self._layout = layout
        self._count = count
        self._known: Optional[Dict[str, str]] = None

    def places(self) -> Dict[str, str]:
        """Name -> place in the part, sorted by name. The file is looked through once."""
        if self._known is None:
            self._known = dict(sorted(self._found().items()))
        return self._known

    def _found(self) -> Dict[str, str]:
        """Name -> place in the part."""
        raise NotImplementedError

    def names(self) -> List[str]:
        """The names, sorted."""
        return list(self.places())

    def values(self, name: str) -> np.ndarray:
        """The values, checked."""
        raise NotImplementedError

    def parameters(self, name: str) -> Dict[str, Any]:
        """What it was computed with; {} if the file does not say."""
        path, found = self._part.path, self._dataset(name)
        text = text_attribute(path, found, schema.PARAMETERS)
        return from_json(path, "%s of %s" % (schema.PARAMETERS, found.name), text)

    def _dataset(self, name):
        places = self.places()
        if name not in places:
            raise MapFileError(
                "layer",
                self._part.path,
                "there is no %s %r" % (self.what, name),
                "%ss of this file: %s" % (self.what, ", ".join(places) or "none"),
            )
        return self._part.dataset(places[name])


class LayerReader(NamedArrays):
    """Cost layers: float datasets with one value per vertex that are not mesh data."""

    what = "layer"

    def _found(self) -> Dict[str, str]:
        found: Dict[str, str] = {}
        for group_place in self._layout.layers:
            group = self._part.subgroup(group_place)
            for name in _dense(self._part.names(group_place, MAX_ARRAYS)):
                place = "%s/%s" % (group_place, name)
                if name in schema.RESERVED or place in self._layout.single or name in found:
                    continue
                if self._is_layer(group, name):
                    found[name] = place
        return found

    def _is_layer(self, group, name):
        key = name.encode("utf-8")
        if group.id.links.get_info(key).type != h5py.h5l.TYPE_HARD:
            return False  # a link is not followed, so it is no layer
        found = h5py.h5o.open(group.id, key)
        return (
            isinstance(found, h5py.h5d.DatasetID)
            and found.get_type().get_class() == h5py.h5t.FLOAT
            and found.shape in ((self._count,), (self._count, 1))
        )

    def values(self, name: str) -> np.ndarray:
        """(V,) float32."""
        values = self._part.values(self._dataset(name))
        return checked_costs(self._part.path, name, values, self._count)


class FaceAttributeReader(NamedArrays):
    """Face attributes: every dataset in their group, and single ones of LVR2."""

    what = "face attribute"

    def _found(self) -> Dict[str, str]:
        group_place = self._layout.face_attributes
        names = _dense(self._part.dataset_names(group_place, MAX_ARRAYS)) if group_place else ()
        found = {name: "%s/%s" % (group_place, name) for name in names}
        for place in self._layout.face_arrays:
            name = place.rpartition("/")[2]
            if name not in found and exists(self._part.group, place):
                found[name] = place
        return found

    def values(self, name: str) -> np.ndarray:
        """(F,) or (F, C) numbers in their own type."""
        found = self._dataset(name)
        if found.ndim not in (1, 2) or len(found) != self._count:
            raise MapFileError(
                "shape",
                self._part.path,
                "%s has the shape %s, not [%d] or [%d,C]"
                % (found.name, list(found.shape), self._count, self._count),
                "one row for each face",
            )
        values = self._part.values(found)
        return checked_face_attribute(self._part.path, name, values, self._count)
