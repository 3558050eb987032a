"""The parameters of label_manager."""
import os
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional

DEFAULT_FOLDER = "/tmp/label_manager/"


@dataclass(frozen=True)
class LabelOptions:
    """All paths are absolute.

    folder: for labels of meshes that are not named. maps: files, without duplicates. part: of each.
    import_folder: of label_manager 1.x, read at the start if import_at_start.
    """

    folder: str = DEFAULT_FOLDER
    maps: List[str] = field(default_factory=list)
    part: Optional[str] = None
    import_folder: str = DEFAULT_FOLDER
    import_at_start: bool = False


def parse(parameters: Dict[str, Any]) -> LabelOptions:
    """The options from the private parameters (name without ~ -> value).

    Raises ValueError: a sentence that names the parameter.
    """
    folder = _folder(parameters, "folder_path") or os.path.abspath(DEFAULT_FOLDER)
    to_import = _folder(parameters, "import_folder")
    part = parameters.get("mesh_part")
    if part is not None and (isinstance(part, bool) or not isinstance(part, (str, int, float))):
        raise ValueError("~mesh_part is %r; give the name of a part" % (part,))
    maps = [path for name in ("map_file", "inputFile") for path in _files(parameters, name, folder)]
    return LabelOptions(
        folder=folder,
        maps=list(dict.fromkeys(maps)),
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
    found = []
    for value in values if isinstance(values, list) else [values]:
        # a name of digits comes as a number from the command line
        text = str(value) if isinstance(value, (str, int, float)) else "\0"
        if "\0" in text or isinstance(value, bool):
            raise ValueError("~%s is %r; give the path of a map file or a mesh" % (name, value))
        if text:
            # a relative one counts from where the node runs, with roslaunch ~/.ros
            here = os.path.abspath(text)
            found.append(here if os.path.exists(here) else os.path.join(folder, text))
    return found
