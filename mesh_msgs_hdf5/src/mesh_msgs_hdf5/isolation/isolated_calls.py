"""What runs in a process of its own, because the file that it reads may be hostile.

The functions are called there by name (isolation.FUNCTIONS), so each is an ordinary one that may
also be called here.
"""
from typing import Any, Dict, List, Optional, Tuple

from mesh_msgs_hdf5.map_file import MapFile

State = Dict[str, Any]


def use_map_file(
    path: str,
    part: Optional[str],
    state: Optional[State],
    member: Optional[str],
    arguments: List[Any],
    keywords: Dict[str, Any],
    strict: bool = False,
) -> Tuple[Any, State]:
    """(value, state) of a member of a MapFile: of a property, or what a method returns.

    state: what an earlier call has returned, so that this one notices if the mesh was replaced in
    between; None opens the file, as MapFile(path, part) does. member: None only opens it.
    """
    if state is None:
        file = MapFile(path, part, strict)
    else:
        file = MapFile.__new__(MapFile)
        vars(file).update(state)
    value = None
    if member is not None:
        value = getattr(file, member)
        if callable(value):
            value = value(*arguments, **keywords)
    return value, vars(file)
