"""Nodes with their topics, services, actions and parameters."""
from pathlib import Path
from typing import Dict, List

from mesh_tools_test.reference.markdown import code, page, table
from mesh_tools_test.reference.names_in_code import PARAMETER
from mesh_tools_test.reference.nodes import NODES, Node, readme_of
from mesh_tools_test.reference.package_pages import PackagePages
from mesh_tools_test.reference.parameter_text import parameter_table
from mesh_tools_test.reference.readme_claims import kind_of
from mesh_tools_test.reference.readme_tables import Table, tables_of


def _anchor(heading: str) -> str:
    """Of a heading, as GitHub and MyST make it."""
    return heading.lower().replace("`", "").replace(" ", "-")


def tables_of_node(node: Node, packages: Dict[str, Path]) -> List[Table]:
    """The tables of the README that tell of a node."""
    found = tables_of(readme_of(node, packages))
    return [one for one in found if node.heading in one.headings and kind_of(one)]


def _as_in_readme(one: Table) -> str:
    return table(one.header, [[cell.text.replace("|", r"\|") for cell in row] for row in one.rows])


def _node(node: Node, packages: Dict[str, Path], pages: PackagePages, at: Path) -> str:
    place = "packages/%s.md#%s" % (node.package, _anchor(node.heading))
    parts = ["## " + node.name, "More of it: [%s](%s)." % (node.package, place)]
    for one in tables_of_node(node, packages):
        if kind_of(one) != PARAMETER or not node.declared:
            text = pages.relinked(_as_in_readme(one), packages[node.package], at)
            parts.append(text.replace("](#", "](packages/%s.md#" % node.package))
    if node.embeds:
        names = ", ".join("[%s](#%s)" % (name, name) for name in node.embeds)
        parts.append("It has the topics, services and parameters of %s, too." % names)
    if node.declared:
        parts.append(parameter_table((name, one) for name, one in node.declared.items()))
    if node.others:
        others = ", ".join(code(name) for name in sorted(node.others))
        parts.append("Also %s: lists, see [there](%s)." % (others, place))
    if node.dynamic:
        names = ", ".join(code(name) for name in node.dynamic)
        parts.append("By dynamic_reconfigure, at any time: %s." % names)
    return page(*parts)


def node_page(packages: Dict[str, Path], pages: PackagePages, at: Path) -> str:
    """The page of all nodes.

    :param pages: of the packages
    :param at: where it will be
    """
    return page(
        "# Nodes",
        "Names with ~ are below that of the node. What each says to `--help`:"
        " [commands](commands.md#nodes).",
        *(_node(node, packages, pages, at) for node in NODES),
    )
