// Solving a part of the mesh again, for the incremental update and for the seams between threads.
//
// The distances and sources D are the one solution of: D(v) is the best of what the lethal
// neighbors w of v give (seed), which depends on which neighbors of w are lethal, and of what each
// w nearer to the obstacle passes on (Propagation), which depends on D(w), and on D(p) of the
// neighbors p of w that are nearer than w, or, where w is lethal, on which of them are. Such a w is
// a neighbor of v, or across an edge opposite to v (FastMarchingAcross), so two edges off, and p
// three. It is the only solution, because each D(v) follows from such with smaller distances.
//
// Let D be such that the equation holds everywhere except within a region, from whose outside
// nothing that has changed can be reached over three edges. Solve the region again, with D held
// fast outside. If then nothing has changed in it within three edges of the outside, the equation
// holds inside (it was just solved) and outside (nothing that it depends on has changed): this is
// the solution, bit for bit what one run over everything finds. If not, the region was too small,
// and is solved again with more around it. How large it is to start with is only a matter of speed.

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

#include "base/require.h"
#include "base/unique.h"
#include "distance/obstacles/obstacle_propagation.h"

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

}  // namespace

std::vector<std::uint32_t> ObstacleDistance::update(ArrayView<std::uint8_t> lethal,
                                                    double most_share)
{
  require(lethal.size() == lethal_.size(), "there have to be as many lethal flags as vertices");
  std::vector<std::uint32_t> changed;
  if (!known_) {
    compute(lethal);
    changed.resize(lethal_.size());
    std::iota(changed.begin(), changed.end(), 0u);
    return changed;
  }
  for (std::size_t v = 0; v < lethal_.size(); ++v) {
    if ((lethal[v] != 0) != (lethal_[v] != 0)) {
      changed.push_back(static_cast<std::uint32_t>(v));
    }
  }
  if (changed.empty()) {
    return changed;
  }
  known_ = false;  // should memory run out
  for (const std::uint32_t v : changed) {
    lethal_[v] = lethal[v];
  }
  const auto most = static_cast<std::size_t>(most_share * static_cast<double>(lethal_.size()));
  newStamps(1);
  region_.clear();
  if (changed.size() > most || !growRegion(changed, reach(), most) || !solveRegion(most, changed)) {
    return computeAnew(lethal);
  }
  known_ = true;
  return changed;
}

/// As update(), from everything.
std::vector<std::uint32_t> ObstacleDistance::computeAnew(ArrayView<std::uint8_t> lethal)
{
  const LargeArray<float> old_distance = distance_;
  const LargeArray<Source> old_source = source_;
  compute(lethal);
  std::vector<std::uint32_t> changed;
  for (std::uint32_t v = 0; v < distance_.size(); ++v) {
    if (isChanged(v, old_distance[v], old_source[v])) {
      changed.push_back(v);
    }
  }
  return changed;
}

bool ObstacleDistance::isChanged(std::uint32_t v, float distance, const Source& source) const
{
  const bool has_source = distance_[v] > 0.0f && distance_[v] < INFINITE;
  return distance_[v] != distance ||
         (has_source && std::memcmp(&source_[v], &source, sizeof(Source)) != 0);
}

/// Solves the region, and more where that is needed. Finds the vertices at which something has
/// changed, ascending. False where the region would hold more than `most`; then distances and
/// sources are as before.
bool ObstacleDistance::solveRegion(std::size_t most, std::vector<std::uint32_t>& changed)
{
  std::vector<float> old_distance;
  std::vector<Source> old_source;
  std::vector<std::uint32_t> too_far;
  do {
    for (std::size_t i = old_distance.size(); i < region_.size(); ++i) {
      old_distance.push_back(distance_[region_[i]]);
      old_source.push_back(source_[region_[i]]);
    }
    runRegion();
    changed.clear();
    too_far.clear();
    markRim(true);
    for (std::size_t i = 0; i < region_.size(); ++i) {
      const std::uint32_t v = region_[i];
      if (isChanged(v, old_distance[i], old_source[i])) {
        changed.push_back(v);
        if (!isInside(v)) {
          too_far.push_back(v);
        }
      }
    }
    markRim(false);
    if (!too_far.empty() && !growRegion(too_far, reach(), most)) {
      for (std::size_t i = 0; i < old_distance.size(); ++i) {
        distance_[region_[i]] = old_distance[i];
        source_[region_[i]] = old_source[i];
      }
      return false;
    }
  } while (!too_far.empty());
  std::sort(changed.begin(), changed.end());
  return true;
}

