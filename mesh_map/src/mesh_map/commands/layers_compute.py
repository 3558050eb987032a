"""mesh_tool layers compute: cost layers computed and stored as the node mesh_map does it."""

import argparse
import difflib
import re
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import yaml
from mesh_msgs_hdf5.commands._common import add_output_options, add_part, say
from mesh_msgs_hdf5.commands.info import values_text
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.commands.summary import layer_summary
from mesh_msgs_hdf5.formats.any_mesh import is_map_file
from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.base.errors import MeshMapError
from mesh_map.base.plugins import find_class, plugin_names, scanned_once
from mesh_map.commands.map_errors import as_map_errors
from mesh_map.costs.layer import BASE_CLASS_TYPE
from mesh_map.io.map_parameters import map_parameters, parameters_in_file
from mesh_map.io.map_source import MapSource
from mesh_map.map.coarse_edges import coarse_remark
from mesh_map.map.mesh_map import MeshMap

NAME = "layers compute"
HELP = "compute cost layers and store them in a map file; mesh_map's node takes them from there"
EXAMPLE = "mesh_tool layers compute garden.h5 height_diff --set height_diff.radius=0.3"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="the map file")
    text = "a layer, such as height_diff or inflation=mesh_layers/InflationLayer, or one of "
    text += "--config (before the options)"
    parser.add_argument("layers", metavar="NAME[=TYPE]", nargs="*", help=text)
    text = (
        "layers with their parameters, as the node mesh_map has them; all, or those that are named"
    )
    parser.add_argument("--config", metavar="FILE.yaml", help=text)
    text = "a parameter of a layer, such as height_diff.radius=0.3; a value is YAML"
    parser.add_argument("--set", action="append", default=[], metavar="NAME.PARAM=VALUE", help=text)
    add_part(parser)
    add_output_options(parser, "say nothing")


def run(arguments: argparse.Namespace) -> int:
    if not (arguments.layers or arguments.config):
        text = "no layer is named"
        raise MapFileError("layer", arguments.file, text, "such as height_diff, or --config FILE")
    if not is_map_file(arguments.file):
        text = "it is no map file, so layers cannot be stored in it"
        raise MapFileError("format", arguments.file, text, "mesh_tool import IN OUT.h5")
    wanted = WantedLayers(arguments.layers, arguments.config, arguments.set)
    with ProgressLine(arguments.quiet) as progress:
        entries, notes = store_layers(arguments.file, arguments.part, wanted, progress)
    value = {"path": arguments.file, "layers": entries, "notes": notes}
    lines = ["  note: " + note for note in notes]
    for entry in entries:
        lines.append(values_text(entry) + ("" if entry["is_new"] else " (it was there already)"))
    say(arguments, value, lines)
    return 0


class WantedLayers(NamedTuple):
    """names: of layers, each perhaps with =TYPE; config: a YAML file, or None; values: of --set."""

    names: Sequence[str]
    config: Optional[str] = None
    values: Sequence[str] = ()

    def check(self, path: str) -> None:
        """Refuse what is no layer or parameter, before there is a map at this path.

        Raises:
            MapFileError: what is wrong.
        """
        with as_map_errors(path), scanned_once():
            values, _ = _configuration(path, None, self)
            _check_set(self.values, map_parameters(values).layers)


def store_layers(
    path: str, part: Optional[str], wanted: WantedLayers, progress: ProgressLine
) -> Tuple[List[Dict[str, Any]], List[str]]:
    """Compute layers and store them in a map file.

    Returns:
        an entry for each layer, as `mesh_tool info` has them, with is_new; and notes.
    Raises:
        MapFileError: one has no result, or cannot be stored; then none of them is.
    """
    with as_map_errors(path) as notes:

        def tell(share: float, what: str) -> None:
            progress.stage(what)
            progress.part(share)

        progress.stage("reading " + path)
        with scanned_once():
            values, names = _configuration(path, part, wanted)
            parameters = map_parameters(values)
            _check_set(wanted.values, parameters.layers)
            source = MapSource(parameters.mesh_file, parameters.mesh_part, parameters.origin)
            mesh_map = source.make_map(parameters.global_frame, **parameters.geometry)
            mesh_map.compute_layers(parameters.layers, tell, source.stored_costs)
        names = names or list(mesh_map.layers)
        notes += _checked(path, mesh_map, names)
        present = [name for name in names if source.is_stored(mesh_map.layers[name])]
        missing = {name: mesh_map.layers[name] for name in names if name not in present}
        done = []
        if missing:
            progress.stage("saving " + path)
            done = source.save_layers(missing)
        unstored = [name for name in missing if name not in done]
        if unstored:
            notes.append("not stored: " + ", ".join(unstored) + ", which nobody could use again")
    file = IsolatedMapFile(path, part)
    entries = [
        dict(layer_summary(file, name), is_new=name in done)
        for name in names
        if name in done + present
    ]
    return entries, notes


