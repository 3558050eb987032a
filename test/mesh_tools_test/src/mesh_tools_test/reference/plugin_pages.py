"""Plugins that packages export, with their parameters."""
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Tuple

from mesh_map.base.parameter import Parameter
from mesh_map.base.plugins import find_class
from mesh_map.costs.layer import OF_ALL

from mesh_tools_test.reference.markdown import code, page, plain, table
from mesh_tools_test.reference.parameter_text import parameter_table
from mesh_tools_test.reference.rviz_properties import properties

INPUTS = Parameter(
    "inputs", (), description="names of the layers that it reads; default: all before it"
)


_PLUGIN = "rviz_mesh_plugin"
_MADE_BY = {  # source -> whose properties it makes
    "mesh_properties": "TexturedMesh, and of the mesh of Map3D",
    "cost_properties": "TexturedMesh, of its cost layers",
    "map3d_display": "Map3D",
    "label_properties": "the display ClusterLabel",
    "selection_properties": "the tool ClusterLabel",
    "surface_pose_tool": "MeshGoal and MeshPoseEstimate",
    "mesh_inspect_tool": "MeshInspect",
    "mesh_measure_tool": "MeshMeasure",
}


class Plugin(NamedTuple):
    """What an XML file says of a plugin.

    name, type, base: as there; package: that exports it.
    """

    package: str
    name: str
    type: str
    base: str
    about: str


class Kind(NamedTuple):
    """Plugins with parameters: their base, and which package loads them."""

    heading: str
    base: str
    loader: str


KINDS = (
    Kind("Layers", "mesh_map::Layer", "mesh_map"),
    Kind("Planners", "mesh_navigation::MeshPlanner", "mesh_navigation"),
    Kind("Controllers", "mesh_navigation::MeshController", "mesh_navigation"),
    Kind("Recovery behaviors", "mesh_navigation::MeshRecovery", "mesh_navigation"),
)
_OF_RVIZ = (
    ("RViz displays", "rviz::Display"),
    ("RViz tools", "rviz::Tool"),
    ("RViz panels", "rviz::Panel"),
)


def exported_plugins(folder: Path) -> List[Plugin]:
    """Those of a package, in the order of its files."""
    root = ElementTree.parse(str(folder / "package.xml"))
    name, found = root.findtext("name", "").strip(), []
    for export in root.iterfind("export/*[@plugin]"):
        path = export.attrib["plugin"].replace("${prefix}", str(folder))
        for one in ElementTree.parse(path).iter("class"):
            about = " ".join(one.findtext("description", "").split())
            type_, base = one.attrib["type"], one.attrib["base_class_type"]
            found.append(Plugin(name, one.get("name", type_), type_, base, about))
    return found


def exported_verbs(folder: Path) -> List[Tuple[str, str, str]]:
    """Name, module and description of the verbs of mesh_tool that a package exports."""
    found = []
    for export in ElementTree.parse(str(folder / "package.xml")).iterfind("export/*[@verbs]"):
        path = export.attrib["verbs"].replace("${prefix}", str(folder))
        for one in ElementTree.parse(path).iter("verb"):
            about = " ".join(one.findtext("description", "").split())
            found.append((one.attrib["name"], one.attrib["module"], about))
    return found


def parameters_of(plugin: Plugin) -> Tuple[Parameter, ...]:
    """Those of a plugin with parameters, without those that every layer has."""
    loader = next(kind.loader for kind in KINDS if kind.base == plugin.base)
    found = find_class(loader, plugin.base, plugin.name)
    own = tuple(getattr(found, "PARAMETERS", None) or getattr(found, "parameters", ()))
    return own + ((INPUTS,) if getattr(found, "READS_LAYERS", False) else ())


def _table(parameters: Tuple[Parameter, ...]) -> str:
    return parameter_table((one.name, one) for one in parameters)


def _with_parameters(kind: Kind, plugins: List[Plugin]) -> str:
    parts = ["## " + kind.heading]
    if kind.heading == "Layers":
        parts += ["Every layer has these parameters:", _table(OF_ALL)]
    for plugin in plugins:
        parts += [
            "### " + plugin.name,
            plain(plugin.about),
            "Class {py:class}`%s` of the package %s." % (plugin.type, plugin.package),
            _table(parameters_of(plugin)) or "It has no parameters of its own.",
        ]
    return page(*parts)


def _of_rviz(heading: str, base: str, plugins: List[Plugin]) -> str:
    of_class: Dict[str, List[Plugin]] = {}
    for plugin in plugins:
        if plugin.base == base:
            of_class.setdefault(plugin.type, []).append(plugin)
    rows = []
    for names in of_class.values():
        first, *others = sorted(names, key=lambda one: one.package != _PLUGIN)
        released = ", ".join(code(one.name) for one in others)
        rows.append((code(first.name), released, plain(first.about)))
    return page("## " + heading, table(("name", "released name", ""), rows))


def _properties(folder: Path) -> Iterator[str]:
    """Tables of the properties in RViz."""
    found = properties(folder / "src")
    for source, title in _MADE_BY.items():
        rows = [
            (plain(one.name), code(one.default), plain(one.about))
            for one in found
            if one.path.stem == source
        ]
        yield page("### Properties of " + title, table(("property", "default", ""), rows))


def plugin_page(packages: Dict[str, Path]) -> str:
    """The page of all plugins."""
    plugins = [plugin for folder in packages.values() for plugin in exported_plugins(folder)]
    verbs = [(package, *verb) for package in packages for verb in exported_verbs(packages[package])]
    rows = [(code(name), package, plain(about)) for package, name, _, about in verbs]
    return page(
        "# Plugins",
        "What packages export, by the names under which configurations know it. What each layer,"
        " planner, controller and recovery behavior does is told with its package:"
        " [layers](packages/mesh_map.md#layers),"
        " [planners](packages/mesh_navigation.md#planners),"
        " [controllers](packages/mesh_navigation.md#controllers) and"
        " [recovery behaviors](packages/mesh_navigation.md#recovery).",
        *(
            _with_parameters(kind, [plugin for plugin in plugins if plugin.base == kind.base])
            for kind in KINDS
        ),
        *(_of_rviz(heading, base, plugins) for heading, base in _OF_RVIZ),
        "Status lines, keys and what the properties below mean in full stand"
        " [with the package](packages/rviz_mesh_plugin.md).",
        *_properties(packages[_PLUGIN]),
        "## Verbs of mesh_tool",
        "Those that other packages than mesh_msgs_hdf5 export; all verbs are among the"
        " [commands](commands.md#mesh_tool).",
        table(("verb", "package", ""), rows),
    )
