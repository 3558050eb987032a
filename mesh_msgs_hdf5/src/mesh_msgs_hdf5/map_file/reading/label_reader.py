"""Reads labels: labels/<class>/<instance> holds the faces of the label class_instance."""
from typing import Dict, List, Optional, Tuple

import h5py

from mesh_msgs.checks.label_name import label_fault
from mesh_msgs_hdf5.checks.check import checked_label
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import check_shape
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import row_attribute, text_attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import (
    child,
    children,
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
)
from mesh_msgs_hdf5.model.mesh import Label


class LabelReader(PartReader):
    """The labels of a part, which are in a group of it, if the layout has one."""

    face_count: int

    def label_names(self) -> List[str]:
        """The texts of the labels, in natural order (tree_2 before tree_10)."""
        return list(self.label_paths())

    def label_paths(self) -> Dict[str, Tuple[str, str]]:
        """Text -> (group, dataset) below the group of labels; in natural order of the texts.

        The text is that of the attribute, or class_instance. Links, and what is no dataset in a
        group of a class, are no labels. Raises MapFileError (label, size, value).
        """
        labels = self.guarded.subgroup(self.layout.labels) if self.layout.labels else None
        found: Dict[str, Tuple[str, str]] = {}
        if labels is None:
            return found
        path = self.guarded.path
        classes = [
            name
            for name in children(path, labels, MAX_LABELS)
            if is_group_of_this_file(labels, name)
        ]
        names: Dict[str, List[str]] = {}
        left = MAX_LABELS  # counted before any is looked at: a class may have many names
        for class_name in classes:
            names[class_name] = children(path, child(path, labels, class_name), left)
            left -= len(names[class_name])
        for class_name in classes:
            group = child(path, labels, class_name)
            for name in names[class_name]:
                text = self._label_text(group, class_name, name)
                if text is None:
                    continue
                check_label(path, text, "/".join((labels.name, class_name, name)))
                if text in found:
                    raise MapFileError(
                        "label",
                        path,
                        "label %s is there twice, in %s/{%s/%s,%s/%s}"
                        % ((text, labels.name) + found[text] + (class_name, name)),
                        "remove one of them",
                    )
                found[text] = class_name, name
        return {text: found[text] for text in sorted(found, key=natural_order)}

    def _label_text(self, group, class_name, name) -> Optional[str]:
        """The text of a label; None if it is none."""
        found = hard_object(group, name)
        if not isinstance(found, h5py.h5d.DatasetID):
            return None
        if h5py.h5a.exists(found, TEXT.encode("utf-8")):
            return text_attribute(self.guarded.path, h5py.Dataset(found), TEXT)
        return join_label(class_name, name)

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
        """All labels by their texts, in natural order."""
        return {text: self._read_label(text, *place) for text, place in self.label_paths().items()}

    def _read_label(self, text, class_name, name):
        path = self.guarded.path
        found = self.guarded.dataset("/".join((self.layout.labels, class_name, name)))
        check_shape(path, found, 1)
        color = row_attribute(path, found, schema.LABEL_COLOR, 3)
        label = Label(self.guarded.values(found).reshape(-1), None if color is None else color)
        return checked_label(path, text, label, self.face_count)