def _checked(path: str, mesh_map: MeshMap, names: List[str]) -> List[str]:
    """Notes on layers that are left out, and on edges that are too long; an error if a layer that
    is to be stored, or is required, has no result."""
    failed = mesh_map.layer_errors
    wrong = [name for name in names if name not in mesh_map.layers]
    if wrong or mesh_map.fault:
        text = mesh_map.fault or "; ".join(
            "layer %s: %s" % (n, failed.get(n, "it is left out")) for n in wrong
        )
        raise MapFileError("layer", path, text, "nothing was stored")
    alone = [
        name
        for name in names
        if mesh_map.layers[name].READS_LAYERS and not mesh_map.layer_set.reads[name]
    ]
    if alone:
        text = "layer %s reads other layers, but none is there" % ", ".join(alone)
        hint = "nothing was stored; name those, too, before it, such as height_diff %s"
        raise MapFileError("layer", path, text, hint % alone[0])
    remark = coarse_remark(mesh_map, {})
    return [remark] if remark else []


def _check_set(texts: Sequence[str], layers: Any) -> None:
    """Refuse names of parameters that the layers do not have, before anything is computed."""
    types = {each["name"]: each.get("type") for each in layers if isinstance(each, Mapping)}
    for text in texts:
        name, _, parameter = text.partition("=")[0].partition(".")
        if not isinstance(types.get(name), str):
            continue  # which is told where the layers are made
        found = find_class("mesh_map", BASE_CLASS_TYPE, types[name])
        known = sorted(each.name for each in found.all_parameters())
        if parameter not in known:
            close = difflib.get_close_matches(parameter, known, 3, 0.5)
            raise MeshMapError(
                "--set %s: layer %s has no parameter %s" % (text, name, parameter),
                ("is %s meant? " % " or ".join(close) if close else "")
                + "it has: %s" % ", ".join(known),
            )


def _configuration(
    path: str, part: Optional[str], wanted: WantedLayers
) -> Tuple[Dict[str, Any], List[str]]:
    """The parameters as a node has them, and the names of the layers that are to be stored; none
    for all."""
    values: Dict[str, Any] = {"layers": []}
    if wanted.config is not None:
        values = dict(parameters_in_file(wanted.config))
    listed = _names_in(values["layers"])
    names = []
    for text in wanted.names:
        name, _, type_name = text.partition("=")
        if name in listed and not type_name:
            names.append(name)
        elif wanted.config is not None:
            known = ", ".join(listed) or "none"
            raise MeshMapError("%s has no layer %s" % (wanted.config, name), "it has: " + known)
        else:
            values["layers"].append({"name": name, "type": type_name or _type_of(name)})
            names.append(name)
    for text in wanted.values:
        _set(values, text)
    values["mesh_file"], values["mesh_part"] = path, part or ""
    return values, names


def _names_in(layers: Any) -> List[str]:
    entries = layers if isinstance(layers, list) else []
    names = [entry.get("name") if isinstance(entry, Mapping) else entry for entry in entries]
    return [name for name in names if isinstance(name, str)]


def _type_of(name: str) -> str:
    """The plugin that is meant by a name: height_diff is mesh_layers/HeightDiffLayer."""
    known = plugin_names("mesh_map", BASE_CLASS_TYPE)
    short = {re.sub(r"(?<!^)(?=[A-Z])", "_", each.split("/")[-1]).lower(): each for each in known}
    found = short.get(name + "_layer")
    if found is None:
        names = sorted(each[: -len("_layer")] for each in short if each.endswith("_layer"))
        raise MeshMapError(
            "there is no type of layers called %s" % name,
            "known: %s; others as %s=PACKAGE/TYPE" % (", ".join(names), name),
        )
    return found


def _set(values: Dict[str, Any], text: str) -> None:
    """Put what --set says into the parameters of a layer."""
    place, sign, written = text.partition("=")
    name, _, parameter = place.partition(".")
    if not (sign and name and parameter):
        raise MeshMapError("--set %s: it is no NAME.PARAM=VALUE" % text)
    if name not in _names_in(values["layers"]):
        raise MeshMapError("--set %s: there is no layer %s" % (text, name))
    try:
        value = yaml.safe_load(written)
    except yaml.YAMLError as error:
        raise MeshMapError("--set %s: %r is no value: %s" % (text, written, error)) from error
    given = values.get(name)
    if not isinstance(given, Mapping):
        entries = [each for each in values["layers"] if isinstance(each, Mapping)]
        given = next((each.get("params") for each in entries if each.get("name") == name), None)
    values[name] = {**(given or {}), parameter: value}
