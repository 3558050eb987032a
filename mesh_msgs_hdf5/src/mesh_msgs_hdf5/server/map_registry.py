"""The maps that a server has, by the UUID of their geometry."""
from typing import Dict, Iterator, List

from mesh_msgs_hdf5.server.served_map import ServedMap

# what clients of mesh_msgs_hdf5 1.x ask for
_THE_ONLY_ONE = ("", "mesh")


class UnknownMap(LookupError):
    """There is no such map; the text names the known ones."""


class MapRegistry:
    """Maps in the order in which they were added."""

    def __init__(self) -> None:
        self._maps: Dict[str, ServedMap] = {}

    def add(self, served: ServedMap) -> None:
        """Raises ValueError if a map of the same geometry is there already."""
        _check_other(served, self._maps)
        self._maps[served.uuid] = served

    def replace(self, old: ServedMap, new: ServedMap) -> None:
        """Put a map in the place of another one. Raises ValueError as add()."""
        others = {uuid: served for uuid, served in self._maps.items() if served is not old}
        _check_other(new, others)
        # in one step: other threads use the old dict meanwhile
        self._maps = {
            served.uuid: served
            for served in (new if served is old else served for served in self._maps.values())
        }

    def find(self, uuid: str) -> ServedMap:
        """The map of that UUID; "" and "mesh" are the only one. Raises UnknownMap."""
        if uuid in self._maps:
            return self._maps[uuid]
        known = ", ".join(self._maps)
        if uuid not in _THE_ONLY_ONE:
            raise UnknownMap("there is no map of uuid %r; known: %s" % (uuid[:80], known))
        if len(self._maps) != 1:
            raise UnknownMap("there are several maps; name one by its uuid: %s" % known)
        return next(iter(self._maps.values()))

    def uuids(self) -> List[str]:
        """Of all maps."""
        return list(self._maps)

    def __iter__(self) -> Iterator[ServedMap]:
        return iter(list(self._maps.values()))

    def __len__(self) -> int:
        return len(self._maps)


def _check_other(served, maps):
    if served.uuid in maps:
        raise ValueError(
            "%s is not served: its geometry is that of %s, and a UUID stands for one map"
            % (served.name, maps[served.uuid].name)
        )
