#include "collision/collision.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/require.h"
#include "base/run.h"
#include "bvh/tree/bvh_box_search.h"
#include "collision/body_band.h"
#include "collision/ground.h"
#include "collision/material.h"

namespace mesh_map {

namespace {

constexpr std::size_t CHUNK = 1024;

const float* cornersOf(const Bvh& bvh, std::size_t triangle)
{
  return bvh.corners().data() + 9 * triangle;
}

/// What is no more than rounding: 0.1 mm, or four times the distance of neighboring floats.
double slackOf(const MeshView& mesh)
{
  float largest = 0.0f;
  for (const float coordinate : mesh.positions) {
    largest = std::max(largest, std::abs(coordinate));
  }
  const float next = std::nextafter(largest, std::numeric_limits<float>::infinity());
  return std::max(1e-4, 4.0 * (double{next} - largest));
}

/// For each face, HAS_CELLS, and bits 1, 2 and 4 of the corners whose cells are below something.
std::vector<std::uint8_t> coveredCorners(const Bvh& bvh, const CollisionQuery& query,
                                         const BodyHeights& heights, double slack, Run& run)
{
  std::vector<std::uint8_t> covered(query.mesh.faceCount(), 0);
  run.each(covered.size(), CHUNK, 0.4, [&](std::size_t face) {
    const FaceBand band(query.mesh, face, heights, slack);
    constexpr unsigned all = 7;
    unsigned found = 0;
    for (unsigned k = 0; k < 3 && !query.rooms.empty(); ++k) {
      const float room = query.rooms[query.mesh.faces[3 * face + k]];
      found |= room > heights.low && room < heights.high ? 1u << k : 0u;
    }
    if (band.valid() && found != all) {
      searchBox(bvh, band.lower(), band.upper(), [&](std::size_t i) {
        found |= band.cornersBelow(cornersOf(bvh, i), all & ~found);
        return found == all;
      });
    }
    covered[face] = static_cast<std::uint8_t>(found | (band.valid() ? HAS_CELLS : 0u));
  });
  return covered;
}

/// collisions() without a radius, from coveredCorners().
std::vector<std::uint8_t> pointCollisions(const Bvh& bvh, const CollisionQuery& query,
                                          const BodyHeights& heights, double slack,
                                          const std::vector<std::uint8_t>& covered, Run& run,
                                          unsigned threads)
{
  const MeshView& mesh = query.mesh;
  const Material material(bvh, mesh, query.solids, run, threads);
  std::vector<std::uint8_t> found(mesh.vertexCount(), 0);
  run.loop(found.size(), CHUNK, 0.2, [&]() -> RangeBody {
    return [&, inside = std::vector<std::uint32_t>()](std::size_t begin, std::size_t end) mutable {
      for (std::size_t v = begin; v < end; ++v) {
        bool has_cell = false, meets = false;
        for (std::size_t j = query.vertex_faces.offsets[v]; j < query.vertex_faces.offsets[v + 1];
             ++j) {
          const std::size_t face = query.vertex_faces.values[j];
          has_cell = has_cell || (covered[face] & HAS_CELLS) != 0;
          for (std::size_t k = 0; k < 3; ++k) {
            meets = meets || (mesh.faces[3 * face + k] == v && (covered[face] >> k & 1u) != 0);
          }
        }
        const float* const foot = mesh.vertex(v);
        if (!has_cell) {
          const VertexBand band(foot, heights, slack);
          meets = searchBox(bvh, band.lower(), band.upper(),
                            [&](std::size_t i) { return band.meets(cornersOf(bvh, i)); });
        }
        const bool open = !query.rooms.empty() && std::isinf(query.rooms[v]);
        if (!meets && !open && !material.empty()) {
          const double middle = foot[2] + 0.5 * (heights.low + heights.high);
          meets = material.at({foot[0], foot[1], middle}, inside);
        }
        found[v] = meets ? 1 : 0;
      }
    };
  });
  return found;
}

/// Adds what the body meets with its radius.
void addBodyCollisions(const Bvh& bvh, const CollisionQuery& query, const BodyHeights& heights,
                       const std::vector<std::uint8_t>& covered, std::vector<std::uint8_t>& found,
                       Run& run)
{
  const std::vector<std::uint8_t> closed = found;
  const std::vector<std::uint32_t> surfaces = surfacesOf(query.mesh);
  run.loop(found.size(), CHUNK, 0.4, [&]() -> RangeBody {
    return [&, ground = Ground(query.mesh, query.vertex_faces, covered, closed, heights.low)](
               std::size_t begin, std::size_t end) mutable {
      for (std::size_t v = begin; v < end; ++v) {
        if (closed[v] != 0) {
          continue;
        }
        const VertexBand body(query.mesh.vertex(v), heights, query.radius);
        ground.begin(static_cast<std::uint32_t>(v), body);
        const bool is_obstacle = searchBox(bvh, body.lower(), body.upper(), [&](std::size_t i) {
          if (!body.meets(cornersOf(bvh, i))) {
            return false;
          }
          const std::uint32_t face = bvh.faces()[i];
          ground.want(face);
          return surfaces[query.mesh.faces[3 * std::size_t{face}]] != surfaces[v] ||
                 !ground.isLow(cornersOf(bvh, i));
        });
        found[v] = is_obstacle || !ground.hasAllWanted() ? 1 : 0;
      }
    };
  });
}

void check(const Bvh& bvh, const CollisionQuery& query)
{
  const std::size_t face_count = query.mesh.faceCount();
  require(bvh.faceCount() == face_count, "the hierarchy is of another mesh");
  require(query.solids.size() == face_count, "one number of a solid per face is needed");
  require(query.vertex_faces.rowCount() == query.mesh.vertexCount(),
          "one row of faces per vertex is needed");
  require(query.rooms.empty() || query.rooms.size() == query.mesh.vertexCount(),
          "one room per vertex is needed, or none");
  for (const std::uint32_t solid : query.solids) {
    require(solid == NO_INDEX || solid < face_count, "there is no solid of such a number");
  }
  require(std::isfinite(query.radius) && query.radius >= 0.0, "the radius has to be 0 or more");
  require(query.step_height >= 0.0 && query.robot_height > query.step_height &&
              std::isfinite(query.robot_height),
          "the robot has to be higher than the steps that it climbs");
}

}  // namespace

std::vector<std::uint8_t> collisions(const Bvh& bvh, const CollisionQuery& query,
                                     const BvhOptions& options)
{
  check(bvh, query);
  Run run(options);
  const double slack = slackOf(query.mesh);
  const BodyHeights heights = {query.step_height + slack, query.robot_height - slack};
  require(heights.high > heights.low,
          "steps are as high as the robot, by " + std::to_string(slack) + " m");
  const std::vector<std::uint8_t> covered = coveredCorners(bvh, query, heights, slack, run);
  std::vector<std::uint8_t> found =
      pointCollisions(bvh, query, heights, slack, covered, run, options.threads);
  if (query.radius > 0.0) {
    addBodyCollisions(bvh, query, heights, covered, found, run);
  }
  run.finish();
  return found;
}

}  // namespace mesh_map
