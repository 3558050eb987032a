"""The summary of a test run counts whatever went wrong as failed."""
import subprocess
from pathlib import Path

import pytest

SUMMARY = Path(__file__).resolve().parents[4] / ".ci/summary.py"
pytestmark = pytest.mark.skipif(not SUMMARY.exists(), reason="not part of an installation")

GOOD = '<testsuite tests="1"><testcase classname="a" name="good" time="1.5"/></testsuite>'
NODE = '<testsuite><testcase classname="RosTest" name="testnode">%s</testcase></testsuite>'
FAILED = '<failure message="it broke"/>'


def summary(folder, files, *options):
    """(exit code, lines) of the summary of these files of one package."""
    (folder / "package").mkdir()
    for name, text in files.items():
        (folder / "package" / name).write_text(text)
    result = subprocess.run(
        [str(SUMMARY), str(folder), *options], stdout=subprocess.PIPE, check=False
    )
    return result.returncode, result.stdout.decode().splitlines()


@pytest.mark.parametrize(
    "files, counts",
    [
        ({"pytest-a.xml": GOOD}, "1 passed, 0 failed, 0 skipped"),
        ({"rosunit-node.xml": GOOD, "rostest-a.xml": NODE % ""}, "1 passed, 0 failed, 0 skipped"),
    ],
)
def test_success(tmp_path, files, counts):
    code, lines = summary(tmp_path, files)
    assert (code, lines[-1]) == (0, counts)


@pytest.mark.parametrize(
    "files, word",
    [
        # what catkin writes in the place of results that a crashed program did not leave
        (
            {"MISSING-gtest-a.xml": '<testsuite><testcase name="ran">%s</testcase></testsuite>'},
            "it broke",
        ),
        # a Google Test that crashed while it wrote
        ({"gtest-a.xml": '<testsuites tests="3"><testsuite name="a"><testcase name="b"'}, "read"),
        # a test node that died: it left no results, or good ones before the end
        ({"rostest-a.xml": NODE}, "it broke"),
        ({"rosunit-node.xml": GOOD, "rostest-a.xml": NODE}, "it broke"),
        # the same name in another test node hides nothing
        ({"rosunit-x.xml": GOOD.replace("good", "testnode"), "rostest-a.xml": NODE}, "it broke"),
        # a module that pytest cannot import
        (
            {
                "pytest-a.xml": '<testsuites><testsuite errors="1"><testcase name="a"><error '
                'message="collection failure">No module</error></testcase></testsuite></testsuites>'
            },
            "collection failure",
        ),
        ({"pytest-a.xml": '<testsuite tests="0"></testsuite>'}, "no test ran"),
        ({"gtest-a.xml": GOOD.replace("<testsuite", '<testsuite failures="2"')}, "2 failures"),
        ({"pytest-a.xml": ""}, "cannot be read"),
    ],
)
def test_whatever_went_wrong_is_a_failure(tmp_path, files, word):
    files = {name: text.replace("%s", FAILED) for name, text in files.items()}
    code, lines = summary(tmp_path, {"pytest-good.xml": GOOD, **files})
    assert code == 1
    assert ", 1 failed," in lines[-1]
    assert any("FAILED: package:" in line for line in lines)
    assert any(word in line for line in lines)


def test_skipped_tests_are_named_with_their_reason(tmp_path):
    text = '<testsuite><testcase name="a"><skipped message="no data"/></testcase></testsuite>'
    code, lines = summary(tmp_path, {"pytest-good.xml": GOOD, "pytest-a.xml": text})
    assert (code, lines[-1]) == (0, "1 passed, 0 failed, 1 skipped")
    assert "skipped: package: a: no data" in lines


def test_no_results_are_a_failure(tmp_path):
    code, lines = summary(tmp_path, {})
    assert (code, lines[-1]) == (1, "0 passed, 0 failed, 0 skipped")


def test_programs_without_a_test_that_was_asked_for_are_no_failure(tmp_path):
    files = {"gtest-a.xml": '<testsuites tests="0"></testsuites>'}
    (tmp_path / "one").mkdir()
    code, lines = summary(tmp_path / "one", {"gtest-b.xml": GOOD, **files}, "--filtered")
    assert (code, lines[-1]) == (0, "1 passed, 0 failed, 0 skipped")
    (tmp_path / "none").mkdir()
    code, lines = summary(tmp_path / "none", files, "--filtered")
    assert (code, lines[-1]) == (1, "0 passed, 0 failed, 0 skipped")
