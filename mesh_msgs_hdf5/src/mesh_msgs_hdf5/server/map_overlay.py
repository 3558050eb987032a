"""A map with changes on top that are not in its file yet; changes put together and taken apart."""
import dataclasses
import threading
from typing import Any, Dict, List, Optional

import numpy as np

from mesh_msgs_hdf5.model.edit import CostsUpdate, Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label

_SINGLE = ("vertex_normals", "vertex_colors", "texture_coordinates", "materials", "features")


def merged(first: Edit, second: Edit) -> Edit:
    """One change that does what the two do one after the other."""
    values: Dict[str, Any] = {}
    for field in dataclasses.fields(Edit):
        old, new = getattr(first, field.name), getattr(second, field.name)
        if isinstance(new, dict) and field.name != "source":
            values[field.name] = {**old, **new}
        else:
            values[field.name] = old if new is None else new
    for costs, parameters in (
        ("vertex_costs", "layer_parameters"),
        ("face_attributes", "face_parameters"),
    ):
        # new values without parameters: the ones before were not computed like this
        lost = set(getattr(second, costs)) - set(getattr(second, parameters))
        values[parameters] = {k: v for k, v in values[parameters].items() if k not in lost}
    values["costs_updates"] = _costs_updates(first, second)
    given = {name for name in _SINGLE if getattr(second, name) is not None}
    values["remove"] = (first.remove - given) | second.remove
    values.update(dict.fromkeys(second.remove))
    return Edit(**values)


def _costs_updates(first, second):
    updates = {k: v for k, v in first.costs_updates.items() if k not in second.vertex_costs}
    for name, update in second.costs_updates.items():
        earlier = first.costs_updates.get(name)
        if earlier is not None:
            updates[name] = CostsUpdate(earlier.changed | update.changed, earlier.default)
        elif name not in first.vertex_costs:  # else all of it is new
            updates[name] = update
    return updates


def without(edit: Edit, done: Edit) -> Edit:
    """What of a change is left where `done`, an earlier state of it, has been made."""
    values: Dict[str, Any] = {}
    for field in dataclasses.fields(Edit):
        now, then = getattr(edit, field.name), getattr(done, field.name)
        if field.name == "remove":
            values[field.name] = now - then
        elif isinstance(now, dict) and field.name != "source":
            values[field.name] = {
                key: value
                for key, value in now.items()
                if key not in then or then[key] is not value
            }
        else:
            values[field.name] = None if now is then else now
    return Edit(**values)


class MapOverlay:
    """The interface of MapFile over a source, with what an Edit changes.

    These are edits of received messages: they remove no layer, face attribute or texture.

    Edits are never modified, only replaced, so that readers need no lock for them. Access to the
    source is one at a time: the lock is shared by all maps of a process, and whoever else reads or
    writes HDF5 files may hold it.

    Attributes: source (MapFile or MeshMembers; may be replaced by one of the same geometry), path,
    part, uuid, frame_id, vertex_count, face_count.
    """

    lock = threading.RLock()

    def __init__(self, source: Any) -> None:
        with self.lock:
            self.source = source
            self.path, self.part = source.path, source.part
            self.uuid, self.frame_id = source.uuid, source.frame_id
            self.vertex_count, self.face_count = source.vertex_count, source.face_count
        self._edit = Edit()
        self._changing = threading.Lock()

    @property
    def unsaved(self) -> Edit:
        """What is not in the file yet; not to be modified."""
        return self._edit

    def change(self, edit: Edit) -> None:
        """Put another change on top."""
        with self._changing:
            self._edit = merged(self._edit, edit)

    def saved(self, edit: Edit) -> None:
        """Forget what is in the file now, but not what has changed once more since."""
        with self._changing:
            self._edit = without(self._edit, edit)

    def follow_source(self) -> None:
        """The file has been changed by another program: updates of layers are of what is there now.

        Raises MapFileError.
        """
        with self._changing:
            costs, updates = dict(self._edit.vertex_costs), dict(self._edit.costs_updates)
            for name, update in updates.items():
                with self.lock:
                    there = layer_or_none(self.source, name)
                costs[name] = update.applied(costs[name], there)
                updates[name] = dataclasses.replace(update)  # goes with its costs; see without()
            self._edit = dataclasses.replace(self._edit, vertex_costs=costs, costs_updates=updates)

    def __getattr__(self, name: str) -> Any:
        """vertices, faces, vertex_normals, vertex_colors, texture_coordinates, materials, features:
        as of MapFile, but for what the changes put in their place or remove.
        """
        if name not in _SINGLE + ("vertices", "faces"):
            raise AttributeError("%s has no attribute %r" % (type(self).__name__, name))
        edit = self._edit
        value = getattr(edit, name, None)
        if value is not None or name in edit.remove:
            return value
        with self.lock:
            return getattr(self.source, name)

    @property
    def notes(self) -> List[str]:
        """What was left out or mended in what was read of the file."""
        return list(self.source.notes)

    @property
    def has_colors(self) -> bool:
        """True if there are vertex colors; they are not read."""
        edit = self._edit
        if edit.vertex_colors is not None or "vertex_colors" in edit.remove:
            return edit.vertex_colors is not None
        with self.lock:
            return bool(self.source.has_colors)

    def layer_names(self) -> List[str]:
        """Names of the vertex cost layers, sorted."""
        with self.lock:
            return _names(self.source.layer_names(), self._edit.vertex_costs)

    def vertex_costs(self, name: str) -> np.ndarray:
        """(V,) float32 of a layer."""
        return self._named("vertex_costs", "vertex_costs", name)

    def layer_parameters(self, name: str) -> Dict[str, Any]:
        """Those of a layer; {} where it has none, or where its values were replaced."""
        edit = self._edit
        if edit.layer_parameters.get(name) is not None:
            return dict(edit.layer_parameters[name] or {})
        if name in edit.layer_parameters or name in edit.vertex_costs:
            return {}
        with self.lock:
            return self.source.layer_parameters(name)

    def vertex_attribute_names(self) -> List[str]:
        """Names of the vertex attributes, sorted."""
        with self.lock:
            return self.source.vertex_attribute_names()

    def vertex_attribute(self, name: str) -> np.ndarray:
        """(V,) or (V, C)."""
        with self.lock:
            return self.source.vertex_attribute(name)

    def face_attribute_names(self) -> List[str]:
        """Names of the face attributes, sorted."""
        with self.lock:
            return _names(self.source.face_attribute_names(), self._edit.face_attributes)

    def face_attribute(self, name: str) -> np.ndarray:
        """(F,) or (F, C)."""
        return self._named("face_attributes", "face_attribute", name)

    def texture_indices(self) -> List[int]:
        """Indices of the textures, sorted."""
        with self.lock:
            return _names(self.source.texture_indices(), self._edit.textures)

    def texture(self, index: int) -> np.ndarray:
        """(height, width, 3 or 4) uint8."""
        return self._named("textures", "texture", index)

    def labels(self) -> Dict[str, Label]:
        """Text -> label, as they are in the file."""
        with self.lock:
            return self.source.labels()

    def _named(self, member: str, of_source: str, key: Any) -> np.ndarray:
        value = getattr(self._edit, member).get(key)
        if value is not None:
            return value
        with self.lock:
            return getattr(self.source, of_source)(key)


def layer_or_none(target: Any, name: str) -> Optional[np.ndarray]:
    """(V,) float32; None where there is no such layer. Raises MapFileError."""
    try:
        return target.vertex_costs(name)
    except MapFileError as error:
        if error.code != "layer":
            raise
        return None


def _names(known, changed):
    return sorted(set(known) | set(changed))
