"""Whether a value is of the type that an annotation names."""
import collections.abc
import functools
import typing
from typing import Any, Mapping


@functools.lru_cache(maxsize=None)
def hints_of(thing: Any) -> Mapping[str, Any]:
    """The annotations of a class or function: name -> type, "return" among them."""
    return typing.get_type_hints(thing)


def fits(value: Any, hint: Any) -> bool:
    """True if the value is of the annotated type, all the way down; None is a hint nothing fits.

    Known: Any, Union, Optional, list, tuple, dict, frozenset and their kin, classes; a bool is no
    int, an int is a float.
    """
    if hint is Any:
        return True
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if not inner or any(isinstance(one, typing.TypeVar) for one in inner):
        origin, hint = None, origin or hint  # a bare Dict
    if origin is typing.Union:
        return any(fits(value, one) for one in inner)
    if origin is tuple:
        if not isinstance(value, tuple) or inner[1:] != (...,) and len(value) != len(inner):
            return False
        wanted = [inner[0]] * len(value) if inner[1:] == (...,) else inner
        return all(map(fits, value, wanted))
    if origin in (dict, collections.abc.Mapping):
        return isinstance(value, dict) and all(
            fits(key, inner[0]) and fits(item, inner[1]) for key, item in value.items()
        )
    if origin in (list, frozenset, collections.abc.Sequence):
        container = list if origin is collections.abc.Sequence else origin
        return isinstance(value, container) and all(fits(item, inner[0]) for item in value)
    if hint in (int, float, bool):
        return type(value) is hint or hint is float and type(value) is int
    return isinstance(hint, type) and isinstance(value, hint)
