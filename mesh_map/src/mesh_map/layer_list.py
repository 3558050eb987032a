"""From a list of layers as users write it to layers that can be computed."""

import logging
import re
from typing import Any, Dict, Mapping, Sequence, Tuple

from mesh_map.errors import MeshMapError, one_line
from mesh_map.layer import BASE_CLASS_TYPE, Layer
from mesh_map.plugins import find_class, scanned_once

_LOG = logging.getLogger("mesh_map")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def make_layers(config: Any) -> Tuple[Dict[str, Layer], Dict[str, str]]:
    """Layers by their names, in the order of the list, and errors (one line each) by their names.

    Entries that cannot be used are logged and left out; of two of one name, the first counts.

    Args:
        config: list of {"name": ..., "type": ..., "params": {...}}; params may be missing.
    """
    layers: Dict[str, Layer] = {}
    errors: Dict[str, str] = {}
    if not isinstance(config, (list, tuple)):
        errors["layers"] = "the list of layers is a %s, not a list" % type(config).__name__
        _LOG.error("%s", errors["layers"])
        return layers, errors
    with scanned_once():
        _make(config, layers, errors)
    return layers, errors


def _make(config: Sequence[Any], layers: Dict[str, Layer], errors: Dict[str, str]) -> None:
    for number, entry in enumerate(config):
        name = "layer %d" % number
        try:
            checked_name, type_name, params = _checked_entry(entry)
            if checked_name in layers or checked_name in errors:
                raise MeshMapError("there are two layers of the name %s" % checked_name)
            name = checked_name
            layers[name] = _made(name, type_name, params)
        except Exception as error:  # a stranger's plugin may fail in any way
            errors[name] = error_line(error)
            log_left_out(name, error)


def error_line(error: BaseException) -> str:
    """One line for users; errors that are not for users are named with their type."""
    if isinstance(error, MeshMapError):
        return str(error)
    return "%s: %s" % (type(error).__name__, one_line(error))


def log_left_out(name: str, error: BaseException) -> None:
    """Says that a layer cannot be used; one without a usable name is "layer N" of the list."""
    failed = "" if isinstance(error, MeshMapError) else "it failed with "
    shown = name if name.startswith("layer ") else "layer " + name
    _LOG.error("%s is left out: %s%s", shown, failed, error_line(error))


def _made(name: str, type_name: str, params: Mapping[str, Any]) -> Layer:
    found = find_class("mesh_map", BASE_CLASS_TYPE, type_name)
    if not issubclass(found, Layer):
        raise MeshMapError("%s is no mesh_map.layer.Layer" % found.__qualname__)
    layer = found(name, params, type_name)
    for warning in layer.warnings:
        _LOG.warning("layer %s: %s", name, warning)
    return layer


def _checked_entry(entry: Any) -> Tuple[str, str, Mapping[str, Any]]:
    """Name, type and parameters of an entry of the list of layers."""
    if not isinstance(entry, Mapping) or not {"name", "type"} <= set(entry):
        raise MeshMapError(
            "an entry of the list of layers is %r" % (entry,), "{name: ..., type: ...} is needed"
        )
    name, type_name, params = entry["name"], entry["type"], entry.get("params") or {}
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise MeshMapError(
            "%r is no name for a layer" % (name,), "letters, digits and _, a letter first"
        )
    if not isinstance(type_name, str):
        raise MeshMapError("the type of layer %s is %r" % (name, type_name), "a string is needed")
    if not isinstance(params, Mapping):
        raise MeshMapError(
            "the parameters of layer %s are %r" % (name, params), "a mapping is needed"
        )
    return name, type_name, params
