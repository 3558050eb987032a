"""Reads what a part has under names of its own: cost layers, attributes of vertices and faces."""
from functools import cached_property
from typing import Any, Dict, Iterable, List, Tuple

import h5py
import numpy as np

from mesh_msgs_hdf5.checks.check import checked_attribute, checked_costs, from_json
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import attribute, text_attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import exists
from mesh_msgs_hdf5.map_file.reading.part_reader import PartReader
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError

MAX_ARRAYS = 4096  # names in a group of layers or attributes
_INDICES = "_idx"  # LVR2 stores a sparse map as <name> and <name>_idx
_CUT = 50  # characters of a name that cannot be used
_LAYER, _VERTEX_ATTRIBUTE, _FACE_ATTRIBUTE = "layer", "vertex attribute", "face attribute"


def _dense(names: List[str]) -> List[str]:
    """The names that are no half of a sparse map."""
    known = set(names)
    return [name for name in names if not name.endswith(_INDICES) and name + _INDICES not in known]


def _shape_text(found, rows):
    text = "%s has the shape %s, not [%d] or [%d,C]: one row for each vertex"
    return text % (found.name, list(found.shape), rows, rows)


def _is_usable(name):
    try:
        schema.check_face_attribute_name("", name)
    except MapFileError:
        return False
    return True


