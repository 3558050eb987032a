#include "bvh/tree/bvh_boxes.h"

#include <algorithm>
#include <vector>

#include "base/run.h"

namespace mesh_map {

namespace {

/// Triangles below a node that one thread handles at a time, at most.
constexpr std::uint32_t PART_SIZE = 8192;

/// Some nodes that follow each other: all those below one of them, and all their triangles.
struct Part
{
  std::size_t begin, end;
  std::size_t first_triangle, end_triangle;
};

class BoxMaker
{
 public:
  explicit BoxMaker(const BvhGeometry& geometry) : geometry_(geometry)
  {
    divide(0, geometry.node_count, 0);
  }

  void run(Run& run, double share)
  {
    run.each(parts_.size(), 1, share, [this](std::size_t i) {
      const Part& part = parts_[i];
      copyCorners(geometry_.mesh, geometry_.faces, part.first_triangle, part.end_triangle,
                  geometry_.corners);
      // From the leaves up (I. Wald, S. Boulos, P. Shirley: Ray Tracing Deformable Scenes Using
      // Dynamic Bounding Volume Hierarchies, 2007): children come after their parents.
      for (std::size_t node = part.end; node-- > part.begin;) {
        setBoxes(geometry_.nodes[node]);
      }
    });
    for (std::size_t i = above_.size(); i-- > 0;) {
      setBoxes(geometry_.nodes[above_[i]]);
    }
  }

 private:
  /// The nodes below one end where those of its next sibling begin.
  void divide(std::size_t node, std::size_t end, std::size_t first)
  {
    const BvhNode& n = geometry_.nodes[node];
    std::uint32_t count = 0;
    for (const std::uint32_t of_child : n.count) {
      count += of_child;
    }
    if (count <= PART_SIZE) {
      parts_.push_back({node, end, first, first + count});
      return;
    }
    above_.push_back(node);
    for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
      if (!isLeaf(n.child[k])) {
        std::size_t child_end = end;
        for (std::size_t later = BVH_WIDTH - 1; later > k; --later) {
          child_end = isLeaf(n.child[later]) ? child_end : n.child[later];
        }
        divide(n.child[k], child_end, first);
      } else if (n.count[k] > 0) {
        copyCorners(geometry_.mesh, geometry_.faces, first, first + n.count[k], geometry_.corners);
      }
      first += n.count[k];
    }
  }

  void setBoxes(BvhNode& node) const
  {
    for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
      FloatBox box;
      if (!isLeaf(node.child[k])) {
        box = boxOf(geometry_.nodes[node.child[k]]);
      } else if (node.child[k] != BVH_NO_CHILD) {
        const std::size_t first = node.child[k] & ~BVH_LEAF;
        for (std::size_t i = first; i < first + node.count[k]; ++i) {
          box.add(geometry_.frame.box(geometry_.corners + 9 * i));
        }
      }
      for (int axis = 0; axis < 3; ++axis) {
        node.lower[axis][k] = box.lower[axis];
        node.upper[axis][k] = box.upper[axis];
      }
    }
  }

  const BvhGeometry& geometry_;
  std::vector<Part> parts_;
  std::vector<std::size_t> above_;
};

}  // namespace

FloatBox boxOf(const BvhNode& node)
{
  FloatBox box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = *std::min_element(node.lower[axis], node.lower[axis] + BVH_WIDTH);
    box.upper[axis] = *std::max_element(node.upper[axis], node.upper[axis] + BVH_WIDTH);
  }
  return box;
}

void copyCorners(const MeshView& mesh, const std::uint32_t* faces, std::size_t begin,
                 std::size_t end, float* corners)
{
  forEachFace(
      mesh, end - begin, [=](std::size_t i) { return faces[begin + i]; },
      [&](std::size_t i) {
        const std::uint32_t* const vertices = mesh.faces.data() + 3 * std::size_t{faces[begin + i]};
        for (std::size_t k = 0; k < 3; ++k) {
          std::copy_n(mesh.vertex(vertices[k]), 3, corners + 9 * (begin + i) + 3 * k);
        }
      });
}

void computeBoxes(const BvhGeometry& geometry, Run& run, double share)
{
  BoxMaker(geometry).run(run, share);
}

}  // namespace mesh_map
