"""mesh_tool reconstruct: a map of scans. Also rosrun mesh_map reconstruct.

Exit codes: 0 done; 1 it could not be done; 2 wrong usage; 3 saved, but with less than was asked
for: the memory budget was reached, or scans or layers could not be stored; 130 and 143: stopped by
SIGINT (Ctrl+C) or SIGTERM, with what it had saved.
"""

import argparse
import math
import os
import secrets
import tempfile
from dataclasses import asdict, fields, replace
from typing import Any, Dict, List, Optional, Tuple

from mesh_msgs_hdf5.commands._common import say
from mesh_msgs_hdf5.commands.info import values_text
from mesh_msgs_hdf5.commands.map_output import (
    add_map_output,
    check_map_output,
    save_map,
    saved_line,
    saved_value,
)
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.formats.any_mesh import is_map_file
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.labels.map_contents import open_map
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.model.schema import check_frame_id

from mesh_map.base.errors import Canceled, MeshMapError
from mesh_map.base.stop_signals import StopSignals
from mesh_map.commands.layers_compute import WantedLayers, store_layers
from mesh_map.commands.map_errors import as_map_errors
from mesh_map.reconstruction.memory import default_memory_limit, parsed_bytes
from mesh_map.reconstruction.options import FieldOptions, SurfaceOptions
from mesh_map.reconstruction.pipeline import Reconstruction
from mesh_map.reconstruction.session import (
    DONE,
    OUT_OF_MEMORY,
    STOPPED,
    InputRecord,
    ReconstructionSession,
    input_records,
)
from mesh_map.reconstruction.state_file import read_state, save_state, state_path
from mesh_map.scans.kept_scans import KeptScans
from mesh_map.scans.scan_inputs import InputOptions, open_inputs
from mesh_map.scans.scan_source import ScanSource

NAME = "reconstruct"
HELP = "make a map of scans: bags, point clouds with poses, or the scans in a map file"
EXAMPLE = "mesh_tool reconstruct drive.bag map.h5 --voxel_size 0.05 --max_range 30"

LESS = 3  # exit code
_LEAST_ROOM = 16 << 20  # bytes
_MADE = "reconstruction"  # what the source of the mesh says
_FIELD = tuple(field.name for field in fields(FieldOptions))
_SURFACE = tuple(field.name for field in fields(SurfaceOptions))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    text = "bags, clouds (.ply .pcd .las .laz), folders of clouds, map files with scans"
    add("inputs", metavar="INPUT", nargs="*", help=text)
    add("output", metavar="map.h5", help="the map file to make")
    add("--voxel_size", type=_length, metavar="M", help="m; as fine as details are (default: 0.1)")
    text = "m from a measured surface up to which it is believed (default: by the voxels)"
    add("--truncation", type=_length, metavar="M", help=text)
    add("--min_range", type=_range, metavar="M", help="leave nearer points out (default: 0)")
    add("--max_range", type=_range, metavar="M", help="leave points farther away out")
    text = "use each N-th point, or this share of them (below 1)"
    add("--decimate", type=_length, metavar="N", help=text)
    text = "take away what rays pass through, as people who walked by; takes longer"
    add("--carve", action="store_true", default=None, help=text)
    text = "with PointCloud2 or LaserScan, of bags; may be given several times (default: the only)"
    add("--topic", action="append", default=[], metavar="TOPIC", dest="topics", help=text)
    text = "of the map (default of bags: map, or the root of tf or odometry; else map)"
    add("--frame", default="", metavar="FRAME", help=text)
    text = "when scans of bags were made: by their stamp (default), or when they were received"
    add("--clock", choices=("stamp", "received"), default="stamp", help=text)
    text = "poses of the sensor: TUM (time x y z qx qy qz qw) or KITTI (12 numbers), a line each"
    add("--poses", metavar="FILE", help=text)
    text = "where the sensor was, in the frame of clouds that have no poses"
    add("--sensor", type=_place, metavar="X,Y,Z", help=text)
    text = "subtracted from all coordinates (default: as needed by large coordinates)"
    add("--origin", type=_place, metavar="X,Y,Z", help=text)
    text = "lay the scans onto each other first, so that poses that drift agree; reads them twice"
    add("--refine", action="store_true", help=text)
    text = "m: close holes in the ground with a perimeter up to this (default: 1; 0: none)"
    add("--fill_holes", type=_range, metavar="M", help=text)
    text = "m: close shadows up to this width where the ground goes on (default: 1; 0: none)"
    add("--fill_shadows", type=_range, metavar="M", help=text)
    text = "m by which a simplified surface may be off (default: 0, all faces, as layers want them)"
    add("--simplify", type=_range, metavar="M", help=text)
    text = "drop pieces of fewer faces that nothing connects (default: 500; 0: none)"
    add("--min_component", type=int, metavar="FACES", help=text)
    text = "of the field, such as 4G or 500M (default: half of what is free); it stops there"
    add("--memory", type=parsed_bytes, metavar="BYTES", help=text)
    text = "put the scans, with their poses, into the map, too"
    add("--with-scans", action="store_true", help=text)
    text = "compute these layers, too, and store them: height_diff,roughness; see layers compute"
    add("--layers", type=_words, metavar="NAME,NAME", default=[], help=text)
    add("--config", metavar="FILE.yaml", help="layers with their parameters, see layers compute")
    text = "go on where the last call for this map has ended, also with more inputs"
    add("--continue", action="store_true", dest="goes_on", help=text)
    text = "keep no file %s beside the map, by which --continue goes on" % state_path("map.h5")
    add("--no-state", action="store_true", help=text)
    add_map_output(parser)
    text = (
        "exit codes: 0 done, 1 it could not be done, 2 wrong usage, %d saved with less than asked"
    )
    text += " (memory budget, scans or layers that could not be stored), 130 or 143 stopped by a"
    text += " signal, with what it had saved"
    parser.epilog = "%s; %s" % (parser.epilog or "", text % LESS)


