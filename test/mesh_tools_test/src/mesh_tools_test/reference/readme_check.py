"""Holds the tables of READMEs to the code: names of nodes, plugins, parameters, properties."""
import math
import re
from pathlib import Path
from typing import Dict, Iterable, Iterator, List, NamedTuple, Optional, Set, Tuple

from mesh_map.base.parameter import Parameter
from mesh_msgs_hdf5.commands import VERBS

from mesh_tools_test.reference.names_in_code import ACTION, PARAMETER, SERVICE, TOPIC, Use
from mesh_tools_test.reference.node_pages import tables_of_node
from mesh_tools_test.reference.nodes import NODES, Node, uses_of
from mesh_tools_test.reference.plugin_pages import (
    INPUTS,
    KINDS,
    Plugin,
    exported_plugins,
    exported_verbs,
    parameters_of,
)
from mesh_tools_test.reference.readme_claims import (
    Claim,
    claims_of_cell,
    claims_of_columns,
    differences,
    documented,
    kind_of,
    normal,
)
from mesh_tools_test.reference.readme_tables import Table, tables_of
from mesh_tools_test.reference.rviz_properties import properties

_HEADINGS = {  # of plugins, and the package whose README has it
    "Layers": "mesh_map",
    "Planners": "mesh_navigation",
    "Controllers": "mesh_navigation",
    "Recovery": "mesh_navigation",
}


class Finding(NamedTuple):
    """What differs between code and README: of what (node or plugin, and a name), and how."""

    key: str
    text: str


def _finding(owner: str, name: str, text: str) -> Finding:
    return Finding("%s %s" % (owner, name), "%s: %s %s" % (owner, name, text))


def names_of(node: Node, uses: List[Use], kind: str) -> Set[str]:
    """The names of a kind that the code of a node has; those that a parameter says by its default.

    What reads many parameters at once (`~`, or a name that is not known) is none.
    """
    found = set()
    for use in uses_of(node, uses):
        name = use.name
        if use.kind == kind and not (kind == PARAMETER and (name == "~" or "<" in name)):
            given = node.declared.get(name.strip("<>")) if name.startswith("<") else None
            if given is not None and given.default:
                name = str(given.default)
            found.add(normal(name) or name)
    if kind == PARAMETER:
        found |= set(node.declared) | node.others
    return found


def check_names(node: Node, uses: List[Use], tables: List[Table]) -> Iterator[Finding]:
    """Names that only the code of a node, or only its README has."""
    for kind in (TOPIC, SERVICE, ACTION, PARAMETER):
        in_code, told = names_of(node, uses, kind), documented(tables, kind)
        for name in sorted(in_code - told):
            yield _finding(node.name, name, "(%s) is in the code, and in no table" % kind)
        known = set(in_code)
        for other in NODES:
            if other.name in node.embeds:
                more = names_of(other, uses, kind)
                known |= more | {"%s/%s" % (other.name, name) for name in more}
        for name in sorted(told - known):
            yield _finding(node.name, name, "(%s) is in a table, and not in the code" % kind)


def check_nodes(packages: Dict[str, Path], uses: List[Use]) -> List[Finding]:
    """Of all nodes: names, and defaults and ranges where their tables have them."""
    found: List[Finding] = []
    for node in NODES:
        tables = tables_of_node(node, packages)
        found += check_names(node, uses, tables)
        for table in tables:
            for claim in claims_of_columns(table) if kind_of(table) == PARAMETER else ():
                if claim.name in node.declared:
                    wrong = differences(claim, node.declared[claim.name])
                    found += [_finding(node.name, claim.name, text) for text in wrong]
    return found


def plugin_claims(tables: Iterable[Table]) -> Tuple[Set[str], Dict[str, List[Claim]]]:
    """Names of plugins in tables, and what these say of parameters: of a plugin by its name, of all
    plugins of a kind by the heading of that."""
    names: Set[str] = set()
    claims: Dict[str, List[Claim]] = {}
    for table in tables:
        heading = table.headings[-1]
        if kind_of(table) == PARAMETER:
            claims.setdefault(heading, []).extend(claims_of_columns(table))
        elif table.header[0] == "type":
            column = _column(table)
            for row in table.rows:
                library = row[0].codes[0].partition("/")[0]
                for code in row[0].codes:
                    name = code if "/" in code else "%s/%s" % (library, code)
                    names.add(name)
                    if column is not None:
                        claims.setdefault(name, []).extend(claims_of_cell(row[column]))
    return names, claims


def _column(table: Table) -> Optional[int]:
    """Which one tells of parameters; None for none."""
    found = [place for place, text in enumerate(table.header) if text.startswith("parameters")]
    return found[0] if found else None


