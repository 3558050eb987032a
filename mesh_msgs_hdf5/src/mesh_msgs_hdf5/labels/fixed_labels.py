"""Labels that cannot be changed, with the interface of LabelStore."""
from typing import Any, Dict, List, NoReturn, Optional

from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import natural_order, split_label
from mesh_msgs_hdf5.model.mesh import Label


class FixedLabels:
    """The labels that a map (MapFile, or what has its interface) has in its file.

    For a map whose labels cannot be stored: refusal says why. Attributes: path, notes, refusal,
    dirty, is_owner, owner as those of LabelStore.
    """

    dirty = False
    is_owner = False
    owner: Optional[Dict[str, Any]] = None

    def __init__(self, source: Any, path: str, refusal: MapFileError) -> None:
        """path: where the labels would be stored."""
        self._source = source
        self.path = path
        self.refusal = refusal
        self.notes = ["labels cannot be changed: %s" % refusal]

    def all(self) -> Dict[str, Label]:
        """Text -> label; tree_2 before tree_10."""
        labels = self._source.labels()
        return {text: labels[text] for text in sorted(labels, key=natural_order)}

    def groups(self) -> List[str]:
        """The classes of all labels."""
        return list(dict.fromkeys(split_label(text)[0] for text in self.all()))

    def group(self, class_name: str) -> Dict[str, Label]:
        """The labels of exactly that class."""
        return {k: label for k, label in self.all().items() if split_label(k)[0] == class_name}

    def set(self, *_: Any, **__: Any) -> NoReturn:
        """Raises MapFileError."""
        raise self.refusal

    set_color = delete = set

    def save(self) -> int:
        """Nothing to do."""
        return 0

    def close(self) -> None:
        """Nothing to do."""