def _length(text: str) -> float:
    value = float(text)
    if not 0 < value < 1e6:
        raise ValueError(text)
    return value


def _range(text: str) -> float:
    value = float(text)
    if not 0 <= value <= math.inf:
        raise ValueError(text)
    return value


def _place(text: str) -> Tuple[float, ...]:
    values = tuple(float(value) for value in text.split(","))
    if len(values) != 3 or not all(abs(value) < 1e12 for value in values):
        raise ValueError(text)
    return values


def _words(text: str) -> List[str]:
    return [word for word in text.split(",") if word]


_length.__name__, _range.__name__ = "number above 0", "number from 0 on"
_place.__name__ = "place (X,Y,Z)"


def run(arguments: argparse.Namespace) -> int:
    output = arguments.output
    if arguments.frame:
        check_frame_id(output, arguments.frame.lstrip("/"))
    layers = WantedLayers(arguments.layers, arguments.config)
    if layers.names or layers.config:
        layers.check(output)
    state = state_path(output, arguments.to_part)
    with as_map_errors(output) as warnings:
        begun = _begun(arguments, state)
        _check_output(arguments, None if begun is None else begun[0])
        stop = StopSignals()
        with ProgressLine(arguments.quiet) as progress:
            work = _Work(arguments, state, stop, progress, begun)
            with stop:
                code = work.run()
            if layers.names or layers.config:
                code = work.store_layers(layers) or code
        work.notes += warnings
    work.say()
    return code


# What was there before


def _begun(arguments: argparse.Namespace, state: str) -> Optional[Tuple[Dict[str, Any], bytes]]:
    """The state to go on from; None to begin."""
    if not arguments.goes_on:
        if not arguments.inputs:
            raise MapFileError("value", arguments.output, "there is no input", EXAMPLE)
        return None
    if not os.path.exists(state):
        text = "there is no %s, from which --continue could go on" % state
        hint = "begin without --continue; --no-state keeps none"
        raise MapFileError("missing", arguments.output, text, hint)
    if arguments.refine:
        text = "--refine needs all scans at once, so that --continue cannot go on with it"
        raise MapFileError("value", arguments.output, text, "begin anew, or leave --refine out")
    return read_state(state)


