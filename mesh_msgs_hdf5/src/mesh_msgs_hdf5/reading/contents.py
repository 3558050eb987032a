"""What is in a map file besides the mesh."""
from typing import Iterable, List, Set

import h5py

from mesh_msgs_hdf5.errors import PathLike
from mesh_msgs_hdf5.reading.hdf5_guard import children, is_group_of_this_file


def other_contents(
    file: h5py.File, path: PathLike, own: Set[str], structure: Set[str], others: Iterable[str]
) -> List[str]:
    """The absolute paths of what is neither in own (see MapReader.own_paths) nor in another part.

    structure: absolute paths of groups that say nothing by themselves. others: names of the other
    parts. Of any other group in which nothing is ours the group is named, not what is in it; links
    are not followed. In the order of a walk through the file.
    """
    known = own.union("/" + part for part in others)
    ways = set(structure)
    for place in known | structure:
        while "/" in place[1:]:
            place = place.rpartition("/")[0]
            ways.add(place)
    found: List[str] = []
    _walk(path, file["/"], "", known, ways, found)
    return found


def _walk(path, group, prefix, known, ways, found):
    """No deeper than what is known, so that nothing can make it go deep."""
    for name in children(path, group):
        place = "%s/%s" % (prefix, name)
        if place in known:
            continue
        if place in ways and is_group_of_this_file(group, name):
            _walk(path, group[name], place, known, ways, found)
        else:
            found.append(place)
