#include "mesh/radius_statistics.h"

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>
#include <mesh_map/base/parallel.h>
#include <mesh_map/mesh/neighborhood.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "base/fixed_point.h"
#include "base/vector3.h"
#include "mesh/radius_grid.h"

namespace mesh_map {

namespace {

/// What a radius pass reads of vertices, one array each, so that loops over them vectorize. Arrays
/// that what is wanted does not need are empty.
struct RadiusAttributes
{
  LargeArray<float> x, y, z;
  LargeArray<float> heights;
  LargeArray<std::uint32_t> angles;  // in fixed point
  LargeArray<double> tips;           // of the normals, 3 each

  std::size_t size() const { return x.size(); }
};

constexpr std::size_t VERTICES_PER_CHUNK = 32768;
constexpr unsigned ANY_HEIGHT_DIFFERENCE = HEIGHT_DIFFERENCE | HEIGHT_DIFFERENCE_AROUND;
constexpr unsigned ANY_ROUGHNESS = ROUGHNESS | ROUGHNESS_AROUND;

float heightDifference(const float* heights, std::uint32_t center, ArrayView<std::uint32_t> members)
{
  float lowest = heights[center], highest = lowest;
  for (const std::uint32_t u : members) {
    lowest = std::min(lowest, heights[u]);
    highest = std::max(highest, heights[u]);
  }
  return highest - lowest;
}

float heightDifferenceAround(const float* heights, std::uint32_t center,
                             ArrayView<std::uint32_t> members)
{
  float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
  for (const std::uint32_t u : members) {
    lowest = u == center ? lowest : std::min(lowest, heights[u]);
    highest = u == center ? highest : std::max(highest, heights[u]);
  }
  return members.size() > 1 ? highest - lowest : std::numeric_limits<float>::quiet_NaN();
}

std::uint64_t sumOf(const std::uint32_t* angles, ArrayView<std::uint32_t> members)
{
  std::uint64_t sum = 0;
  for (const std::uint32_t u : members) {
    sum += angles[u];
  }
  return sum;
}

/// Distances of some at a time, so that their roots are computed side by side.
float ridge(const RadiusAttributes& of, std::uint32_t center, ArrayView<std::uint32_t> members,
            double units)
{
  constexpr std::size_t AT_A_TIME = 64;
  const double* const tips = of.tips.data();
  const double x = tips[3 * std::size_t{center}], y = tips[3 * std::size_t{center} + 1],
               z = tips[3 * std::size_t{center} + 2];
  std::uint64_t sum = 0;
  for (std::size_t first = 0; first < members.size(); first += AT_A_TIME) {
    const std::size_t count = std::min(AT_A_TIME, members.size() - first);
    double distances[AT_A_TIME];
    for (std::size_t i = 0; i < count; ++i) {
      const double* const tip = tips + 3 * std::size_t{members[first + i]};
      const double dx = tip[0] - x, dy = tip[1] - y, dz = tip[2] - z;
      distances[i] = dx * dx + dy * dy + dz * dz;
    }
    for (std::size_t i = 0; i < count; ++i) {
      distances[i] = std::sqrt(distances[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      sum += toFixed(distances[i], units);
    }
  }
  return meanOfFixed(sum, units, members.size() - 1);  // its own distance is 0
}

double diagonal(ArrayView<float> positions)
{
  double squared = 0.0;
  for (std::size_t axis = 0; axis < 3 && !positions.empty(); ++axis) {
    float lowest = positions[axis], highest = lowest;
    for (std::size_t i = axis; i < positions.size(); i += 3) {
      lowest = std::min(lowest, positions[i]);
      highest = std::max(highest, positions[i]);
    }
    squared += (double{highest} - lowest) * (double{highest} - lowest);
  }
  return std::sqrt(squared);
}

/// Per meter. The tips of two normals are at most 2 m farther apart than the vertices; this leaves
/// room for twice as much.
double ridgeUnits(const RadiusQuery& query)
{
  const double largest = std::min(query.radius, diagonal(query.positions)) + 2.0;
  return std::exp2(std::floor(31.0 - std::log2(largest)));
}

/// Writes the statistics of one vertex, given those around it.
class RadiusWriter
{
 public:
  /// `results` has to outlive this object.
  RadiusWriter(const RadiusQuery& query, RadiusStatistics& results)
      : height_differences_(wanted(query, HEIGHT_DIFFERENCE, results.height_differences)),
        height_differences_around_(
            wanted(query, HEIGHT_DIFFERENCE_AROUND, results.height_differences_around)),
        roughnesses_(wanted(query, ROUGHNESS, results.roughnesses)),
        roughnesses_around_(wanted(query, ROUGHNESS_AROUND, results.roughnesses_around)),
        ridges_(wanted(query, RIDGE, results.ridges)),
        ridge_units_(ridges_ == nullptr ? 1.0 : ridgeUnits(query))
  {
  }

  /// `members` are the places in `of` of the vertices around `center`, itself among them; v is its
  /// index in the results.
  void write(const RadiusAttributes& of, std::uint32_t center, ArrayView<std::uint32_t> members,
             std::size_t v) const
  {
    if (height_differences_ != nullptr) {
      height_differences_[v] = heightDifference(of.heights.data(), center, members);
    }
    if (height_differences_around_ != nullptr) {
      height_differences_around_[v] = heightDifferenceAround(of.heights.data(), center, members);
    }
    if (roughnesses_ != nullptr || roughnesses_around_ != nullptr) {
      const std::uint64_t sum = sumOf(of.angles.data(), members);
      if (roughnesses_ != nullptr) {
        roughnesses_[v] = meanOfFixed(sum, ANGLE_UNITS, members.size());
      }
      if (roughnesses_around_ != nullptr) {
        roughnesses_around_[v] =
            meanOfFixed(sum - of.angles[center], ANGLE_UNITS, members.size() - 1);
      }
    }
    if (ridges_ != nullptr) {
      ridges_[v] = ridge(of, center, members, ridge_units_);
    }
  }

 private:
  static float* wanted(const RadiusQuery& query, RadiusStatistic statistic,
                       std::vector<float>& results)
  {
    return (query.wanted & statistic) != 0 ? results.data() : nullptr;
  }

  float* height_differences_;
  float* height_differences_around_;
  float* roughnesses_;
  float* roughnesses_around_;
  float* ridges_;
  double ridge_units_;
};

/// Those of all vertices, the one of index order[i] in place i; without an order, of index i.
/// `positions`: x, y and z, too.
RadiusAttributes gatherAttributes(const RadiusQuery& query, ArrayView<std::uint32_t> order,
                                  bool positions)
{
  const std::size_t count = query.positions.size() / 3;
  const bool heights = (query.wanted & ANY_HEIGHT_DIFFERENCE) != 0;
  const bool angles = (query.wanted & ANY_ROUGHNESS) != 0, normals = (query.wanted & RIDGE) != 0;
  RadiusAttributes all;
  all.x.resize(positions ? count : 0);
  all.y.resize(positions ? count : 0);
  all.z.resize(positions ? count : 0);
  all.heights.resize(heights ? count : 0);
  all.angles.resize(angles ? count : 0);
  all.tips.resize(normals ? 3 * count : 0);
  parallelEach(count, VERTICES_PER_CHUNK, query.threads, [&, up = query.up](std::size_t i) {
    const std::size_t v = order.empty() ? i : order[i];
    const float* const position = query.positions.data() + 3 * v;
    if (positions) {
      all.x[i] = position[0];
      all.y[i] = position[1];
      all.z[i] = position[2];
    }
    if (heights) {
      all.heights[i] = static_cast<float>(dot(pointOf(position), up));
    }
    if (angles) {
      all.angles[i] = toFixed(query.angles[v], ANGLE_UNITS);
    }
    if (normals) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        all.tips[3 * i + axis] = double{position[axis]} + query.normals[3 * v + axis];
      }
    }
  });
  return all;
}

/// All vertices in the order of a grid, so that those of a cell lie side by side.
struct OrderedMesh
{
  RadiusAttributes attributes;
  LargeArray<std::uint32_t> offsets, neighbors;  // places, not indices
};

template <class T>
void copy(const std::vector<RadiusGrid::Range>& ranges, const LargeArray<T>& from,
          std::size_t width, LargeArray<T>& to)
{
  to.clear();
  if (!from.empty()) {
    for (const auto& [begin, end] : ranges) {
      to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(width * begin),
                from.begin() + static_cast<std::ptrdiff_t>(width * end));
    }
  }
}

/// Those vertices of a mesh that can be within the radius of any vertex of one cell, side by side
/// in small arrays that stay in the cache, and what edges connect of them.
class Block
{
 public:
  explicit Block(const OrderedMesh& mesh) : mesh_(mesh), local_(mesh.attributes.size(), 0) {}

