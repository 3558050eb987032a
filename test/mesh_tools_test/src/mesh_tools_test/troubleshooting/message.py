"""One error or warning as it stands in the sources."""

import re
from typing import Iterable, List, NamedTuple

VARIES = "…"
_WORD = re.compile(r"[A-Za-z][a-z]+")
_PERCENT = re.compile(
    r"%(?:\(\w+\))?[-+#0]*(?:\*|\d+)?(?:\.(?:\*|\d+))?(?:hh|ll|[hlzjtL])?[a-zA-Z%]"
)
_MARKUP = re.compile(
    r"</|HTTP/|\(\) \{|^\{\w+\}|^(usage|example|More):|^<"
)  # XML, headers, scripts, rows of tables, help
_BRACES = re.compile(r"\{\{|\}\}|\{[^{}]*\}")


class Message(NamedTuple):
    """A text that a user may read; path: relative to the repository, line: from 1."""

    path: str
    line: int
    text: str


def words_in(text: str) -> int:
    """How many words a text has of its own."""
    return len(_WORD.findall(text))


def tidy(text: str) -> str:
    """On one line, what varies in a row as one sign, without what only separates it from more."""
    text = re.sub(r"\s+", " ", percent(text) if "%" in text else text)
    return re.sub(r"…(?: ?…)+", VARIES, text).strip(" ;,")


def is_message(text: str) -> bool:
    """Whether a text says something of its own: a word alone is a name, or a part of a message."""
    return words_in(text) > 1 and " " in text.strip(VARIES + " ") and not _MARKUP.search(text)


def percent(text: str) -> str:
    """The text of a format of printf, or of Python's %, with signs for what varies."""
    return _PERCENT.sub(lambda found: "%" if found.group() == "%%" else VARIES, text)


def braces(text: str) -> str:
    """The same of a format of str.format()."""
    return _BRACES.sub(
        lambda found: found.group()[0] if found.group() in ("{{", "}}") else VARIES, text
    )


def unique(messages: Iterable[Message]) -> List[Message]:
    """Each text once, at the first place that has it, in the order of places."""
    first = {}
    for message in sorted(messages):
        first.setdefault(message.text, message)
    return sorted(first.values())
