"""The command `render_test`: what it tells of programs that pass, fail, break off and hang."""

import re
import signal
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Callable, Dict, Tuple

import pytest

from osmesa_harness import render_test
from osmesa_harness.results import label_results, progress_file

GOOGLE_TEST_XML = """<?xml version="1.0" encoding="UTF-8"?>
<testsuites tests="2" failures="{failures}" disabled="0" errors="0" time="1" name="AllTests">
  <testsuite name="Suite" tests="2" failures="{failures}" disabled="0" errors="0" time="1">
    <testcase name="one" status="run" classname="Suite" />
    <testcase name="two" status="run" classname="Suite" />
  </testsuite>
</testsuites>
"""

UNFINISHED = " in Failing.does_what_it_is_asked_for and left no results of it and what follows"

Render = Callable[..., Tuple[int, ElementTree.Element, Path]]


@pytest.fixture
def render(script, program, environment: Dict[str, str], tmp_path: Path) -> Render:
    """Runs the failing program on a back end; its exit status, results and folder of pictures."""

    def run(
        fail_by: str, back_end: str = "osmesa", timeout: str = "60", reference: str = ""
    ) -> Tuple[int, ElementTree.Element, Path]:
        results = tmp_path / "results" / f"{back_end}.xml"
        pictures = tmp_path / f"pictures_{back_end}"
        arguments = ["--back-end", back_end, "--results", str(results), "--label", f"a_{back_end}"]
        arguments += ["--out", str(pictures), "--timeout", timeout, "--env", f"FAIL_BY={fail_by}"]
        arguments += ["--reference", reference] if reference else []
        done = subprocess.run(
            script("render_test", *arguments, program("failing_render_program")), env=environment
        )
        return done.returncode, ElementTree.parse(str(results)).getroot(), pictures

    return run


def problems(results: ElementTree.Element) -> str:
    found = list(results.iter("failure")) + list(results.iter("error"))
    return "\n".join(problem.get("message", "") for problem in found)


def test_a_good_run_is_told_under_its_label(render):
    status, results, _ = render("")
    assert status == 0
    assert results.get("name") == "a_osmesa"
    assert {case.get("classname") for case in results.iter("testcase")} == {
        "a_osmesa.BackEnd",
        "a_osmesa.Failing",
    }
    first = next(results.iter("testcase"))
    assert first.get("name") == "is_the_one_asked_for"
    assert problems(results) == ""


def test_a_wrong_picture_fails_and_is_shown(render):
    status, results, pictures = render("picture")
    assert status == 1
    assert "first at (7, 5): rgb(48, 48, 48), expected rgb(255, 0, 0)" in problems(results)
    assert {picture.name for picture in pictures.iterdir()} == {
        "empty_actual.png",
        "empty_expected.png",
        "empty_diff.png",
        "drawn.png",
    }
    assert str(pictures / "empty_diff.png") in problems(results)


def test_pictures_and_results_of_an_earlier_run_are_removed(render):
    _, _, pictures = render("picture")
    _, results, _ = render("crash")
    assert list(pictures.iterdir()) == []
    assert "first at (7, 5)" not in problems(results)


@pytest.mark.parametrize(
    "fail_by, timeout, status, message",
    [
        ("crash", "60", 128 + signal.SIGSEGV, "ended by signal 11" + UNFINISHED),
        ("crash_in_a_thread", "60", 128 + signal.SIGSEGV, "ended by signal 11" + UNFINISHED),
        ("abort", "60", 128 + signal.SIGABRT, "ended by signal 6" + UNFINISHED),
        ("hang", "20", 124, "stopped after its time limit of 20 s" + UNFINISHED),
        ("exit", "60", 3, "ended with exit status 3"),
    ],
)
def test_a_run_that_ends_badly_never_looks_like_a_success(
    render, fail_by, timeout, status, message
):
    ended, results, _ = render(fail_by, timeout=timeout)
    assert ended == status
    assert problems(results) == f"failing_render_program {message}"
    assert results.get("errors") == "1"
    # What had passed before is told nevertheless.
    passed = [
        f"{case.get('classname')}.{case.get('name')}"
        for case in results.iter("testcase")
        if case.find("error") is None
    ]
    assert passed[0] == "a_osmesa.BackEnd.is_the_one_asked_for"
    assert len(passed) == (2 if fail_by == "exit" else 1)
    assert results.get("tests") == str(len(passed) + 1)


@pytest.mark.parametrize("fail_by", ["crash", "crash_in_a_thread"])
def test_a_crash_tells_its_test_and_its_native_stack(script, program, environment, fail_by):
    environment.update(FAIL_BY=fail_by, OSMESA_HARNESS_OUT=environment["HOME"])
    failing = program("failing_render_program")
    status, printed = run_by_hand(script("headless", "--master", failing), environment)
    assert status == 128 + signal.SIGSEGV
    head = "crash: signal 11 in Failing.does_what_it_is_asked_for"
    stack = printed.partition(head)[2].partition("crash: end of the stack")[0]
    offsets = re.findall(re.escape(failing) + r"\(\+(0x[0-9a-f]+)\)", stack)
    assert offsets, printed
    told = subprocess.run(
        ["addr2line", "-f", "-e", failing, *offsets], check=True, stdout=subprocess.PIPE
    )
    assert "crashHere" in told.stdout.decode().split()