  void gather(const std::vector<RadiusGrid::Range>& ranges)
  {
    places_.clear();
    for (const auto& [begin, end] : ranges) {
      for (std::uint32_t place = begin; place < end; ++place) {
        local_[place] = static_cast<std::uint32_t>(places_.size());
        places_.push_back(place);
      }
    }
    const RadiusAttributes& from = mesh_.attributes;
    copy(ranges, from.x, 1, attributes.x);
    copy(ranges, from.y, 1, attributes.y);
    copy(ranges, from.z, 1, attributes.z);
    copy(ranges, from.heights, 1, attributes.heights);
    copy(ranges, from.angles, 1, attributes.angles);
    copy(ranges, from.tips, 3, attributes.tips);

    offsets.assign(1, 0);
    neighbors.clear();
    for (const std::uint32_t place : places_) {
      for (std::uint32_t k = mesh_.offsets[place]; k < mesh_.offsets[place + 1]; ++k) {
        const std::uint32_t to = mesh_.neighbors[k], local = local_[to];
        if (local < places_.size() && places_[local] == to) {
          neighbors.push_back(local);
        }
      }
      offsets.push_back(static_cast<std::uint32_t>(neighbors.size()));
    }
  }

  std::size_t size() const { return places_.size(); }
  /// Where a vertex of the block is in the arrays below.
  std::uint32_t localOf(std::uint32_t place) const { return local_[place]; }

