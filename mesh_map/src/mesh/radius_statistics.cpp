#include "mesh/radius_statistics.h"

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>
#include <mesh_map/base/parallel.h>
#include <mesh_map/mesh/neighborhood.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "base/fixed_point.h"
#include "base/simd.h"
#include "base/vector3.h"
#include "mesh/large_faces.h"
#include "mesh/neighborhood_group.h"
#include "mesh/packed_position.h"
#include "mesh/radius_attributes.h"
#include "mesh/spatial_order.h"

namespace mesh_map {

namespace {

HeightRange heightsOf(const float* heights, ArrayView<std::uint32_t> members)
{
  HeightRange range;
  for (const std::uint32_t u : members) {
    range.add(heights[u]);
  }
  return range;
}

HeightRange heightsAround(const float* heights, std::uint32_t center,
                          ArrayView<std::uint32_t> members)
{
  HeightRange range;
  for (const std::uint32_t u : members) {
    if (u != center) {
      range.add(heights[u]);
    }
  }
  return range;
}

std::uint64_t sumOf(const std::uint32_t* angles, ArrayView<std::uint32_t> members)
{
  std::uint64_t sum = 0;
  for (const std::uint32_t u : members) {
    sum += angles[u];
  }
  return sum;
}

/// A part of the scale of tips, with room for twice that, as whole numbers.
constexpr double TIP_UNITS = 1u << 30;

/// The sum of the distances between a tip and four others, in whole numbers: in which order they
/// are summed does not matter.
class TipDistances
{
 public:
  explicit TipDistances(const Tip& center)
      : position_(load4(center.position)), normal_(load4(center.normal))
  {
  }

  void add(const Tip& first, const Tip& second, const Tip& third, const Tip& fourth)
  {
    Floats4 x = squares(first), y = squares(second), z = squares(third), none = squares(fourth);
    transpose(x, y, z, none);
    const Ints4 units =
        __builtin_convertvector(squareRoot(x + y + z) * static_cast<float>(TIP_UNITS), Ints4);
    for (unsigned k = 0; k < 4; ++k) {
      sum_ += static_cast<std::uint32_t>(units[k]);
    }
  }

  std::uint64_t sum() const { return sum_; }

 private:
  Floats4 squares(const Tip& of) const
  {
    const Floats4 way = (load4(of.position) - position_) + (load4(of.normal) - normal_);
    return way * way;
  }

  Floats4 position_, normal_;
  std::uint64_t sum_ = 0;
};

float ridge(const RadiusAttributes& of, std::uint32_t center, ArrayView<std::uint32_t> members)
{
  const Tip* const tips = of.tips.data();
  TipDistances distances(tips[center]);
  const std::size_t count = members.size();
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    distances.add(tips[members[i]], tips[members[i + 1]], tips[members[i + 2]],
                  tips[members[i + 3]]);
  }
  if (i < count) {
    const auto tip = [&](std::size_t k) { return tips[k < count ? members[k] : center]; };
    distances.add(tip(i), tip(i + 1), tip(i + 2), tips[center]);  // its own distance is 0
  }
  return meanOfFixed(distances.sum(), TIP_UNITS / of.tip_scale, count - 1);
}

/// What a pass looks at: vertices in one order or another.
struct RadiusMesh
{
  std::vector<PackedPosition> positions;
  RowsView neighbors;
  RadiusAttributes attributes;
  ArrayView<std::uint32_t> order;    // the index of each place; empty where they are the same
  LargeArray<std::uint8_t> touched;  // by a large face, per place; empty where none is large

