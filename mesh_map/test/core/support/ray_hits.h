#pragma once

#include "bvh/rays/ray_test.h"

/// Whether and where a ray meets one triangle (9 floats), as RayTest tells: the face is NO_INDEX if
/// it does not, else 0.
inline mesh_map::RayHit hitOf(const mesh_map::RayTest& ray, const float* corners,
                              bool back_faces = true)
{
  mesh_map::RayHit hit;
  if (ray.valid() && meets(ray, corners, back_faces, &hit.distance, &hit.barycentric)) {
    hit.face = 0;
  }
  return hit;
}
