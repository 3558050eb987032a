"""Names of topics, services, actions and parameters that Python sources use, found in their syntax.

What gives a name to ROS are calls: of rospy (`rospy.Publisher("odom", ...)`), and of functions and
classes of ours that hand a name on (`LatchedTopics(prefix + "layer_info", ...)`), which are found
by themselves. What is not known of a name stands in it as `<...>`.
"""
import ast
from pathlib import Path
from typing import Dict, Iterable, Iterator, List, NamedTuple, Optional, Set, Tuple

TOPIC, SERVICE, ACTION, PARAMETER = "topic", "service", "action", "parameter"
_ROS = {
    "Publisher": TOPIC,
    "Subscriber": TOPIC,
    "Service": SERVICE,
    "ActionServer": ACTION,
    "get_param": PARAMETER,
}
_OF_LIBRARIES = {  # what libraries and helpers call something by a name of their own
    "TransformBroadcaster": ("/tf",),
    "StaticTransformBroadcaster": ("/tf_static",),
    "TransformListener": ("/tf", "/tf_static"),
    "Diagnostics": ("/diagnostics",),
}
_DICTIONARIES = ("parameters", "given")  # what holds all parameters of a node
_SAME = ("resolve_name", "str")  # calls that leave a name as it is
_DEPTH = 8


class Use(NamedTuple):
    """A name, and where it is used."""

    kind: str
    name: str
    path: Path
    line: int


class _Scope:
    """What names may stand for: expressions, or the k-th argument of a function."""

    def __init__(self, outer: Optional["_Scope"] = None):
        self.outer = outer
        self.values: Dict[str, List[ast.expr]] = {}
        self.arguments: Dict[str, Tuple[str, int]] = {}  # name -> (callable, position)

    def find(self, name: str) -> List[ast.expr]:
        if name in self.values:
            return self.values[name]
        return [] if name in self.arguments or self.outer is None else self.outer.find(name)

    def argument(self, name: str) -> Optional[Tuple[str, int]]:
        if name in self.values:
            return None
        if name in self.arguments:
            return self.arguments[name]
        return self.outer.argument(name) if self.outer else None

    def bind(self, target: ast.expr, value: ast.expr) -> None:
        """A target of an assignment, also `self.x`."""
        if isinstance(target, ast.Tuple) and isinstance(value, (ast.Tuple, ast.List)):
            for one, part in zip(target.elts, value.elts):
                self.bind(one, part)
        elif _key(target):
            self.values.setdefault(_key(target), []).append(value)

    def bind_each(self, target: ast.expr, values: ast.expr) -> None:
        """The target of a loop over what is written out, there or in a constant."""
        if isinstance(values, ast.Name):
            for found in self.find(values.id):
                if not isinstance(found, ast.Name):
                    self.bind_each(target, found)
        elif isinstance(values, (ast.Tuple, ast.List, ast.Set)):
            for one in values.elts:
                self.bind(target, one)
        elif isinstance(values, ast.Dict):
            for one in values.keys:
                if one is not None:
                    self.bind(target, one)
        elif isinstance(values, ast.Call) and isinstance(values.func, ast.Attribute):
            whole = values.func.value
            found = self.find(whole.id) if isinstance(whole, ast.Name) else [whole]
            for one in found:
                if isinstance(one, ast.Dict):
                    self._bind_items(target, values.func.attr, one)

    def _bind_items(self, target: ast.expr, method: str, whole: ast.Dict) -> None:
        for key, value in zip(whole.keys, whole.values):
            if key is None:
                continue
            if method == "items":
                self.bind(target, ast.Tuple([key, value], ast.Load()))
            elif method == "values":
                self.bind(target, value)
            elif method == "keys":
                self.bind(target, key)


def _key(node: ast.AST) -> str:
    """What a value is kept under: members of objects are no variables."""
    return "." + node.attr if isinstance(node, ast.Attribute) else _called(node)


def _called(node: ast.AST) -> str:
    """The last part of a dotted name: "name" of `name` and of `self.name`."""
    if isinstance(node, ast.Name):
        return node.id
    return node.attr if isinstance(node, ast.Attribute) else ""


class _Call(NamedTuple):
    callee: str
    node: ast.Call
    scope: _Scope
    path: Path


