"""Names of the field's words: what breaks that is found, what users meet is left alone."""
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / ".ci"))
word_rules = pytest.importorskip("word_rules", reason="the linter is not part of an installation")

PYTHON, CPP = Path("p/src/p/part.py"), Path("p/src/room/part.cpp")


def findings(path, text):
    """(line, sentence) of each finding."""
    return [(line, sentence) for _, line, sentence in word_rules.check(path, text)]


@pytest.mark.parametrize("word", sorted(word_rules.BANNED))
def test_each_word_is_found_in_each_kind_of_name(word):
    camel = word.capitalize()
    python = [
        f"class Mesh{camel}:\n    pass\n",
        f"def find_{word}():\n    pass\n",
        f"class A:\n    {word}: int\n",
        f"class A:\n    def f(self):\n        self._{word} = 1\n",
    ]
    cpp = [f"class Mesh{camel}\n{{\n}};\n", f"int find{camel}();\n", f"  int {word}_ = 0;\n"]
    for path, texts in ((PYTHON, python), (CPP, cpp)):
        for text in texts:
            ((line, sentence),) = findings(path, text)
            assert word in text.splitlines()[line - 1].lower()
            assert sentence.endswith(f"the field's word for '{word}' is {word_rules.BANNED[word]}")
    ((line, _),) = findings(Path(f"p/src/room/mesh_{word}.h"), "")
    assert line == 0


@pytest.mark.parametrize(
    "path, text",
    [
        (PYTHON, '"""The way of a front."""\nway = 1  # to the desk\n'),
        (PYTHON, "from mesh_map.wave_front import WaveFrontSolver\nfeedback = 1\n"),
        (PYTHON, "class WaveFrontPlanner:\n    wave_front_speed: float\n"),
        (CPP, '// The way of a front.\nsay("inbox Desk(");\n#include "room/inbox_desk.h"\n'),
        (CPP, "/* Inbox\n   Desk */ queue.pop_front();\nfor (auto& x : list.front()) {}\n"),
        (CPP, "QPainter painting(&image);\nfeedback_ = always();\n"),
        (Path("p/test/room/test_way.py"), "def test_a_way_across():\n    pass\n"),
    ],
)
def test_prose_names_of_libraries_and_of_users_are_left_alone(path, text):
    assert findings(path, text) == []


def test_lines_are_counted_below_comments_of_several_lines():
    text = '/* 1\n2 */\nR"(\n4)";\nclass Desk\n'
    assert [line for line, _ in findings(CPP, text)] == [5]


def test_a_class_has_a_name_of_its_own():
    one, two, test = Path("a/src/a/one.py"), Path("b/src/b/two.py"), Path("b/test/test_two.py")
    both = "import x\n\n\nclass Part:\n    pass\n"
    ((place, line, sentence),) = word_rules.check_classes({two: both, one: both, test: both})
    assert (place, line) == (two.as_posix(), 4)
    assert sentence.startswith("Part: another class of this name is in a/src/a/one.py")
    private = "class _Part:\n    pass\n\n\nclass MeshGeometry:\n    pass\n"
    assert not list(word_rules.check_classes({one: private, two: private}))
