"""C++ sources as tokens: enough of the language to find literals, calls and functions in them."""

import ast
import re
from typing import Dict, List, NamedTuple, Optional

_TOKEN = re.compile(
    r"""(?P<skip>\s+|//[^\n]*|/\*.*?\*/|\#(?:\\\n|[^\n])*)
    |(?P<raw>(?:u8|[uUL])?R"(?P<mark>[^()\\\s]{0,16})\((?P<inside>.*?)\)(?P=mark)")
    |(?P<text>(?:u8|[uUL])?"(?:\\.|[^"\\\n])*")
    |(?P<char>(?:u8|[uUL])?'(?:\\.|[^'\\\n])*')
    |(?P<number>\.?\d(?:[eEpP][+-]|'?[\w.])*)
    |(?P<name>[A-Za-z_]\w*)
    |(?P<sign>::|->|<<=?|[-+*/%=!<>&|^]=|&&|\|\||\+\+|--|\S)""",
    re.VERBOSE | re.DOTALL,
)
_PAIRS = {"(": ")", "[": "]", "{": "}"}


class Token(NamedTuple):
    """kind: text (a literal, value: what it says), name, number, char or sign; line from 1."""

    kind: str
    value: str
    line: int


def tokens_of(source: str) -> List[Token]:
    """The tokens of a source without comments and preprocessor; neighboring literals are one."""
    found: List[Token] = []
    line = 1
    for match in _TOKEN.finditer(source):
        kind, value = match.lastgroup, match.group()
        start = line
        line += value.count("\n")
        if match.group("skip"):
            continue
        if match.group("raw"):
            kind, value = "text", match.group("inside")
        elif match.group("text"):
            kind, value = "text", _plain(value[value.index('"') :])
        if kind == "text" and found and found[-1].kind == "text":
            found[-1] = found[-1]._replace(value=found[-1].value + value)
        else:
            found.append(Token(kind, value, start))
    return found


def _plain(literal: str) -> str:
    """What a literal says; its escapes are those of Python as far as messages have them."""
    try:
        return ast.literal_eval(literal)
    except (SyntaxError, ValueError):
        return literal[1:-1]


def partners(tokens: List[Token]) -> Dict[int, int]:
    """Position of each opening bracket -> that of the one that closes it."""
    found, waiting = {}, []
    for position, token in enumerate(tokens):
        if token.kind == "sign" and token.value in _PAIRS:
            waiting.append(position)
        elif token.kind == "sign" and token.value in _PAIRS.values():
            while waiting and _PAIRS[tokens[waiting[-1]].value] != token.value:
                waiting.pop()
            if waiting:
                found[waiting.pop()] = position
    return found


def split(
    tokens: List[Token], closing: Dict[int, int], start: int, end: int, signs: set
) -> List[range]:
    """The parts of tokens[start:end] between signs that stand outside of brackets."""
    parts, begin, position = [], start, start
    while position < end:
        token = tokens[position]
        if token.kind == "sign":
            if position in closing:
                position = min(closing[position], end)
                continue_at = position + 1
                position = continue_at
                continue
            if token.value in signs:
                parts.append(range(begin, position))
                begin = position + 1
        position += 1
    parts.append(range(begin, end))
    return [part for part in parts if part]


class Function(NamedTuple):
    """A function with a body: its name, parameters in their order, and where its body is."""

    name: str
    parameters: List[str]
    body: range


_NO_FUNCTIONS = {"if", "for", "while", "switch", "catch", "return", "sizeof", "decltype"}


def functions_of(tokens: List[Token], closing: Dict[int, int]) -> List[Function]:
    """The functions that are defined, in the order of their bodies."""
    found = []
    for position, token in enumerate(tokens[:-1]):
        if token.kind == "name" and tokens[position + 1].value == "(":
            if token.value not in _NO_FUNCTIONS and position + 1 in closing:
                body = _body(tokens, closing, closing[position + 1] + 1)
                if body is not None:
                    parts = split(tokens, closing, position + 2, closing[position + 1], {","})
                    names = [_parameter(tokens, part) for part in parts]
                    found.append(Function(token.value, names, body))
    return found


def _body(tokens: List[Token], closing: Dict[int, int], position: int) -> Optional[range]:
    """The body behind the parameters, if there is one."""
    initializers = False
    while position < len(tokens):
        token = tokens[position]
        if token.kind == "name":
            follows = tokens[position + 1].value if position + 1 < len(tokens) else ""
            if initializers and follows in ("(", "{") and position + 1 in closing:
                position = closing[position + 1] + 1
                continue
            if not initializers and token.value not in (
                "const",
                "noexcept",
                "override",
                "final",
                "mutable",
            ):
                return None
        elif token.value == "{" and token.kind == "sign" and position in closing:
            return range(position + 1, closing[position])
        elif token.value == ":" and not initializers:
            initializers = True
        elif token.value not in ("::", ",", "&", "&&") or not initializers:
            return None
        position += 1
    return None


def _parameter(tokens: List[Token], part: range) -> str:
    """The name of a parameter: the last one before its default."""
    name = ""
    for position in part:
        if tokens[position].value == "=":
            break
        if tokens[position].kind == "name":
            name = tokens[position].value
    return name
