"""Flowcharts of Mermaid become diagrams of Graphviz, with all that is in them."""
import subprocess

import pytest

from mesh_tools_test.site import assembly
from mesh_tools_test.site.diagrams import DiagramError, dot, drawn

CHART = """flowchart LR
  subgraph low["below: C++ & more"]
    core["<b>core</b> a<b<br/>two lines"]
  end
  top["top"]
  top --> core
  top -- "calls < twice" --> core
  top -. "over ROS" .-> core
"""


def drawing(text):
    """The SVG of a diagram in Graphviz's language."""
    run = subprocess.run(["dot", "-Tsvg"], input=text.encode(), stdout=subprocess.PIPE, check=True)
    return run.stdout.decode()


def test_nodes_groups_and_edges_are_drawn_with_their_labels():
    found = dot(CHART)
    assert "rankdir=LR" in found
    svg = drawing(found)
    assert svg.count('class="node"') == 2 and svg.count('class="edge"') == 3
    assert svg.count('class="cluster"') == 1 and svg.count("stroke-dasharray") == 1
    for text in ("below: C++ &amp; more", ">two lines<", "calls &lt; twice", ">top<", "over ROS"):
        assert text in svg
    assert 'font-weight="bold" font-size="11.00">core<' in svg


def test_a_label_that_only_looks_like_a_mark_is_text():
    assert "a&lt;b<br/>" in dot('flowchart TD\nn["a<b<br/>"]')


@pytest.mark.parametrize(
    "chart, line",
    [
        ("sequenceDiagram\n", "sequenceDiagram"),
        ("flowchart TD\n  a ==> b\n", "a ==> b"),
        ("flowchart TD\n  a(round)\n", "a(round)"),
    ],
)
def test_what_is_not_known_is_refused_with_its_line(chart, line):
    with pytest.raises(DiagramError, match=line.split("(")[0]):
        dot(chart)


def test_a_page_keeps_all_else():
    page = "before\n\n```mermaid\n%s```\n\n```bash\nls\n```\n" % CHART
    found = drawn(page)
    assert found.startswith("before\n\n```{graphviz}\n") and found.endswith(
        "\n\n```bash\nls\n```\n"
    )
    assert dot(CHART) in found and "mermaid" not in found


def test_all_diagrams_of_the_pages_can_be_drawn():
    pages = [path.read_text(encoding="utf-8") for path in assembly.DOCS.rglob("*.md")]
    charts = [page for page in pages if "```mermaid" in page]
    assert charts
    for page in charts:
        assert "mermaid" not in drawn(page).replace("`mermaid`", "")
