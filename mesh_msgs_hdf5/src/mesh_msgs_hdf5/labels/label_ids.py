"""Labels as numbers of faces, as programs that learn from them want it: a class and an instance."""
import json
from typing import Any, Dict, List, Mapping, NamedTuple, Tuple

import numpy as np

from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.label_names import natural_order, split_label
from mesh_msgs_hdf5.model.mesh import Label

FORMAT, VERSION = "mesh_label_ids", 1
UNLABELLED = 0
_MOST = (1 << 16) - 1  # ids fit the 16 bits of a pixel


class LabelIds(NamedTuple):
    """Numbers of faces, and what they mean.

    classes, instances: (F,) int32 from 1, UNLABELLED where there is no label; each label is an
    instance. table: what they mean, as JSON has it. overlapping: how many faces have several
    labels; of those the last counts, as in pictures.
    """

    classes: np.ndarray
    instances: np.ndarray
    table: Dict[str, Any]
    overlapping: int


def label_ids(
    path: PathLike,
    labels: Mapping[str, Label],
    uuid: str,
    face_count: int,
    known: Mapping[int, str],
) -> LabelIds:
    """The ids of labels. Classes that are known (number -> name) have those numbers, others the
    next ones; path is for errors. Raises MapFileError (value, size).
    """
    classes = _numbered(path, [split_label(text)[0] for text in labels], known)
    of_class = np.full(face_count, UNLABELLED, np.int32)
    of_instance = np.full(face_count, UNLABELLED, np.int32)
    times = np.zeros(face_count, np.int64)
    entries: List[Dict[str, Any]] = []
    for number, (text, label) in enumerate(labels.items(), 1):
        class_name, instance = split_label(text)
        of_class[label.faces], of_instance[label.faces] = classes[class_name], number
        times[label.faces] += 1
        color = None if label.color is None else [int(value) for value in label.color]
        entry = {"instance_id": number, "class_id": classes[class_name], "label": text}
        entries.append({**entry, "class": class_name, "instance": instance, "color": color})
    if len(entries) > _MOST:
        raise MapFileError("size", path, "%d labels are more than %d" % (len(entries), _MOST))
    counts = np.bincount(of_class, minlength=max(classes.values(), default=0) + 1)
    table = {
        "format": FORMAT,
        "version": VERSION,
        "uuid": uuid,
        "faces": face_count,
        "unlabelled": UNLABELLED,
        "classes": [
            {"id": number, "name": name, "faces": int(counts[number])}
            for name, number in sorted(classes.items(), key=lambda pair: pair[1])
        ],
        "labels": entries,
    }
    return LabelIds(of_class, of_instance, table, int(np.count_nonzero(times > 1)))


def _numbered(path: PathLike, names: List[str], known: Mapping[int, str]) -> Dict[str, int]:
    """Class -> number."""
    numbers = {name: number for number, name in known.items()}
    wrong = [number for number in numbers.values() if not 0 < number <= _MOST]
    if wrong or len(numbers) < len(known):
        text = "class %d is not from 1 to %d" % (wrong[0], _MOST) if wrong else "a class is twice"
        raise MapFileError("value", path, "the table of classes cannot be used: " + text)
    following = max(numbers.values(), default=0) + 1
    for name in sorted(set(names) - set(numbers), key=natural_order):
        numbers[name] = following
        following += 1
    if following - 1 > _MOST:
        text = "%d classes are more than %d" % (len(numbers), _MOST)
        raise MapFileError("size", path, text, "choose labels like tree_1, with few classes")
    return numbers


def ids_to_csv(ids: LabelIds) -> bytes:
    """A line for each face: its index, the number of its class and of its instance."""
    table = np.stack([np.arange(len(ids.classes)), ids.classes, ids.instances], axis=1)
    pattern, parts = "%d,%d,%d\n", [b"face,class_id,instance_id\n"]
    for start in range(0, len(table), 1 << 15):
        block = table[start : start + (1 << 15)]
        parts.append((pattern * len(block) % tuple(block.reshape(-1).tolist())).encode("ascii"))
    return b"".join(parts)


def table_text(table: Mapping[str, Any]) -> bytes:
    """The table as a file has it: an entry in a line."""
    lines = []
    for key, value in table.items():
        if isinstance(value, list):
            text = ",\n  ".join(json.dumps(entry) for entry in value)
            lines.append('"%s": [\n  %s]' % (key, text) if value else '"%s": []' % key)
        else:
            lines.append('"%s": %s' % (key, json.dumps(value)))
    return ("{" + ",\n ".join(lines) + "}\n").encode("utf-8")


def overlap_note(ids: LabelIds) -> Tuple[str, ...]:
    """A note for faces with several labels, if there are."""
    if not ids.overlapping:
        return ()
    return ("%d faces have several labels: the last counts" % ids.overlapping,)
