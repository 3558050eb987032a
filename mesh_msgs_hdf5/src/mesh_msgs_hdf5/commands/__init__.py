"""The verbs of mesh_tool, one module each; what they share is in _common.py. Other packages may
export more (see verbs.exported_verbs).

Each has NAME, HELP, EXAMPLE, add_arguments(parser), run(arguments) -> exit code. It may have
ACTIONS, the words that may come behind the verb (the first of them is meant if none does), and
TROUBLE, the exit code for a MapFileError if that is not 1. A module is imported when its verb is
used, so that a command starts quickly.
"""
import importlib
from types import ModuleType
from typing import Dict

# verb -> module
VERBS: Dict[str, str] = {
    "info": "info",
    "validate": "validate",
    "import": "import_mesh",
    "export": "export_mesh",
    "convert": "convert",
    "repair": "repair",
    "diff": "diff",
    "layers": "layers",
    "labels": "labels",
    "parts": "parts",
    "repack": "repack",
    "scans": "scans",
    "render": "render",
    "completion": "completion",
}
# of verbs that packages of this repository export (see verbs.exported_verbs): where they come from
ELSEWHERE: Dict[str, str] = {
    "layers compute": "mesh_map",
    "refine": "mesh_map",
    "crop": "mesh_map",
    "merge": "mesh_map",
    "reconstruct": "mesh_map",
}


def command(verb: str) -> ModuleType:
    """The module of a verb."""
    return importlib.import_module("mesh_msgs_hdf5.commands." + VERBS[verb])
