"""What is read out of sources, definitions and READMEs, on small ones."""
import pytest
from mesh_map.base.parameter import Parameter

from mesh_tools_test.reference.docstrings import prepared
from mesh_tools_test.reference.markdown import plain, table
from mesh_tools_test.reference.message_pages import commented
from mesh_tools_test.reference.names_in_code import NameGatherer
from mesh_tools_test.reference.package_pages import PackagePages
from mesh_tools_test.reference.parameter_text import parameter_table
from mesh_tools_test.reference.python_pages import documented_modules, module_of
from mesh_tools_test.reference.readme_check import plugin_claims
from mesh_tools_test.reference.readme_claims import (
    Claim,
    claims_of_cell,
    claims_of_columns,
    differences,
    documented,
)
from mesh_tools_test.reference.readme_tables import read_tables
from mesh_tools_test.reference.rviz_properties import properties
from mesh_tools_test.reference.repository import ROOT


def gathered(folder, **sources):
    paths = []
    for name, text in sources.items():
        paths.append(folder / (name + ".py"))
        paths[-1].write_text(text)
    return {(use.kind, use.name) for use in NameGatherer(paths).uses()}


def test_names_written_out_in_constants_and_in_loops(tmp_path):
    found = gathered(
        tmp_path,
        topics='SHARED = "shared"\n',
        node="""
_OWN = "own"
_MANY = (("first", int), ("second", str))
class Node:
    def __init__(self, prefix, names):
        rospy.Publisher("plain", int)
        rospy.Subscriber(_OWN, int)
        rospy.Service(prefix + SHARED, int)
        self.all = [rospy.Publisher("many/" + name, kind) for name, kind in _MANY]
        for name in ("third", "fourth"):
            rospy.Publisher(f"~{name}/x", int)
        self.each = {name: rospy.Publisher(f"~{name}/path", int) for name in names}
        rospy.get_param("~speed", 1.0)
""",
    )
    assert found == {
        ("topic", "plain"),
        ("topic", "own"),
        ("service", "<prefix>shared"),
        ("topic", "many/first"),
        ("topic", "many/second"),
        ("topic", "~third/x"),
        ("topic", "~fourth/x"),
        ("topic", "~<name>/path"),
        ("parameter", "~speed"),
    }


def test_names_that_functions_and_classes_hand_on(tmp_path):
    found = gathered(
        tmp_path,
        helpers="""
class Latched:
    def __init__(self, name, kind):
        self.name = name.strip()
        self.publisher = rospy.Publisher(rospy.resolve_name(name), kind)
class Paced:
    def __init__(self, period, name):
        self.topics = Latched(name, int)
def _service(name):
    return rospy.Service(name, int)
_service("of_helpers")
""",
        node="""
class Better(Paced):
    def __init__(self):
        super().__init__(1.0, "better")
Paced(2.0, "paced")
def _service(name): pass
_service("nothing")
def parse(parameters):
    return _text(parameters, "folder"), parameters.get("rate", 1)
def _text(parameters, name):
    return str(parameters.get(name, ""))
""",
    )
    assert found == {
        ("topic", "better"),
        ("topic", "paced"),
        ("service", "of_helpers"),
        ("parameter", "folder"),
        ("parameter", "rate"),
    }


README = """
# Title

## Node `x`

| parameter | default | |
|---|---|---|
| `~rate`, `~wait` | 5.0, 0 (off) | Hz, 1 to 100; s, 0 to 2.5 |
| `~<layer>/factor` | 0.5 m [0, 1] | |
| `~frames` | [0, 0, −1] | |
| `~empty` | the one of the file | |
| `~<layer>/…` | | |

| topic (published) | type |
|---|---|
| `~a/b`, `/c` | `int` \\| `str` |

### Layers

| type | parameters: default [range] |
|---|---|
| `my/Layer`, `Other` | `radius` 0.3 m [0.02, inf], `on` true (with [brackets, too]), `kind` round |
"""


def test_what_tables_say():
    parameters, topics, layers = read_tables(README)
    assert parameters.headings == ("Title", "Node `x`")
    assert layers.headings == ("Title", "Node `x`", "Layers")
    assert documented([parameters], "parameter") == {"rate", "wait", "factor", "frames", "empty"}
    assert documented([topics, parameters], "topic") == {"a/b", "c"}
    claims = claims_of_columns(parameters)
    assert claims[:2] == [Claim("rate", 5.0, 1, 100), Claim("wait", 0, 0, 2.5)]
    assert claims[2:4] == [Claim("factor", 0.5, 0, 1), Claim("frames", (0, 0, -1), None, None)]
    told = [
        Claim("radius", 0.3, 0.02, float("inf")),
        Claim("on", True, None, None),
        Claim("kind", "round", None, None),
    ]
    assert claims_of_cell(layers.rows[0][1]) == told
    assert plugin_claims([layers]) == (
        {"my/Layer", "my/Other"},
        {"my/Layer": told, "my/Other": told},
    )


