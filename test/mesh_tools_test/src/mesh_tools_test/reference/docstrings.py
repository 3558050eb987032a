"""Docstrings as they stand in the sources, made reStructuredText: for Sphinx's autodoc.

In them, members and values are told as lists of lines `name: what it is`, an indented block after a
colon is code, and |x| is an absolute value. Sections such as `Args:` are left to napoleon. In
conf.py, with "sphinx.ext.napoleon" among the extensions:

    def setup(app):
        app.connect("autodoc-process-docstring", docstrings.prepare, priority=400)
"""
import re
from typing import Any, Iterator, List

# before napoleon, whose handler has 500
_ITEM = re.compile(r'^"?[*`\w.]+"?(?:(?:, | and )"?[*`\w.]+"?)*(?: \([^)]*\))?: ')
_SECTION = re.compile(
    r"^(Args|Arguments|Attributes|Example|Examples|Note|Notes|Raises|Returns|Warning|Yields):$"
)
_BAR = re.compile(r"(?<!\\)\|")


def prepare(_app: Any, _what: str, _name: str, _object: Any, _options: Any, lines: List[str]):
    """The handler: changes the lines in their place."""
    lines[:] = prepared(lines)


def prepared(lines: List[str]) -> List[str]:
    """The lines of a docstring as reStructuredText that napoleon takes."""
    found: List[str] = []
    blocks = list(_blocks(lines))
    for number, block in enumerate(blocks):
        first = block[0]
        if first.startswith(" "):  # goes on with the block before: code, or a section
            found += block
        elif _SECTION.match(first) or first.startswith((":", "* ", "- ", "..")):
            found += [_BAR.sub(r"\\|", line) for line in block]
        else:
            before_code = number + 1 < len(blocks) and blocks[number + 1][0].startswith(" ")
            found += _paragraph([_BAR.sub(r"\\|", line) for line in block], before_code)
        found.append("")
    return found


def _blocks(lines: List[str]) -> Iterator[List[str]]:
    """What stands between empty lines."""
    block: List[str] = []
    for line in [*lines, ""]:
        if line.strip():
            block.append(line)
        elif block:
            yield block
            block = []


def _paragraph(block: List[str], before_code: bool) -> List[str]:
    found: List[str] = []
    in_list = False
    outermost = [line for line in block if not line.startswith(" ")]
    is_list = len(outermost) > 1 and all(_ITEM.match(line) for line in outermost)
    hangs = len(outermost) < len(block)
    for line in block:
        text = line.strip()
        if _ITEM.match(text) and (is_list or hangs):
            if found and not in_list:
                found.append("")
            found.append("* " + text)
            in_list = True
        else:
            found.append("  " + text if in_list else text)
    if before_code and found[-1].endswith(":") and not found[-1].endswith("::"):
        found[-1] += ":"
    return found
