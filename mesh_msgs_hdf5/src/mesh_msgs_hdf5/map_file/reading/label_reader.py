"""Reads labels: labels/<class>/<instance> holds the faces of the label class_instance."""
from typing import Dict, FrozenSet, List, Optional, Sequence, Tuple

import h5py
import numpy as np

from mesh_msgs.checks.label_name import label_fault
from mesh_msgs_hdf5.checks.check import checked_label
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import check_shape
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import row_attribute, text_attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import (
    child,
    hard_object,
    is_group_of_this_file,
)
from mesh_msgs_hdf5.map_file.reading.part_reader import PartReader
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import (
    MAX_LABELS,
    TEXT,
    check_label,
    join_label,
    label_path,
    natural_order,
    usable_label,
)
from mesh_msgs_hdf5.model.mesh import Label

_CUT = 50  # characters of a text that cannot be used, where a number comes behind it


class LabelReader(PartReader):
    """The labels of a part, which are in a group of it, if the layout has one."""

    face_count: int
    _renamed: Sequence[str] = ()

    def label_names(self) -> List[str]:
        """The texts of the labels, in natural order (tree_2 before tree_10)."""
        return list(self.label_paths())

    def label_paths(self) -> Dict[str, Tuple[str, str]]:
        """Text -> (group, dataset) below the group of labels; in natural order of the texts.

        The text is that of the attribute, or class_instance. Links, and what is no dataset in a
        group of a class, are no labels. A text that cannot be one, or is another label's, is read
        as one like it, with a note (see renamed_labels).
        """
        found = self.tolerated(self._label_paths, {})
        return {text: found[text] for text in sorted(found, key=natural_order)}

    def renamed_labels(self) -> FrozenSet[str]:
        """Those of the texts that the file does not say so."""
        self.label_paths()
        return frozenset(self._renamed)

    def _label_paths(self):
        labels = self.guarded.subgroup(self.layout.labels) if self.layout.labels else None
        found: Dict[str, Tuple[str, str]] = {}
        if labels is None:
            return found
        path = self.guarded.path
        classes = [
            name
            for name in self.guarded.children(labels, MAX_LABELS)
            if is_group_of_this_file(labels, name)
        ]
        names: Dict[str, List[str]] = {}
        left = MAX_LABELS  # counted before any is looked at: a class may have many names
        for class_name in classes:
            names[class_name] = self.guarded.children(child(path, labels, class_name), left)
            left -= len(names[class_name])
        wrong: List[Tuple[str, Tuple[str, str], MapFileError]] = []
        for class_name in classes:
            group = child(path, labels, class_name)
            for name in names[class_name]:
                text = self._label_text(group, class_name, name)
                if text is None:
                    continue
                try:
                    self._check_text(labels, text, (class_name, name), found)
                except MapFileError as error:
                    if self.strict:
                        raise
                    wrong.append((text, (class_name, name), error))
                    continue
                found[text] = class_name, name
        self._renamed = self._rename(wrong, found)
        return found

    def _check_text(self, labels, text, place, found):
        path = self.guarded.path
        check_label(path, text, "/".join((labels.name,) + place))
        if text in found:
            raise MapFileError(
                "label",
                path,
                "label %s is there twice, in %s/{%s/%s,%s/%s}"
                % ((text, labels.name) + found[text] + place),
                "remove one of them",
            )

    def _rename(self, wrong, found):
        """Put labels whose texts cannot be used into found, and return how they are called there.

        All others have their texts already: no label loses its own to one of these.
        """
        numbers: Dict[str, int] = {}
        renamed = []
        for text, place, error in wrong:
            text = wanted = usable_label(text)
            while text in found:
                numbers[wanted] = numbers.get(wanted, 1) + 1
                text = usable_label("%s_%d" % (wanted[:_CUT], numbers[wanted]))
            found[text] = place
            renamed.append(text)
            self.note("%s: it is read as %s" % (error.message, text))
        return renamed

    def _label_text(self, group, class_name, name) -> Optional[str]:
        """The text of a label; None if it is none."""
        found = hard_object(group, name)
        if not isinstance(found, h5py.h5d.DatasetID):
            return None
        text = None
        if h5py.h5a.exists(found, TEXT.encode("utf-8")):
            dataset, path = h5py.Dataset(found), self.guarded.path
            text = self.tolerated(lambda: text_attribute(path, dataset, TEXT), None)
        return join_label(class_name, name) if text is None else text

    def label(self, text: str) -> Label:
        """One label; each face once, at its first place in the file.

        Only if it is not at its own place, all are looked at.
        """
        place = self._own_place(text)
        if place is not None:
            return self._read_label(text, *place)
        known = self.label_paths()
        if text not in known:
            shown = ", ".join(list(known)[:20]) + (", ..." if len(known) > 20 else "")
            raise MapFileError(
                "label",
                self.guarded.path,
                "there is no label %r" % (text,),
                "labels of this file: %s" % (shown or "none"),
            )
        return self._read_label(text, *known[text])

    def _own_place(self, text) -> Optional[Tuple[str, str]]:
        """The place that label_path gives, if a label of this text is there."""
        labels = self.guarded.subgroup(self.layout.labels) if self.layout.labels else None
        if labels is None or not isinstance(text, str) or label_fault(text):
            return None
        class_name, name, _ = label_path(text)
        if not is_group_of_this_file(labels, class_name):
            return None
        group = child(self.guarded.path, labels, class_name)
        there = self._label_text(group, class_name, name) == text
        return (class_name, name) if there else None

    def labels(self) -> Dict[str, Label]:
        """All labels that can be read by their texts, in natural order."""
        found = {}
        for text, place in self.label_paths().items():
            label = self.tolerated(lambda: self._read_label(text, *place), None)
            if label is not None:
                found[text] = label
        return found

    def _read_label(self, text, class_name, name):
        path = self.guarded.path
        found = self.guarded.dataset("/".join((self.layout.labels, class_name, name)))
        check_shape(path, found, 1)
        color = self.tolerated(lambda: self._color(text, found), None)
        faces = self.guarded.values(found).reshape(-1)
        if not self.strict and faces.dtype.kind in "iu":
            faces = self._faces_of_mesh(text, faces)
        return checked_label(path, text, Label(faces, color), self.face_count)

    def _color(self, text, found):
        path = self.guarded.path
        color = row_attribute(path, found, schema.LABEL_COLOR, 3)
        return checked_label(path, text, Label(np.zeros(0, np.uint32), color), 0).color

    def _faces_of_mesh(self, text, faces):
        wrong = (faces < 0) | (faces >= self.face_count)
        if wrong.any():
            first = wrong.argmax()
            self.note(
                "left out: %d of %d faces of label %s, for the mesh has only %d; first entry %d, %d"
                % (wrong.sum(), len(faces), text, self.face_count, first, faces[first])
            )
            faces = faces[~wrong]
        return faces
