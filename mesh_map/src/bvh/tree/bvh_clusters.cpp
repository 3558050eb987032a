#include "bvh/tree/bvh_clusters.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/run.h"
#include "bvh/tree/bvh_check.h"
#include "bvh/tree/float_box.h"

namespace mesh_map {

namespace {

/// Numbers points so that those with nearby numbers are near each other: a Morton curve (G. Morton,
/// 1966; for hierarchies: C. Lauterbach et al.: Fast BVH Construction on GPUs, 2009) of 32 bits
/// that gives each axis as many of them as its extent deserves. Points outside of the box get the
/// numbers of its border.
class MortonCurve
{
 public:
  static constexpr unsigned BITS = 32;

  explicit MortonCurve(const FloatBox& box)
      : lower_(box.lower), scale_(all4(0.0f)), highest_(all4(0.0f))
  {
    // From the highest bit on, each one halves the cells along the axis where they are the longest.
    float size[3];
    unsigned bits[3] = {};
    int axis_of_bit[BITS];
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = box.upper[axis] - box.lower[axis];
      size[axis] = std::isfinite(extent) && extent > 0.0f ? extent : 0.0f;
    }
    for (int& axis : axis_of_bit) {
      axis = size[1] > size[0] ? 1 : 0;
      axis = size[2] > size[axis] ? 2 : axis;
      if (!(size[axis] > 0.0f)) {
        axis = -1;
      } else if (++bits[axis] == BITS_PER_AXIS) {
        size[axis] = 0.0f;
      } else {
        size[axis] *= 0.5f;
      }
    }
    unsigned left[3] = {bits[0], bits[1], bits[2]};
    for (unsigned bit = 0; bit < BITS; ++bit) {
      const int axis = axis_of_bit[bit];
      if (axis >= 0) {
        const unsigned from = --left[axis];
        const std::uint32_t to = std::uint32_t{1} << (BITS - 1 - bit);
        for (unsigned value = 0; value < 256; ++value) {
          if (((value >> (from % 8)) & 1) != 0) {
            dilated_[2 * static_cast<unsigned>(axis) + from / 8][value] |= to;
          }
        }
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      const float cells = std::exp2(static_cast<float>(bits[axis]));
      const float scale = cells / (box.upper[axis] - box.lower[axis]);
      if (bits[axis] > 0 && std::isfinite(scale)) {
        scale_[axis] = scale;
        highest_[axis] = cells - 1.0f;
      }
    }
  }

  std::uint32_t operator()(Floats4 point) const
  {
    // NaN (of infinite numbers) becomes 0.
    Floats4 cell = (point - lower_) * scale_;
    cell = minimum(maximum(cell, all4(0.0f)), highest_);
    const auto x = static_cast<unsigned>(cell[0]), y = static_cast<unsigned>(cell[1]),
               z = static_cast<unsigned>(cell[2]);
    return dilated_[0][x & 0xFF] | dilated_[1][x >> 8] | dilated_[2][y & 0xFF] |
           dilated_[3][y >> 8] | dilated_[4][z & 0xFF] | dilated_[5][z >> 8];
  }

 private:
  static constexpr unsigned BITS_PER_AXIS = 16;

  Floats4 lower_, scale_, highest_;
  std::array<std::array<std::uint32_t, 256>, 6> dilated_{};  // per axis: low byte, high byte
};

constexpr std::size_t FACES_PER_CHUNK = 2048;
constexpr std::size_t CLUSTERS_PER_CHUNK = 256;

/// Triangles of a cluster at most.
constexpr std::uint32_t CLUSTER_SIZE = 64;

}  // namespace

void appendCells(const KeyedIndex* faces, std::uint32_t begin, std::uint32_t end,
                 std::uint32_t largest, LargeArray<std::uint32_t>& begins)
{
  if (end - begin <= largest) {
    begins.push_back(begin);
    return;
  }
  std::uint32_t difference = faces[begin].key ^ faces[end - 1].key;
  if (difference == 0) {
    for (std::uint32_t i = begin; i < end; ++i) {
      begins.push_back(i);
    }
    return;
  }
  while ((difference & (difference - 1)) != 0) {
    difference &= difference - 1;  // until only the highest bit is left
  }
  const KeyedIndex* const border = std::partition_point(
      faces + begin, faces + end,
      [difference](const KeyedIndex& face) { return (face.key & difference) == 0; });
  const auto middle = static_cast<std::uint32_t>(border - faces);
  appendCells(faces, begin, middle, largest, begins);
  appendCells(faces, middle, end, largest, begins);
}

BvhClusters findClusters(const MeshView& mesh, const FaceSample& sample, const LocalFrame& frame,
                         Run& run, double share)
{
  const auto count = static_cast<std::uint32_t>(mesh.faceCount());
  const MortonCurve curve(sample.mainBox(frame));
  BvhClusters result;
  result.faces = LargeArray<KeyedIndex>(count);
  std::atomic<bool> sound{true};
  run.loop(count, FACES_PER_CHUNK, share * 0.25, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      if (!sound || !facesAreSound(mesh, begin, end)) {
        sound = false;
        return;
      }
      KeyedIndex* const faces = result.faces.data();
      forEachFace(
          mesh, end - begin, [=](std::size_t i) { return static_cast<std::uint32_t>(begin + i); },
          [&](std::size_t i) {
            const FloatBox box = frame.box(mesh, begin + i);
            faces[begin + i] = {curve(box.lower + box.upper),
                                static_cast<std::uint32_t>(begin + i)};
          });
    };
  });
  if (!sound) {
    refuseFaces(mesh);
  }
  sortByKey(result.faces, run, share * 0.5);

  result.begins.reserve(count / (CLUSTER_SIZE / 4) + 2);
  appendCells(result.faces.data(), 0, count, CLUSTER_SIZE, result.begins);
  const std::size_t clusters = result.begins.size();
  result.begins.push_back(count);

  result.items = LargeArray<BvhItem>(clusters);
  run.loop(clusters, CLUSTERS_PER_CHUNK, share * 0.25, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      const std::uint32_t first = result.begins[begin];
      std::size_t cluster = begin;
      FloatBox box;
      forEachFace(
          mesh, result.begins[end] - first,
          [&](std::size_t i) { return result.faces[first + i].index; },
          [&](std::size_t i) {
            box.add(frame.box(mesh, result.faces[first + i].index));
            if (first + i + 1 == result.begins[cluster + 1]) {
              result.items[cluster] = BvhItem(box, static_cast<std::uint32_t>(cluster),
                                              result.begins[cluster + 1] - result.begins[cluster]);
              box = FloatBox();
              ++cluster;
            }
          });
    };
  });
  return result;
}

}  // namespace mesh_map
