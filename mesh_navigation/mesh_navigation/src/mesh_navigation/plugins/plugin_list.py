"""The plugins of a server: found by name in plugin descriptions, made ready for a map."""

import re
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple, Type

from mesh_map.base.errors import MeshMapError, PluginError
from mesh_map.base.plugins import find_class, scanned_once
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.body.body import POINT, Body
from mesh_navigation.plugins.controller import MeshController
from mesh_navigation.plugins.planner import MeshPlanner
from mesh_navigation.plugins.plugin import MeshPlugin
from mesh_navigation.plugins.recovery import MeshRecovery


class PluginKind(NamedTuple):
    """One of the kinds of plugins that a server has."""

    what: str
    """What one is called in messages."""
    parameter: str
    """The list of them."""
    base_class_type: str
    """In plugin descriptions."""
    cls: Type[MeshPlugin]
    default: Tuple[Mapping[str, str], ...]
    """Where no others are configured: those of the released configurations, by their names there,
    as far as they had names there."""


PLANNERS = PluginKind(
    "planner",
    "~planners",
    "mesh_navigation::MeshPlanner",
    MeshPlanner,
    (
        {"name": "dijkstra_mesh_planner", "type": "dijkstra_mesh_planner/DijkstraMeshPlanner"},
        {"name": "wave_front_planner", "type": "wave_front_planner/WaveFrontPlanner"},
        {"name": "mmp_planner", "type": "mmp_planner/MMPPlanner"},
    ),
)
CONTROLLERS = PluginKind(
    "controller",
    "~controllers",
    "mesh_navigation::MeshController",
    MeshController,
    ({"name": "mesh_controller", "type": "mesh_controller/MeshController"},),
)
BEHAVIORS = PluginKind(
    "recovery behavior",
    "~recovery_behaviors",
    "mesh_navigation::MeshRecovery",
    MeshRecovery,
    (
        {"name": "clear_layers", "type": "mesh_recovery/ClearLayers"},
        {"name": "wait", "type": "mesh_recovery/Wait"},
        {"name": "back_up", "type": "mesh_recovery/BackUp"},
    ),
)


# Topics and parameters of a plugin have its name.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def read_entries(value: Any, parameter: str) -> Tuple[Dict[str, str], List[str]]:
    """Name -> type of a plugin list, and one sentence for each entry that is none.

    Args:
        value: what the user gave, a list of ``{name: ..., type: ...}``.
        parameter: its name, for the sentences.
    """
    if not isinstance(value, (list, tuple)):
        return {}, [f"{parameter} is no list of {{name, type}} but {value!r}"]
    types: Dict[str, str] = {}
    complaints = []
    for index, item in enumerate(value):
        where = f"{parameter}[{index}]"
        if not isinstance(item, Mapping) or not all(
            isinstance(item.get(key), str) and item[key] for key in ("name", "type")
        ):
            complaints.append(f"{where} is skipped: it is no {{name, type}} of texts but {item!r}")
        elif not _NAME.fullmatch(item["name"]):
            complaints.append(
                f"{where} is skipped: {item['name']!r} is no name of letters, digits and _"
            )
        elif item["name"] in types:
            complaints.append(f"{where} is skipped: there is a '{item['name']}' before it")
        else:
            types[item["name"]] = item["type"]
    return types, complaints


class Prepared:
    """The plugins of one kind, ready for one map; those that could not be made so have a fault."""

    def __init__(
        self,
        kind: PluginKind,
        classes: Mapping[str, Type[MeshPlugin]],
        mesh_map: MeshMap,
        parameters: Mapping[str, Mapping[str, Any]],
        body: Body = POINT,
    ) -> None:
        """
        Args:
            kind: of the plugins.
            classes: of them, by their names.
            mesh_map: the map.
            parameters: given parameters by the plugin's name.
            body: of the robot on that map.
        """
        self.complaints: List[str] = []
        """One sentence for each thing that is not as the user asked."""
        self._plugins: Dict[str, Any] = {}
        self._faults: Dict[str, str] = {}
        for name, cls in classes.items():
            try:
                plugin = cls()
                plugin.body = body
                complaints = plugin.initialize(name, mesh_map, parameters.get(name, {}))
            except (Exception, SystemExit) as error:  # Whatever it raises, the others go on.
                text = (f"{type(error).__name__}: {error}".splitlines() or [""])[0]
                self._faults[name] = f"{kind.what} '{name}' could not be initialized: {text}"
                self.complaints.append(self._faults[name])
            else:
                self._plugins[name] = plugin
                self.complaints += [f"{name}/{complaint}" for complaint in complaints or ()]

    def ready(self) -> List[Any]:
        """Those that can be used, in the order of the list."""
        return list(self._plugins.values())

    def __getitem__(self, name: str) -> Any:
        """One of them.

        Raises:
            NotReady: it cannot be used although it was loaded.
        """
        if name in self._faults:
            raise NotReady("NOT_INITIALIZED", self._faults[name])
        return self._plugins[name]


