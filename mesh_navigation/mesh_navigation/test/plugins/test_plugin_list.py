"""Lists of plugins: what cannot be used is skipped with a reason, the rest goes on."""

import pytest

from mesh_map.base.errors import PluginError
from mesh_navigation.base.outcomes import NotReady
from mesh_navigation.planners.dijkstra import DijkstraMeshPlanner
from mesh_navigation.plugins import plugin_list
from mesh_navigation.plugins.controller import MeshController
from mesh_navigation.plugins.planner import MeshPlanner
from mesh_navigation.plugins.plugin_list import (
    BEHAVIORS,
    CONTROLLERS,
    PLANNERS,
    PluginList,
    find_plugin,
    read_entries,
)

DIJKSTRA = "dijkstra_mesh_planner/DijkstraMeshPlanner"


class Broken(MeshPlanner):
    def initialize(self, name, mesh_map, given={}):
        raise RuntimeError("no wheels\non this map")


class Silent(MeshPlanner):
    def initialize(self, name, mesh_map, given={}):
        raise RuntimeError


class Exiting(MeshPlanner):
    def initialize(self, name, mesh_map, given={}):
        raise SystemExit("enough")


class Telling(MeshPlanner):
    def initialize(self, name, mesh_map, given={}):
        super().initialize(name, mesh_map, given)
        return [f"{name} {mesh_map} {given}"]


class Unbuildable(MeshPlanner):
    def __init__(self, argument):
        super().__init__()


class Controller(MeshController):
    pass


@pytest.fixture
def classes(monkeypatch):
    """Plugins of the tests beside those of the package."""
    own = (Broken, Silent, Exiting, Telling, Unbuildable, Controller)
    found = {f"t/{cls.__name__}": cls for cls in own}
    found["t/Stranger"] = dict
    original = plugin_list.find_class

    def find(package, base, name):
        return found[name] if name in found else original(package, base, name)

    monkeypatch.setattr(plugin_list, "find_class", find)


def entries(*names):
    return [{"name": name.lower(), "type": f"t/{name}"} for name in names]


def test_the_plugin_description_leads_to_the_planner():
    assert type(find_plugin(PLANNERS, DIJKSTRA)) is DijkstraMeshPlanner


@pytest.mark.parametrize("kind", [PLANNERS, CONTROLLERS, BEHAVIORS])
def test_an_unknown_type_is_named_with_the_known_ones(kind):
    with pytest.raises(PluginError) as caught:
        find_plugin(kind, "nobody/None")
    text = str(caught.value)
    assert "\n" not in text and "nobody/None" in text and kind.base_class_type in text
    assert (DIJKSTRA in text) == (kind is PLANNERS)


def test_default_list_of_planners():
    planners = PluginList(PLANNERS)
    expected = ["dijkstra_mesh_planner", "wave_front_planner", "mmp_planner"]
    assert (planners.names, planners.complaints) == (expected, [])
    assert planners.choose("") == "dijkstra_mesh_planner"


@pytest.mark.parametrize("kind", [PLANNERS, CONTROLLERS, BEHAVIORS])
def test_the_default_list_of_each_kind_can_be_loaded(kind):
    plugins = PluginList(kind)
    assert (plugins.names, plugins.complaints) == ([entry["name"] for entry in kind.default], [])
    assert PluginList(kind, []).names == [] and PluginList(kind, []).complaints == []


def test_configuration_of_the_field():
    """What cannot be found is skipped; the others go on."""
    planners = PluginList(
        PLANNERS,
        [
            {"name": "wave_front_planner", "type": "nobody/NoPlanner"},
            {"name": "dijkstra_mesh_planner", "type": DIJKSTRA},
            {"name": "mmp_planner", "type": "nobody/NoMMPPlanner"},
        ],
    )
    assert planners.names == ["dijkstra_mesh_planner"]
    assert planners.choose("") == planners.choose("dijkstra_mesh_planner") == planners.names[0]
    assert planners.choose("wave_front_planner") is None
    first, second = planners.complaints
    assert first.startswith("planner 'wave_front_planner' is skipped: ")
    assert "nobody/NoPlanner" in first and DIJKSTRA in first
    assert second.startswith("planner 'mmp_planner' is skipped: ")
    assert planners.why_not("a") == "there is no planner 'a'; known: dijkstra_mesh_planner"
    empty = PluginList(BEHAVIORS, [])
    assert empty.why_not("") == "there is no recovery behavior ''; known: none could be loaded"


def test_classes_of_another_kind(classes):
    planners = PluginList(PLANNERS, entries("Stranger", "Unbuildable", "Controller"))
    assert planners.names == [] and planners.choose("") is None
    assert "t/Stranger is no subclass of mesh_navigation.plugins.planner.MeshPlanner" in (
        planners.complaints[0]
    )
    assert "t/Unbuildable() fails with TypeError" in planners.complaints[1]
    assert "t/Controller is no subclass" in planners.complaints[2]
    assert PluginList(CONTROLLERS, entries("Controller")).names == ["controller"]


def test_plugins_that_cannot_be_initialized(classes):
    planners = PluginList(PLANNERS, entries("Broken", "Telling", "Silent", "Exiting"))
    prepared = planners.prepared("map", {"telling": {"cost_limit": 2}})
    assert prepared.complaints == [
        "planner 'broken' could not be initialized: RuntimeError: no wheels",
        "telling/telling map {'cost_limit': 2}",
        "planner 'silent' could not be initialized: RuntimeError: ",
        "planner 'exiting' could not be initialized: SystemExit: enough",
    ]
    with pytest.raises(NotReady) as caught:
        prepared["broken"]
    assert (caught.value.kind, str(caught.value)) == ("NOT_INITIALIZED", prepared.complaints[0])
    assert prepared["telling"].name == "telling"
    assert prepared.ready() == [prepared["telling"]]


def test_each_map_has_plugins_of_its_own(classes):
    planners = PluginList(PLANNERS, entries("Telling"))
    first, second = planners.prepared("one"), planners.prepared("two")
    assert first["telling"] is not second["telling"]
    assert (first["telling"].map, second["telling"].map) == ("one", "two")


@pytest.mark.parametrize(
    "value, names, words",
    [
        ("dijkstra", [], "~planners is no list of {name, type} but 'dijkstra'"),
        ({"name": "a", "type": "b"}, [], "is no list"),
        ([7], [], "~planners[0] is skipped: it is no {name, type} of texts but 7"),
        ([{"name": "a"}], [], "~planners[0] is skipped"),
        ([{"name": "my planner", "type": "t"}], [], "'my planner' is no name of letters"),
        ([{"name": "", "type": "t"}], [], "~planners[0] is skipped"),
        ([{"name": "a", "type": 3}], [], "~planners[0] is skipped"),
        (
            [{"name": "a", "type": "t"}, {"name": "a", "type": "u"}],
            ["a"],
            "~planners[1] is skipped: there is a 'a' before it",
        ),
    ],
)
def test_malformed_lists(value, names, words):
    found, complaints = read_entries(value, "~planners")
    assert list(found) == names
    assert len(complaints) == 1 and words in complaints[0]