  RadiusAttributes attributes;
  std::vector<std::uint32_t> offsets, neighbors;

 private:
  const OrderedMesh& mesh_;
  std::vector<std::uint32_t> local_;  // per place; may be of an earlier block
  std::vector<std::uint32_t> places_;
};

OrderedMesh inOrderOf(const RadiusGrid& grid, const RadiusQuery& query)
{
  const std::size_t count = grid.order().size();
  const ArrayView<std::uint32_t> order = {grid.order().data(), count};
  OrderedMesh mesh;
  mesh.attributes = gatherAttributes(query, order, true);
  const std::uint32_t* const offsets = query.neighbors.offsets.data();
  LargeArray<std::uint32_t> places(count);
  mesh.offsets.resize(count + 1);
  mesh.offsets[0] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t v = order[i];
    places[v] = static_cast<std::uint32_t>(i);
    mesh.offsets[i + 1] = mesh.offsets[i] + (offsets[v + 1] - offsets[v]);
  }
  mesh.neighbors.resize(query.neighbors.values.size());
  parallelEach(count, VERTICES_PER_CHUNK, query.threads, [&](std::size_t i) {
    const std::uint32_t v = order[i];
    std::uint32_t* to = mesh.neighbors.data() + mesh.offsets[i];
    for (std::uint32_t k = offsets[v]; k < offsets[v + 1]; ++k) {
      *to++ = places[query.neighbors.values[k]];
    }
  });
  return mesh;
}

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
        const Found way = searchNearer(u, center);
        if (way == Found::TOO_FAR) {
          return searchAlongEdges(center);
        }
        all = all && way == Found::NEARER;
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

  enum class Found
  {
    NEARER,
    SEPARATE,
    TOO_FAR
  };

  /// Whether edges within the radius lead from u to one that is nearer, or to the center (others
  /// may be in the same place). If not, all that they lead to is marked as farther than the radius.
  Found searchNearer(std::uint32_t u, std::uint32_t center)
  {
    float* const distances = distances_.data();
    std::uint32_t* const reached = reached_.data();
    const float own = distances[u], limit = maybe_within_;
    if (own > limit) {
      return Found::SEPARATE;  // marked before
    }
    const std::uint32_t search = ++searches_;
    std::size_t count = 1;
    reached[0] = u;
    seen_[u] = search;
    for (std::size_t i = 0; i < count; ++i) {
      if (effort_ == 0) {
        return Found::TOO_FAR;
      }
      --effort_;
      for (std::uint32_t k = block_.offsets[reached[i]]; k < block_.offsets[reached[i] + 1]; ++k) {
        const std::uint32_t to = block_.neighbors[k];
        if (distances[to] < own || to == center) {
          return Found::NEARER;
        }
        reached[count] = to;
        count += (distances[to] <= limit) & (seen_[to] != search);
        seen_[to] = search;
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      distances[reached[i]] = std::numeric_limits<float>::infinity();
    }
    return Found::SEPARATE;
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

/// A thread's share of the cells.
class BlockWorker
{
 public:
  BlockWorker(const RadiusGrid& grid, const OrderedMesh& mesh, double radius, RadiusWriter writer)
      : grid_(grid), writer_(writer), radius_(radius), block_(mesh), search_(block_, radius)
  {
  }

  void work(std::size_t begin, std::size_t end)
  {
    for (std::size_t cell = begin; cell < end; ++cell) {
      around_.clear();
      grid_.around(cell, radius_, around_);
      block_.gather(around_);
      search_.begin();
      const auto [first, last] = grid_.cell(cell);
      for (std::uint32_t place = first; place < last; ++place) {
        const std::uint32_t center = block_.localOf(place);
        writer_.write(block_.attributes, center, search_.find(center), grid_.order()[place]);
      }
    }
  }

 private:
  const RadiusGrid& grid_;
  RadiusWriter writer_;
  double radius_;
  Block block_;
  BlockSearch search_;
  std::vector<RadiusGrid::Range> around_;
};

/// The pass over cells of a grid: see RadiusSearch::GRID. `results` has room for what is wanted.
void radiusStatisticsByGrid(const RadiusQuery& query, double cell_size, RadiusStatistics& results)
{
  constexpr std::size_t cells_per_chunk = 16;
  const RadiusGrid grid(query.positions, cell_size, query.threads);
  const OrderedMesh mesh = inOrderOf(grid, query);
  const RadiusWriter writer(query, results);
  parallelFor(grid.cellCount(), cells_per_chunk, query.threads, [&]() -> RangeBody {
    const auto worker = std::make_shared<BlockWorker>(grid, mesh, query.radius, writer);
    return [worker](std::size_t begin, std::size_t end) { worker->work(begin, end); };
  });
}

void statisticsByEdges(const RadiusQuery& query, const std::vector<PackedPosition>& packed,
                       RadiusStatistics& results)
{
  constexpr std::size_t vertices_per_chunk = 4096;
  const RadiusAttributes attributes = gatherAttributes(query, {}, false);
  const RadiusWriter writer(query, results);
  const auto one = [neighborhood = RadiusNeighborhood(packed, query.neighbors),
                    radius = query.radius, &attributes, writer](std::size_t v) mutable {
    const auto center = static_cast<std::uint32_t>(v);
    writer.write(attributes, center, neighborhood.find(center, radius), v);
  };
  parallelEach(packed.size(), vertices_per_chunk, query.threads, one);
}

/// The mean number of vertices around a vertex, itself included, of a sample of at least one.
double meanCount(const RadiusQuery& query, const std::vector<PackedPosition>& packed)
{
  constexpr std::size_t samples = 48;
  RadiusNeighborhood neighborhood(packed, query.neighbors);
  const std::size_t taken = std::min(samples, packed.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < taken; ++i) {
    const std::size_t v = i * packed.size() / taken;
    sum +=
        static_cast<double>(neighborhood.find(static_cast<std::uint32_t>(v), query.radius).size());
  }
  return sum / static_cast<double>(taken);
}

/// Whether squared distances around this radius are far from the limits of single precision.
bool fitsGrid(double radius)
{
  return radius > 1e-15 && radius < 1e15;
}

}  // namespace

RadiusStatistics radiusStatistics(const RadiusQuery& query)
{
  const std::size_t count = query.positions.size() / 3;
  RadiusStatistics results;
  const auto roomFor = [&](RadiusStatistic statistic, std::vector<float>& result) {
    result.resize((query.wanted & statistic) != 0 ? count : 0);
  };
  roomFor(HEIGHT_DIFFERENCE, results.height_differences);
  roomFor(ROUGHNESS, results.roughnesses);
  roomFor(RIDGE, results.ridges);
  roomFor(HEIGHT_DIFFERENCE_AROUND, results.height_differences_around);
  roomFor(ROUGHNESS_AROUND, results.roughnesses_around);
  const std::vector<PackedPosition> packed = packPositions(query.positions);
  if (query.search == RadiusSearch::EDGES || count == 0 || !fitsGrid(query.radius)) {
    statisticsByEdges(query, packed, results);
    return results;
  }
  constexpr double enough_for_grid = 60.0;  // measured
  const double mean_count = meanCount(query, packed);
  if (query.search == RadiusSearch::AUTOMATIC && mean_count < enough_for_grid) {
    statisticsByEdges(query, packed, results);
  } else {
    // About as many vertices in a cell, however many are within the radius.
    constexpr double wanted_in_cell = 100.0, smallest = 0.125;
    const double share = std::sqrt(wanted_in_cell / std::max(mean_count, 1.0) * PI);
    const double cell_size = query.radius * std::clamp(share, smallest, 1.0);
    radiusStatisticsByGrid(query, cell_size, results);
  }
  return results;
}

}  // namespace mesh_map
