"""Changes of the labels in a map file by a command, beside the nodes that may own them.

A node that owns the labels (see label_store.py) keeps edits in a journal. A command takes them over
for a moment, so that it sees those edits and none is lost; while a node owns them, it refuses.
"""
import contextlib
from typing import Dict, Iterable, Iterator, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.any_mesh import is_map_file, open_members
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import check_label, split_label
from mesh_msgs_hdf5.model.mesh import Color, Label

Labels = Dict[str, Label]
_UNREADABLE = Label(np.zeros(0, np.uint32))
Changes = Dict[str, Optional[Label]]


def present_labels(path: str, part: Optional[str]) -> Tuple[Labels, str, int, List[str]]:
    """(labels, UUID of the mesh, its number of faces, notes) of a file of any format.

    Labels that are in the journal of a map only are there too. Raises MapFileError.
    """
    file = open_members(path, part).members
    if not is_map_file(path):
        return file.labels(), file.uuid, file.face_count, []
    with LabelStore(path, part, read_only=True) as store:
        labels = store.all()
        return labels, store.uuid, file.face_count, store.notes + store.file_notes()


@contextlib.contextmanager
def changing(path: str, part: Optional[str]) -> Iterator[Tuple[Labels, IsolatedMapFile]]:
    """The labels and the map file, while no node can change them. Raises MapFileError.

    A label that cannot be read is there without faces, so that it can be deleted.

    The edits of a journal that nobody owns any more are saved first.
    """
    file = IsolatedMapFile(path, part)
    if file.schema != "S1":
        message = "it is of schema %s, which is only read" % file.schema
        raise MapFileError("schema", path, message, "mesh_tool convert IN.h5 OUT.h5")
    with LabelStore(path, file.part, {"program": "mesh_tool"}) as store:
        if store.refusal is not None:
            raise store.refusal
        store.save()
        labels = store.all()
        labels = {text: labels.get(text, _UNREADABLE) for text in store.names()}
        yield labels, IsolatedMapFile(path, file.part)


def check_there(path: str, labels: Labels, texts: Iterable[str]) -> None:
    """Refuse a text that is no label's."""
    for text in texts:
        if text not in labels:
            names = list(labels)
            shown = ", ".join(names[:8]) + (", ... (%d)" % len(names) if len(names) > 8 else "")
            hint = "there are: " + shown if names else "the map has none"
            raise MapFileError("label", path, "there is no label %r" % text, hint)


def _check_readable(path, labels, texts):
    check_there(path, labels, texts)
    for text in texts:
        if labels[text] is _UNREADABLE:
            message = "label %r cannot be read (see mesh_tool validate)" % text
            raise MapFileError("label", path, message, "delete it, and make it anew")


def deleted(path: str, labels: Labels, texts: Iterable[str], whole_class: bool) -> Changes:
    """The labels of these texts (with whole_class: of all labels of these classes) removed."""
    if whole_class:
        classes = set(texts)
        known = {split_label(text)[0] for text in labels}
        for name in sorted(classes - known):
            hint = "there are: " + ", ".join(sorted(known)) if known else "the map has none"
            raise MapFileError("label", path, "there is no class %r" % name, hint)
        texts = [text for text in labels if split_label(text)[0] in classes]
    texts = list(texts)
    check_there(path, labels, texts)
    return dict.fromkeys(texts)


def renamed(path: str, labels: Labels, old: str, new: str) -> Changes:
    """A label with another text."""
    _check_readable(path, labels, [old])
    check_label(path, new)
    if new in labels:
        raise MapFileError("exists", path, "there is a label %r already" % new, "delete it first")
    return {old: None, new: labels[old]}


def colored(path: str, labels: Labels, texts: Iterable[str], color: Optional[Color]) -> Changes:
    """Labels with another color, or none."""
    texts = list(texts)
    _check_readable(path, labels, texts)
    return {text: Label(labels[text].faces, color) for text in texts}
