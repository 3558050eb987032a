#ifndef MESH_MAP_SRC_RADIUS_BLOCK_SEARCH_H
#define MESH_MAP_SRC_RADIUS_BLOCK_SEARCH_H

#include <mesh_map/array_view.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "radius_block.h"

namespace mesh_map {

/// Finds N_r(v) and v among the vertices of a block.
///
/// Those within the radius are all connected with v where edges within the radius lead from each
/// other one of them to one that is nearer to v: again and again, v is reached. For most this is a
/// neighbor, often the same one as for the last v; otherwise it is searched for along edges nearby.
/// Where there is none, all that was reached is not connected with v, and left out. Only where
/// this gets too much, all that is connected is searched from v.
class BlockSearch
{
 public:
  BlockSearch(const Block& block, double radius)
      : block_(block),
        squared_radius_(radius * radius),
        surely_within_(static_cast<float>(squared_radius_ * (1.0 - SLACK))),
        maybe_within_(static_cast<float>(squared_radius_ * (1.0 + SLACK)))
  {
  }

  /// Call this after the block has changed.
  void begin()
  {
    distances_.resize(block_.size());
    found_.resize(block_.size() + 1);
    reached_.resize(block_.size() + 1);
    seen_.assign(block_.size(), 0);
    searches_ = 0;
    guides_.resize(block_.size());
    for (std::uint32_t u = 0; u < guides_.size(); ++u) {
      guides_[u] = u;
    }
  }

  ArrayView<std::uint32_t> find(std::uint32_t center)
  {
    const std::size_t count = findByDistance(center);
    const std::uint32_t* const found = found_.data();
    const float* const distances = distances_.data();
    const std::uint32_t* const guides = guides_.data();
    effort_ = 2 * count;
    bool all = true;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t u = found[i];
      if (!(distances[guides[u]] < distances[u]) && u != center && !findGuide(u)) {
        const Way way = searchNearer(u, center);
        if (way == Way::TOO_FAR) {
          return searchAlongEdges(center);
        }
        all = all && way == Way::NEARER;
      }
    }
    return {found, all ? count : removeSeparate(count)};
  }

 private:
  /// More than the relative error of a squared distance in single precision.
  static constexpr double SLACK = 1e-6;

  /// Fills found_ with all within the radius, and distances_ with squared distances: above
  /// maybe_within_ for those that are not.
  std::size_t findByDistance(std::uint32_t center)
  {
    const std::size_t size = block_.size();
    const float* const x = block_.attributes.x.data();
    const float* const y = block_.attributes.y.data();
    const float* const z = block_.attributes.z.data();
    float* const distances = distances_.data();
    const float cx = x[center], cy = y[center], cz = z[center];
    for (std::size_t u = 0; u < size; ++u) {
      const float dx = x[u] - cx, dy = y[u] - cy, dz = z[u] - cz;
      distances[u] = dx * dx + dy * dy + dz * dz;
    }
    std::uint32_t* const found = found_.data();
    const float limit = maybe_within_, sure = surely_within_;
    std::size_t count = 0, unsure = 0;
    for (std::size_t u = 0; u < size; ++u) {
      found[count] = static_cast<std::uint32_t>(u);
      count += distances[u] <= limit;
      unsure += (distances[u] <= limit) & (distances[u] >= sure);
    }
    return unsure == 0 ? count : decideExactly(center, count);
  }

  std::size_t decideExactly(std::uint32_t center, std::size_t count)
  {
    const RadiusAttributes& of = block_.attributes;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t u = found_[i];
      if (distances_[u] >= surely_within_ && u != center) {
        const double dx = double{of.x[u]} - of.x[center];
        const double dy = double{of.y[u]} - of.y[center];
        const double dz = double{of.z[u]} - of.z[center];
        if (!(dx * dx + dy * dy + dz * dz < squared_radius_)) {
          distances_[u] = std::numeric_limits<float>::infinity();
          continue;
        }
      }
      found_[kept++] = u;
    }
    return kept;
  }

  /// Makes the nearest neighbor the guide; false if it is not nearer than u itself.
  bool findGuide(std::uint32_t u)
  {
    std::uint32_t guide = u;
    for (std::uint32_t k = block_.offsets[u]; k < block_.offsets[u + 1]; ++k) {
      const std::uint32_t to = block_.neighbors[k];
      guide = distances_[to] < distances_[guide] ? to : guide;
    }
    guides_[u] = guide;
    return guide != u;
  }

  enum class Way
  {
    NEARER,
    SEPARATE,
    TOO_FAR
  };

  /// Whether edges within the radius lead from u to one that is nearer, or to the center (others
  /// may be in the same place). If not, all that they lead to is marked as farther than the radius.
  Way searchNearer(std::uint32_t u, std::uint32_t center)
  {
    float* const distances = distances_.data();
    std::uint32_t* const reached = reached_.data();
    const float own = distances[u], limit = maybe_within_;
    if (own > limit) {
      return Way::SEPARATE;  // marked before
    }
    const std::uint32_t search = ++searches_;
    std::size_t count = 1;
    reached[0] = u;
    seen_[u] = search;
    for (std::size_t i = 0; i < count; ++i) {
      if (effort_ == 0) {
        return Way::TOO_FAR;
      }
      --effort_;
      for (std::uint32_t k = block_.offsets[reached[i]]; k < block_.offsets[reached[i] + 1]; ++k) {
        const std::uint32_t to = block_.neighbors[k];
        if (distances[to] < own || to == center) {
          return Way::NEARER;
        }
        reached[count] = to;
        count += (distances[to] <= limit) & (seen_[to] != search);
        seen_[to] = search;
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      distances[reached[i]] = std::numeric_limits<float>::infinity();
    }
    return Way::SEPARATE;
  }

  std::size_t removeSeparate(std::size_t count)
  {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t u = found_[i];
      found_[kept] = u;
      kept += distances_[u] <= maybe_within_;
    }
    return kept;
  }

  ArrayView<std::uint32_t> searchAlongEdges(std::uint32_t center)
  {
    const std::uint32_t* const offsets = block_.offsets.data();
    const std::uint32_t* const neighbors = block_.neighbors.data();
    float* const distances = distances_.data();
    std::uint32_t* const found = found_.data();
    const float limit = maybe_within_, reached = std::numeric_limits<float>::infinity();
    std::size_t count = 1;
    found[0] = center;
    distances[center] = reached;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::uint32_t k = offsets[found[i]]; k < offsets[found[i] + 1]; ++k) {
        const std::uint32_t to = neighbors[k];
        found[count] = to;
        count += distances[to] <= limit;
        distances[to] = reached;
      }
    }
    return {found, count};
  }

  const Block& block_;
  double squared_radius_;
  float surely_within_, maybe_within_;
  std::vector<float> distances_;
  std::vector<std::uint32_t> found_;
  std::vector<std::uint32_t> guides_;  // per vertex a neighbor that was nearer to the last center
  std::vector<std::uint32_t> reached_;
  std::vector<std::uint32_t> seen_;  // per vertex the last search that saw it
  std::uint32_t searches_ = 0;
  std::size_t effort_ = 0;  // vertices that may still be looked at for this center
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_RADIUS_BLOCK_SEARCH_H
