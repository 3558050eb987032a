"""The errors and warnings of Python sources, found in their syntax trees.

Where a text arrives that a user reads (an error that is made, a line of a log, a message of a
result) it is followed back: through variables, parameters of helpers (then each caller gives one),
and what functions return.
"""

import ast
import builtins
import re
from typing import Dict, Iterable, List, NamedTuple, Optional, Set, Tuple

from mesh_tools_test.troubleshooting.message import (
    VARIES,
    Message,
    braces,
    is_message,
    percent,
    tidy,
    unique,
    words_in,
)

# Mistakes in code that calls ours: no input, file or parameter causes them.
CONTRACTS = {
    "AssertionError",
    "AttributeError",
    "IndexError",
    "KeyError",
    "NotImplementedError",
    "StopIteration",
    "TypeError",
}
_EXCEPTIONS = {
    name
    for name, value in vars(builtins).items()
    if isinstance(value, type) and issubclass(value, BaseException)
}
_EXCEPTIONS |= {
    "ArgumentTypeError",
    "DeserializationError",
    "ROSException",
    "ROSInterruptException",
    "SerializationError",
    "ServiceException",
}
_LOG = re.compile(r"log(warn|err|fatal)\w*$")
_LOGGER_METHODS = {"warning", "warn", "error", "critical", "exception"}
_LOGGER = re.compile(r"log|parser|warnings", re.IGNORECASE)
_TEXT_FIELDS = ("message", "what")
_BAD_NEWS = re.compile(
    r"^_?(\w+_)?(complaints?|difference|failure|fault|guidance|notes|obstruction|problems?|refusal"
    r"|trouble|unusable|why|why_not)$"
)
_WRAPPERS = {"one_line", "str", "tuple", "list", "sorted", "set", "reversed", "shortened"}
_MOST = 12  # alternatives of one text: more of them are told apart, not multiplied
_OWN_WORDS = 3  # a text with fewer of its own is only a frame
_OWN_SENTENCE = 4  # what stands inside another text is told apart if it has so many words


class _Module(NamedTuple):
    path: str
    tree: ast.Module


class _Scope(NamedTuple):
    """Where an expression stands: its module, and the functions around it, innermost first."""

    module: _Module
    functions: Tuple[ast.AST, ...]
    owner: Optional[str]


_LEAVES = (ast.Name, ast.Constant, ast.expr_context, ast.operator, ast.alias, ast.arguments)
_ARRIVALS = (ast.Call, ast.Return, ast.Assign, ast.Tuple)
_Text = Tuple[str, str, int]  # with the place of its first words


def python_messages(sources: Dict[str, str]) -> List[Message]:
    """All messages of some sources; sources: path -> text."""
    gatherer = _Gatherer(_Module(path, ast.parse(text)) for path, text in sources.items())
    return unique(gatherer.found)