class NameGatherer:
    """Looks through sources.

    :param paths: of all that may hand a name on
    """

    def __init__(self, paths: Iterable[Path]):
        self._calls: List[_Call] = []
        trees = {path: ast.parse(path.read_text(encoding="utf-8"), str(path)) for path in paths}
        self._constants = _constants(trees.values())
        for path, tree in trees.items():
            self._visit(tree.body, _Scope(self._constants), path, "", "")
        self._takers = {(name, 0): kind for name, kind in _ROS.items()}
        while self._pass_on():
            pass

    def uses(self) -> List[Use]:
        """All names that are given to ROS, in the order of the sources."""
        found = []
        for call in self._calls:
            for name in _OF_LIBRARIES.get(call.callee, ()):
                found.append(Use(TOPIC, name, call.path, call.node.lineno))
            for kind, argument in self._names(call):
                if isinstance(argument, ast.Name) and call.scope.argument(argument.id):
                    continue  # whoever calls this gives the name
                for name in sorted(set(self._texts(argument, call.scope, _DEPTH))):
                    found.append(Use(kind, name, call.path, argument.lineno))
        return found

    def _names(self, call: _Call) -> Iterator[Tuple[str, ast.expr]]:
        if call.callee == "get" and _called(call.node.func.value) in _DICTIONARIES:
            yield PARAMETER, call.node.args[0]
        for (callee, position), kind in self._takers.items():
            if callee == call.callee and position < len(call.node.args):
                yield kind, _bare(call.node.args[position])

    def _pass_on(self) -> bool:
        """Whether there are more that hand a name on than were known."""
        before = len(self._takers)
        for call in self._calls:
            for kind, argument in list(self._names(call)):
                taker = isinstance(argument, ast.Name) and call.scope.argument(argument.id)
                if taker:
                    self._takers.setdefault(taker, kind)
        return len(self._takers) > before

    def _visit(self, nodes, scope: _Scope, path: Path, class_name: str, base: str) -> None:
        for node in nodes:
            if isinstance(node, ast.ClassDef):
                inner = _Scope(scope)
                for one in ast.walk(node):  # what its members may be
                    if isinstance(one, ast.Assign) and isinstance(one.targets[0], ast.Attribute):
                        inner.bind(one.targets[0], one.value)
                bases = [_called(one) for one in node.bases]
                self._visit(node.body, inner, path, node.name, bases[0] if bases else "")
            elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                self._visit(
                    node.body, _of_function(node, scope, class_name, path), path, class_name, base
                )
            else:
                self._look(node, scope, path, class_name, base)

    def _look(self, node: ast.AST, scope: _Scope, path: Path, class_name: str, base: str) -> None:
        """Calls in an expression or a statement, and what it says of names."""
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            self._visit([node], scope, path, class_name, base)
            return
        if isinstance(node, ast.Assign):
            for target in node.targets:
                scope.bind(target, node.value)
        elif isinstance(node, ast.For):
            scope.bind_each(node.target, node.iter)
        elif isinstance(node, (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)):
            scope = _Scope(scope)
            for loop in node.generators:
                for one in ast.walk(loop.target):
                    scope.values.setdefault(_called(one), [])  # hides those around
                scope.bind_each(loop.target, loop.iter)
        elif isinstance(node, ast.Call):
            callee = _called(node.func)
            if callee == "__init__" and isinstance(node.func, ast.Attribute):
                callee = base  # super().__init__(...)
            self._calls.append(_Call(_of_file(callee, path), node, scope, path))
        for child in ast.iter_child_nodes(node):
            self._look(child, scope, path, class_name, base)

    def _texts(self, node: ast.expr, scope: _Scope, depth: int) -> List[str]:
        """All texts that an expression may be."""
        node = _bare(node)
        if isinstance(node, ast.Constant):
            return [node.value] if isinstance(node.value, str) else []
        if isinstance(node, ast.JoinedStr):
            return self._joined(node.values, scope, depth)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            return self._joined([node.left, node.right], scope, depth)
        if isinstance(node, ast.FormattedValue):
            return self._texts(node.value, scope, depth)
        if isinstance(node, ast.Subscript):
            return ["<%s>" % text for text in self._texts(node.slice, scope, depth)] or ["<>"]
        if isinstance(node, ast.IfExp):
            both = (node.body, node.orelse)
            return [text for one in both for text in self._texts(one, scope, depth)]
        name, found = _called(node), []  # type: str, List[ast.expr]
        if name and depth:
            found = scope.find(_key(node))
        texts = [text for one in found for text in self._texts(one, scope, depth - 1)]
        return texts or ["<%s>" % name]

    def _joined(self, parts: List[ast.expr], scope: _Scope, depth: int) -> List[str]:
        texts = [""]
        for part in parts:
            texts = [one + more for one in texts for more in self._texts(part, scope, depth)]
        return texts


def _bare(node: ast.expr) -> ast.expr:
    """Without calls that leave a name as it is."""
    while isinstance(node, ast.Call) and _called(node.func) in _SAME and node.args:
        node = node.args[0]
    return node


def _of_file(name: str, path: Path) -> str:
    """The name of a callable; a private one is known in its file alone."""
    return "%s %s" % (path, name) if name.startswith("_") else name


def _of_function(node: ast.FunctionDef, outer: _Scope, class_name: str, path: Path) -> _Scope:
    scope, names = _Scope(outer), [one.arg for one in node.args.args]
    if class_name and names[:1] in (["self"], ["cls"]):
        names = names[1:]
    callable_name = _of_file(class_name if node.name == "__init__" else node.name, path)
    scope.arguments = {name: (callable_name, position) for position, name in enumerate(names)}
    return scope


def _constants(trees: Iterable[ast.Module]) -> _Scope:
    """Names in capitals at the top of any source: others import them by that name."""
    scope = _Scope()
    for tree in trees:
        for node in tree.body:
            if isinstance(node, ast.Assign) and len(node.targets) == 1:
                target = node.targets[0]
                if isinstance(target, ast.Name) and target.id.isupper():
                    if not target.id.startswith("_"):
                        scope.bind(target, node.value)
    return scope


def python_files(folder: Path) -> Set[Path]:
    """All modules below a folder."""
    return set(folder.glob("**/*.py"))