class NamedArrayReader(PartReader):
    """The layers and attributes of a part. Each group of the file is looked through once."""

    vertex_count: int
    face_count: int
    schema_version: int

    @cached_property
    def layer_places(self) -> Dict[str, str]:
        """Name -> place in the part, sorted by name, of the cost layers: float datasets with one
        value per vertex that are not mesh data.
        """
        return self._vertex_places[0]

    @cached_property
    def vertex_attribute_places(self) -> Dict[str, str]:
        """Name -> place in the part, sorted by name, of the other numbers that vertices have."""
        return self._vertex_places[1]

    @cached_property
    def _vertex_places(self) -> Tuple[Dict[str, str], Dict[str, str]]:
        return self.tolerated(self._found_vertex_places, ({}, {}))

    def _found_vertex_places(self):
        layers: Dict[str, str] = {}
        attributes: Dict[str, str] = {}
        for group_place in self.layout.layers:
            group = self.guarded.subgroup(group_place)
            for name in _dense(self.guarded.names(group_place, MAX_ARRAYS)):
                place = "%s/%s" % (group_place, name)
                known = name in layers or name in attributes
                if name in schema.RESERVED or place in self.layout.single or known:
                    continue
                kind = self._kind_of(group, name)
                if kind:
                    (layers if kind == _LAYER else attributes)[name] = place
        return self._usable(_LAYER, layers), self._usable(_VERTEX_ATTRIBUTE, attributes)

    def _kind_of(self, group, name):
        """_LAYER, _VERTEX_ATTRIBUTE, or "" for what is neither.

        What looks like one but has not a row for each vertex is one of them in a file of ours, and
        cannot be read; in those of others it is unknown.
        """
        key = name.encode("utf-8")
        if group.id.links.get_info(key).type != h5py.h5l.TYPE_HARD:
            return ""  # a link is not followed, so it is no layer
        found = h5py.h5o.open(group.id, key)
        if not isinstance(found, h5py.h5d.DatasetID) or not found.shape:
            return ""
        shape, kind = found.shape, found.get_type().get_class()
        if kind == h5py.h5t.FLOAT and shape in ((self.vertex_count,), (self.vertex_count, 1)):
            return _VERTEX_ATTRIBUTE if self._is_marked(found) else _LAYER
        numbers = kind in (h5py.h5t.FLOAT, h5py.h5t.INTEGER) and found.get_type().get_size() <= 8
        if not numbers or len(shape) > 2 or not shape[-1] or not self.vertex_count:
            return ""
        if shape[0] == self.vertex_count:
            return _VERTEX_ATTRIBUTE
        if not self.schema_version or shape[0] == self.face_count:  # LVR2 has channels of faces
            return ""
        costs = kind == h5py.h5t.FLOAT and shape[0] == int(np.prod(shape))
        names = (schema.KIND, schema.PARAMETERS)
        ours = any(h5py.h5a.exists(found, name.encode()) for name in names)
        if not (costs or ours or shape[-1] == self.vertex_count):
            return ""
        return _LAYER if costs and not self._is_marked(found) else _VERTEX_ATTRIBUTE

    def with_rows(self, names: Iterable[str]) -> List[str]:
        """Those of these names of layers or vertex attributes that have a row for each vertex."""
        places = {**self.vertex_attribute_places, **self.layer_places}
        found = {name: self.guarded.group[places[name]] for name in names}
        return [name for name in names if found[name].shape[0] == self.vertex_count]

    def _is_marked(self, found):
        if not h5py.h5a.exists(found, schema.KIND.encode()):
            return False
        try:
            return (
                attribute(self.guarded.path, h5py.Dataset(found), schema.KIND) == schema.ATTRIBUTE
            )
        except MapFileError:
            return False

    @cached_property
    def face_attribute_places(self) -> Dict[str, str]:
        """Name -> place in the part, sorted by name: every dataset in the group of face attributes,
        and single ones of LVR2.
        """
        return self.tolerated(self._face_attribute_places, {})

    def _face_attribute_places(self):
        group_place = self.layout.face_attributes
        names = _dense(self.guarded.dataset_names(group_place, MAX_ARRAYS)) if group_place else ()
        found = {name: "%s/%s" % (group_place, name) for name in names}
        for place in self.layout.face_arrays:
            name = place.rpartition("/")[2]
            if name not in found and exists(self.guarded.group, place):
                found[name] = place
        return self._usable(_FACE_ATTRIBUTE, found)

    def _usable(self, what, found):
        """The same, sorted, with names that can be saved; a note says what has another one."""
        usable = {name: place for name, place in found.items() if _is_usable(name)}
        for name, place in found.items():
            if name in usable or self.strict:
                usable[name] = place
                continue
            plain = new = "".join(c if c.isprintable() else "_" for c in name)[:_CUT] or "_"
            number = 1
            while new in usable or new in found or not _is_usable(new):
                number += 1
                new = "%s_%d" % (plain, number)
            usable[new] = place
            self.note("the name of %s %r is not printable: it is read as %s" % (what, name, new))
        return dict(sorted(usable.items()))

    def layer_names(self) -> List[str]:
        """The names of the vertex cost layers, sorted."""
        return list(self.layer_places)

    def vertex_costs(self, name: str) -> np.ndarray:
        """(V,) float32 of one layer: finite >= 0 is a cost, +inf lethal, NaN unknown."""
        found = self._named(_LAYER, self.layer_places, name)
        values = self.guarded.values(self._with_rows(found))
        values = self._sound_costs("layer %s" % name, values, "vertex")
        return checked_costs(self.guarded.path, name, values, self.vertex_count)

    def _with_rows(self, found: h5py.Dataset) -> h5py.Dataset:
        """The same, if it has a row for each vertex."""
        if len(found) != self.vertex_count:
            text, hint = _shape_text(found, self.vertex_count), "mesh_tool repair leaves it out"
            raise MapFileError("shape", self.guarded.path, text, hint)
        return found

    def layer_parameters(self, name: str) -> Dict[str, Any]:
        """The parameters that a layer was computed with (dict); {} if the file does not say."""
        return self._parameters(self._named(_LAYER, self.layer_places, name))

    def all_layer_parameters(self) -> Dict[str, Dict[str, Any]]:
        """Layer name -> its parameters, of all layers, sorted; no costs are read."""
        return {name: self.layer_parameters(name) for name in self.layer_names()}

    def vertex_attribute_names(self) -> List[str]:
        """The names of the vertex attributes, sorted."""
        return list(self.vertex_attribute_places)

    def vertex_attribute(self, name: str) -> np.ndarray:
        """(V,) or (V, C) numbers of one vertex attribute, in the type that they are stored in."""
        found = self._named(_VERTEX_ATTRIBUTE, self.vertex_attribute_places, name)
        values = self.guarded.values(self._with_rows(found))
        return checked_attribute(self.guarded.path, "vertex", name, values, self.vertex_count)

    def vertex_parameters(self, name: str) -> Dict[str, Any]:
        """The parameters that a vertex attribute was computed with; {} if the file does not say."""
        return self._parameters(self._named(_VERTEX_ATTRIBUTE, self.vertex_attribute_places, name))

    def face_attribute_names(self) -> List[str]:
        """The names of the face attributes, sorted."""
        return list(self.face_attribute_places)

    def face_attribute(self, name: str) -> np.ndarray:
        """(F,) or (F, C) numbers of one face attribute, in the type that they are stored in."""
        found = self._named(_FACE_ATTRIBUTE, self.face_attribute_places, name)
        if found.ndim not in (1, 2) or len(found) != self.face_count:
            raise MapFileError(
                "shape",
                self.guarded.path,
                "%s has the shape %s, not [%d] or [%d,C]"
                % (found.name, list(found.shape), self.face_count, self.face_count),
                "one row for each face",
            )
        values = self.guarded.values(found)
        if self.layout.schema == "S2" and found.shape[1:] == (1,):
            values = values.reshape(-1)  # LVR2 has no arrays of one dimension
        if values.dtype == np.float32 and values.size == self.face_count:
            values = self._sound_costs("face attribute %s" % name, values, "face")
        return checked_attribute(self.guarded.path, "face", name, values, self.face_count)

    def face_parameters(self, name: str) -> Dict[str, Any]:
        """The parameters that a face attribute was computed with; {} if the file does not say."""
        return self._parameters(self._named(_FACE_ATTRIBUTE, self.face_attribute_places, name))

    def _parameters(self, found):
        def read():
            text = text_attribute(self.guarded.path, found, schema.PARAMETERS)
            return from_json(self.guarded.path, "%s of %s" % (schema.PARAMETERS, found.name), text)

        return self.tolerated(read, {})

    def _sound_costs(self, name, values, noun):
        """Costs as float32; -inf, which means nothing, is unknown, as NaN: never free."""
        if self.strict or values.dtype.kind != "f":
            return values
        values = self.float32(values, name)
        wrong = values == -np.inf
        if wrong.any():
            text = "%s: %d values -inf are taken for unknown (NaN), first %s %d"
            self.note(text % (name, np.count_nonzero(wrong), noun, wrong.reshape(-1).argmax()))
            values = np.where(wrong, np.float32(np.nan), values)
        return values

    def _named(self, what, places, name):
        if name not in places:
            raise MapFileError(
                "layer",
                self.guarded.path,
                "there is no %s %r" % (what, name),
                "%ss of this file: %s" % (what, ", ".join(places) or "none"),
            )
        return self.guarded.dataset(places[name])