def check_plugins(packages: Dict[str, Path]) -> List[Finding]:
    """Of all plugins with parameters: names, defaults, and ranges with two ends."""
    tables = [
        table
        for package in dict.fromkeys(_HEADINGS.values())
        for table in tables_of(packages[package] / "README.md")
        if _HEADINGS.get(table.headings[-1]) == package
    ]
    names, claims = plugin_claims(tables)
    plugins = {
        plugin.name: plugin
        for package in dict.fromkeys(_HEADINGS.values())
        for plugin in exported_plugins(packages[package])
        if plugin.base in {kind.base for kind in KINDS}
    }
    found = [_finding(name, "", "is in a table, and no plugin") for name in names - set(plugins)]
    found += [_finding(name, "", "is in no table") for name in set(plugins) - names]
    known: Dict[str, Set[str]] = {}
    for plugin in plugins.values():
        heading = _heading(plugin)
        parameters = [one for one in parameters_of(plugin) if one is not INPUTS]
        for where in (plugin.name, heading):
            known.setdefault(where, set()).update(one.name for one in parameters)
        told = claims.get(plugin.name, []) + claims.get(heading, [])
        found += _of_plugin(plugin, parameters, told)
    for where, inside in known.items():
        for claim in claims.get(where, []):
            if claim.name not in inside:
                found.append(_finding(where, claim.name, "is in a table, and no parameter"))
    return found


def _heading(plugin: Plugin) -> str:
    """Of the README: the first word of that of the reference."""
    return next(kind.heading for kind in KINDS if kind.base == plugin.base).split()[0]


def _of_plugin(plugin: Plugin, parameters: List[Parameter], told: List[Claim]) -> Iterator[Finding]:
    for parameter in parameters:
        claims = [claim for claim in told if claim.name == parameter.name]
        if not claims:
            yield _finding(plugin.name, parameter.name, "is in no table")
        for claim in claims:
            for text in differences(claim, parameter):
                yield _finding(plugin.name, parameter.name, text)
            if claim.low is None and _is_bounded(parameter):
                text = "has no range in its table: %s to %s"
                limits = (parameter.minimum, parameter.maximum)
                yield _finding(plugin.name, parameter.name, text % limits)


def _is_bounded(parameter: Parameter) -> bool:
    """On both sides."""
    limits = (parameter.minimum, parameter.maximum)
    return all(limit is not None and math.isfinite(limit) for limit in limits)


def check_rviz(packages: Dict[str, Path]) -> List[Finding]:
    """Of RViz: names of displays, tools and panels, and of their properties."""
    folder = packages["rviz_mesh_plugin"]
    text, tables = (folder / "README.md").read_text(encoding="utf-8"), tables_of(
        folder / "README.md"
    )
    plugins = {
        plugin.name
        for package in ("rviz_mesh_plugin", "rviz_map_plugin")
        for plugin in exported_plugins(packages[package])
    }
    told = set(re.findall(r"`(rviz_(?:mesh|map)_plugin/\w+)`", text))
    found = [_finding(name, "", "is in no README") for name in sorted(plugins - told)]
    found += [_finding(name, "", "is no plugin") for name in sorted(told - plugins)]
    in_code = {one.name for one in properties(folder / "src")}
    in_tables = {
        name.replace("\\", "")
        for table in tables
        for row in table.rows
        if table.header[0] == "property"
        for name in row[0].text.strip("→ ").split(", ")
    }
    for name in sorted(in_code - in_tables):
        found.append(_finding("rviz", name, "(property) is in the code, and in no table"))
    sources = "".join(path.read_text(encoding="utf-8") for path in folder.glob("src/**/*.cpp"))
    for name in sorted(in_tables - in_code):
        if '"%s"' % name in sources:  # made in a loop over such names
            continue
        found.append(_finding("rviz", name, "(property) is in a table, and not in the code"))
    return found


def check_verbs(packages: Dict[str, Path]) -> List[Finding]:
    """Of mesh_tool: its verbs, also those that other packages export."""
    verbs = {name.split()[0] for name in VERBS}
    verbs |= {
        verb.split()[0] for folder in packages.values() for verb, *_ in exported_verbs(folder)
    }
    told = {
        code.split()[0].replace("--completion", "completion")
        for table in tables_of(packages["mesh_msgs_hdf5"] / "README.md")
        if table.headings[-1] == "Command mesh_tool" and table.header[0] == "command"
        for row in table.rows
        for code in row[0].codes
        if not code.startswith("[")
    }
    found = [_finding("mesh_tool", name, "is in no table") for name in sorted(verbs - told)]
    return found + [_finding("mesh_tool", name, "is no verb") for name in sorted(told - verbs)]
