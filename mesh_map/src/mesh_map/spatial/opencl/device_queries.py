"""Queries about one mesh on a device that holds it.

As bvh_device.h describes: kernels name the few triangles that may be the answer, which is
then found natively among them, in double precision; so it is the native one to the last bit.
"""

from typing import Any, Callable, Iterator, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map import _kernels
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.base.query_arguments import Rays
from mesh_map.spatial.opencl.program import DeviceProgram

Arrays = Tuple[np.ndarray, ...]


class _Job(NamedTuple):
    """Items of work for a kernel, each on its own.

    pack, finish: what is done natively before and after, for the items from begin to before end.
    """

    kernel: str
    count: int
    answers: int
    flags: int
    pack: Callable[[int, int], np.ndarray]
    finish: Callable[[int, int, np.ndarray], Arrays]


class DeviceQueries:
    """A mesh on a device. Threads may share it. Whatever the device does wrong raises an error."""

    def __init__(self, program: DeviceProgram, bvh: Any, threads: int) -> None:
        """Uploads the mesh; a device that is the processor itself reads it in place.

        Args:
            program: of the device.
            bvh: _kernels._Bvh, which must stay as it is.
            threads: for what is done natively; 0 for all cores.
        Raises:
            MemoryError: the mesh has no room there.
        """
        self._program, self._bvh, self._threads = program, bvh, threads
        largest = max(bvh._nodes.nbytes, bvh._corners.nbytes)
        if largest > program.max_buffer:
            raise MemoryError(
                "a mesh of %d faces takes a buffer of %d MB, of which the device has %d"
                % (bvh._face_count, largest >> 20, program.max_buffer >> 20)
            )
        self._nodes, self._corners = (self._mesh_buffer(a) for a in (bvh._nodes, bvh._corners))
        self._no_mask = program.buffer_of(np.zeros(16, np.uint8))

    def _mesh_buffer(self, array: np.ndarray) -> Any:
        if self._program.info.type != "CPU":
            return self._program.buffer_of(array)
        cl = self._program.cl
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.USE_HOST_PTR
        return cl.Buffer(self._program.context, flags, hostbuf=array)

    def cast(
        self,
        rays: Rays,
        back_faces: bool,
        mask: Optional[np.ndarray],
        any_hit: bool,
        cancel: Optional[CancelFlag],
    ) -> Iterator[Arrays]:
        """Answers in order, chunk by chunk: (faces, distances, barycentric), or (hits,)."""
        bvh, threads = self._bvh, self._threads

        def pack(begin: int, end: int) -> np.ndarray:
            return bvh._pack_rays(*rays.part(begin, end), threads)

        def finish(begin: int, end: int, answers: np.ndarray) -> Arrays:
            asked = (*rays.part(begin, end), back_faces, mask, answers, threads)
            return (bvh._finish_rays_any(*asked),) if any_hit else bvh._finish_rays(*asked)

        flags = _kernels._DEVICE_BACK_FACES if back_faces else 0
        flags |= _kernels._DEVICE_ANY_HIT if any_hit else 0
        answers = _kernels._DEVICE_RAY_ANSWERS
        return self._run(_Job("cast_rays", rays.count, answers, flags, pack, finish), mask, cancel)

    def closest(
        self,
        points: np.ndarray,
        max_distance: float,
        mask: Optional[np.ndarray],
        cancel: Optional[CancelFlag],
    ) -> Iterator[Arrays]:
        """Answers in order, chunk by chunk: (faces, positions, barycentric, distances)."""
        bvh, threads = self._bvh, self._threads

        def pack(begin: int, end: int) -> np.ndarray:
            return bvh._pack_points(points[begin:end], max_distance, threads)

        def finish(begin: int, end: int, answers: np.ndarray) -> Arrays:
            return bvh._finish_points(points[begin:end], max_distance, mask, answers, threads)

        answers = _kernels._DEVICE_CANDIDATES
        return self._run(
            _Job("closest_points", len(points), answers, 0, pack, finish), mask, cancel
        )

    def select(
        self, region: Any, roots: np.ndarray, inside: bool, mask: Optional[np.ndarray]
    ) -> np.ndarray:
        """The faces that a region with a kernel selects, ascending."""
        program, bvh = self._program, self._bvh
        verdicts = np.zeros(bvh._face_count, np.uint8)
        if len(roots):
            packed, planes = bvh._pack_region(region)
            cl = program.cl
            flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
            buffer = cl.Buffer(program.context, flags, hostbuf=verdicts)
            arguments = [self._nodes, self._corners, program.buffer_of(packed)]
            arguments += [np.uint32(planes)] if planes else []
            arguments += [program.buffer_of(roots), np.uint32(len(roots)), buffer]
            kernel = "select_planes" if planes else "select_sphere"
            program.launch(kernel, len(roots), *arguments)
            cl.enqueue_copy(program.queue, verdicts, buffer)
        return bvh._finish_selection(region, inside, mask, verdicts)

    def _run(
        self, job: _Job, mask: Optional[np.ndarray], cancel: Optional[CancelFlag]
    ) -> Iterator[Arrays]:
        """While the device has a chunk, the host packs the next and finishes the one before."""
        flags, mask_buffer = job.flags, self._no_mask
        if mask is not None:
            flags |= _kernels._DEVICE_MASKED
            mask_buffer = self._program.buffer_of(self._bvh._device_mask(mask))
        before = None
        for begin in range(0, job.count, self._program.chunk):
            if cancel is not None and cancel.is_set():
                raise Canceled("cancelled")
            end = min(begin + self._program.chunk, job.count)
            started = self._start(job, begin, end, mask_buffer, flags)
            if before is not None:
                yield self._finish(job, *before)
            before = (begin, end, *started)
        if before is not None:
            yield self._finish(job, *before)

    def _start(
        self, job: _Job, begin: int, end: int, mask: Any, flags: int
    ) -> Tuple[np.ndarray, Any]:
        """Answers to be, and the event after which they are there.

        Events of copies keep the arrays, and wait for their end where nobody else does.
        """
        program = self._program
        cl, count = program.cl, end - begin
        items = program.buffer_of(job.pack(begin, end))
        answers = np.zeros(count * job.answers, np.uint32)
        buffer = cl.Buffer(program.context, cl.mem_flags.WRITE_ONLY, answers.nbytes)
        arguments = (items, mask, np.uint32(flags), np.uint32(count), buffer)
        program.launch(job.kernel, count, self._nodes, self._corners, *arguments)
        done = cl.enqueue_copy(program.queue, answers, buffer, is_blocking=False)
        program.queue.flush()
        return answers, done

    def _finish(self, job: _Job, begin: int, end: int, answers: np.ndarray, done: Any) -> Arrays:
        done.wait()
        return job.finish(begin, end, answers)
