"""The pages of troubleshooting: every error and warning of the sources is explained, once."""

import ast

import pytest

from mesh_tools_test.troubleshooting import pages, troubleshooting
from mesh_tools_test.troubleshooting.message import Message
from mesh_tools_test.troubleshooting.sources import repository, sources


@pytest.fixture(name="messages", scope="module")
def messages_of_the_sources():
    return troubleshooting.gathered(repository())


def test_each_message_is_explained_once_and_nothing_else_is(messages):
    found = troubleshooting.findings(messages, pages.read_entries(repository()))
    assert not found, "\n" + "\n".join(found)


def test_messages_of_all_packages_and_kinds_are_found(messages):
    texts = {message.text for message in messages}
    assert len(texts) == len(messages) > 1000
    for text in (
        "there is no such file",  # a table of errors
        "it is no JSON: …",  # through a helper
        "left out: … vertices without faces",  # a note
        "there are two layers of the name …",  # an exception
        "no path: start is in component … of …, goal in component …",  # an outcome
        "velocity_guard: no sign of life for … s; the robot stands",  # the log
        "no mesh is shown: add and enable a TexturedMesh or Map3D display",  # a reason in a panel
        "the mesh cannot be drawn: …",  # a status line
        "a message is lost: …",  # the log of C++
        "the outline crosses itself, by its sides … and …",  # an exception of C++
    ):
        assert text in texts


def test_every_source_has_its_page(messages):
    root = repository()
    for message in messages:
        assert (root / pages.page_for(message.path)).is_file()


def test_a_mesh_that_import_refuses_comes_with_a_way_out():
    """The last argument of MapFileError is what a user can do."""
    python, _ = sources(repository())
    refusals, without = 0, []
    for path, text in python.items():
        if "/formats/" in path:
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "MapFileError":
                    refusals += 1
                    if len(node.args) < 4 or getattr(node.args[3], "value", None) == "":
                        without.append("%s:%d" % (path, node.lineno))
    assert refusals > 50
    assert without == []


PAGE = """# Title

## Section

- `it is … and …`
- `` a `b` c ``

**Cause.** Something
is so.

**Way out.** Do
it.
"""
MESSAGES = [Message("mesh_msgs/src/a.py", 7, "it is … and …"), Message("b.py", 1, "a `b` c")]


def test_an_entry_has_messages_cause_and_way_out():
    (entry,) = pages.entries_of("docs/page.md", PAGE)
    assert entry.line == 5
    assert entry.messages == [(5, "it is … and …"), (6, "a `b` c")]
    assert (entry.cause, entry.way_out) == ("Something is so.", "Do it.")
    assert troubleshooting.findings(MESSAGES, [entry]) == []
    for _, text in entry.messages:
        assert pages.entries_of("p", "- " + pages.code(text))[0].messages == [(1, text)]


def test_a_message_that_no_page_explains_is_told_with_its_page():
    (finding,) = troubleshooting.findings(MESSAGES[:1], [])
    assert finding.startswith("mesh_msgs/src/a.py:7: no page explains it: ")
    assert "docs/troubleshooting/messages.md" in finding and "`it is … and …`" in finding


def test_a_stale_entry_is_told_with_what_it_may_be_now():
    entries = pages.entries_of("docs/page.md", PAGE.replace("it is", "it was"))
    finding = "\n".join(troubleshooting.findings(MESSAGES, entries))
    assert "docs/page.md:5: no source says `it was … and …`" in finding
    assert "is it now `it is … and …`?" in finding


def test_a_message_on_two_pages_is_told():
    entries = pages.entries_of("docs/one.md", PAGE) + pages.entries_of("docs/two.md", PAGE)
    found = troubleshooting.findings(MESSAGES, entries)
    assert len(found) == 2
    assert found[0] == "docs/two.md:5: `it is … and …` is in line 5 of docs/one.md, too"


@pytest.mark.parametrize("part", ["Something\nis so.", "Do\nit."])
def test_an_empty_cause_or_way_out_is_told(part):
    entries = pages.entries_of("docs/page.md", PAGE.replace(part, ""))
    (finding,) = troubleshooting.findings(MESSAGES, entries)
    assert finding.startswith("docs/page.md:5: no ")


def test_a_line_that_is_no_message_is_told():
    entries = pages.entries_of(
        "docs/page.md", PAGE.replace("- `it is … and …`", "- `it is … and …")
    )
    assert "docs/page.md:5" in "\n".join(troubleshooting.findings(MESSAGES, entries))
