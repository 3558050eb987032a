"""JUnit XML of one test program that is run several times, in ways of different names."""

import os
import xml.etree.ElementTree as ElementTree

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


def label_results(path: str, label: str, program: str, status: int, timeout: float) -> None:
    """Makes the XML that Google Test wrote to `path` tell of one run among several.

    Suites and classes get the prefix `label`. A run that broke off, or that ended badly though no
    test failed, is told as an error of its own, so that it never looks like a success.
    """
    if os.path.exists(path):
        tree = ElementTree.parse(path)
        root = tree.getroot()
        if status != 0 and _bad_tests(root) == 0:
            _add_error(root, program, f"{program} {_what_happened(status, timeout)}")
    else:
        root = ElementTree.Element("testsuites", tests="0", failures="0", errors="0", time="0")
        tree = ElementTree.ElementTree(root)
        reason = f"{program} {_what_happened(status, timeout)} and left no results"
        _add_error(root, program, reason)
    root.set("name", label)
    for suite in root.iter("testsuite"):
        suite.set("name", f"{label}.{suite.get('name')}")
    for case in root.iter("testcase"):
        case.set("classname", f"{label}.{case.get('classname')}")
    os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    tree.write(path, encoding="UTF-8", xml_declaration=True)
