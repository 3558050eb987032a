"""The kernels of mesh_map_core (bvh.cl), built for a device."""

import threading
from typing import Any, Dict, Tuple

from mesh_map import _kernels
from mesh_map.spatial.opencl.device import DeviceInfo
from mesh_map.spatial.opencl.driver_calls import link_program
from mesh_map.spatial.opencl.program_cache import ProgramCache

# Items at once: tens of milliseconds of work, so that cancelling takes no longer.
_CHUNK = {"GPU": 1 << 18}
_CHUNK_OF_OTHERS = 1 << 16


class DeviceProgram:
    """A device, a queue and the kernels. Threads may share it.

    Attributes:
        info: the device.
        cl: module pyopencl.
        context, queue: of pyopencl.
        from_cache: nothing was compiled.
        chunk: items of a batch to ask at once.
        max_buffer: bytes that a buffer has at most.
        key: all that the compiled program depends on.
        faster_from: {query: from which size of a batch on it was measured to be faster than native
            code}; for a GPU, back_end.h says that.
    """

    def __init__(self, device: Any, info: DeviceInfo, cache: ProgramCache) -> None:
        """Loads the program from the cache, or compiles it.

        Raises:
            pyopencl.Error: the driver refuses.
        """
        import pyopencl as cl

        self.info, self.cl = info, cl
        self.context = cl.Context([device])
        self.queue = cl.CommandQueue(self.context)
        self.chunk = _CHUNK.get(info.type, _CHUNK_OF_OTHERS)
        self.max_buffer = int(device.max_mem_alloc_size)
        self._group = min(_kernels._DEVICE_WORK_GROUP, device.max_work_group_size)
        self._device, self._cache = device, cache
        self.key = "\n".join(info + (_kernels._BVH_KERNEL_OPTIONS, _kernels._BVH_KERNELS))
        self._program, self.from_cache = self._built()
        self.faster_from: Dict[str, int] = {}
        self._lock = threading.Lock()  # of the arguments of kernels
        self._launchers: Dict[str, Any] = {
            kernel.function_name: kernel for kernel in self._program.all_kernels()
        }

    def _built(self) -> Tuple[Any, bool]:
        # The class below pyopencl's own: that has a second cache, and makes a Python warning of
        # whatever a compiler says.
        program_class = self.cl._cl._Program
        options = _kernels._BVH_KERNEL_OPTIONS.encode()
        binary = self._cache.load(self.key)
        if binary is not None:
            try:
                program = program_class(self.context, [self._device], [binary])
                program._build(options, [self._device])
                return program, True
            except self.cl.Error:
                pass  # the driver has reasons of its own: compile again
        program = program_class(self.context, _kernels._BVH_KERNELS)
        try:
            program._build(options, [self._device])
        except self.cl.Error as error:
            log = " ".join(str(text) for _, text in program._get_build_logs())
            raise RuntimeError("%s: %s" % (error, log[:500])) from error
        return program, False

    def threshold(self, query: str) -> int:
        """From which size of a batch on it shall answer; for queries see query_counts()."""
        usual = _kernels._device_threshold(query, self.info.type == "GPU")
        return self.faster_from.get(query, usual)

    def keep(self) -> None:
        """Stores the program in the cache, best after its first launches: some drivers compile
        parts of it only then.
        """
        if not self.from_cache:
            link_program(self._program)
            binaries = self._program.get_info(self.cl.program_info.BINARIES)
            if len(binaries) == 1:
                self._cache.store(self.key, binaries[0])

    def launch(self, name: str, count: int, *arguments: Any) -> None:
        """Enqueues a kernel with one work item for each of `count` items.

        Args:
            name: of the kernel.
            count: at least 1.
            arguments: buffers, and NumPy scalars.
        """
        group = self._group
        size = (count + group - 1) // group * group
        with self._lock:
            kernel = self._launchers[name]
            for index, argument in enumerate(arguments):
                kernel.set_arg(index, argument)
            self.cl.enqueue_nd_range_kernel(self.queue, kernel, (size,), (group,))

    def buffer_of(self, array: Any) -> Any:
        """A buffer that kernels read, with the content of a NumPy array, which is copied."""
        flags = self.cl.mem_flags
        return self.cl.Buffer(self.context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=array)