void ObstacleDistance::runRegion()
{
  VertexFan fan;
  for (const std::uint32_t v : region_) {
    distance_[v] = lethal_[v] != 0 ? 0.0f : INFINITE;
    seed(v, fan);
  }
  std::vector<std::uint32_t> starts;
  for (const std::uint32_t v : region_) {
    forNeighbors(*mesh_, v, [&](std::uint32_t u) {
      if (stamps_[u] != stamp_) {
        starts.push_back(u);
      }
    });
  }
  makeUnique(starts);
  const std::size_t next_to_it = starts.size();
  for (std::size_t i = 0; i < next_to_it; ++i) {  // what is across an edge is two edges off
    forNeighbors(*mesh_, starts[i], [&](std::uint32_t u) {
      if (stamps_[u] != stamp_ && !mesh_->seenAcross(u).empty()) {
        starts.push_back(u);
      }
    });
  }
  starts.insert(starts.end(), region_.begin(), region_.end());
  makeUnique(starts);
  Propagation propagation(*this, stamp_, true);
  for (const std::uint32_t v : starts) {
    if (passesOn(v)) {
      propagation.start(v);
    }
  }
  propagation.run(nullptr);
}

/// Does it tell others what it knows, once it has its distance?
bool ObstacleDistance::passesOn(std::uint32_t v) const
{
  // What is next to lethal vertices was told by seed().
  return distance_[v] < INFINITE && (distance_[v] > 0.0f || !mesh_->seenAcross(v).empty());
}

/// Marks the vertices of the region within two edges of the outside.
void ObstacleDistance::markRim(bool mark)
{
  at_rim_.resize(mesh_->vertexCount(), 0);
  for (const std::uint32_t v : region_) {
    bool is_rim = false;
    forNeighbors(*mesh_, v, [&](std::uint32_t u) { is_rim = is_rim || stamps_[u] != stamp_; });
    at_rim_[v] = mark && is_rim ? 1 : 0;
  }
  for (std::size_t i = 0; mark && i < region_.size(); ++i) {
    const std::uint32_t v = region_[i];
    bool is_next = false;
    forNeighbors(*mesh_, v, [&](std::uint32_t u) { is_next = is_next || at_rim_[u] == 1; });
    at_rim_[v] = at_rim_[v] == 0 && is_next ? 2 : at_rim_[v];
  }
}

/// Is everything within three edges of a vertex of the region in it? With the rim marked.
bool ObstacleDistance::isInside(std::uint32_t v) const
{
  bool result = at_rim_[v] == 0;
  forNeighbors(*mesh_, v, [&](std::uint32_t u) { result = result && at_rim_[u] == 0; });
  return result;
}

void ObstacleDistance::addToRegion(std::uint32_t v)
{
  if (stamps_[v] != stamp_) {
    stamps_[v] = stamp_;
    region_.push_back(v);
  }
}

/// Adds what can be reached over edges that are together not longer than `reach`, and all within
/// four edges. False where these are more than `most`; then it gives up early.
bool ObstacleDistance::growRegion(const std::vector<std::uint32_t>& from, double reach,
                                  std::size_t most)
{
  using Place = std::pair<float, std::uint32_t>;
  std::priority_queue<Place, std::vector<Place>, std::greater<Place>> places;
  std::vector<std::uint32_t> reached;
  const auto come = [&](std::uint32_t v, double length) {
    if (length < lengths_[v] && length <= reach) {
      lengths_[v] = static_cast<float>(length);
      places.push({lengths_[v], v});
      reached.push_back(v);
    }
  };
  lengths_.resize(reach > 0.0 ? mesh_->vertexCount() : lengths_.size(), INFINITE);
  if (reach > 0.0) {
    for (const std::uint32_t v : from) {
      come(v, 0.0);
    }
  }
  while (!places.empty() && region_.size() <= most) {
    const Place place = places.top();
    places.pop();
    if (place.first == lengths_[place.second]) {
      addToRegion(place.second);
      forNeighbors(*mesh_, place.second, [&](std::uint32_t u) {
        if (lengths_[u] > place.first) {
          const Vector3 edge = between(mesh_->position(place.second), mesh_->position(u));
          come(u, place.first + norm(edge));
        }
      });
    }
  }
  for (const std::uint32_t v : reached) {
    lengths_[v] = INFINITE;
  }
  std::vector<std::uint32_t> last = from, next;
  for (unsigned edges = 0; edges < 4 && region_.size() <= most; ++edges) {
    next.clear();
    for (const std::uint32_t v : last) {
      addToRegion(v);
      forNeighbors(*mesh_, v, [&next](std::uint32_t u) { next.push_back(u); });
    }
    makeUnique(next);
    last = next;
  }
  std::for_each(last.begin(), last.end(), [this](std::uint32_t v) { addToRegion(v); });
  return region_.size() <= most;
}

/// The first of `count` stamps that no vertex has; the last of them is that of the region.
std::uint8_t ObstacleDistance::newStamps(std::size_t count)
{
  if (stamp_ > std::numeric_limits<std::uint8_t>::max() - count) {
    std::fill(stamps_.begin(), stamps_.end(), std::uint8_t{0});
    stamp_ = 0;
  }
  const std::size_t first = stamp_ + std::size_t{1};
  stamp_ = static_cast<std::uint8_t>(stamp_ + count);
  return static_cast<std::uint8_t>(first);
}

}  // namespace mesh_map