  std::size_t indexOf(std::uint32_t place) const { return order.empty() ? place : order[place]; }
};

/// Writes the statistics of one vertex, given those around it.
class RadiusWriter
{
 public:
  /// What is given has to outlive this object.
  RadiusWriter(const RadiusQuery& query, const LargeFaces& large_faces, RadiusStatistics& results)
      : large_faces_(large_faces),
        height_differences_(wanted(query, HEIGHT_DIFFERENCE, results.height_differences)),
        height_differences_around_(
            wanted(query, HEIGHT_DIFFERENCE_AROUND, results.height_differences_around)),
        roughnesses_(wanted(query, ROUGHNESS, results.roughnesses)),
        roughnesses_around_(wanted(query, ROUGHNESS_AROUND, results.roughnesses_around)),
        ridges_(wanted(query, RIDGE, results.ridges)),
        surface_height_differences_(
            wanted(query, SURFACE_HEIGHT_DIFFERENCE, results.surface_height_differences)),
        surface_height_differences_around_(wanted(query, SURFACE_HEIGHT_DIFFERENCE_AROUND,
                                                  results.surface_height_differences_around))
  {
  }

  /// `members` are the places of the vertices around the one in place `center`, itself among them.
  void write(const RadiusMesh& mesh, std::uint32_t center, ArrayView<std::uint32_t> members) const
  {
    const RadiusAttributes& of = mesh.attributes;
    const std::size_t v = mesh.indexOf(center);
    if (height_differences_ != nullptr || surface_height_differences_ != nullptr) {
      writeHeights(heightsOf(of.heights.data(), members), mesh, center, members,
                   height_differences_, surface_height_differences_);
    }
    if (height_differences_around_ != nullptr || surface_height_differences_around_ != nullptr) {
      writeHeights(heightsAround(of.heights.data(), center, members), mesh, center, members,
                   height_differences_around_, surface_height_differences_around_);
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
      ridges_[v] = ridge(of, center, members);
    }
  }

 private:
  static float* wanted(const RadiusQuery& query, RadiusStatistic statistic,
                       std::vector<float>& results)
  {
    return (query.wanted & statistic) != 0 ? results.data() : nullptr;
  }

  /// Given the heights of the members that count.
  void writeHeights(HeightRange range, const RadiusMesh& mesh, std::uint32_t center,
                    ArrayView<std::uint32_t> members, float* of_vertices, float* of_surface) const
  {
    const std::size_t v = mesh.indexOf(center);
    if (of_vertices != nullptr) {
      of_vertices[v] = range.size();
    }
    if (of_surface != nullptr) {
      if (mesh.touched.size() > 0) {
        for (const std::uint32_t u : members) {
          if (mesh.touched[u] != 0) {
            large_faces_.addHeights(v, mesh.indexOf(u), range);
          }
        }
      }
      of_surface[v] = range.size();
    }
  }

  const LargeFaces& large_faces_;
  float* height_differences_;
  float* height_differences_around_;
  float* roughnesses_;
  float* roughnesses_around_;
  float* ridges_;
  float* surface_height_differences_;
  float* surface_height_differences_around_;
};

constexpr std::size_t VERTICES_PER_CHUNK = 4096;

/// What a mesh has beside positions and neighbors, in its order.
void gather(const RadiusQuery& query, const LargeFaces& large_faces, RadiusMesh& mesh)
{
  mesh.attributes = gatherAttributes(query, mesh.order);
  const ArrayView<std::uint8_t> touched = large_faces.touched();
  mesh.touched.resize(touched.size());
  for (std::uint32_t place = 0; place < touched.size(); ++place) {
    mesh.touched[place] = touched[mesh.indexOf(place)];
  }
}

void statisticsOfEach(const RadiusQuery& query, const RadiusMesh& mesh, const RadiusWriter& writer)
{
  const auto one = [neighborhood = RadiusNeighborhood(mesh.positions, mesh.neighbors),
                    radius = query.radius, &mesh, writer](std::size_t place) mutable {
    const auto center = static_cast<std::uint32_t>(place);
    writer.write(mesh, center, neighborhood.find(center, radius));
  };
  parallelEach(mesh.positions.size(), VERTICES_PER_CHUNK, query.threads, one);
}

/// A thread's share of the vertices, a few beside each other at a time.
class GroupWorker
{
 public:
  GroupWorker(const RadiusMesh& mesh, double radius, const RadiusWriter& writer)
      : mesh_(mesh),
        writer_(writer),
        squared_radius_(radius * radius),
        neighborhoods_(mesh.positions, mesh.neighbors, radius)
  {
  }

