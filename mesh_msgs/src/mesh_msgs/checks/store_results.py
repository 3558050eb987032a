"""Validation of what is said of messages that were sent to be stored."""

from typing import Any, List

from mesh_msgs.checks.findings import Finding

_STORED, _WAITING = 0, 2  # the first and the last result of StoreResult


def store_result(msg: Any) -> List[Finding]:
    """result_unknown, result_topic, result_text."""
    findings = []
    if not _STORED <= msg.result <= _WAITING:
        what = "the result is %d" % msg.result
        hint = "choose one of the constants of StoreResult"
        findings.append(Finding("result_unknown", what, None, 1, hint))
    if not msg.topic:
        hint = "name the topic that the message came on"
        findings.append(Finding("result_topic", "the result names no topic", None, 1, hint))
    if msg.result != _STORED and not msg.text:
        what = "the message is not stored, and nothing says why"
        findings.append(Finding("result_text", what, None, 1, "say it in its text"))
    return findings