class PluginList:
    """Plugins of one kind by name, in the order of the list; the first is the default.

    Names are known at once. The plugins themselves are made anew for each map.
    """

    def __init__(self, kind: PluginKind, value: Any = None) -> None:
        """Find the class of each entry. What cannot be used is left out, see ``complaints``.

        Args:
            kind: of the plugins.
            value: what the user gave as the list; None: nothing, the default of the kind counts.
        """
        self.kind = kind
        types, self.complaints = read_entries(
            kind.default if value is None else value, kind.parameter
        )
        self._classes: Dict[str, Type[MeshPlugin]] = {}
        with scanned_once():
            for name, type_name in types.items():
                try:
                    self._classes[name] = type(find_plugin(kind, type_name))
                except PluginError as error:
                    self.complaints.append(f"{kind.what} '{name}' is skipped: {error}")

    @property
    def names(self) -> List[str]:
        """Names of the plugins that could be loaded, the default first."""
        return list(self._classes)

    def choose(self, name: str) -> Optional[str]:
        """The name of the plugin to use, empty for the default; None if there is none of it."""
        if not name:
            return next(iter(self._classes), None)
        return name if name in self._classes else None

    def why_not(self, name: str) -> str:
        """The sentence for a name that `choose` has no plugin for."""
        known = ", ".join(self.names) or "none could be loaded"
        return f"there is no {self.kind.what} '{name}'; known: {known}"

    def prepared(
        self,
        mesh_map: MeshMap,
        parameters: Mapping[str, Mapping[str, Any]] = {},
        body: Body = POINT,
    ) -> Prepared:
        """New plugins, ready for a map; those for another map are as they were.

        Args:
            mesh_map: the map.
            parameters: given parameters by the plugin's name.
            body: of the robot on that map.
        """
        return Prepared(self.kind, self._classes, mesh_map, parameters, body)


def find_plugin(kind: PluginKind, type_name: str) -> Any:
    """A plugin of the type that a plugin description names, not yet initialized.

    Raises:
        PluginError: there is none, or it cannot be made.
    """
    cls = find_class("mesh_navigation", kind.base_class_type, type_name)
    if not (isinstance(cls, type) and issubclass(cls, kind.cls)):
        base = f"{kind.cls.__module__}.{kind.cls.__name__}"
        raise PluginError(f"{type_name} is no subclass of {base}")
    try:
        return cls()
    except (Exception, SystemExit) as error:  # Whatever it raises, the others go on.
        raise PluginError(f"{type_name}() fails with {type(error).__name__}: {error}") from error


def checked_plugin(
    kind: PluginKind, type_name: str, parameters: Mapping[str, Any], called: str = ""
) -> Any:
    """A plugin that has no map yet; what there is to complain of is known before one is read.

    Args:
        kind: of the plugin.
        type_name: as for `find_plugin`.
        parameters: those that differ from their defaults.
        called: what it is called in messages; empty: its type.

    Raises:
        MeshMapError: no such plugin, or a name or value that is none of its parameters.
    """
    made, called = find_plugin(kind, type_name), called or type_name
    known = {parameter.name: parameter for parameter in made.parameters}
    for name, value in parameters.items():
        if name not in known:
            text = f"{kind.what} {called} has no parameter '{name}'"
            raise MeshMapError(text, "it has: " + (", ".join(known) or "none"))
        warning = known[name].checked(value)[1]
        if warning:
            raise MeshMapError(f"{kind.what} {called}: {warning.split(':')[0]}")
    return made


def ready_plugin(
    kind: PluginKind,
    type_name: str,
    mesh_map: MeshMap,
    parameters: Mapping[str, Any],
    called: str = "",
    body: Body = POINT,
) -> Any:
    """A plugin that is ready for a map and a body on it; the others as for `checked_plugin`."""
    made, called = checked_plugin(kind, type_name, parameters, called), called or type_name
    made.body = body
    for complaint in made.initialize(called.split("/")[-1], mesh_map, parameters) or ():
        raise MeshMapError(f"{kind.what} {called}: {complaint}")
    return made
