"""What is missing, or too much, on the pages of troubleshooting; as a program it lists that.

Each message of the sources stands on one page, once; each entry has messages that are still in the
sources, a cause and a way out.
"""

import difflib
import gc
import sys
from pathlib import Path
from typing import Dict, Iterable, List, Tuple

from mesh_tools_test.troubleshooting.cpp_messages import cpp_messages
from mesh_tools_test.troubleshooting.message import Message, unique
from mesh_tools_test.troubleshooting.pages import (
    CAUSE,
    WAY_OUT,
    Entry,
    code,
    page_for,
    read_entries,
)
from mesh_tools_test.troubleshooting.python_messages import python_messages
from mesh_tools_test.troubleshooting.sources import repository, sources


def gathered(root: Path) -> List[Message]:
    """All messages of the sources below root."""
    python, cpp = sources(root)
    collects = gc.isenabled()
    gc.disable()  # it would walk the syntax trees again and again: a third of the time
    try:
        return unique(python_messages(python) + cpp_messages(cpp))
    finally:
        if collects:
            gc.enable()


def findings(messages: Iterable[Message], entries: List[Entry]) -> List[str]:
    """What is wrong, each with its place and the way out."""
    known = {message.text: message for message in messages}
    explained = {text for entry in entries for _, text in entry.messages}
    open_ones = sorted(set(known) - explained)
    places: Dict[str, List[Tuple[str, int]]] = {}
    found = []
    for entry in entries:
        where = "%s:%d" % (entry.page, entry.line)
        if not entry.cause:
            found.append("%s: no cause: a paragraph that begins with %s" % (where, CAUSE))
        if not entry.way_out:
            found.append("%s: no way out: a paragraph that begins with %s" % (where, WAY_OUT))
        for line, text in entry.messages:
            if not text:
                found.append("%s:%d: no message in code font: - `...`" % (entry.page, line))
                continue
            places.setdefault(text, []).append((entry.page, line))
            if text not in known:
                found.append("%s:%d: %s" % (entry.page, line, _stale(text, open_ones)))
    for text, at in places.items():
        for page, line in at[1:]:
            found.append(
                "%s:%d: %s is in line %d of %s, too" % (page, line, code(text), *at[0][::-1])
            )
    for message in known.values():
        if message.text not in places:
            add = "%s:%d: no page explains it: add to %s the entry - %s"
            page = page_for(message.path)
            found.append(add % (message.path, message.line, page, code(message.text)))
    return sorted(found)


def _stale(text: str, others: List[str]) -> str:
    near = difflib.get_close_matches(text, others, 1)
    now = "is it now %s?" % code(near[0]) if near else "take it out"
    return "no source says %s (any more): %s" % (code(text), now)


def main() -> int:
    """Print all findings; 1 if there are some."""
    root = repository()
    found = findings(gathered(root), read_entries(root))
    for finding in found:
        print(finding)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
