"""A map with changes on top that are not in its file yet; changes put together and taken apart."""
import dataclasses
import threading
from typing import Any, Dict, List, Optional

import numpy as np

from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials

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
    given = {name for name in _SINGLE if getattr(second, name) is not None}
    values["remove"] = (first.remove - given) | second.remove
    values.update(dict.fromkeys(second.remove))
    return Edit(**values)


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

    @property
    def vertices(self) -> np.ndarray:
        """(V, 3) float32."""
        with self.lock:
            return self.source.vertices

    @property
    def faces(self) -> np.ndarray:
        """(F, 3) uint32."""
        with self.lock:
            return self.source.faces

    @property
    def vertex_normals(self) -> Optional[np.ndarray]:
        """(V, 3) float32 or None."""
        return self._single("vertex_normals")

    @property
    def vertex_colors(self) -> Optional[np.ndarray]:
        """(V, 3) uint8 or None."""
        return self._single("vertex_colors")

    @property
    def texture_coordinates(self) -> Optional[np.ndarray]:
        """(V, 2) float32 or None."""
        return self._single("texture_coordinates")

    @property
    def materials(self) -> Optional[Materials]:
        """Materials or None."""
        return self._single("materials")

    @property
    def features(self) -> Optional[Features]:
        """Features or None."""
        return self._single("features")

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
        costs = self._edit.vertex_costs.get(name)
        if costs is not None:
            return costs
        with self.lock:
            return self.source.vertex_costs(name)

    def face_attribute_names(self) -> List[str]:
        """Names of the face attributes, sorted."""
        with self.lock:
            return _names(self.source.face_attribute_names(), self._edit.face_attributes)

    def face_attribute(self, name: str) -> np.ndarray:
        """(F,) or (F, C)."""
        values = self._edit.face_attributes.get(name)
        if values is not None:
            return values
        with self.lock:
            return self.source.face_attribute(name)

    def texture_indices(self) -> List[int]:
        """Indices of the textures, sorted."""
        with self.lock:
            return _names(self.source.texture_indices(), self._edit.textures)

    def texture(self, index: int) -> np.ndarray:
        """(height, width, 3 or 4) uint8."""
        pixels = self._edit.textures.get(index)
        if pixels is not None:
            return pixels
        with self.lock:
            return self.source.texture(index)

    def labels(self) -> Dict[str, Label]:
        """Text -> label, as they are in the file."""
        with self.lock:
            return self.source.labels()

    def _single(self, name: str) -> Any:
        edit = self._edit
        value = getattr(edit, name)
        if value is not None or name in edit.remove:
            return value
        with self.lock:
            return getattr(self.source, name)


def _names(known, changed):
    return sorted(set(known) | set(changed))