class _Gatherer:
    def __init__(self, modules: Iterable[_Module]) -> None:
        self.found: Set[Message] = set()
        self._functions: Dict[str, List[Tuple[ast.AST, _Scope]]] = {}
        self._calls: Dict[str, List[Tuple[ast.Call, _Scope]]] = {}
        self._classes: Dict[str, List[ast.ClassDef]] = {}
        self._constants: Dict[str, List[Tuple[_Scope, ast.expr]]] = {}
        self._assigned: Dict[int, Dict[str, List[ast.expr]]] = {}
        self._seen: Set[Tuple[int, object]] = set()
        self._active: Set[int] = set()
        self._least = 2  # words of what is being followed
        self._waiting: List[Tuple[ast.AST, _Scope, int]] = []
        nodes: List[Tuple[ast.AST, _Scope]] = []
        for module in modules:
            self._index(module.tree, _Scope(module, (), None), nodes)
        self._exceptions = self._derived(_EXCEPTIONS)
        self._records = self._with_message()
        for node, scope in nodes:
            for expression in self._arrivals(node, scope):
                self._later(expression, scope)
        while self._waiting:
            self._follow(*self._waiting.pop())

    # What there is.

    def _index(self, node: ast.AST, scope: _Scope, nodes: List[Tuple[ast.AST, _Scope]]) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, _LEAVES):
                continue
            if isinstance(child, _ARRIVALS):
                nodes.append((child, scope))
            inner = scope
            if isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef)):
                self._functions.setdefault(child.name, []).append((child, scope))
                inner = scope._replace(functions=(child,) + scope.functions)
            elif isinstance(child, ast.ClassDef):
                self._classes.setdefault(child.name, []).append(child)
                inner = scope._replace(owner=child.name)
            elif isinstance(child, ast.Call):
                self._calls.setdefault(_name(child.func), []).append((child, scope))
            elif isinstance(child, ast.Assign) and not scope.functions:
                for target in child.targets:
                    if isinstance(target, ast.Name):
                        self._constants.setdefault(target.id, []).append((scope, child.value))
            self._index(child, inner, nodes)

    def _derived(self, names: Set[str]) -> Set[str]:
        while True:
            more = {
                name
                for name, classes in self._classes.items()
                if any(_name(base) in names for one in classes for base in one.bases)
            }
            if more <= names:
                return names
            names = names | more

    def _with_message(self) -> Dict[str, List[str]]:
        """Class -> its fields, or parameters, of the classes that are made with a message."""
        found = {}
        for name, classes in self._classes.items():
            for one in classes:
                fields = [
                    item.target.id
                    for item in one.body
                    if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name)
                ]
                for item in one.body:
                    if isinstance(item, ast.FunctionDef) and item.name == "__init__":
                        fields = [argument.arg for argument in item.args.args[1:]]
                text = next((field for field in fields if field in _TEXT_FIELDS), None)
                if text is not None:
                    found[name] = ["message" if field == text else field for field in fields]
        for name in self._exceptions:
            bases = [_name(base) for one in self._classes.get(name, ()) for base in one.bases]
            for base in bases:
                if name not in found and base in found:
                    found[name] = found[base]
        return found

    # Where a text arrives.

    def _arrivals(self, node: ast.AST, scope: _Scope) -> List[ast.expr]:
        if isinstance(node, ast.Call):
            return self._in_call(node)
        if isinstance(node, ast.Return) and node.value is not None and scope.functions:
            return [node.value] if _BAD_NEWS.match(scope.functions[0].name) else []
        if isinstance(node, ast.Assign):
            if any(_BAD_NEWS.match(_name(target)) for target in node.targets):
                return [node.value]
            if any(isinstance(t, ast.Attribute) and t.attr == "message" for t in node.targets):
                return [node.value]
        if isinstance(node, ast.Tuple) and any(_is_bad_level(part) for part in node.elts):
            return [part for part in node.elts if not _is_bad_level(part)]
        return []

    def _in_call(self, call: ast.Call) -> List[ast.expr]:
        name = _name(call.func)
        given = {key.arg: key.value for key in call.keywords}
        if name in CONTRACTS:
            return []
        if name in self._records:
            bound = _bind(call, self._records[name])
            others = [value for key, value in bound.items() if key != "message"]
            if any(_is_success(value) for value in others):
                return []
            return [bound["message"]] if "message" in bound else []
        if name in self._exceptions:
            numbered = isinstance(getattr(builtins, name, None), type) and len(call.args) > 1
            position = 1 if numbered and issubclass(getattr(builtins, name), OSError) else 0
            return call.args[position : position + 1]
        if isinstance(call.func, ast.Attribute):
            receiver = _dotted(call.func.value)
            if _LOG.match(name):
                return [_formatted(call.args[1 if "throttle" in name else 0 :])]
            if name in _LOGGER_METHODS and _LOGGER.search(receiver):
                return [_formatted(call.args)]
            if name == "_log" and call.args and isinstance(call.args[0], ast.JoinedStr):
                return call.args[:1]
            if name == "append" and _BAD_NEWS.match(receiver.split(".")[-1]):
                return call.args
        if name == "print" and _dotted(given.get("file")) == "sys.stderr":
            return call.args[:1]
        if any(_is_bad_level(value) for value in call.args):
            return [value for value in call.args if not _is_bad_level(value)]
        if "message" in given and not any(_is_success(value) for value in given.values()):
            return [given["message"]]
        return []

    # Where it comes from.

    def _follow(self, expression: ast.expr, scope: _Scope, least: int) -> None:
        self._least = least
        for text, path, line in self._texts(expression, scope):
            text = tidy(text)
            if words_in(text) >= least and is_message(text):
                self.found.add(Message(path, line, text))

    def _later(self, expression: Optional[ast.AST], scope: _Scope, least: int = 2) -> None:
        key = (id(expression), least)
        if expression is not None and key not in self._seen:
            self._seen.add(key)
            self._waiting.append((expression, scope, least))

    def _texts(self, node: ast.AST, scope: _Scope) -> List[_Text]:
        """The texts that an expression may have, each with its line; what is not known varies."""
        unknown = [(VARIES, scope.module.path, getattr(node, "lineno", 0))]
        if id(node) in self._active:
            return unknown
        self._active.add(id(node))
        try:
            return self._inner_texts(node, scope) or unknown
        finally:
            self._active.remove(id(node))

    def _inner_texts(self, node: ast.AST, scope: _Scope) -> List[_Text]:
        path = scope.module.path
        if isinstance(node, ast.Constant):
            known = node.value if isinstance(node.value, str) else VARIES
            return [("" if node.value is None else known, path, node.lineno)]
        if isinstance(node, ast.JoinedStr):
            parts = [p.value if isinstance(p, ast.Constant) else VARIES for p in node.values]
            inside = [p.value for p in node.values if isinstance(p, ast.FormattedValue)]
            return self._framed([("".join(map(str, parts)), path, node.lineno)], inside, scope)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mod):
            frames = [(percent(text), *at) for text, *at in self._texts(node.left, scope)]
            inside = node.right.elts if isinstance(node.right, ast.Tuple) else [node.right]
            return self._framed(frames, inside, scope)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            return self._sum(self._texts(node.left, scope), self._texts(node.right, scope))
        if isinstance(node, ast.IfExp):
            return self._texts(node.body, scope) + self._texts(node.orelse, scope)
        if isinstance(node, ast.BoolOp):
            return self._all(node.values, scope)
        if isinstance(node, (ast.List, ast.Tuple, ast.Set)):
            return self._all(node.elts, scope)
        if isinstance(node, ast.Dict):
            return self._all(node.values, scope)
        if isinstance(node, (ast.Starred, ast.NamedExpr, ast.Subscript, ast.Await)):
            return self._texts(node.value, scope)
        if isinstance(node, (ast.GeneratorExp, ast.ListComp, ast.SetComp)):
            return self._texts(node.elt, scope)
        if isinstance(node, ast.Name):
            return self._of_name(node, scope)
        if isinstance(node, ast.Call):
            return self._of_call(node, scope)
        return []

    def _all(self, nodes: Iterable[ast.AST], scope: _Scope) -> List[_Text]:
        return [text for node in nodes for text in self._texts(node, scope)]

    def _framed(
        self, frames: List[_Text], inside: Iterable[ast.expr], scope: _Scope
    ) -> List[_Text]:
        framed = any(words_in(text) < _OWN_WORDS for text, *_ in frames)
        for value in inside:
            self._later(value, scope, self._least if framed else _OWN_SENTENCE)
        return frames

    def _sum(self, left: List[_Text], right: List[_Text]) -> List[_Text]:
        left, right = self._settled(left), self._settled(right)
        if len(left) * len(right) > _MOST:
            return left + right
        return [(a + b, *(at if words_in(a) else other)) for a, *at in left for b, *other in right]

    def _settled(self, texts: List[_Text]) -> List[_Text]:
        """Part of a text: what is said now and then varies, and is told apart."""
        if len(texts) < 2 or all(words_in(text) >= _OWN_WORDS for text, *_ in texts):
            return texts
        for text, path, line in texts:
            if words_in(text) >= _OWN_WORDS and is_message(tidy(text)):
                self.found.add(Message(path, line, tidy(text)))
        return [(VARIES, *texts[0][1:])]

    def _of_name(self, node: ast.Name, scope: _Scope) -> List[_Text]:
        for depth, function in enumerate(scope.functions):
            values = self._assigned_in(function).get(node.id)
            inner = scope._replace(functions=scope.functions[depth:])
            if node.id in _parameters(function):
                self._ask_callers(function, node.id, inner)
                return self._all(values or [], inner)
            if values:
                return self._all(values, inner)
        places = self._constants.get(node.id, [])
        own = [place for place in places if place[0].module.path == scope.module.path]
        if own or (len(places) == 1 and node.id.isupper()):
            around, value = (own or places)[-1]
            return self._texts(value, around)
        return []

    def _assigned_in(self, function: ast.AST) -> Dict[str, List[ast.expr]]:
        if id(function) not in self._assigned:
            found: Dict[str, List[ast.expr]] = {}
            for node in ast.walk(function):
                if isinstance(node, ast.Assign):
                    for target in node.targets:
                        _pair(target, node.value, found)
                elif isinstance(node, (ast.AnnAssign, ast.AugAssign, ast.NamedExpr)):
                    if node.value is not None:
                        _pair(node.target, node.value, found)
                elif isinstance(node, (ast.For, ast.comprehension)):
                    rows = isinstance(node.iter, (ast.Tuple, ast.List))
                    for row in node.iter.elts if rows else [node.iter]:
                        _pair(node.target, row, found)
                elif isinstance(node, ast.Call) and _name(node.func) in ("append", "extend"):
                    if isinstance(node.func.value, ast.Name):
                        found.setdefault(node.func.value.id, []).extend(node.args)
            self._assigned[id(function)] = found
        return self._assigned[id(function)]

    def _of_call(self, call: ast.Call, scope: _Scope) -> List[_Text]:
        name = _name(call.func)
        if name in self._exceptions or name in self._records:
            return []
        if isinstance(call.func, ast.Attribute) and name == "format":
            frames = self._texts(call.func.value, scope)
            inside = call.args + [key.value for key in call.keywords]
            return self._framed([(braces(text), *at) for text, *at in frames], inside, scope)
        if isinstance(call.func, ast.Attribute) and name == "join" and call.args:
            return self._texts(call.args[0], scope)
        if isinstance(call.func, ast.Attribute) and name == "get" and call.args:
            if isinstance(call.func.value, ast.Name) and call.func.value.id.strip("_").isupper():
                return self._all([call.func.value] + call.args[1:], scope)
        if name in _WRAPPERS and call.args:
            return self._texts(call.args[0], scope)
        for function, around in self._named(name, scope):
            key = (id(function), self._least)
            if key in self._seen:
                continue
            self._seen.add(key)
            inner = around._replace(functions=(function,) + around.functions)
            for node in _own_nodes(function):
                if isinstance(node, (ast.Return, ast.Yield)):
                    self._later(node.value, inner, self._least)
        return []

    def _named(self, name: str, scope: _Scope) -> List[Tuple[ast.AST, _Scope]]:
        known = self._functions.get(name, [])
        own = [one for one in known if one[1].module.path == scope.module.path]
        return own or (known if len(known) <= 3 else [])

    def _ask_callers(self, function: ast.AST, parameter: str, scope: _Scope) -> None:
        """A helper hands on what its callers say."""
        key = (id(function), (parameter, self._least))
        if key in self._seen or parameter in ("self", "cls"):
            return
        self._seen.add(key)
        name = function.name
        names = [argument.arg for argument in function.args.args]
        if names[:1] in (["self"], ["cls"]):
            names = names[1:]
        rest = function.args.vararg
        path = scope.module.path
        if name == "__init__":
            name = scope.owner or name
        elsewhere = not name.startswith("_")
        for call, place in self._calls.get(name, []):
            if elsewhere or place.module.path == path:
                value = _bind(call, names).get(parameter)
                self._later(value, place, self._least)
                if rest is not None and rest.arg == parameter:
                    for value in call.args[len(names) :]:
                        self._later(value, place, self._least)