  void work(std::size_t begin, std::size_t end)
  {
    begin_ = begin;
    left_.assign(end - begin, 1);
    for (std::size_t place = begin; place < end; ++place) {
      if (left_[place - begin] == 0) {
        continue;
      }
      choose(static_cast<std::uint32_t>(place));
      neighborhoods_.find(group_);
      for (unsigned k = 0; k < group_.size(); ++k) {
        writer_.write(mesh_, group_[k], neighborhoods_.around(k));
      }
    }
  }

 private:
  ArrayView<std::uint32_t> neighborsOf(std::uint32_t place) const
  {
    const std::uint32_t begin = mesh_.neighbors.offsets[place];
    return {mesh_.neighbors.values.data() + begin, mesh_.neighbors.offsets[place + 1] - begin};
  }
  bool isLeft(std::uint32_t place) const
  {
    return place - begin_ < left_.size() && left_[place - begin_] != 0;
  }
  std::size_t countLeft(std::uint32_t place) const
  {
    std::size_t count = 0;
    for (const std::uint32_t to : neighborsOf(place)) {
      count += isLeft(to);
    }
    return count;
  }
  bool isNear(std::uint32_t a, std::uint32_t b) const
  {
    const Vector3 way = between(mesh_.positions[a], mesh_.positions[b]);
    return dot(way, way) < squared_radius_;
  }
  void take(std::uint32_t place)
  {
    group_.push_back(place);
    left_[place - begin_] = 0;
  }

  /// A group with this vertex, around the one of its neighbors that has most beside it.
  void choose(std::uint32_t place)
  {
    std::uint32_t center = place;
    std::size_t most = 0;
    for (const std::uint32_t to : neighborsOf(place)) {
      if (isLeft(to) && isNear(place, to)) {
        const std::size_t count = countLeft(to);
        center = count > most ? to : center;
        most = std::max(most, count);
      }
    }
    group_.clear();
    take(center);
    if (center != place) {
      take(place);
    }
    for (const std::uint32_t to : neighborsOf(center)) {
      if (group_.size() == NeighborhoodGroup::AT_MOST) {
        break;
      }
      if (isLeft(to) && isNear(center, to)) {
        take(to);
      }
    }
  }

  const RadiusMesh& mesh_;
  RadiusWriter writer_;
  double squared_radius_;
  NeighborhoodGroup neighborhoods_;
  std::size_t begin_ = 0;
  std::vector<std::uint8_t> left_;  // per vertex of the share
  std::vector<std::uint32_t> group_;
};

void statisticsOfGroups(const RadiusQuery& query, const RadiusMesh& mesh,
                        const RadiusWriter& writer)
{
  parallelFor(mesh.positions.size(), VERTICES_PER_CHUNK, query.threads, [&]() -> RangeBody {
    const auto worker = std::make_shared<GroupWorker>(mesh, query.radius, writer);
    return [worker](std::size_t begin, std::size_t end) { worker->work(begin, end); };
  });
}

/// Some edges: how long they are, and how far their ends are apart in the arrays.
struct EdgeSample
{
  double mean_length = 0.0;
  double far = 0.0;  // share of those that lead to another part of the arrays

