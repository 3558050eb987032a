"""Markdown that pages are made of."""
import re
from typing import Iterable, Sequence

_SPECIAL = re.compile(r"([\\`*_\[\]<>|$])")


def plain(text: str) -> str:
    """Text that means nothing but itself, on one line."""
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()))


def code(text: str) -> str:
    """Text in the letters of a program, also within a table; nothing of nothing."""
    return "`%s`" % text.replace("|", r"\|") if text else ""


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of cells that are Markdown; "" without rows."""
    lines = ["| %s |" % " | ".join(row) for row in rows]
    if not lines:
        return ""
    lines[:0] = ["| %s |" % " | ".join(header), "|" + "---|" * len(header)]
    return "\n".join(lines) + "\n"


def block(text: str, language: str = "text") -> str:
    """Text as it stands."""
    return "```%s\n%s\n```\n" % (language, text.rstrip("\n"))


def page(*parts: str) -> str:
    """The parts that are not empty, with a line between them."""
    return "\n\n".join(part.strip("\n") for part in parts if part.strip()) + "\n"
