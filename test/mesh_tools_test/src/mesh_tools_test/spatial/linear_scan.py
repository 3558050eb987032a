"""The peer without a hierarchy: an OpenCL work item looks at each triangle, for every question.

That is how the released tool picks: the kernel writes a number for each triangle, the host reads
all of them back and looks for those that were hit.
"""

from typing import Any

import numpy as np

KERNELS = """
float3 corner(global const float *vertices, global const uint *faces, size_t i)
{
  return vload3(faces[i], vertices);
}

// Distance along the ray by Moeller and Trumbore, or -1.
kernel void scan_ray(global const float *vertices, global const uint *faces, uint count,
                     float4 origin, float4 direction, global float *result)
{
  const size_t face = get_global_id(0);
  if (face >= count) {
    return;
  }
  const float3 a = corner(vertices, faces, 3 * face);
  const float3 ab = corner(vertices, faces, 3 * face + 1) - a;
  const float3 ac = corner(vertices, faces, 3 * face + 2) - a;
  const float3 p = cross(direction.xyz, ac), t = origin.xyz - a, q = cross(t, ab);
  const float f = 1.0f / dot(ab, p), u = f * dot(t, p), v = f * dot(direction.xyz, q);
  const float distance = f * dot(ac, q);
  const int hit = u >= 0.0f && v >= 0.0f && u + v <= 1.0f && distance >= 0.0f;
  result[face] = hit ? distance : -1.0f;
}

// 1 where a corner is in the ball, else -1.
kernel void scan_sphere(global const float *vertices, global const uint *faces, uint count,
                        float4 sphere, global float *result)
{
  const size_t face = get_global_id(0);
  if (face >= count) {
    return;
  }
  int inside = 0;
  for (int k = 0; k < 3; ++k) {
    const float3 d = corner(vertices, faces, 3 * face + k) - sphere.xyz;
    inside |= dot(d, d) <= sphere.w * sphere.w;
  }
  result[face] = inside ? 1.0f : -1.0f;
}

// 1 where a corner is on the inner side of all planes, else -1.
kernel void scan_planes(global const float *vertices, global const uint *faces, uint count,
                        constant float4 *planes, int plane_count, global float *result)
{
  const size_t face = get_global_id(0);
  if (face >= count) {
    return;
  }
  int inside = 0;
  for (int k = 0; k < 3; ++k) {
    const float3 p = corner(vertices, faces, 3 * face + k);
    int all = 1;
    for (int i = 0; i < plane_count; ++i) {
      all &= dot(planes[i].xyz, p) + planes[i].w >= 0.0f;
    }
    inside |= all;
  }
  result[face] = inside ? 1.0f : -1.0f;
}
"""
GROUP = 64


class LinearScan:
    """A mesh on an OpenCL device, without any order."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray, device: Any) -> None:
        """Uploads the mesh to a device of pyopencl."""
        import pyopencl

        self._cl = pyopencl
        context = pyopencl.Context([device])
        self._queue = pyopencl.CommandQueue(context)
        program = pyopencl.Program(context, KERNELS).build()
        self._kernels = {
            name: getattr(program, "scan_" + name) for name in ("ray", "sphere", "planes")
        }
        flags = pyopencl.mem_flags
        read = flags.READ_ONLY | flags.COPY_HOST_PTR
        self._context, self._read = context, read
        self._vertices = pyopencl.Buffer(context, read, hostbuf=np.ascontiguousarray(vertices))
        self._faces = pyopencl.Buffer(context, read, hostbuf=np.ascontiguousarray(faces))
        self._count = len(faces)
        self._answers = np.zeros(self._count, np.float32)
        self._result = pyopencl.Buffer(context, flags.WRITE_ONLY, self._answers.nbytes)
        # Some drivers compile parts of a kernel at its first launch.
        self.cast(np.zeros(3), np.ones(3))
        self.in_sphere(np.zeros(3), 1.0)
        self.in_planes(np.ones((6, 4)))

    def _scan(self, name: str, *arguments: Any) -> np.ndarray:
        size = ((self._count + GROUP - 1) // GROUP * GROUP,)
        self._kernels[name](
            self._queue,
            size,
            (GROUP,),
            self._vertices,
            self._faces,
            np.uint32(self._count),
            *arguments,
            self._result,
        )
        self._cl.enqueue_copy(self._queue, self._answers, self._result)
        return self._answers

    def cast(self, origin: np.ndarray, direction: np.ndarray) -> int:
        """The face that the ray hits first, or -1."""
        ray = np.zeros((2, 4), np.float32)
        ray[0, :3], ray[1, :3] = origin, direction
        answers = self._scan("ray", ray[0], ray[1])
        hits = np.flatnonzero(answers >= 0.0)
        return int(hits[answers[hits].argmin()]) if len(hits) else -1

    def in_sphere(self, center: np.ndarray, radius: float) -> np.ndarray:
        """The faces that have a corner in the ball."""
        sphere = np.append(np.asarray(center, np.float32), np.float32(radius))
        return np.flatnonzero(self._scan("sphere", sphere) > 0.0)

    def in_planes(self, planes: np.ndarray) -> np.ndarray:
        """The faces that have a corner inside all planes (N, 4)."""
        rows = np.ascontiguousarray(planes, np.float32)
        buffer = self._cl.Buffer(self._context, self._read, hostbuf=rows)
        return np.flatnonzero(self._scan("planes", buffer, np.int32(len(rows))) > 0.0)
