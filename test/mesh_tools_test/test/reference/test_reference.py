"""READMEs say what the code has, and the reference made of both has everything."""
import pytest

from mesh_tools_test.reference.cpp_pages import XML
from mesh_tools_test.reference.nodes import NODES, gathered_uses
from mesh_tools_test.reference.plugin_pages import exported_plugins
from mesh_tools_test.reference.python_pages import PACKAGES, documented_modules
from mesh_tools_test.reference.readme_check import (
    check_nodes,
    check_plugins,
    check_rviz,
    check_verbs,
)
from mesh_tools_test.reference.reference import write_reference
from mesh_tools_test.reference.repository import ROOT, packages

# node or plugin, and a name -> why it is in the code, or in a table, alone
EXEMPT = {
    "hdf5_map_server run_id": "roscore's own parameter",
    "label_manager run_id": "roscore's own parameter",
    "surface_robot use_sim_time": "ROS's own parameter",
    "hdf5_map_server <>": "a topic of another process, which owns the labels",
    "label_manager <>": "a topic of another process, which owns the labels",
    "label_manager <name>": "cluster_label, and ~cluster_label where that is another topic",
    "label_manager cluster_label": "see <name>",
    "mesh_map <topic>": "parameter topic of a source of an ObstacleLayer",
    "mbf_mesh_nav <topic>": "of the guard: cmd_vel, as the server resolves it",
    "mbf_mesh_nav <zone_topic>": "parameter guard/zone_topic, empty by default",
    "mbf_mesh_nav <>": "base class of the action servers",
    "mbf_mesh_nav guard": "its members are told, each by its name",
    "mbf_mesh_nav mesh_map/mesh_file": "a parameter of mesh_map",
    "surface_robot <topic>": "parameter costs_topic, empty by default",
    "mesh_controller/MeshController ": "named above its table",
    "cvp_mesh_planner/CVPMeshPlanner cost_factor": "its other default is told in words",
}


@pytest.fixture(scope="module")
def uses():
    return gathered_uses()


def test_readmes_tell_of_all_names_and_parameters_and_of_no_others(uses):
    known = packages()
    found = [*check_nodes(known, uses), *check_plugins(known)]
    found += [*check_rviz(known), *check_verbs(known)]
    assert [one.text for one in found if one.key not in EXEMPT] == []
    assert set(EXEMPT) - {one.key for one in found} == set()


def test_names_are_found_in_the_code_of_every_node(uses):
    """Those that are looked for are not none: a gatherer that finds nothing would be content."""
    found = {(use.kind, use.name.lstrip("~")) for use in uses}
    assert {
        ("topic", "store/vertex_costs_update"),
        ("topic", "<>/vertex_costs/updates"),
        ("service", "get_geometry_vertexnormals"),
        ("service", "check_path_cost"),
        ("action", "move_base"),
        ("parameter", "save_delay"),
        ("parameter", "import_folder"),
    } <= found
    assert len(found) > 90
    packages_with_nodes = {"mesh_msgs_hdf5", "mesh_map", "mesh_navigation", "mesh_localization"}
    assert {node.package for node in NODES} == packages_with_nodes


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The pages of the reference, which the test of the site lets Sphinx read."""
    folder = tmp_path_factory.mktemp("site")
    write_reference(folder / "reference")
    return folder


def test_every_message_plugin_and_header_has_its_place(site):
    reference = site / "reference"
    plugins = (reference / "plugins.md").read_text()
    nodes = (reference / "nodes.md").read_text()
    cpp = (reference / "cpp.md").read_text()
    assert all("\n## %s\n" % node.name in nodes for node in NODES)
    for package, folder in packages().items():
        for definition in [*folder.glob("msg/*"), *folder.glob("srv/*"), *folder.glob("action/*")]:
            page = (reference / "messages" / (package + ".md")).read_text()
            assert "\n### %s\n" % definition.stem in page
        assert all(plugin.name in plugins for plugin in exported_plugins(folder))
    for header in (ROOT / "mesh_map/include").glob("**/*.h"):
        assert "\n## %s\n" % header.relative_to(ROOT / "mesh_map/include").as_posix() in cpp
    assert "mesh_map::castRay" in cpp and (reference / XML / "index.xml").is_file()


@pytest.mark.parametrize("package", PACKAGES)
def test_modules_that_readmes_name_have_their_page(site, package):
    page = (site / "reference" / "python" / (package + ".md")).read_text()
    modules = documented_modules(package, packages()[package] / "README.md")
    assert len(modules) > 5
    assert all(module in page for module in modules)
