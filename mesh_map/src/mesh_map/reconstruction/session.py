"""A reconstruction of whole inputs: scan after scan, until the end or until it is told to stop."""

import time
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from threading import Event
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from mesh_msgs_hdf5.model.errors import MapFileError

from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import MeshMapError
from mesh_map.reconstruction.pipeline import Reconstruction
from mesh_map.reconstruction.pose_refinement import RefinedPoses, refine_poses
from mesh_map.reconstruction.signed_distance import FieldMemoryError
from mesh_map.scans.kept_scans import KeptScans
from mesh_map.scans.scan import Scan
from mesh_map.scans.scan_source import ScanSource, file_bytes, fingerprint

DONE, STOPPED, OUT_OF_MEMORY = "done", "stopped", "out of memory"


@dataclass
class InputRecord:
    """What has been used of an input.

    path: as the user gave it.
    kind: "bag", "clouds" or "map".
    bytes: of its files.
    blake2b: 32 hexadecimal digits of what is in them; "" if they could not be read at the end.
    position: a position of its source (see Step).
    scans, points: that are in the field.
    complete: nothing of it is left.
    options: of its source.
    """

    path: str
    kind: str
    bytes: int
    blake2b: str = ""
    position: int = 0
    scans: int = 0
    points: int = 0
    complete: bool = False
    options: Dict[str, Any] = field(default_factory=dict)


def input_records(values: Sequence[Mapping[str, Any]]) -> List[InputRecord]:
    """Of what json has written.

    Raises:
        MeshMapError: it is something else.
    """
    try:
        return [InputRecord(**dict(value)) for value in values]
    except TypeError as error:
        raise MeshMapError("what is stored of the inputs is damaged: %s" % error) from error


class Rate:
    """Points in a second, over the last few."""

    def __init__(self) -> None:
        self._begin = time.monotonic()
        self._done = 0

    def add(self, points: int) -> float:
        """Points per second so far, with these."""
        self._done += points
        return self._done / max(1e-3, time.monotonic() - self._begin)


