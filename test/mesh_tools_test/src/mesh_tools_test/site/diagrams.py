"""Mermaid's flowcharts, which git hosts draw, in Graphviz's language: drawn when the site is built.

Mermaid itself runs in the reader's browser, fetched from the network.
"""
import re
from typing import List

_CHART = re.compile(r"^```mermaid\n(?P<chart>.*?)^```$", re.MULTILINE | re.DOTALL)
_BEGIN = re.compile(r"flowchart (?P<direction>TD|LR)")
_SUBGRAPH = re.compile(r'subgraph (?P<name>\w+)\["(?P<label>[^"]*)"\]')
_NODE = re.compile(r'(?P<name>\w+)\["(?P<label>[^"]*)"\]')
_EDGE = re.compile(
    r"(?P<start>\w+) *"
    r'(?:-->|-- "(?P<label>[^"]*)" -->|-\. "(?P<dotted>[^"]*)" \.->) *(?P<end>\w+)'
)
_MARKS = re.compile(r"</?b>|<br/>")  # what labels have of HTML, the same in both languages
_FONT = 'fontname="Helvetica, Arial, sans-serif" fontsize=11'
# The page may be dark, the diagram is not.
_HEAD = (
    'bgcolor="white" nodesep=0.3 ranksep=0.5 pad=0.2',
    f"graph [{_FONT} labeljust=l]",
    f'node [{_FONT} shape=box style="rounded,filled" fillcolor="#e8eef7" color="#3b5b8c"]',
    f'edge [{_FONT} color="#444444"]',
)


class DiagramError(Exception):
    """A flowchart with what is not known here; the text has the line."""


def drawn(page: str) -> str:
    """A page of Markdown with the directives of sphinx.ext.graphviz in place of flowcharts.

    :raises DiagramError: a line that is none of those above
    """
    return _CHART.sub(lambda found: _directive(found.group("chart")), page)


def _directive(chart: str) -> str:
    return "```{graphviz}\n:align: center\n\n%s\n```" % dot(chart)


def dot(chart: str) -> str:
    """A flowchart in Graphviz's language.

    :raises DiagramError: a line that is none of those above
    """
    first, *rest = [line.strip() for line in chart.splitlines() if line.strip()]
    begin = _BEGIN.fullmatch(first)
    if begin is None:
        raise DiagramError("a diagram begins with 'flowchart TD' or 'flowchart LR': %r" % first)
    direction = {"TD": "TB", "LR": "LR"}[begin.group("direction")]
    lines = ["digraph {", "rankdir=" + direction, *_HEAD]
    for line in rest:
        lines += _statement(line)
    return "\n".join([*lines, "}"])


def _statement(line: str) -> List[str]:
    if line == "end":
        return ["}"]
    for pattern, written in ((_SUBGRAPH, _subgraph), (_NODE, _node), (_EDGE, _edge)):
        found = pattern.fullmatch(line)
        if found is not None:
            return written(found)
    raise DiagramError("no subgraph, node, edge or end of a flowchart: %r" % line)


def _subgraph(found: "re.Match[str]") -> List[str]:
    look = 'style="rounded" color="#999999"'
    return ["subgraph cluster_%s {" % found.group("name"), _label(found.group("label")), look]


def _node(found: "re.Match[str]") -> List[str]:
    return ["%s [%s]" % (found.group("name"), _label(found.group("label")))]


def _edge(found: "re.Match[str]") -> List[str]:
    edge = "%s -> %s" % (found.group("start"), found.group("end"))
    label, dotted = found.group("label"), found.group("dotted")
    if dotted is not None:
        return ["%s [%s style=dashed]" % (edge, _label(_aside(dotted)))]
    return [edge if label is None else "%s [%s]" % (edge, _label(_aside(label)))]


def _aside(label: str) -> str:
    """Not on the line."""
    return "<br/>".join("  %s  " % line for line in label.split("<br/>"))


def _label(text: str) -> str:
    """With the marks of HTML as they are, and all else as text."""
    marks = _MARKS.findall(text)
    parts = [
        part.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
        for part in _MARKS.split(text)
    ]
    return "label=<%s>" % "".join(part + mark for part, mark in zip(parts, [*marks, ""]))