  EdgeSample(const std::vector<PackedPosition>& positions, const RowsView& neighbors)
  {
    constexpr std::size_t samples = 1000;
    constexpr std::size_t parts = 32;
    const std::size_t count = positions.size(), step = count / samples + 1;
    std::size_t edges = 0;
    for (std::size_t v = 0; v < count; v += step) {
      for (std::uint32_t k = neighbors.offsets[v]; k < neighbors.offsets[v + 1]; ++k, ++edges) {
        const std::size_t to = neighbors.values[k];
        mean_length += norm(between(positions[v], positions[to]));
        far += std::max(v, to) - std::min(v, to) > count / parts;
      }
    }
    mean_length /= static_cast<double>(std::max<std::size_t>(edges, 1));
    far /= static_cast<double>(std::max<std::size_t>(edges, 1));
  }
};

/// The pass in the order of a grid: see RadiusSearch::GRID.
void statisticsByGrid(const RadiusQuery& query, const LargeFaces& large_faces, RadiusMesh mesh,
                      double edge_length, const RadiusWriter& writer)
{
  constexpr double edges_across_cell = 16.0;
  const bool has_size = edge_length > 0.0 && edge_length < 1e15;
  const double cell_size = has_size ? edges_across_cell * edge_length : query.radius;
  const LargeArray<std::uint32_t> order = spatialOrder(query.positions, cell_size, query.threads);
  const std::size_t count = order.size();
  const ArrayView<std::uint32_t> old_offsets = query.neighbors.offsets;
  LargeArray<std::uint32_t> places(count), offsets(count + 1);
  LargeArray<std::uint32_t> neighbors(query.neighbors.values.size());
  offsets[0] = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t v = order[i];
    places[v] = static_cast<std::uint32_t>(i);
    offsets[i + 1] = offsets[i] + (old_offsets[v + 1] - old_offsets[v]);
  }
  parallelEach(count, VERTICES_PER_CHUNK, query.threads, [&](std::size_t i) {
    const std::uint32_t v = order[i];
    const float* const at = query.positions.data() + 3 * std::size_t{v};
    mesh.positions[i] = {at[0], at[1], at[2], 0.0f};
    std::uint32_t* to = neighbors.data() + offsets[i];
    for (std::uint32_t k = old_offsets[v]; k < old_offsets[v + 1]; ++k) {
      *to++ = places[query.neighbors.values[k]];
    }
  });
  mesh.order = {order.data(), count};
  mesh.neighbors = {{offsets.data(), count + 1}, {neighbors.data(), neighbors.size()}};
  gather(query, large_faces, mesh);
  statisticsOfGroups(query, mesh, writer);
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
  roomFor(SURFACE_HEIGHT_DIFFERENCE, results.surface_height_differences);
  roomFor(SURFACE_HEIGHT_DIFFERENCE_AROUND, results.surface_height_differences_around);
  constexpr unsigned of_surface = SURFACE_HEIGHT_DIFFERENCE | SURFACE_HEIGHT_DIFFERENCE_AROUND;
  LargeFaces large_faces;
  if ((query.wanted & of_surface) != 0) {
    large_faces = LargeFaces({query.positions, query.faces}, query.vertex_faces, query.radius,
                             query.up, query.threads);
  }
  const RadiusWriter writer(query, large_faces, results);
  RadiusMesh mesh{packPositions(query.positions), query.neighbors, {}, {}, {}};
  const bool in_groups =
      query.search != RadiusSearch::EDGES && NeighborhoodGroup::fits(query.radius);
  if (in_groups && count > 0) {
    // Measured: from about there on, memory is waited for.
    constexpr std::size_t large = 30'000;
    constexpr double much = 0.1;
    const EdgeSample edges(mesh.positions, mesh.neighbors);
    if (query.search == RadiusSearch::GRID || (count > large && edges.far > much)) {
      statisticsByGrid(query, large_faces, std::move(mesh), edges.mean_length, writer);
      return results;
    }
  }
  gather(query, large_faces, mesh);
  if (in_groups) {
    statisticsOfGroups(query, mesh, writer);
  } else {
    statisticsOfEach(query, mesh, writer);
  }
  return results;
}

}  // namespace mesh_map