class ReconstructionSession:
    """The inputs of a reconstruction, and how far they have got.

    Args:
        reconstruction: takes the scans.
        sources: one for each input.
        records: of inputs that were used before, which go on where they were.
    Attributes:
        records: those given, and one for each new source.
        notes: what is to be said.
    """

    def __init__(
        self,
        reconstruction: Reconstruction,
        sources: Sequence[ScanSource],
        records: Sequence[InputRecord] = (),
    ) -> None:
        self.reconstruction, self.records = reconstruction, list(records)
        self.notes: List[str] = []
        self._sources = list(sources)
        self._known = list(records)
        self._mine: Dict[int, InputRecord] = {}
        self._refined: Dict[Tuple[int, int], np.ndarray] = {}  # by source and position
        self._bytes = [file_bytes(source.files()) for source in sources]

    def refine(
        self,
        is_stopped: Callable[[], bool],
        progress: Callable[[str, float], None] = lambda text, part: None,
        cancel: Optional[CancelFlag] = None,
    ) -> Optional[RefinedPoses]:
        """Read all scans once and lay them onto each other; `run` then uses the poses found.

        Args:
            is_stopped, progress: as is_stopped and tell for `run`.
            cancel: ends it within a scan.
        Returns:
            what was found, in the order of the scans; None if it was stopped: `run` then uses the
            poses that are given.
        Raises:
            Canceled: by `cancel`.
        """
        places: List[Tuple[int, int]] = []
        counts = self.reconstruction.left_out.stored()

        def scans() -> Iterator[Scan]:
            for i, source in enumerate(self._sources):
                for step in source.steps(0):
                    if is_stopped():
                        return
                    if step.scan is not None:
                        places.append((i, step.position))
                        part = (i + source.part) / len(self._sources)
                        progress("%d scans aligned" % len(places), part)
                        yield step.scan

        options = self.reconstruction.options
        try:
            found = refine_poses(
                scans(),
                voxel_size=options.voxel_size,
                min_range=options.min_range,
                max_range=options.max_range,
                progress=progress,
                is_stopped=is_stopped,
                cancel=cancel,
            )
        finally:
            self.reconstruction.left_out.go_back(counts)
        if is_stopped():
            return None
        self._refined = dict(zip(places, found.poses))
        return found

    def run(
        self,
        is_stopped: Callable[[], bool],
        tell: Callable[[str, float], None] = lambda text, part: None,
        kept: Optional[KeptScans] = None,
    ) -> str:
        """Use all scans, or those until it is told to stop, or the memory limit is reached.

        Args:
            is_stopped: asked between scans.
            tell: takes a line of progress, and how much of all inputs is done, from 0 to 1.
            kept: takes the scans that are used.
        Returns:
            DONE, STOPPED or OUT_OF_MEMORY; for the last, `notes` ends with the reason.
        Raises:
            MapFileError, MeshMapError: an input is another one than before.
        """
        ended = Event()
        with ThreadPoolExecutor(1) as threads:  # reads the files once more, while scans are used
            digests = [
                threads.submit(fingerprint, source.files(), ended.is_set, source.identity)
                for source in self._sources
            ]
            outcome, rate = DONE, Rate()
            try:
                for i, source in enumerate(self._sources):
                    outcome = self._use(i, source, digests[i], rate, is_stopped, tell, kept)
                    if outcome != DONE:
                        break
                for i, source in enumerate(self._sources):
                    if i in self._mine:
                        record = self._mine[i]
                        record.blake2b = record.blake2b or self._digest(record.path, digests[i])
                    else:
                        self._add_unused(i, source)
            finally:
                ended.set()
        return outcome

    def stored(self) -> List[Dict[str, Any]]:
        """The records as json can write them."""
        return [asdict(record) for record in self.records]

    def _add_unused(self, i: int, source: ScanSource) -> None:
        """Keep an input that has not been begun with, for whoever goes on."""
        if source.path not in [record.path for record in self.records]:
            record = InputRecord(source.path, source.kind, self._bytes[i], options=source.options)
            self.records.append(record)

    def _use(
        self,
        i: int,
        source: ScanSource,
        digest: "Future[str]",
        rate: Rate,
        is_stopped: Callable[[], bool],
        tell: Callable[[str, float], None],
        kept: Optional[KeptScans],
    ) -> str:
        """One source, from where it is on."""
        record = self._record(i, source, digest)
        self._mine[i] = record
        if record.complete:
            self.notes.append("%s: all of its scans are in the map already" % source.path)
            return DONE
        if is_stopped():
            return STOPPED
        try:
            for step in source.steps(record.position):
                if step.scan is not None:
                    before = self.reconstruction.points
                    pose = self._refined.get((i, step.position), step.scan.pose)
                    used = self.reconstruction.add(replace(step.scan, pose=pose))
                    points = self.reconstruction.points - before
                    record.points += points
                    record.scans += used is not None
                    if kept is not None and used is not None:
                        kept.keep(used)
                    tell(self._line(rate.add(points)), (i + source.part) / len(self._sources))
                record.position = step.position
                if is_stopped():
                    return STOPPED
        except FieldMemoryError as error:
            self.notes.append(str(error))
            return OUT_OF_MEMORY
        for note in source.notes:
            if note not in self.notes:
                self.notes.append(note)
        record.complete = True
        return DONE

    def _record(self, i: int, source: ScanSource, digest: "Future[str]") -> InputRecord:
        record = InputRecord(source.path, source.kind, self._bytes[i], options=source.options)
        if self._known:
            record.blake2b = digest.result()
            for known in self._known:
                is_unused = known.path == source.path and not known.position
                if known.blake2b == record.blake2b or is_unused:
                    known.blake2b, known.bytes = record.blake2b, record.bytes
                    return known
            again = [known for known in self._known if known.path == source.path]
            if again:
                text = (
                    "%s is not the file of which %d scans are in the map: its bytes, or its poses,"
                    " differ"
                )
                hint = "give it another name if its scans are to be added, too, or begin anew"
                raise MeshMapError(text % (source.path, again[0].scans), hint)
        self.records.append(record)
        return record

    def _digest(self, path: str, digest: "Future[str]") -> str:
        try:
            return digest.result()
        except MapFileError as error:
            self.notes.append("%s cannot be read again for its digest: %s" % (path, error.message))
            return ""

    def _line(self, rate: float) -> str:
        made = self.reconstruction
        text = "%d scans, %.1f M points, %.2f M points/s, %d MB"
        return text % (made.scans, made.points / 1e6, rate / 1e6, made.memory >> 20)
