"""The parameters of label_manager."""
import os
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional

from mesh_msgs_hdf5.files.probe import check_node_path

DEFAULT_FOLDER = "/tmp/label_manager/"


@dataclass(frozen=True)
class LabelOptions:
    """All paths are absolute.

    folder: for labels of meshes that are not named. maps: files, without duplicates. part: of each.
    import_folder: of label_manager 1.x, read at the start if import_at_start. given: path of a map
    -> as it was given.
    """

    folder: str = DEFAULT_FOLDER
    maps: List[str] = field(default_factory=list)
    part: Optional[str] = None
    import_folder: str = DEFAULT_FOLDER
    import_at_start: bool = False
    given: Dict[str, str] = field(default_factory=dict, compare=False)

    def check(self, path: str) -> None:
        """Refuse a map that was given by a relative path and is not there. Raises MapFileError."""
        if not os.path.lexists(path):
            check_node_path(self.given[path])


def parse(parameters: Dict[str, Any]) -> LabelOptions:
    """The options from the private parameters (name without ~ -> value).

    Raises ValueError: a sentence that names the parameter.
    """
    folder = _folder(parameters, "folder_path") or os.path.abspath(DEFAULT_FOLDER)
    to_import = _folder(parameters, "import_folder")
    part = parameters.get("mesh_part")
    if part is not None and (isinstance(part, bool) or not isinstance(part, (str, int, float))):
        raise ValueError("~mesh_part is %r; give the name of a part" % (part,))
    maps: Dict[str, str] = {}
    for name in ("map_file", "inputFile"):
        maps.update(_files(parameters, name, folder))
    return LabelOptions(
        folder=folder,
        maps=list(maps),
        given=maps,
        part=None if part is None else str(part),
        import_folder=to_import or folder,
        import_at_start=bool(to_import),
    )


def _folder(parameters, name):
    value = parameters.get(name, "")
    if not isinstance(value, str) or "\0" in value:
        raise ValueError("~%s is %r; give the path of a folder" % (name, value))
    return value and os.path.abspath(value)


def _files(parameters, name, folder):
    values = parameters.get(name, [])
    found = {}
    for value in values if isinstance(values, list) else [values]:
        # a name of digits comes as a number from the command line
        text = str(value) if isinstance(value, (str, int, float)) else "\0"
        if "\0" in text or isinstance(value, bool):
            raise ValueError("~%s is %r; give the path of a map file or a mesh" % (name, value))
        if text:
            # a relative one counts from where the node runs, with roslaunch ~/.ros
            here, there = os.path.abspath(text), os.path.join(folder, text)
            found[here if os.path.exists(here) else there] = text
    return found
