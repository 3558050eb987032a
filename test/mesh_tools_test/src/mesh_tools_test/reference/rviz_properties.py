"""Properties of RViz's displays and tools, as the sources of the plugin make them."""
import re
from pathlib import Path
from typing import Iterator, List, NamedTuple

# rviz's own classes, and the methods of ours that make them
_MADE = re.compile(
    r"\b(\w*Property|add|alpha|box|choice|color|group|line|number|topic)(?:<[\w:]+>)?\(\s*(?=\")"
)
_PLAIN = re.compile(r'(?:"[^"]*"|[-\d.]+f?|true|false)$')
_TEXT = re.compile(r'"((?:[^"\\]|\\.)*)"')


class Property(NamedTuple):
    """name and default (as C++ has it; "" where it is no plain value) as in .rviz files."""

    name: str
    default: str
    about: str
    path: Path


def properties(folder: Path) -> List[Property]:
    """Those in the sources of a folder, in the order of the files."""
    found: List[Property] = []
    for path in sorted(folder.glob("**/*.cpp")):
        if not path.stem.endswith("_test"):
            text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
            for one in _MADE.finditer(text):
                arguments = [_joined(part) for part in _arguments(text[one.end() :])]
                if len(arguments) > 2:  # the last one is the parent: others are no properties
                    found.append(_property(one.group(1), arguments, path))
    return found


def _joined(argument: str) -> str:
    return argument.replace("\n", "").strip()


def _property(maker: str, arguments: List[str], path: Path) -> Property:
    name, *others = arguments
    texts = ["".join(_TEXT.findall(one)) for one in others if one.startswith('"')]
    default = ""
    if maker == "alpha":  # of what it is one
        default, texts = "1", ["1 is opaque: of " + texts[0]]
    elif maker != "topic" and _PLAIN.match(others[0]):
        default = re.sub(r"(?<=\d)f$", "", others[0].strip('"'))
        texts = texts[1:] if others[0].startswith('"') else texts
    about = max(texts, key=len) if texts else ""
    return Property("".join(_TEXT.findall(name)), default, about.replace('\\"', '"'), path)


def _arguments(text: str) -> Iterator[str]:
    """The arguments of a call, from behind its parenthesis on."""
    depth, begin, place = 0, 0, 0
    while place < len(text):
        if text[place] == '"':
            place = _TEXT.match(text, place).end()
            continue
        if text[place] in "([{":
            depth += 1
        elif text[place] in ")]}":
            if depth == 0:
                yield text[begin:place]
                return
            depth -= 1
        elif text[place] == "," and depth == 0:
            yield text[begin:place]
            begin = place + 1
        place += 1
