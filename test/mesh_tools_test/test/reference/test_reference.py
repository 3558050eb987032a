"""READMEs say what the code has, and the reference made of both is a site without faults."""
import importlib
import inspect
import io
import os
import subprocess
import sys

import pytest
from docutils.core import publish_doctree
from docutils.nodes import literal
from docutils.parsers.rst import roles
from sphinx.ext.napoleon import Config, GoogleDocstring

from mesh_tools_test.reference.cpp_pages import XML
from mesh_tools_test.reference.docstrings import prepared
from mesh_tools_test.reference.nodes import NODES, gathered_uses
from mesh_tools_test.reference.readme_check import check_nodes, check_plugins
from mesh_tools_test.reference.plugin_pages import exported_plugins
from mesh_tools_test.reference.python_pages import PACKAGES, documented_modules
from mesh_tools_test.reference.reference import write_reference
from mesh_tools_test.reference.repository import ROOT, packages
from mesh_tools_test.reference.cpp_pages import XML
from mesh_tools_test.reference.docstrings import prepared
from mesh_tools_test.reference.nodes import NODES, gathered_uses
from mesh_tools_test.reference.readme_check import (
    check_nodes,
    check_plugins,
    check_rviz,
    check_verbs,
)
from mesh_tools_test.reference.plugin_pages import exported_plugins
from mesh_tools_test.reference.python_pages import PACKAGES, documented_modules
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
    assert {node.package for node in NODES} == {"mesh_msgs_hdf5", "mesh_map", "mesh_navigation"}


CONF = """
project = "Reference"
extensions = ["myst_parser"]
myst_heading_anchors = 4
exclude_patterns = ["reference/python", "reference/cpp.md"]  # slow; ./run docs has them
"""
INDEX = """# Index

```{toctree}
:glob:

reference/*
reference/*/*
```
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The sources of a site with nothing but the reference."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "conf.py").write_text(CONF)
    (folder / "index.md").write_text(INDEX)
    write_reference(folder / "reference")
    return folder


def built(site, out):
    """The exit code of Sphinx, for which a warning is an error, and what it printed."""
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-q", "-W", "-b", "dummy", str(site), str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=dict(os.environ, LC_ALL="C.UTF-8"),
        check=False,
    )
    return done.returncode, done.stdout.decode("utf-8", "replace")


def test_pages_of_the_reference_are_a_site(site, tmp_path):
    assert built(site, tmp_path) == (0, "")


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


def a_role(_name, source, text, _line, _inliner, options=None, content=()):
    return [literal(source, text)], []


def documented(module):
    """Name -> what has a docstring of its own in a module, as autodoc finds it."""
    found = {module.__name__: module}
    for name, one in vars(module).items():
        own = getattr(one, "__module__", None) == module.__name__
        if own and not name.startswith("_") and (inspect.isclass(one) or inspect.isfunction(one)):
            found["%s.%s" % (module.__name__, name)] = one
            for member, inner in vars(one).items() if inspect.isclass(one) else ():
                if not member.startswith("_") and isinstance(inner, (property, type(a_role))):
                    found["%s.%s.%s" % (module.__name__, name, member)] = inner
    return {name: one for name, one in found.items() if inspect.getdoc(one)}


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_are_text_that_sphinx_reads(package):
    for role in ("class", "func", "meth", "data", "attr", "mod"):
        roles.register_local_role(role, a_role)
    modules = documented_modules(package, packages()[package] / "README.md")
    assert len(modules) > 5
    wrong = {}
    for module in modules:
        for name, one in documented(importlib.import_module(module)).items():
            what = "class" if inspect.isclass(one) else "function"
            lines = prepared(inspect.getdoc(one).splitlines())
            text = GoogleDocstring(lines, Config(napoleon_use_ivar=True), what=what, obj=one)
            warnings = io.StringIO()
            settings = {"warning_stream": warnings, "report_level": 2}
            publish_doctree(str(text), settings_overrides=settings)
            if warnings.getvalue():
                wrong[name] = warnings.getvalue()
    assert wrong == {}