def test_the_progress_of_a_run_that_broke_off_is_its_result(tmp_path: Path):
    path = tmp_path / "results.xml"
    progress = Path(progress_file(str(path)))
    progress.write_text(
        '<begun classname="A" name="one"/>\n<testcase classname="A" name="one" time="0.5">'
        '</testcase>\n<begun classname="B" name="two"/>\n<testcase classname="B" name="two" '
        'time="1"><failure message="a &lt; b&#10;&quot;c&quot;"/></testcase>\n'
        '<begun classname="B" name="three"/>\n<testcase classname="B" na'
    )
    label_results(str(path), "label", "program", 128 + signal.SIGSEGV, 9.0)
    root = ElementTree.parse(str(path)).getroot()
    assert [root.get(count) for count in ("tests", "failures", "errors")] == ["3", "1", "1"]
    assert problems(root).split("\n", 2)[:2] == ["a < b", '"c"']
    assert "program ended by signal 11 in B.three" in problems(root)
    assert not progress.exists()


def test_pictures_of_both_back_ends_are_compared(render, tmp_path):
    _, _, pictures = render("")
    assert render("", "xvfb", reference=str(pictures))[0] == 0
    (pictures / "drawn.png").write_bytes(b"")
    status, results, _ = render("", "xvfb", reference=str(pictures))
    assert status == 1
    assert "drawn.png cannot be read as a picture" in problems(results)


def run_by_hand(command, environment) -> Tuple[int, str]:
    done = subprocess.run(
        command,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        universal_newlines=True,
    )
    return done.returncode, done.stdout


@pytest.mark.parametrize(
    "option, expected, complaint",
    [
        ("--x", "1", "OSMesa was asked for, but llvmpipe"),
        ("--x-osmesa", "0", "OSMesa draws, though it should not"),
    ],
)
def test_the_wrong_back_end_is_noticed(script, program, environment, option, expected, complaint):
    environment["OSMESA_HARNESS_EXPECT_OSMESA"] = expected
    environment["OSMESA_HARNESS_OUT"] = environment["HOME"]
    command = script("headless", option, "--master", program("failing_render_program"))
    status, printed = run_by_hand(command, environment)
    assert status == 1
    assert complaint in printed
    assert "BackEnd.is_the_one_asked_for" in printed.partition("listed below")[2]


def test_without_a_master_a_render_test_says_so_at_once(script, program, environment):
    environment["ROS_MASTER_URI"] = "http://localhost:1/"
    status, printed = run_by_hand(
        script("headless", program("failing_render_program")), environment
    )
    assert status == 1
    assert "no ROS master at http://localhost:1" in printed
    assert "--master" in printed


@pytest.mark.parametrize("failures", [0, 1])
def test_failed_tests_are_not_told_twice(tmp_path: Path, failures):
    path = tmp_path / "results.xml"
    path.write_text(GOOGLE_TEST_XML.format(failures=failures))
    label_results(str(path), "label", "program", 1, 9.0)
    root = ElementTree.parse(str(path)).getroot()
    assert int(root.get("errors")) == 1 - failures
    assert int(root.get("tests")) == 3 - failures
    names = {suite.get("name") for suite in root.iter("testsuite")}
    assert names == {"label.Suite"} | (set() if failures else {"label.program"})


@pytest.mark.parametrize(
    "back_end, signals, ended_before, statuses",
    [
        ("xvfb", [signal.SIGSEGV, 0], False, 0),
        ("xvfb", [signal.SIGSEGV, signal.SIGSEGV, 0], False, 128 + signal.SIGSEGV),
        ("xvfb", [signal.SIGSEGV, 0], True, 128 + signal.SIGSEGV),
        ("xvfb", [signal.SIGTERM, 0], False, 128 + signal.SIGTERM),
        ("osmesa", [signal.SIGSEGV, 0], False, 128 + signal.SIGSEGV),
    ],
)
def test_what_breaks_in_the_first_frames_on_xvfb_is_started_once_more(
    monkeypatch, capsys, tmp_path, back_end, signals, ended_before, statuses
):
    """Once, and nothing else is."""
    results = tmp_path / "results.xml"
    runs = []

    def run(command, *_):
        number = signals[len(runs)]
        runs.append(command)
        progress = '<begun classname="BackEnd" name="first"/>\n'
        if ended_before:
            progress += '<testcase classname="BackEnd" name="first" time="1"/>\n'
        Path(progress_file(str(results))).write_text(progress)
        if number == 0:
            results.write_text(GOOGLE_TEST_XML.format(failures=0))
            return 0
        return 128 + number

    monkeypatch.setattr(render_test, "run_headless", run)
    arguments = ["--back-end", back_end, "--results", str(results), "--label", "a"]
    status = render_test.main([*arguments, "--out", str(tmp_path / "pictures"), "program"])
    assert status == statuses
    is_restarted = back_end == "xvfb" and signals[0] == signal.SIGSEGV and not ended_before
    assert len(runs) == (2 if is_restarted else 1)
    assert ("once more" in capsys.readouterr().err) == is_restarted
    assert (problems(ElementTree.parse(str(results)).getroot()) == "") == (status == 0)
