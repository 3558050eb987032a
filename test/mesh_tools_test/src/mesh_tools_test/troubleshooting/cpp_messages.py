"""The errors and warnings of C++ sources, found among their tokens.

As in Python a text that a user reads is followed back: through variables of the function,
parameters of helpers, and what functions return.
"""

import re
from typing import Dict, Iterable, List, NamedTuple, Optional, Set, Tuple

from mesh_tools_test.troubleshooting.cpp_tokens import (
    Function,
    Token,
    functions_of,
    partners,
    split,
    tokens_of,
)
from mesh_tools_test.troubleshooting.message import (
    VARIES,
    Message,
    is_message,
    percent,
    tidy,
    unique,
    words_in,
)

# Mistakes in code that calls ours, and what only ends a computation: no user reads them.
CONTRACTS = {"Canceled", "bad_alloc", "error_already_set", "logic_error", "out_of_range"}
_LOG = re.compile(r"ROS_(WARN|ERROR|FATAL)\w*$")
_STATUS = {"warn", "error"}
_TELLING = {"end", "fail", "refuse", "say", "setText", "tellOutcome"}  # what users read in the end
_LAST = {"PyErr_SetString", "require", "set_error", "value_error", "warn"}  # their last argument
_BAD_NEWS = re.compile(
    r"^(\w+_)?(clicked|ending|failure|message|pointed|problem|reason|refusal|report|result|trouble"
    r"|warning|why)_?$"
)
_REASONS = re.compile(r"^(why|refus|problem)")  # functions that tell why not, in tables as well
_PIECE = re.compile(r"^[\s':;,]|[\s'(]$")  # of a text that goes on
_SENTENCE = 4  # words: so long a text that a function returns is a reason
_INSTRUCTION = re.compile(
    r"^(Click (at|on) (the|two|a) |Drag to |Press the left|Point at |<|Moves |Looking |Measuring "
    r"|Writ)"
)
_WRAPPERS = {
    "QString",
    "QStringLiteral",
    "arg",
    "c_str",
    "fromStdString",
    "fromUtf8",
    "joined",
    "move",
    "qPrintable",
    "shortened",
    "string",
    "tr",
}
_NUMBERED = {"counted"}  # "1 layer", "2 layers": no text of its own
_ARG = re.compile(r"%\d")
_MOST = 12
_OWN_WORDS = 3

_Text = Tuple[str, str, int]


class _File(NamedTuple):
    path: str
    tokens: List[Token]
    closing: Dict[int, int]
    functions: List[Function]

    def around(self, position: int) -> Optional[Function]:
        """The innermost function around a position."""
        found = [f for f in self.functions if position in f.body]
        return min(found, key=lambda f: len(f.body)) if found else None


def cpp_messages(sources: Dict[str, str]) -> List[Message]:
    """All messages of some sources; sources: path -> text."""
    files = []
    for path, text in sources.items():
        tokens = tokens_of(text)
        closing = partners(tokens)
        files.append(_File(path, tokens, closing, functions_of(tokens, closing)))
    return unique(_Gatherer(files).found)


