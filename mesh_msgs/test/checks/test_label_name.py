"""The rule for names of labels, on the cases that RViz's is held to as well."""

import json
from pathlib import Path

import pytest
from mesh_msgs.checks.label_name import label_fault

CASES = json.loads((Path(__file__).resolve().parents[1] / "label_names.json").read_text("utf-8"))


@pytest.mark.parametrize("case", CASES, ids=[case["name"] for case in CASES])
def test_what_may_name_a_label(case):
    fault = label_fault(case["label"])
    assert (fault is None) == case["usable"]
    if fault:
        assert fault.what.isprintable() and 0 <= fault.index < len(case["label"].encode("utf-8"))


def test_the_first_character_at_fault_is_named():
    assert label_fault("ab\x9f\n") == ("contains a control character", 2)
    assert label_fault("a\u2067b") == ("contains U+2067, which makes it look like another", 1)
    assert label_fault("a\udcff") == ("is no UTF-8", 1)
    assert label_fault("x" * 10_000_000) == ("has 10000000 bytes", 255)
    assert label_fault("") is None