def _check_output(arguments: argparse.Namespace, header: Optional[Dict[str, Any]]) -> None:
    """Refuse what cannot be saved before the work begins. header: of the state to go on from."""
    output = arguments.output
    parts = isolated("parts", output) if os.path.exists(output) and is_map_file(output) else []
    if header is not None and parts:
        part = arguments.to_part or ("mesh" if "mesh" in parts else parts[0] or "/")
        if not arguments.force and part.strip("/") in parts:
            _check_ours(output, part, header)
        # what else is in the file, such as scans, stays
        arguments.to_part, arguments.force = part, True
    elif arguments.to_part is not None and arguments.to_part.strip("/") in parts:
        if not arguments.force:
            text = "it has a part %s already" % arguments.to_part
            raise MapFileError("exists", output, text, "--force replaces it")
    for path in arguments.inputs:
        if os.path.exists(output) and os.path.exists(path) and os.path.samefile(path, output):
            text = "it is an input and the output"
            raise MapFileError("exists", output, text, "name another output")
    check_map_output(arguments, None)
    folder = os.path.dirname(os.path.abspath(output))
    room = os.statvfs(folder)
    free = room.f_bavail * room.f_frsize
    if free < _LEAST_ROOM:
        text = "the disk has only %d kB left" % (free >> 10)
        raise MapFileError("save", output, text, "make room on the disk, or save elsewhere")


def _check_ours(output: str, part: str, header: Dict[str, Any]) -> None:
    """Refuse to replace a mesh that is not that of the state, or has labels."""
    contents = open_map(output, part).members
    known = {entry["blake2b"] for entry in header["inputs"]}
    theirs = [entry.get("blake2b") for entry in contents.source.get("inputs", ())]
    if contents.source.get("made") != _MADE or not known.issuperset(filter(None, theirs)):
        text = "it was not made by this command, or was changed since, and would be replaced"
        raise MapFileError("exists", output, text, "--force replaces it, or name another output")
    labels = contents.label_names()
    if labels:
        text = "it has %d labels, which would be lost with the mesh" % len(labels)
        raise MapFileError("exists", output, text, "mesh_tool labels export keeps them; --force")


# The work


