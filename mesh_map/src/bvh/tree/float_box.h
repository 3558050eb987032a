#ifndef MESH_MAP_SRC_BVH_TREE_FLOAT_BOX_H
#define MESH_MAP_SRC_BVH_TREE_FLOAT_BOX_H

#include <limits>

namespace mesh_map {

/// Four floats side by side, of which boxes use three.
typedef float Float4 __attribute__((vector_size(16)));

/// Of a number and a NaN it is b.
inline Float4 minimum(Float4 a, Float4 b)
{
  return a < b ? a : b;
}
inline Float4 maximum(Float4 a, Float4 b)
{
  return a > b ? a : b;
}
inline Float4 allOf(float value)
{
  return Float4{value, value, value, value};
}
inline Float4 load3(const float* values)
{
  return Float4{values[0], values[1], values[2], 0.0f};
}

/// An axis-parallel box. An empty one is inverted.
struct FloatBox
{
  Float4 lower = allOf(std::numeric_limits<float>::infinity());
  Float4 upper = allOf(-std::numeric_limits<float>::infinity());

  void add(const FloatBox& other)
  {
    lower = minimum(other.lower, lower);
    upper = maximum(other.upper, upper);
  }
  void add(Float4 point)
  {
    lower = minimum(point, lower);
    upper = maximum(point, upper);
  }
};

/// Half the surface.
inline float halfArea(const FloatBox& box)
{
  const Float4 size = box.upper - box.lower;
  return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_BVH_TREE_FLOAT_BOX_H
