"""JUnit XML of one test program that is run several times, in ways of different names."""

import os
import xml.etree.ElementTree as ElementTree
from typing import Dict, Tuple

from osmesa_harness.processes import TIMED_OUT


def _what_happened(status: int, timeout: float) -> str:
    if status == TIMED_OUT:
        return f"stopped after its time limit of {timeout:g} s"
    if status > 128:
        return f"ended by signal {status - 128}"
    return f"ended with exit status {status}"


def _add_error(root: ElementTree.Element, program: str, message: str) -> None:
    suite = ElementTree.SubElement(
        root, "testsuite", name="program", tests="1", failures="0", errors="1", time="0"
    )
    case = ElementTree.SubElement(suite, "testcase", name=program, classname="program", time="0")
    ElementTree.SubElement(case, "error", message=message, type="program")
    for count in ("tests", "errors"):
        root.set(count, str(int(root.get(count, "0")) + 1))


def _bad_tests(root: ElementTree.Element) -> int:
    return sum(int(root.get(count, "0")) for count in ("failures", "errors"))


def _read_progress(path: str) -> Tuple[ElementTree.Element, str]:
    """The results of the tests that had ended, and " in SUITE.TEST" for the one that had not.

    `path` is what the program wrote to OSMESA_HARNESS_PROGRESS; its last line may be cut short.
    """
    root = ElementTree.Element("testsuites", tests="0", failures="0", errors="0", time="0")
    running = ""
    suites: Dict[str, ElementTree.Element] = {}
    lines = []
    if os.path.exists(path):
        with open(path, encoding="utf-8", errors="replace") as progress:
            lines = progress.read().split("\n")[:-1]
    for line in lines:
        case = ElementTree.fromstring(line)
        name = case.get("classname", "")
        if case.tag == "begun":
            running = f" in {name}.{case.get('name')}"
            continue
        running = ""
        if name not in suites:
            suites[name] = ElementTree.SubElement(
                root, "testsuite", name=name, tests="0", failures="0", errors="0", time="0"
            )
        suites[name].append(case)
        failed = case.find("failure") is not None
        for element in (suites[name], root):
            element.set("tests", str(int(element.get("tests", "0")) + 1))
            element.set("failures", str(int(element.get("failures", "0")) + int(failed)))
            seconds = float(element.get("time", "0")) + float(case.get("time", "0"))
            element.set("time", f"{seconds:g}")
    return root, running


def progress_file(path: str) -> str:
    """Where a program tells of its tests while it runs that is to write its results to `path`."""
    return path + ".progress"


def has_ended_tests(path: str) -> bool:
    """Has a program that was to write its results to `path` come to the end of any test?"""
    if os.path.exists(path):
        return True
    root, _ = _read_progress(progress_file(path))
    return root.get("tests") != "0"


def label_results(path: str, label: str, program: str, status: int, timeout: float) -> None:
    """Makes the XML that Google Test wrote to `path` tell of one run among several.

    Suites and classes get the prefix `label`. A run that broke off, or that ended badly though no
    test failed, is told as an error of its own, so that it never looks like a success; with the
    tests that had ended before it broke off, as its progress_file() has them, which is removed.
    """
    progress = progress_file(path)
    if os.path.exists(path):
        tree = ElementTree.parse(path)
        root = tree.getroot()
        if status != 0 and _bad_tests(root) == 0:
            _add_error(root, program, f"{program} {_what_happened(status, timeout)}")
    else:
        root, running = _read_progress(progress)
        tree = ElementTree.ElementTree(root)
        reason = f"{program} {_what_happened(status, timeout)}{running} and left no results"
        _add_error(root, program, reason + (" of it and what follows" if running else ""))
    root.set("name", label)
    for suite in root.iter("testsuite"):
        suite.set("name", f"{label}.{suite.get('name')}")
    for case in root.iter("testcase"):
        case.set("classname", f"{label}.{case.get('classname')}")
    os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    tree.write(path, encoding="UTF-8", xml_declaration=True)
    if os.path.exists(progress):
        os.remove(progress)