class _Gatherer:
    def __init__(self, files: List[_File]) -> None:
        self.found: Set[Message] = set()
        self._functions: Dict[str, List[Tuple[_File, Function]]] = {}
        self._calls: Dict[str, List[Tuple[_File, int]]] = {}
        self._seen: Set[Tuple[str, int, int]] = set()
        self._asked: Set[Tuple[str, int, str]] = set()
        self._active: Set[Tuple[str, int, int]] = set()
        self._waiting: List[Tuple[_File, range]] = []
        for file in files:
            for function in file.functions:
                self._functions.setdefault(function.name, []).append((file, function))
            for position, token in enumerate(file.tokens[:-1]):
                if token.kind == "name" and file.tokens[position + 1].value == "(":
                    self._calls.setdefault(token.value, []).append((file, position))
        for file in files:
            for position in range(len(file.tokens) - 1):
                for part in self._arrivals(file, position):
                    self._follow(file, part)
        while self._waiting:
            self._follow(*self._waiting.pop())

    # Where a text arrives.

    def _arrivals(self, file: _File, position: int) -> List[range]:
        token, before = file.tokens[position], file.tokens[position - 1].value
        if token.kind != "name":
            return []
        following = file.tokens[position + 1].value
        if token.value == "throw":
            return self._thrown(file, position)
        if token.value == "return":
            return self._returned(file, position)
        if following == "{" and token.value == "Finding":
            return self._arguments(file, position + 1)[1:2]
        if following == "(":
            parts = self._arguments(file, position + 1)
            if not parts:
                return []
            if _LOG.match(token.value):
                parts = parts[1 if "THROTTLE" in token.value or "NAMED" in token.value else 0 :]
                return parts
            level = before == "::" and file.tokens[position - 2].value == "StatusLine"
            if level and token.value in _STATUS:
                return [range(parts[0].start, parts[-1].stop)]
            if token.value in _TELLING and before not in ("::", ">", "&"):
                return [part for part in parts if file.tokens[part.start].value != "hint"]
            if token.value == "log":
                words = {file.tokens[i].value for i in parts[0]}
                return parts[1:] if "WARNING" in words else []
            if token.value == "joined" and self._finds(file, position):
                return [range(position, file.closing[position + 1] + 1)]
            if token.value in _LAST:
                return parts[-1:]
        if following in ("=", "+=") and _BAD_NEWS.match(token.value):
            end = self._end_of_statement(file, position + 2)
            return [range(position + 2, end)]
        return []

    def _returned(self, file: _File, position: int) -> List[range]:
        """A sentence that a function returns."""
        function = file.around(position)
        if function is not None and _REASONS.match(function.name):
            literals = [i for i in function.body if file.tokens[i].kind == "text"]
            whole = [i for i in literals if not _PIECE.search(file.tokens[i].value)]
            end = self._end_of_statement(file, position + 1)
            return [range(i, i + 1) for i in whole] + [range(position + 1, end)]
        part = range(position + 1, self._end_of_statement(file, position + 1))
        first = file.tokens[part.start]
        literals = [i for i in part if file.tokens[i].kind == "text"]
        words = max([words_in(file.tokens[i].value) for i in literals], default=0)
        if words < _SENTENCE or file.path.startswith("mesh_map/"):
            return []
        choice = "?" in {file.tokens[i].value for i in part}
        return [part] if first.kind == "text" or first.value == "{" or choice else []

    def _finds(self, file: _File, position: int) -> bool:
        """Whether a function that collects findings is around a position."""
        return any(position in f.body and "findings" in f.parameters for f in file.functions)

    def _thrown(self, file: _File, position: int) -> List[range]:
        name = before = ""
        for at in range(position + 1, min(position + 8, len(file.tokens))):
            token = file.tokens[at]
            if token.kind == "name":
                name, before = token.value, file.tokens[at - 1].value
            elif token.value in ("(", "{") and at in file.closing:
                if name in CONTRACTS:
                    return []
                if name[0].islower() and name in self._functions and before != "::":
                    return [range(position + 1, file.closing[at] + 1)]
                return self._arguments(file, at)
            elif token.value != "::":
                return []
        return []

    def _arguments(self, file: _File, opening: int) -> List[range]:
        end = file.closing.get(opening)
        return split(file.tokens, file.closing, opening + 1, end, {","}) if end else []

    def _end_of_statement(self, file: _File, position: int) -> int:
        while position < len(file.tokens) and file.tokens[position].value not in (";", "}", ")"):
            position = file.closing.get(position, position) + 1
        return position

    # Where it comes from.

    def _follow(self, file: _File, part: range) -> None:
        key = (file.path, part.start, part.stop)
        if key in self._seen:
            return
        self._seen.add(key)
        for text, path, line in self._texts(file, part):
            text = tidy(text)
            if is_message(text) and not _INSTRUCTION.search(text):
                self.found.add(Message(path, line, text))

    def _texts(self, file: _File, part: range) -> List[_Text]:
        """The texts that an expression may have; what is not known varies."""
        unknown = [(VARIES, file.path, file.tokens[part.start].line)] if part else []
        key = (file.path, part.start, part.stop)
        if not part or key in self._active:
            return unknown
        self._active.add(key)
        try:
            return self._inner_texts(file, part) or unknown
        finally:
            self._active.remove(key)

    def _inner_texts(self, file: _File, part: range) -> List[_Text]:
        tokens, closing = file.tokens, file.closing
        pieces = split(tokens, closing, part.start, part.stop, {","})
        if len(pieces) > 1:
            return self._of_sum(file, pieces)
        choice = split(tokens, closing, part.start, part.stop, {"?"})
        if len(choice) > 1:
            return self._of_choice(file, range(choice[1].start, part.stop))
        pieces = split(tokens, closing, part.start, part.stop, {"+", "<<"})
        if len(pieces) > 1:
            return self._of_sum(file, pieces)
        first = tokens[part.start]
        if first.kind == "text":
            return self._of_literal(file, part)
        if first.value in ("(", "{") and closing.get(part.start) == part.stop - 1:
            return self._texts(file, range(part.start + 1, part.stop - 1))
        names = [i for i in part if tokens[i].kind == "name"]
        if not names:
            return []
        if len(part) == 1:
            return self._of_name(file, part.start)
        # [...::]function(arguments)[.arg(argument) ...]
        at = names[0]
        while at + 2 < part.stop and tokens[at + 1].value in ("::", ".", "->"):
            at += 2
        if at + 1 < part.stop and tokens[at + 1].value in ("(", "{") and at + 1 in closing:
            arguments = range(at + 2, closing[at + 1])
            if tokens[at].value in _WRAPPERS:
                if not arguments:  # text.c_str()
                    return self._texts(file, range(part.start, part.start + 1))
                inside = self._arguments(file, at + 1)
                if tokens[at].value in ("joined", "string", "shortened", "move"):
                    inside = inside[: None if tokens[at].value == "joined" else 1]
                    return self._texts(file, range(inside[0].start, inside[-1].stop))
                found = self._texts(file, inside[0])
                return [(_ARG.sub(VARIES, text), *rest) for text, *rest in found]
            self._returned_by(file, tokens[at].value)
        return []

    def _of_literal(self, file: _File, part: range) -> List[_Text]:
        token = file.tokens[part.start]
        text = percent(token.value) if self._is_format(file, part) else token.value
        return [(text, file.path, token.line)]

    def _is_format(self, file: _File, part: range) -> bool:
        """Whether a literal is the format of a ROS_...(format, ...)."""
        before = part.start - 1
        for _ in range(4):  # a period, or a name, may come first
            if file.tokens[before].value == "(":
                return bool(_LOG.match(file.tokens[before - 1].value))
            before -= 1
        return False

    def _of_choice(self, file: _File, rest: range) -> List[_Text]:
        """The two texts of `condition ? one : other`."""
        depth, position = 0, rest.start
        while position < rest.stop:
            value = file.tokens[position].value
            if file.tokens[position].kind == "sign" and position in file.closing:
                position = file.closing[position]
            elif value == "?":
                depth += 1
            elif value == ":" and depth == 0:
                one, other = range(rest.start, position), range(position + 1, rest.stop)
                return self._texts(file, one) + self._texts(file, other)
            elif value == ":":
                depth -= 1
            position += 1
        return []

    def _of_sum(self, file: _File, pieces: List[range]) -> List[_Text]:
        texts = [("", file.path, 0)]
        for piece in pieces:
            more = self._texts(file, piece)
            if len(more) > 1 and any(words_in(text) < _OWN_WORDS for text, *_ in more):
                more = self._left_open(more)  # something that is said now and then
            if len(texts) * len(more) > _MOST:
                more = self._left_open(more)
            texts = [
                (a + b, *(at if words_in(a) else other)) for a, *at in texts for b, *other in more
            ]
        return texts

    def _left_open(self, texts: List[_Text]) -> List[_Text]:
        """Texts inside another one that are told apart; there they vary."""
        for text, path, line in texts:
            whole = not text.endswith(("'", "("))
            if whole and words_in(text) >= _OWN_WORDS and is_message(tidy(text)):
                self.found.add(Message(path, line, tidy(text)))
        return [(VARIES, *texts[0][1:])]

    def _of_name(self, file: _File, position: int) -> List[_Text]:
        name, function = file.tokens[position].value, file.around(position)
        places: Iterable[int] = ()
        if function is not None:
            places = self._assignments(file, name, function.body)
        values = [range(at, self._end_of_statement(file, at)) for at in places]
        begun = [value for value in values if file.tokens[value.start - 1].value != "+="]
        if values:
            added = [value for value in values if value not in begun]
            self._waiting += [(file, value) for value in added]
            more = VARIES if added else ""
            texts = [text for value in begun for text in self._texts(file, value)]
            return [(text + more, *rest) for text, *rest in texts]
        outer = [f for f in file.functions if position in f.body and name in f.parameters]
        if outer and outer[0].name not in _NUMBERED:
            self._ask_callers(file, min(outer, key=lambda f: len(f.body)), name)
            return []
        places = self._assignments(file, name, range(len(file.tokens))) if name.isupper() else ()
        values = [range(place, self._end_of_statement(file, place)) for place in places]
        return [text for value in values for text in self._texts(file, value)]

    def _assignments(self, file: _File, name: str, body: range) -> List[int]:
        """Where the values begin that a variable gets."""
        found = []
        for at in body:
            token = file.tokens[at]
            if token.kind == "name" and token.value == name and at + 2 < len(file.tokens):
                following = file.tokens[at + 1].value
                if following in ("=", "+=", "<<"):
                    found.append(at + 2)
                elif following == "[" and file.tokens[at + 2].value == "]":
                    found.append(at + 4)
        return found

    def _returned_by(self, file: _File, name: str) -> None:
        known = self._functions.get(name, [])
        own = [one for one in known if one[0].path == file.path]
        for place, function in own or (known if len(known) <= 3 else []):
            for at in function.body:
                if place.tokens[at].value == "return" and place.around(at) == function:
                    end = self._end_of_statement(place, at + 1)
                    self._waiting.append((place, range(at + 1, end)))

    def _ask_callers(self, file: _File, function: Function, parameter: str) -> None:
        key = (file.path, function.body.start, parameter)
        if key in self._asked:
            return
        self._asked.add(key)
        position = function.parameters.index(parameter)
        stem = file.path.rsplit(".", 1)[0].rsplit("/", 1)[-1]
        calls = self._calls.get(function.name, [])
        declared = sum(1 for _ in self._functions.get(function.name, []))
        for place, at in calls:
            same = place.path.rsplit(".", 1)[0].rsplit("/", 1)[-1] == stem
            arguments = self._arguments(place, at + 1)
            if (same or declared == 1) and len(arguments) > position:
                self._waiting.append((place, arguments[position]))