def _name(node: Optional[ast.AST]) -> str:
    if isinstance(node, ast.Name):
        return node.id
    return node.attr if isinstance(node, ast.Attribute) else ""


def _dotted(node: Optional[ast.AST]) -> str:
    if isinstance(node, ast.Attribute):
        return _dotted(node.value) + "." + node.attr
    return _dotted(node.func) if isinstance(node, ast.Call) else _name(node)


def _formatted(arguments: List[ast.expr]) -> ast.expr:
    """What a logger makes of its arguments."""
    if len(arguments) < 2:
        return arguments[0] if arguments else ast.Constant("", lineno=0)
    inside = ast.Tuple(arguments[1:], ast.Load())
    return ast.BinOp(arguments[0], ast.Mod(), inside, lineno=arguments[0].lineno)


def _is_bad_level(node: ast.AST) -> bool:
    return _name(node) in ("WARN", "ERROR")


def _is_success(node: ast.AST) -> bool:
    return _name(node) == "SUCCESS" or (isinstance(node, ast.Constant) and node.value is True)


def _parameters(function: ast.AST) -> List[str]:
    arguments = function.args
    names = [argument.arg for argument in arguments.args + arguments.kwonlyargs]
    return names + ([arguments.vararg.arg] if arguments.vararg else [])


def _bind(call: ast.Call, names: List[str]) -> Dict[str, ast.expr]:
    bound = {key.arg: key.value for key in call.keywords if key.arg}
    for name, value in zip(names, call.args):
        if isinstance(value, ast.Starred):
            break
        bound[name] = value
    return bound


def _pair(target: ast.AST, value: ast.expr, found: Dict[str, List[ast.expr]]) -> None:
    if isinstance(target, ast.Name):
        found.setdefault(target.id, []).append(value)
    elif isinstance(target, (ast.Tuple, ast.List)):
        same = isinstance(value, ast.Tuple) and len(value.elts) == len(target.elts)
        for index, part in enumerate(target.elts):
            _pair(part, value.elts[index] if same else value, found)


def _own_nodes(function: ast.AST) -> Iterable[ast.AST]:
    """The nodes of a function without those of the functions inside it."""
    waiting = list(ast.iter_child_nodes(function))
    while waiting:
        node = waiting.pop()
        if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            yield node
            waiting.extend(ast.iter_child_nodes(node))
