"""Names of labels: the text "tree_1" is instance 1 of the class tree, in the file tree/1.

A text without an underscore is a free one; it has a class and an empty instance. Texts that have no
plain path (free ones, and those with an empty or dotted part) are kept in an attribute of the
dataset too, from which they are read back.
"""
import re
from typing import Any, List, Tuple

from mesh_msgs.checks.label_name import MAX_LABEL_BYTES, label_fault
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

TEXT = "label"  # attribute with the whole text, where the path does not tell it
MAX_LABELS = 50_000  # of a map
# what HDF5 does not take as a name, or takes for "here" and "above"
_ESCAPED = {"": "%", ".": "%2E", "..": "%2E%2E"}


def split_label(text: str) -> Tuple[str, str]:
    """(class, instance) of a label's text: before and after the first underscore."""
    class_name, _, instance = text.partition("_")
    return class_name, instance


def join_label(class_name: str, instance: str) -> str:
    """The text of a label from its path in a file that does not say it otherwise."""
    return "%s_%s" % (class_name, instance)


def natural_order(text: str) -> List[Any]:
    """A sort key that counts: tree_2 comes before tree_10."""
    parts = re.split("([0-9]+)", text)
    return [(int(part), part) if index % 2 else part for index, part in enumerate(parts)]


def label_path(text: str) -> Tuple[str, str, bool]:
    """(group, dataset, plain) of a label; if it is not plain, TEXT must be stored with it."""
    class_name, instance = split_label(text)
    group, dataset = (_escaped(name) for name in (class_name, instance))
    return group, dataset, "_" in text and (group, dataset) == (class_name, instance)


def _escaped(name):
    return "%25" + name[1:] if name.startswith("%") else _ESCAPED.get(name, name)


def usable_label(text: str) -> str:
    """A text that can be a label, as like as possible to one that cannot."""
    fault = label_fault(text)
    while fault is not None:
        if fault.index >= MAX_LABEL_BYTES:
            text = text.encode("utf-8", "replace")[: fault.index].decode("utf-8", "ignore")
        else:
            text = text[: fault.index] + "_" + text[fault.index + 1 :]
        fault = label_fault(text)
    return text or "_"


def check_label(path: PathLike, text: str, place: str = "") -> None:
    """Refuse a text that cannot be a label: code label.

    path: of the map, place: of the dataset that has it in there, for the error.
    """
    fault = label_fault(text)
    if text and fault is None:
        return
    hint = "name it like tree_1: class, underscore, instance, in up to %d bytes" % MAX_LABEL_BYTES
    where = ""
    if place:
        where = " (of the dataset %s)" % place
        hint += "; in this file with h5py, or where it was made"
    what = fault.what if fault else "is empty"
    raise MapFileError("label", path, "label %r%s %s" % (text[:80], where, what), hint)
