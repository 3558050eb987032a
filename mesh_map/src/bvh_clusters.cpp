#include "bvh_clusters.h"

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "bvh_check.h"
#include "bvh_morton.h"
#include "bvh_run.h"

namespace mesh_map {

namespace {

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