class _Work:
    """One call of the command, from the inputs to the saved map."""

    def __init__(
        self,
        arguments: argparse.Namespace,
        state: str,
        stop: StopSignals,
        progress: ProgressLine,
        begun: Optional[Tuple[Dict[str, Any], bytes]],
    ) -> None:
        self.arguments, self._stop, self._progress = arguments, stop, progress
        self._state = state
        self.notes: List[str] = []
        self._code = 0
        self._value: Dict[str, Any] = {}
        self._lines: List[str] = []
        self._changes: List[str] = []
        self._refined: Dict[str, Any] = {}
        surface = dict(begun[0].get("surface", {})) if begun is not None else {}
        given = {name: getattr(arguments, name) for name in _SURFACE}
        surface.update({name: value for name, value in given.items() if value is not None})
        self._surface_options = SurfaceOptions(**surface)
        memory = arguments.memory or default_memory_limit()
        self._header: Dict[str, Any] = {}
        records: List[InputRecord] = []
        if begun is None:
            self._made = Reconstruction(self._field_options({}), memory)
        else:
            self._header = begun[0]
            self._made = Reconstruction.restored(self._header, begun[1], memory)
            self._field_options(self._made.options.stored())
            records = input_records(self._header["inputs"])
        progress.stage("opening the inputs")
        self._frame = arguments.frame.lstrip("/") or self._header.get("frame", "")
        if self._frame != self._header.get("frame", self._frame):
            text = "the map is in frame %s, not %s" % (self._header["frame"], self._frame)
            raise MeshMapError(text, "leave --frame out, or begin anew")
        self._session = ReconstructionSession(self._made, self._open(records), records)

    def _open(self, records: List[InputRecord]) -> List[ScanSource]:
        """Sources of the inputs of before that are not complete, and of those that are named;
        those of before are opened as they were."""
        arguments = self.arguments
        named = list(dict.fromkeys(arguments.inputs))
        groups: List[Tuple[InputOptions, List[str]]] = []
        for record in records:
            if not os.path.exists(record.path):
                if not record.complete:
                    text = "%s is not there any more: %d of its scans are in the map"
                    self.notes.append(text % (record.path, record.scans))
                continue
            options = InputOptions(**record.options)
            if not groups or groups[-1][0] != options:
                groups.append((options, []))
            groups[-1][1].append(record.path)
        known = {record.path for record in records}
        if records and arguments.poses and known.issuperset(named):
            self.notes.append(
                "--poses is not used: the inputs are those of before, with their poses"
            )
        new = InputOptions(arguments.topics, "", arguments.clock, arguments.poses, arguments.sensor)
        groups.append((new, [path for path in named if path not in known]))
        wanted = {*named, *(record.path for record in records if not record.complete)}
        sources: List[ScanSource] = []
        static: List[Any] = []
        for options, paths in groups:
            if not wanted.intersection(paths):
                continue
            options = replace(options, frame=self._frame)
            inputs = open_inputs(paths, options, self._made.left_out, static)
            self._frame = self._frame or inputs.frame
            self.notes += [note for note in inputs.notes if note not in self.notes]
            sources += [source for source in inputs.sources if source.path in wanted]
        self._frame = self._frame or "map"
        return sources

    def _field_options(self, before: Dict[str, Any]) -> FieldOptions:
        """Those of the arguments; refuses others than those of before."""
        given = {name: getattr(self.arguments, name) for name in _FIELD}
        given = {name: value for name, value in given.items() if value is not None}
        options = FieldOptions(**given)
        stored = options.stored()
        for name in given if before else ():
            if stored[name] != before[name]:
                text = "--%s is %s, but the map was begun with %s"
                text %= name, stored[name], before[name]
                raise MeshMapError(text, "leave it out, or begin anew")
        return options

    def run(self) -> int:
        """Use the scans, make the surface, save it; returns the exit code."""
        arguments, stop, progress = self.arguments, self._stop, self._progress
        if arguments.refine:
            self._refine()
        if not arguments.with_scans:
            outcome = self._session.run(stop.is_stopped, self._tell)
            self._end(outcome, None)
            return self._code
        with KeptScans(arguments.output) as kept:
            outcome = self._session.run(stop.is_stopped, self._tell, kept)
            self._end(outcome, kept)
        progress.stage("")
        return self._code

    def _refine(self) -> None:
        try:
            found = self._session.refine(self._stop.is_stopped, self._tell, self._stop.cancel)
        except Canceled:
            raise KeyboardInterrupt from None
        if found is not None:
            self._refined = found.counts()
            self._changes.append(found.line())

    def _tell(self, text: str, part: float) -> None:
        self._progress.stage(text)
        self._progress.part(part)

    def _end(self, outcome: str, kept: Optional[KeptScans]) -> None:
        made = self._made
        self.notes += [note for note in self._session.notes if note not in self.notes]
        if not made.scans:
            if outcome == STOPPED:
                raise KeyboardInterrupt
            reasons = "; ".join(made.left_out.lines() + self._session.notes[-1:])
            raise MeshMapError("no scan could be used: " + (reasons or "there is none"))
        if outcome == STOPPED:
            self._code = self._stop.exit_code
            text = "stopped after %d scans; --continue goes on (again: ends at once)"
            if not self.arguments.quiet:
                self._progress.write("mesh_tool: " + text % made.scans)
        elif outcome == OUT_OF_MEMORY:
            self._code = LESS
        try:
            self._save(outcome, kept)
        except Canceled:
            raise KeyboardInterrupt from None

    def _save(self, outcome: str, kept: Optional[KeptScans]) -> None:
        arguments, made, progress = self.arguments, self._made, self._progress
        if not arguments.no_state:  # first: whatever happens later, the work is not lost
            self._save_state()
        progress.stage("making the surface")
        mesh, changes = made.surface(self._surface_options, self._stop.cancel)
        self._changes += changes.lines()
        mesh.frame_id = self._frame
        mesh.source = self._source(outcome, changes.counts())
        progress.stage("saving " + arguments.output)
        self._save_map(mesh)
        if kept is not None and len(kept):
            progress.stage("saving the scans")
            try:
                names = kept.put(self.arguments.output)
                self._value["file_bytes"] = os.stat(self.arguments.output).st_size
                self.notes.append("%d scans were put into the map, too" % len(names))
            except MapFileError as error:
                self.notes.append("the map is saved, but not its scans: %s" % error)
                self._code = self._code or LESS

    def _save_state(self) -> None:
        path = self._state
        self._progress.stage("saving " + path)
        values, data = self._made.stored()
        header = {
            **values,
            "surface": asdict(self._surface_options),
            "frame": self._frame,
            "inputs": self._session.stored(),
        }
        try:
            size = save_state(path, header, data)
        except MapFileError as error:
            self.notes.append("--continue cannot go on: %s" % error)
            self._code = self._code or LESS
            return
        text = "%s: %d MB, by which --continue goes on (it may be deleted)"
        self._lines.append(text % (path, -(-size >> 20)))

    def _save_map(self, mesh: Mesh) -> None:
        """Where it is to be, or else, so that the work is not lost, among temporary files."""
        arguments = self.arguments
        try:
            self.notes += save_map(arguments, mesh)
        except MapFileError as error:
            if error.code not in ("save", "changed"):
                raise
            stem = os.path.splitext(os.path.basename(arguments.output))[0]
            path = "%s_%s.h5" % (os.path.join(tempfile.gettempdir(), stem), secrets.token_hex(4))
            other = argparse.Namespace(**{**vars(arguments), "output": path, "to_part": None})
            try:
                save_map(other, mesh)
            except MapFileError:
                raise error from None
            self.notes.append("%s; it is saved as %s instead" % (error, path))
            self._code, self.arguments = self._code or LESS, other
        self._value.update(saved_value(self.arguments, mesh))

    def _source(self, outcome: str, changes: Dict[str, Any]) -> Dict[str, Any]:
        """What the map says of how it was made."""
        made = self._made
        return {
            "made": _MADE,
            "parameters": {**made.options.stored(), **asdict(self._surface_options)},
            "inputs": self._session.stored(),
            "scans": made.scans,
            "points": made.points,
            "left_out": made.left_out.stored(),
            "changes": changes,
            **({"refined": self._refined} if self._refined else {}),
            "complete": outcome == DONE,
        }

    def store_layers(self, layers: WantedLayers) -> int:
        """Compute layers; returns the exit code if they could not be stored, else 0."""
        arguments = self.arguments
        if self._stop.is_stopped():
            self.notes.append("no layers were computed; mesh_tool layers compute does that")
            return 0
        try:
            entries, notes = store_layers(
                arguments.output, arguments.to_part, layers, self._progress
            )
        except MapFileError as error:
            self.notes.append("the map is saved, but without layers: %s" % error)
            return self._code or LESS
        self._value["layers"] = entries
        self._lines += [values_text(entry) for entry in entries]
        self.notes += notes
        return 0

    def say(self) -> None:
        """The result."""
        made = self._made
        left_out = made.left_out.lines()
        notes = [note for note in dict.fromkeys(self.notes) if note not in left_out]
        value = {
            "inputs": self._session.stored(),
            "scans": made.scans,
            "points": made.points,
            "left_out": made.left_out.stored(),
            **({"refined": self._refined} if self._refined else {}),
            "notes": left_out + notes,
            **self._value,
        }
        head = "%d scans, %d points: %d vertices, %d faces"
        head %= made.scans, made.points, value["vertices"], value["faces"]
        lines = [head, *("  " + line for line in self._changes + left_out)]
        lines += ["  note: " + note for note in notes]
        say(self.arguments, value, lines + [saved_line(self._value)] + self._lines)
