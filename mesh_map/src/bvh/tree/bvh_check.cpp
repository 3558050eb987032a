#include "bvh/tree/bvh_check.h"

#include <mesh_map/bvh/tree/bvh_node.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "base/run.h"
#include "base/vector3.h"
#include "bvh/tree/float_box.h"

namespace mesh_map {

namespace {

constexpr std::size_t FACES_PER_CHUNK = 32768;

std::string numbered(const char* what, std::size_t index)
{
  return std::string(what) + " " + std::to_string(index);
}

/// The faces beside the one that is named.
std::string others(std::size_t count)
{
  if (count < 2) {
    return "";
  }
  return " (and " + std::to_string(count - 1) + (count == 2 ? " face" : " faces") + " more)";
}

}  // namespace

void checkFaceCount(const MeshView& mesh)
{
  if (mesh.faceCount() == 0) {
    throw std::invalid_argument(
        "a mesh without faces has no spatial index: give it at least one face");
  }
  if (mesh.faceCount() >= BVH_LEAF) {
    throw std::invalid_argument("the mesh has " + std::to_string(mesh.faceCount()) +
                                " faces, but a spatial index holds " +
                                std::to_string(BVH_LEAF - 1) + " at most: divide the mesh");
  }
}

bool facesAreSound(const MeshView& mesh, std::size_t begin, std::size_t end)
{
  const std::uint32_t* const corners = mesh.faces.data();
  std::uint32_t highest = 0;
  for (std::size_t i = 3 * begin; i < 3 * end; ++i) {
    highest = std::max(highest, corners[i]);
  }
  if (highest >= mesh.vertexCount()) {
    return false;
  }
  Floats4 zero = all4(0.0f);  // NaN from the first number on that is not finite
  for (std::size_t i = 3 * begin; i < 3 * end; ++i) {
    zero += load3(mesh.positions.data() + 3 * std::size_t{corners[i]}) * all4(0.0f);
  }
  return zero[0] == 0.0f && zero[1] == 0.0f && zero[2] == 0.0f;
}

void refuseFaces(const MeshView& mesh)
{
  const std::size_t vertices = mesh.vertexCount(), faces = mesh.faceCount();
  std::size_t out_of_range = 0, infinite = 0, first_out_of_range = faces, first_infinite = faces;
  for (std::size_t face = faces; face-- > 0;) {
    const std::uint32_t* const corners = mesh.faces.data() + 3 * face;
    if (std::any_of(corners, corners + 3, [=](std::uint32_t v) { return v >= vertices; })) {
      ++out_of_range;
      first_out_of_range = face;
    } else if (!std::all_of(corners, corners + 3, [&](std::uint32_t v) {
                 return isFinite(mesh.positions.data() + 3 * std::size_t{v});
               })) {
      ++infinite;
      first_infinite = face;
    }
  }
  if (out_of_range > 0) {
    const std::uint32_t* const corners = mesh.faces.data() + 3 * first_out_of_range;
    throw std::invalid_argument(
        numbered("face", first_out_of_range) + others(out_of_range) + " refers to " +
        numbered("vertex",
                 *std::find_if(corners, corners + 3, [=](auto v) { return v >= vertices; })) +
        ", but the mesh has " + std::to_string(vertices) +
        " vertices: remove such faces, or give all vertices");
  }
  const std::uint32_t* const corners = mesh.faces.data() + 3 * std::min(first_infinite, faces - 1);
  const std::uint32_t vertex = *std::find_if(corners, corners + 2, [&](std::uint32_t v) {
    return !isFinite(mesh.positions.data() + 3 * std::size_t{v});
  });
  const float* const position = mesh.positions.data() + 3 * std::size_t{vertex};
  throw std::invalid_argument(
      numbered("face", first_infinite) + others(infinite) + " has " + numbered("vertex", vertex) +
      " at (" + std::to_string(position[0]) + ", " + std::to_string(position[1]) + ", " +
      std::to_string(position[2]) +
      "), which is not finite: remove such faces, or repair their vertices");
}

void checkMesh(const MeshView& mesh, Run& run, double share)
{
  checkFaceCount(mesh);
  std::atomic<bool> sound{true};
  run.loop(mesh.faceCount(), FACES_PER_CHUNK, share, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      if (!facesAreSound(mesh, begin, end)) {
        sound = false;
      }
    };
  });
  if (!sound) {
    refuseFaces(mesh);
  }
}

}  // namespace mesh_map
