"""Each rule of a release finds what breaks it."""
import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / ".ci"))
release_rules = pytest.importorskip("release_rules", reason="not part of an installation")

PACKAGE_XML = """<package format="3"><name>{name}</name><version>1.2.3</version>
<exec_depend>rospy</exec_depend>{more}</package>"""
CONTROL = """Source: mesh-tools

Package: mesh-tools
Depends: ros-a-b (= ${binary:Version}), ros-c (= ${binary:Version})
Description: all
 of them

Package: ros-a-b
Depends: ${misc:Depends},
         ros-c (= ${binary:Version})

Package: ros-c
Depends: ${misc:Depends}
"""
FOLDERS = Path("a_b"), Path("more/c")
FILES = {
    "a_b/package.xml": PACKAGE_XML.format(name="a_b", more="<depend>c</depend>"),
    "a_b/CHANGELOG.rst": "^^^^\nA\n^^^^\n\nForthcoming\n-----------\n* x\n",
    "a_b/src/a_b/__init__.py": '__version__ = "1.2.3"\n',
    "more/c/package.xml": PACKAGE_XML.format(name="c", more=""),
    "more/c/CHANGELOG.rst": "^^^^\nC\n^^^^\n\n1.2.3 (2026-01-02)\n------------------\n* x\n",
    "debian/changelog": "mesh-tools (1.2.3) bookworm; urgency=medium\n",
    "debian/control": CONTROL,
}


def findings(root, name=None, old="", new=""):
    """The findings of a tree in which one file is changed, as lines."""
    shutil.rmtree(str(root))
    for path, text in FILES.items():
        assert name != path or old in text
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text.replace(old, new, 1) if name == path else text)
    found = release_rules.check(root, {Path(path) for path in FILES}, FOLDERS)
    return ["%s: %s" % (path, text) for path, _, text in found]


def test_a_tree_ready_for_release_has_no_findings(tmp_path):
    assert findings(tmp_path) == []


@pytest.mark.parametrize(
    "name, old, new, words",
    [
        ("more/c/package.xml", "1.2.3", "1.2.4", "more/c/package.xml: version 1.2.4 is not 1.2.3"),
        ("debian/changelog", "1.2.3", "1.2.2", "debian/changelog: version 1.2.2 is not 1.2.3"),
        ("a_b/src/a_b/__init__.py", "1.2.3", "9.0", "__init__.py: version 9.0 is not 1.2.3"),
        ("more/c/CHANGELOG.rst", " (2026-01-02)", "", "1.2.3: no Forthcoming or VERSION"),
        ("a_b/CHANGELOG.rst", "---", "", "no section"),
        ("debian/control", "Package: ros-c", "Package: ros-d", "no Package ros-c"),
        ("debian/control", "Package: ros-c", "Package: ros-d", "ros-d: there is no such"),
        ("debian/control", "         ros-c (= ${binary:Version})", " x", "ros-a-b: Depends lacks"),
        ("debian/control", "(= ${binary:Version}), ros-c", ", x", "mesh-tools: Depends lacks"),
    ],
)
def test_what_is_not_ready_is_found(tmp_path, name, old, new, words):
    if name == "a_b/CHANGELOG.rst":
        old = "-----------\n"
    assert any(words in line for line in findings(tmp_path, name, old, new))