@pytest.mark.parametrize(
    "claim, wrong",
    [
        (Claim("x", 0.5, 0, 1), 0),
        (Claim("x", 0.5, None, None), 0),
        (Claim("x", 0.6, 0, 1), 1),
        (Claim("x", 0.5, 0.1, 2), 2),
        (Claim("x", True, 0, 1), 1),
        (Claim("x", "in words", 0, 1), 1),
    ],
)
def test_differences_of_numbers(claim, wrong):
    assert len(differences(claim, Parameter("x", 0.5, 0.0, 1.0))) == wrong


def test_differences_of_others():
    assert differences(Claim("x", "in words", None, None), Parameter("x", "")) == []
    assert differences(Claim("x", "other", None, None), Parameter("x", "mean")) != []
    assert differences(Claim("x", (), None, None), Parameter("x", (1,))) != []
    assert differences(Claim("x", False, None, None), Parameter("x", True)) != []


def test_properties_of_rviz(tmp_path):
    (tmp_path / "some.cpp").write_text(
        """
  mode_ = new rviz::EnumProperty("Mode", "Box", "What a drag (or click) "
                                 "selects.", parent, SLOT(go()), this);
  size_ = make.number("Size", 0.5f, tr("In meters"), parent);  // make.box("Not", true, "x")
  topic_ = sources.topic<mesh_msgs::Mesh>("Topic", "The mesh.", parent);
  alpha_ = make.alpha("Alpha", "faces", parent);
  color_ = make.color("Color", QColor(1, 2, 3), "Of \\"this\\".", parent);
"""
    )
    assert [one[:3] for one in properties(tmp_path)] == [
        ("Mode", "Box", "What a drag (or click) selects."),
        ("Size", "0.5", ""),
        ("Topic", "", "The mesh."),
        ("Alpha", "1", "1 is opaque: of faces"),
        ("Color", "", 'Of "this".'),
    ]


def test_comments_of_definitions():
    about, names = commented(
        "# About.\n# More.\n\n# Which way.\nuint8 UP=1  # not down\n"
        "string name # of it\n\nint32[] x\n"
    )
    assert about == "About. More."
    assert names == {"UP": "Which way. not down", "name": "of it", "x": ""}


def test_markdown():
    assert plain("a_b | [c]\n<d>") == r"a\_b \| \[c\] \<d\>"
    assert table(("a",), []) == ""
    text = parameter_table([("low/x", Parameter("x", 1.0, 0.0, None, "m | s", choices=()))])
    assert text.splitlines()[-1] == r"| `low/x` | float | `1.0` | 0 to inf | m \| s |"


def test_links_of_readmes(tmp_path):
    known = {"mesh_map": ROOT / "mesh_map", "mesh_msgs": ROOT / "mesh_msgs"}
    pages = PackagePages(known, tmp_path / "reference", tmp_path)
    page = tmp_path / "reference/packages/mesh_map.md"

    def relinked(text):
        return pages.relinked(text, known["mesh_map"], page)

    assert relinked("[a](../mesh_msgs/README.md#messages)") == "[a](mesh_msgs.md#messages)"
    assert relinked("[a](../mesh_msgs)") == "[a](mesh_msgs.md)"
    assert relinked("[a](../docs/architecture.md)") == "[a](../../architecture.md)"
    assert relinked("[a](#b) [c](https://d.e/f)") == "[a](#b) [c](https://d.e/f)"
    assert relinked("[config](config)") == "`mesh_map/config`"
    assert relinked("[those](layers.xml)") == "those (`mesh_map/layers.xml`)"
    with pytest.raises(ValueError, match="no_such.md"):
        relinked("[a](no_such.md)")


def test_docstrings_become_lists_and_code():
    text = """What |x| is:

    x | y

costs: (V,) of
    vertices.
lethal, unknown: numbers

A paragraph: of two
lines.

Args:
    a: what it is,
        at length."""
    assert prepared(text.splitlines()) == [
        r"What \|x\| is::",
        "",
        "    x | y",
        "",
        "* costs: (V,) of",
        "  vertices.",
        "* lethal, unknown: numbers",
        "",
        "A paragraph: of two",
        "lines.",
        "",
        "Args:",
        "    a: what it is,",
        "        at length.",
        "",
    ]


def test_modules_that_a_readme_names(tmp_path):
    readme = tmp_path / "README.md"
    readme.write_text(
        "See mesh_map.base.plugins, not mesh_map.no_such nor mesh_msgs.text\n\n"
        "    from mesh_map import MeshMap\n\n"
        "## Python\n\n| module | |\n|---|---|\n| **`mesh_map.geometry`** | |\n"
        "| `.topology`, `.normals` | |\n| `costs.layer.Layer` | `.walk` |\n"
    )
    assert documented_modules("mesh_map", readme) == [
        "mesh_map.base.plugins",
        "mesh_map.costs.layer",
        "mesh_map.geometry",
        "mesh_map.geometry.normals",
        "mesh_map.geometry.topology",
        "mesh_map.map.mesh_map",
    ]
    assert module_of("mesh_map.costs.layer.Layer.params") == "mesh_map.costs.layer"
    assert module_of("no_such_package.module") == ""
