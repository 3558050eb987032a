"""The planners of a server: found by name in plugin descriptions, made ready for a map."""

import re
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple

from mesh_map.errors import PluginError
from mesh_map.mesh_map import MeshMap
from mesh_map.plugins import find_class, scanned_once

from mesh_navigation.planner import MeshPlanner

BASE_CLASS = "mesh_navigation::MeshPlanner"
DEFAULT_PLANNERS = (
    {"name": "dijkstra_mesh_planner", "type": "dijkstra_mesh_planner/DijkstraMeshPlanner"},
    {"name": "wave_front_planner", "type": "wave_front_planner/WaveFrontPlanner"},
    {"name": "mmp_planner", "type": "mmp_planner/MMPPlanner"},
)
"""Where no others are configured: those of the released configurations, by their names there."""


# Topics and parameters of a planner have its name.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


class Entry(NamedTuple):
    """One line of the parameter ~planners."""

    name: str
    type: str


def read_entries(value: Any, parameter: str) -> Tuple[List[Entry], List[str]]:
    """The entries of a plugin list, and one sentence for each that is none.

    Args:
        value: what the user gave, a list of ``{name: ..., type: ...}``.
        parameter: its name, for the sentences.
    """
    if not isinstance(value, (list, tuple)):
        return [], [f"{parameter} is no list of {{name, type}} but {value!r}"]
    entries: List[Entry] = []
    complaints = []
    for index, item in enumerate(value):
        where = f"{parameter}[{index}]"
        if not isinstance(item, Mapping) or not all(
            isinstance(item.get(key), str) and item[key] for key in Entry._fields
        ):
            complaints.append(f"{where} is skipped: it is no {{name, type}} of texts but {item!r}")
        elif not _NAME.fullmatch(item["name"]):
            complaints.append(
                f"{where} is skipped: {item['name']!r} is no name of letters, digits and _"
            )
        elif item["name"] in [entry.name for entry in entries]:
            complaints.append(f"{where} is skipped: there is a '{item['name']}' before it")
        else:
            entries.append(Entry(item["name"], item["type"]))
    return entries, complaints


class PlannerList:
    """Planners by name, in the order of the list; the first is the default.

    Names are known at once. The planners themselves exist after ``initialize``.
    """

    def __init__(self, value: Any = DEFAULT_PLANNERS, parameter: str = "~planners") -> None:
        """Find the class of each entry. What cannot be used is left out, see ``complaints``."""
        entries, self.complaints = read_entries(value, parameter)
        self._planners: Dict[str, MeshPlanner] = {}
        self._faults: Dict[str, str] = {}
        with scanned_once():
            for entry in entries:
                try:
                    self._planners[entry.name] = find_planner(entry.type)
                except PluginError as error:
                    self.complaints.append(f"planner '{entry.name}' is skipped: {error}")

    @property
    def names(self) -> List[str]:
        """Names of the planners that could be loaded, the default first."""
        return list(self._planners)

    def choose(self, name: str) -> Optional[str]:
        """The name of the planner to use, empty for the default; None if there is none of it."""
        if not name:
            return next(iter(self._planners), None)
        return name if name in self._planners else None

    def initialize(
        self, mesh_map: MeshMap, parameters: Mapping[str, Mapping[str, Any]]
    ) -> List[str]:
        """Make the planners ready for a map.

        Args:
            mesh_map: the map.
            parameters: given parameters by the planner's name.

        Returns:
            One sentence for each thing that is not as the user asked.
        """
        complaints = []
        for name, planner in self._planners.items():
            given = parameters.get(name, {})
            try:
                found = planner.initialize(name, mesh_map, given)
            except Exception as error:  # A plugin may raise anything; the other planners go on.
                text = f"{type(error).__name__}: {error}".splitlines()[0]
                self._faults[name] = f"planner '{name}' could not be initialized: {text}"
                complaints.append(self._faults[name])
            else:
                complaints += [f"{name}/{complaint}" for complaint in found or []]
        return complaints

    def ready(self) -> List[MeshPlanner]:
        """The planners that could be initialized."""
        return [planner for name, planner in self._planners.items() if name not in self._faults]

    def fault(self, name: str) -> Optional[str]:
        """Why a planner cannot be used although it was loaded, or None."""
        return self._faults.get(name)

    def __getitem__(self, name: str) -> MeshPlanner:
        return self._planners[name]


def find_planner(type_name: str) -> MeshPlanner:
    """A planner of the type that a plugin description names, not yet initialized.

    Raises:
        PluginError: there is none, or it cannot be made.
    """
    cls = find_class("mesh_navigation", BASE_CLASS, type_name)
    if not (isinstance(cls, type) and issubclass(cls, MeshPlanner)):
        raise PluginError(f"{type_name} is no subclass of mesh_navigation.planner.MeshPlanner")
    try:
        return cls()
    except Exception as error:  # A plugin may raise anything; the other planners go on.
        raise PluginError(f"{type_name}() fails with {type(error).__name__}: {error}") from error
