"""The list of planners: what cannot be used is skipped with a reason, the rest goes on."""

import pytest

from mesh_map.errors import PluginError
from mesh_navigation import planner_list
from mesh_navigation.planner import MeshPlanner
from mesh_navigation.planner_list import PlannerList, read_entries
from mesh_navigation.planners.dijkstra import DijkstraMeshPlanner

DIJKSTRA = "dijkstra_mesh_planner/DijkstraMeshPlanner"


class Broken(MeshPlanner):
    def initialize(self, name, mesh_map, given={}):
        raise RuntimeError("no wheels\non this map")


class Unbuildable(MeshPlanner):
    def __init__(self, argument):
        super().__init__()


@pytest.fixture
def classes(monkeypatch):
    """Plugins of the tests beside those of the package."""
    found = {"t/Broken": Broken, "t/Unbuildable": Unbuildable, "t/Stranger": dict}
    original = planner_list.find_class

    def find(package, base, name):
        return found[name] if name in found else original(package, base, name)

    monkeypatch.setattr(planner_list, "find_class", find)


def test_the_plugin_description_leads_to_the_planner():
    found = planner_list.find_class("mesh_navigation", "mesh_navigation::MeshPlanner", DIJKSTRA)
    assert found is DijkstraMeshPlanner


def test_an_unknown_type_is_named_with_the_known_ones():
    with pytest.raises(PluginError, match=DIJKSTRA) as caught:
        planner_list.find_class("mesh_navigation", planner_list.BASE_CLASS, "nobody/NoPlanner")
    assert "\n" not in str(caught.value) and "nobody/NoPlanner" in str(caught.value)


def test_default_list():
    planners = PlannerList()
    expected = ["dijkstra_mesh_planner", "wave_front_planner", "mmp_planner"]
    assert (planners.names, planners.complaints) == (expected, [])
    assert planners.choose("") == "dijkstra_mesh_planner"


def test_configuration_of_the_field():
    """What cannot be found is skipped; the others go on."""
    planners = PlannerList(
        [
            {"name": "wave_front_planner", "type": "nobody/NoPlanner"},
            {"name": "dijkstra_mesh_planner", "type": DIJKSTRA},
            {"name": "mmp_planner", "type": "nobody/NoMMPPlanner"},
        ]
    )
    assert planners.names == ["dijkstra_mesh_planner"]
    assert planners.choose("") == planners.choose("dijkstra_mesh_planner") == planners.names[0]
    assert planners.choose("wave_front_planner") is None
    first, second = planners.complaints
    assert first.startswith("planner 'wave_front_planner' is skipped: ")
    assert "nobody/NoPlanner" in first and DIJKSTRA in first
    assert second.startswith("planner 'mmp_planner' is skipped: ")


def test_classes_that_are_no_planners(classes):
    planners = PlannerList(
        [{"name": "a", "type": "t/Stranger"}, {"name": "b", "type": "t/Unbuildable"}]
    )
    assert planners.names == [] and planners.choose("") is None
    assert "t/Stranger is no subclass" in planners.complaints[0]
    assert "t/Unbuildable() fails with TypeError" in planners.complaints[1]


def test_a_planner_that_cannot_be_initialized(classes):
    planners = PlannerList(
        [{"name": "broken", "type": "t/Broken"}, {"name": "base", "type": DIJKSTRA}]
    )
    planners["base"].initialize = lambda name, mesh_map, given: [f"{name} {mesh_map} {given}"]
    complaints = planners.initialize("map", {"base": {"cost_limit": 2}})
    assert complaints == [
        "planner 'broken' could not be initialized: RuntimeError: no wheels",
        "base/base map {'cost_limit': 2}",
    ]
    assert planners.fault("broken") == complaints[0] and planners.fault("base") is None
    assert planners.ready() == [planners["base"]]


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
    entries, complaints = read_entries(value, "~planners")
    assert [entry.name for entry in entries] == names
    assert len(complaints) == 1 and words in complaints[0]
