#include <mesh_map/bvh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace mesh_map {

namespace {

struct Item
{
  float lower[3], upper[3];
  std::uint32_t face;
};

constexpr float INF = std::numeric_limits<float>::infinity();

void checkMesh(const MeshView& mesh)
{
  if (mesh.faceCount() == 0) {
    throw std::invalid_argument("a mesh without faces has no spatial index");
  }
  for (std::size_t i = 0; i < 3 * mesh.faceCount(); ++i) {
    if (mesh.faces[i] >= mesh.vertexCount()) {
      throw std::invalid_argument("face " + std::to_string(i / 3) + " refers to vertex " +
                                  std::to_string(mesh.faces[i]) + ", but the mesh has " +
                                  std::to_string(mesh.vertexCount()));
    }
  }
}

}  // namespace

/// Median splits: simple, slow, correct.
class BvhBuilder
{
 public:
  BvhBuilder(Bvh& bvh, const MeshView& mesh) : bvh_(bvh), mesh_(mesh) {}

  void run()
  {
    const std::size_t count = mesh_.faceCount();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bvh_.center_[axis] = mesh_.positions[3 * mesh_.faces[0] + axis];
    }
    items_.resize(count);
    for (std::size_t f = 0; f < count; ++f) {
      Item& item = items_[f];
      item.face = static_cast<std::uint32_t>(f);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        item.lower[axis] = INF;
        item.upper[axis] = -INF;
        for (std::size_t k = 0; k < 3; ++k) {
          const float local =
              mesh_.positions[3 * std::size_t{mesh_.faces[3 * f + k]} + axis] - bvh_.center_[axis];
          item.lower[axis] = std::min(item.lower[axis], std::nextafter(local, -INF));
          item.upper[axis] = std::max(item.upper[axis], std::nextafter(local, INF));
        }
      }
    }
    node(0, count);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const BvhNode& root = bvh_.nodes_[0];
      bvh_.lower_[axis] = *std::min_element(root.lower[axis], root.lower[axis] + BVH_WIDTH);
      bvh_.upper_[axis] = *std::max_element(root.upper[axis], root.upper[axis] + BVH_WIDTH);
    }
    bvh_.corners_.assign(9 * count + Bvh::TAIL, 0.0f);
    bvh_.faces_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      bvh_.faces_[i] = items_[i].face;
      for (std::size_t k = 0; k < 9; ++k) {
        bvh_.corners_[9 * i + k] =
            mesh_.positions[3 * std::size_t{mesh_.faces[3 * items_[i].face + k / 3]} + k % 3];
      }
    }
  }

 private:
  std::size_t split(std::size_t begin, std::size_t end)
  {
    if (end - begin <= BVH_LEAF_SIZE) {
      return end;
    }
    float low[3] = {INF, INF, INF}, high[3] = {-INF, -INF, -INF};
    for (std::size_t i = begin; i < end; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], items_[i].lower[axis]);
        high[axis] = std::max(high[axis], items_[i].upper[axis]);
      }
    }
    int axis = 0;
    for (int other = 1; other < 3; ++other) {
      axis = high[other] - low[other] > high[axis] - low[axis] ? other : axis;
    }
    const std::size_t middle = (begin + end) / 2;
    std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
                     [axis](const Item& a, const Item& b) {
                       return a.lower[axis] + a.upper[axis] < b.lower[axis] + b.upper[axis];
                     });
    return middle;
  }

  std::uint32_t node(std::size_t begin, std::size_t end)
  {
    const auto index = static_cast<std::uint32_t>(bvh_.nodes_.size());
    bvh_.nodes_.emplace_back();
    const std::size_t middle = split(begin, end);
    const std::size_t borders[5] = {begin, split(begin, middle), middle,
                                    middle == end ? end : split(middle, end), end};
    for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
      const std::size_t first = borders[k], last = borders[k + 1];
      BvhNode made = bvh_.nodes_[index];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        made.lower[axis][k] = INF;
        made.upper[axis][k] = -INF;
        for (std::size_t i = first; i < last; ++i) {
          made.lower[axis][k] = std::min(made.lower[axis][k], items_[i].lower[axis]);
          made.upper[axis][k] = std::max(made.upper[axis][k], items_[i].upper[axis]);
        }
      }
      made.count[k] = static_cast<std::uint32_t>(last - first);
      made.child[k] = BVH_NO_CHILD;
      if (last > first && last - first <= BVH_LEAF_SIZE) {
        made.child[k] = BVH_LEAF | static_cast<std::uint32_t>(first);
      }
      bvh_.nodes_[index] = made;
      if (last - first > BVH_LEAF_SIZE) {
        const std::uint32_t child = node(first, last);
        bvh_.nodes_[index].child[k] = child;
      }
    }
    return index;
  }

  Bvh& bvh_;
  const MeshView& mesh_;
  std::vector<Item> items_;
};

Bvh Bvh::build(const MeshView& mesh, const BvhOptions&)
{
  checkMesh(mesh);
  Bvh bvh;
  BvhBuilder(bvh, mesh).run();
  return bvh;
}

std::size_t Bvh::memory() const
{
  return nodes_.capacity() * sizeof(BvhNode) + corners_.capacity() * sizeof(float) +
         faces_.capacity() * sizeof(std::uint32_t);
}

}  // namespace mesh_map
