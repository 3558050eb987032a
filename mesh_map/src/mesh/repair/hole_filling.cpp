#include "mesh/repair/hole_filling.h"

#include <mesh_map/base/parallel.h>
#include <mesh_map/mesh/topology.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "mesh/repair/hole_patch.h"
#include "mesh/repair/triangle_crossing.h"

namespace mesh_map {
namespace {

struct Box
{
  Vector3 low = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                 std::numeric_limits<double>::infinity()};
  Vector3 high = -low;

  void add(const Vector3& point)
  {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], point[k]);
      high[k] = std::max(high[k], point[k]);
    }
  }

  bool meets(const Box& other) const
  {
    for (std::size_t k = 0; k < 3; ++k) {
      if (low[k] > other.high[k] || high[k] < other.low[k]) {
        return false;
      }
    }
    return true;
  }

  double diagonal() const { return high[0] < low[0] ? 0.0 : distance(low, high); }
};

/// Boxes by the cells of a grid that they are in; those that are in very many are kept apart.
class BoxGrid
{
 public:
  explicit BoxGrid(const std::vector<Box>& boxes) : boxes_(boxes)
  {
    std::vector<double> sizes;
    for (const Box& box : boxes) {
      sizes.push_back(box.diagonal());
    }
    if (!sizes.empty()) {
      std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(sizes.size() / 2),
                       sizes.end());
      cell_ = std::max(2.0 * sizes[sizes.size() / 2], 1e-6);
    }
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      if (!visitCells(boxes[i], [&](std::uint64_t cell) { cells_[cell].push_back(i); })) {
        large_.push_back(i);
      }
    }
  }

  /// visit(i) for each box that meets this one, some more than once.
  template <class Visit>
  void visitMeeting(const Box& box, const Visit& visit) const
  {
    const auto visitIf = [&](std::uint32_t i) {
      if (boxes_[i].meets(box)) {
        visit(i);
      }
    };
    for (const std::uint32_t i : large_) {
      visitIf(i);
    }
    const bool few = visitCells(box, [&](std::uint64_t cell) {
      const auto found = cells_.find(cell);
      if (found != cells_.end()) {
        std::for_each(found->second.begin(), found->second.end(), visitIf);
      }
    });
    for (std::uint32_t i = 0; !few && i < boxes_.size(); ++i) {
      visitIf(i);
    }
  }

 private:
  /// visit(cell) for the cells of a box; false, and nothing visited, where they are too many.
  template <class Visit>
  bool visitCells(const Box& box, const Visit& visit) const
  {
    constexpr double most = 64.0;
    std::array<std::int64_t, 3> low, high;
    double count = 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double first = std::floor(box.low[k] / cell_), last = std::floor(box.high[k] / cell_);
      count *= last - first + 1.0;
      if (!(count <= most) || std::abs(first) > 1e15 || std::abs(last) > 1e15) {
        return false;
      }
      low[k] = static_cast<std::int64_t>(first);
      high[k] = static_cast<std::int64_t>(last);
    }
    for (std::int64_t x = low[0]; x <= high[0]; ++x) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          // Cells that share a number only cost a comparison of boxes.
          visit(static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15u ^
                static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4Fu ^
                static_cast<std::uint64_t>(z) * 0x165667B19E3779F9u);
        }
      }
    }
    return true;
  }

  const std::vector<Box>& boxes_;
  double cell_ = 1.0;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
  std::vector<std::uint32_t> large_;
};

/// The eigenvector of the smallest eigenvalue of a symmetric matrix, by Jacobi's rotations.
Vector3 smallestAxis(std::array<Vector3, 3> matrix)
{
  std::array<Vector3, 3> axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // columns
  for (int sweep = 0; sweep < 20; ++sweep) {
    for (std::size_t p = 0; p < 2; ++p) {
      for (std::size_t q = p + 1; q < 3; ++q) {
        if (matrix[p][q] == 0.0) {
          continue;
        }
        const double theta = 0.5 * std::atan2(2.0 * matrix[p][q], matrix[q][q] - matrix[p][p]);
        const double c = std::cos(theta), s = std::sin(theta);
        for (std::size_t k = 0; k < 3; ++k) {
          const double kp = matrix[k][p], kq = matrix[k][q];
          matrix[k][p] = c * kp - s * kq;
          matrix[k][q] = s * kp + c * kq;
        }
        for (std::size_t k = 0; k < 3; ++k) {
          const double pk = matrix[p][k], qk = matrix[q][k];
          matrix[p][k] = c * pk - s * qk;
          matrix[q][k] = s * pk + c * qk;
          const double ap = axes[k][p], aq = axes[k][q];
          axes[k][p] = c * ap - s * aq;
          axes[k][q] = s * ap + c * aq;
        }
      }
    }
  }
  std::size_t least = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    least = matrix[k][k] < matrix[least][least] ? k : least;
  }
  return {axes[0][least], axes[1][least], axes[2][least]};
}

std::uint64_t edgeKey(std::uint32_t a, std::uint32_t b)
{
  return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
}

class HoleFiller
{
 public:
  HoleFiller(const MeshView& mesh, const HoleLimits& limits, unsigned threads)
      : mesh_(mesh),
        limits_(limits),
        threads_(threads),
        topology_(buildTopology(mesh.faces, mesh.vertexCount(), threads))
  {
    result_.loops = borderLoops(mesh.faces, topology_);
  }

  HoleFilling fill()
  {
    judgeLoops();
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t loop = 0; loop < result_.fates.size(); ++loop) {
      if (fateOf(loop) == HoleFate::FILLED) {
        wanted.push_back(loop);
      }
    }
    patches_.resize(wanted.size());
    holes_.resize(wanted.size());
    parallelFor(wanted.size(), 1, threads_, [&]() -> RangeBody {
      return [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          propose(i, wanted[i]);
        }
      };
    });
    for (const HolePatch& patch : patches_) {
      Box box;
      for (const Vector3& point : patch.points) {
        box.add(point);
      }
      boxes_.push_back(box);
    }
    const BoxGrid grid(boxes_);
    findCrossings(grid);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      accept(i, wanted[i], grid);
    }
    return std::move(result_);
  }

 private:
  HoleFate fateOf(std::uint32_t loop) const { return static_cast<HoleFate>(result_.fates[loop]); }

  void setFate(std::uint32_t loop, HoleFate fate)
  {
    result_.fates[loop] = static_cast<std::uint8_t>(fate);
  }

  Vector3 pointAt(std::uint32_t vertex) const { return pointOf(mesh_.vertex(vertex)); }

  // Which loops are holes.

  void judgeLoops()
  {
    const BorderLoops& loops = result_.loops;
    result_.fates.assign(loops.size(), static_cast<std::uint8_t>(HoleFate::FILLED));
    result_.perimeters.assign(loops.size(), 0.0);
    result_.deviations.assign(loops.size(), 0.0);
    normals_.resize(loops.size());
    parallelEach(loops.size(), 64, threads_,
                 [this](std::size_t loop) { judge(static_cast<std::uint32_t>(loop)); });
    if (limits_.keep_outer) {
      markOuter();
    }
  }

  void judge(std::uint32_t loop)
  {
    const std::uint32_t* const vertices = result_.loops.vertices.data();
    const std::uint32_t begin = result_.loops.offsets[loop], end = result_.loops.offsets[loop + 1];
    double perimeter = 0.0;
    Vector3 middle = {0.0, 0.0, 0.0};
    for (std::uint32_t i = begin; i < end; ++i) {
      const Vector3 a = pointAt(vertices[i]), b = pointAt(vertices[i + 1 < end ? i + 1 : begin]);
      const double length = distance(a, b);
      perimeter += length;
      middle = middle + 0.5 * length * (a + b);
    }
    middle = perimeter > 0.0 ? middle / perimeter : pointAt(vertices[begin]);
    std::array<Vector3, 3> spread = {};
    for (std::uint32_t i = begin; i < end; ++i) {
      const Vector3 a = pointAt(vertices[i]) - middle;
      const double weight =
          distance(pointAt(vertices[i]), pointAt(vertices[i + 1 < end ? i + 1 : begin])) +
          distance(pointAt(vertices[i]), pointAt(vertices[i > begin ? i - 1 : end - 1]));
      for (std::size_t p = 0; p < 3; ++p) {
        spread[p] = spread[p] + weight * a[p] * a;
      }
    }
    const Vector3 normal = smallestAxis(spread);
    double deviation = 0.0;
    for (std::uint32_t i = begin; i < end; ++i) {
      deviation = std::max(deviation, std::abs(dot(pointAt(vertices[i]) - middle, normal)));
    }
    result_.perimeters[loop] = perimeter;
    result_.deviations[loop] = deviation;
    normals_[loop] = normal;
    const double slope = std::acos(std::min(1.0, std::abs(dot(normal, limits_.up))));
    if (!(perimeter < limits_.perimeter)) {
      setFate(loop, HoleFate::LONG);
    } else if (!(deviation <= limits_.flatness * perimeter)) {
      setFate(loop, HoleFate::UNEVEN);
    } else if (slope > limits_.slope) {
      setFate(loop, HoleFate::STEEP);
    }
  }

  void markOuter()
  {
    const BorderLoops& loops = result_.loops;
    std::vector<std::uint32_t> longest(topology_.component_count, NO_INDEX);
    for (std::uint32_t loop = 0; loop < loops.size(); ++loop) {
      std::uint32_t& best = longest[componentOf(loop)];
      if (best == NO_INDEX || result_.perimeters[loop] > result_.perimeters[best]) {
        best = loop;
      }
    }
    std::vector<Box> boxes(topology_.component_count);
    for (std::uint32_t v = 0; v < mesh_.vertexCount(); ++v) {
      boxes[std::size_t(topology_.components[v])].add(pointAt(v));
    }
    for (std::size_t component = 0; component < longest.size(); ++component) {
      const std::uint32_t loop = longest[component];
      if (loop != NO_INDEX) {
        Box box;
        for (std::uint32_t i = loops.offsets[loop]; i < loops.offsets[loop + 1]; ++i) {
          box.add(pointAt(loops.vertices[i]));
        }
        if (box.diagonal() >= 0.5 * boxes[component].diagonal()) {
          setFate(loop, HoleFate::OUTER);
        }
      }
    }
  }

  std::size_t componentOf(std::uint32_t loop) const
  {
    return std::size_t(topology_.components[result_.loops.vertices[result_.loops.offsets[loop]]]);
  }

  // What closes one.

  /// The vertices of a loop in the order of the faces that close it, and the faces beside.
  struct Hole
  {
    std::vector<std::uint32_t> vertices, faces;
    bool is_crossed = false;
  };

  void propose(std::size_t i, std::uint32_t loop)
  {
    const BorderLoops& loops = result_.loops;
    const std::uint32_t begin = loops.offsets[loop], end = loops.offsets[loop + 1];
    Hole& hole = holes_[i];
    hole = {};
    HoleLoop shape;
    shape.normal = normals_[loop];
    for (std::uint32_t k = end; k-- > begin;) {
      hole.vertices.push_back(loops.vertices[k]);
      hole.faces.push_back(loops.faces[k > begin ? k - 1 : end - 1]);
    }
    for (std::size_t k = 0; k < hole.vertices.size(); ++k) {
      const std::uint32_t face = hole.faces[k];
      shape.points.push_back(pointAt(hole.vertices[k]));
      shape.beside.push_back(besideNormal(face));
      shape.spacing.push_back(spacingAt(hole.vertices[k]));
    }
    const EdgeTest has_edge = [this, &hole](std::size_t a, std::size_t b) {
      return hasEdge(hole.vertices[a], hole.vertices[b]);
    };
    HolePatch& patch = patches_[i];
    patch = closedHole(shape, has_edge);
    if (!patch.faces.empty() && limits_.refine) {
      HolePatch fine = patch;
      refinePatch(shape, has_edge, fine);
      if (largestFold(shape, rounded(fine)) <= limits_.fold) {
        patch = rounded(fine);
      }
    }
    if (patch.faces.empty() || largestFold(shape, patch) > limits_.fold) {
      patch.faces.clear();
      setFate(loop, HoleFate::FOLDED);
    }
  }

  /// The normal of a face; 0 of one so thin that it says nothing.
  Vector3 besideNormal(std::uint32_t face) const
  {
    const float *const a = mesh_.corner(face, 0), *const b = mesh_.corner(face, 1),
                       *const c = mesh_.corner(face, 2);
    const Vector3 normal = triangleNormal(a, b, c), none = {0.0, 0.0, 0.0};
    double longest = 0.0;
    for (const Vector3& side : {difference(b, a), difference(c, b), difference(a, c)}) {
      longest = std::max(longest, dot(side, side));
    }
    return norm(normal) > 0.02 * longest ? normal : none;
  }

  /// The points as they will be stored.
  static HolePatch rounded(HolePatch patch)
  {
    for (Vector3& point : patch.points) {
      for (double& value : point) {
        value = static_cast<double>(static_cast<float>(value));
      }
    }
    return patch;
  }

  double spacingAt(std::uint32_t vertex) const
  {
    double sum = 0.0;
    const std::uint32_t begin = topology_.neighbor_offsets[vertex],
                        end = topology_.neighbor_offsets[vertex + 1];
    for (std::uint32_t i = begin; i < end; ++i) {
      sum += distance(pointAt(vertex), pointAt(topology_.neighbors[i]));
    }
    return sum / double(end - begin);
  }

  bool hasEdge(std::uint32_t a, std::uint32_t b) const
  {
    const std::uint32_t* const neighbors = topology_.neighbors.data();
    const auto found = std::binary_search(neighbors + topology_.neighbor_offsets[a],
                                          neighbors + topology_.neighbor_offsets[a + 1], b);
    return a == b || found || new_edges_.count(edgeKey(a, b)) > 0;
  }

  // Whether it fits in.

  /// Marks the holes whose patches cross the mesh.
  void findCrossings(const BoxGrid& grid)
  {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // (hole, face)
    for (std::uint32_t face = 0; face < mesh_.faceCount() && !boxes_.empty(); ++face) {
      Box box;
      for (std::size_t k = 0; k < 3; ++k) {
        box.add(pointOf(mesh_.corner(face, k)));
      }
      grid.visitMeeting(box, [&](std::uint32_t i) { pairs.emplace_back(i, face); });
    }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    std::vector<std::size_t> starts(holes_.size() + 1, pairs.size());
    for (std::size_t k = pairs.size(); k-- > 0;) {
      starts[pairs[k].first] = k;
    }
    for (std::size_t i = holes_.size(); i-- > 0;) {
      starts[i] = std::min(starts[i], starts[i + 1]);
    }
    near_faces_.resize(holes_.size());
    parallelEach(holes_.size(), 1, threads_, [&](std::size_t i) {
      for (std::size_t k = starts[i]; k < starts[i + 1]; ++k) {
        near_faces_[i].push_back(pairs[k].second);
      }
      holes_[i].is_crossed = crossesMesh(i);
    });
  }

  bool crossesMesh(std::size_t i) const
  {
    for (const std::uint32_t face : near_faces_[i]) {
      const std::uint32_t* const corners = mesh_.faces.data() + 3 * std::size_t{face};
      const Triangle triangle = {pointAt(corners[0]), pointAt(corners[1]), pointAt(corners[2])};
      if (crosses(i, triangle, {corners[0], corners[1], corners[2]})) {
        return true;
      }
    }
    return false;
  }

  /// Whether a patch crosses a triangle with these vertices.
  bool crosses(std::size_t i, const Triangle& triangle,
               const std::array<std::uint32_t, 3>& vertices) const
  {
    Box box;
    std::for_each(triangle.begin(), triangle.end(), [&](const Vector3& p) { box.add(p); });
    for (std::size_t f = 0; f < patches_[i].faces.size(); ++f) {
      const Triangle own = triangleOf(i, f);
      Box own_box;
      std::for_each(own.begin(), own.end(), [&](const Vector3& p) { own_box.add(p); });
      if (!own_box.meets(box)) {
        continue;
      }
      unsigned shared_of_own = 0, shared = 0;
      for (unsigned k = 0; k < 3; ++k) {
        for (unsigned l = 0; l < 3; ++l) {
          const std::uint32_t corner = patches_[i].faces[f][k];
          if (corner < holes_[i].vertices.size() && holes_[i].vertices[corner] == vertices[l]) {
            shared_of_own |= 1u << k;
            shared |= 1u << l;
          }
        }
      }
      if (trianglesCross(own, shared_of_own, triangle, shared)) {
        return true;
      }
    }
    return false;
  }

  Triangle triangleOf(std::size_t i, std::size_t face) const
  {
    const HolePatch& patch = patches_[i];
    return {patch.points[patch.faces[face][0]], patch.points[patch.faces[face][1]],
            patch.points[patch.faces[face][2]]};
  }

  /// Of new vertices another number than any vertex of the mesh.
  std::array<std::uint32_t, 3> verticesOf(std::size_t i, std::size_t face) const
  {
    std::array<std::uint32_t, 3> vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t corner = patches_[i].faces[face][k];
      vertices[k] = corner < holes_[i].vertices.size() ? holes_[i].vertices[corner] : NO_INDEX;
    }
    return vertices;
  }

  bool crossesAccepted(std::size_t i, const BoxGrid& grid) const
  {
    bool found = false;
    grid.visitMeeting(boxes_[i], [&](std::uint32_t other) {
      if (found || other == i || accepted_.count(other) == 0) {
        return;
      }
      for (std::size_t face = 0; face < patches_[other].faces.size() && !found; ++face) {
        found = crosses(i, triangleOf(other, face), verticesOf(other, face));
      }
    });
    return found;
  }

  bool hasTakenEdge(std::size_t i) const
  {
    for (const HolePatch::Face& face : patches_[i].faces) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = face[k], b = face[(k + 1) % 3];
        const std::vector<std::uint32_t>& vertices = holes_[i].vertices;
        if (a < vertices.size() && b < vertices.size() &&
            new_edges_.count(edgeKey(vertices[a], vertices[b])) > 0) {
          return true;
        }
      }
    }
    return false;
  }

  void accept(std::size_t i, std::uint32_t loop, const BoxGrid& grid)
  {
    if (!patches_[i].faces.empty() && hasTakenEdge(i)) {
      propose(i, loop);  // without the edges of the holes before
      holes_[i].is_crossed = crossesMesh(i);
    }
    if (patches_[i].faces.empty()) {
      return;
    }
    if (holes_[i].is_crossed || crossesAccepted(i, grid)) {
      setFate(loop, HoleFate::CROSSING);
      return;
    }
    accepted_.insert(static_cast<std::uint32_t>(i));
    write(i);
  }

  void write(std::size_t i)
  {
    const HolePatch& patch = patches_[i];
    const Hole& hole = holes_[i];
    const std::size_t loop_count = hole.vertices.size();
    if (result_.faces.size() / 3 + patch.faces.size() > limits_.face_limit) {
      throw std::length_error("more new faces than " + std::to_string(limits_.face_limit));
    }
    const auto first = static_cast<std::uint32_t>(mesh_.vertexCount() + result_.points.size() / 3);
    for (std::size_t v = loop_count; v < patch.points.size(); ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        result_.points.push_back(static_cast<float>(patch.points[v][k]));
        result_.vertex_parents.push_back(hole.vertices[patch.sources[v - loop_count][k]]);
        result_.vertex_weights.push_back(patch.weights[v - loop_count][k]);
      }
    }
    const auto number = [&](std::uint32_t v) {
      return v < loop_count ? hole.vertices[v] : first + v - static_cast<std::uint32_t>(loop_count);
    };
    for (const HolePatch::Face& face : patch.faces) {
      for (std::size_t k = 0; k < 3; ++k) {
        result_.faces.push_back(number(face[k]));
        new_edges_.insert(edgeKey(number(face[k]), number(face[(k + 1) % 3])));
      }
    }
    const std::vector<std::uint32_t> parents = facesBeside(hole, patch);
    result_.face_parents.insert(result_.face_parents.end(), parents.begin(), parents.end());
  }

  /// For each face of a patch the face beside the loop that is the fewest faces away.
  static std::vector<std::uint32_t> facesBeside(const Hole& hole, const HolePatch& patch)
  {
    std::unordered_map<std::uint64_t, std::uint32_t> sides;  // directed -> face of the patch
    const auto key = [](std::uint32_t a, std::uint32_t b) { return (std::uint64_t{a} << 32) | b; };
    for (std::uint32_t f = 0; f < patch.faces.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        sides[key(patch.faces[f][k], patch.faces[f][(k + 1) % 3])] = f;
      }
    }
    std::vector<std::uint32_t> parents(patch.faces.size(), NO_INDEX), queue;
    for (std::uint32_t i = 0; i < hole.vertices.size(); ++i) {
      const auto next = static_cast<std::uint32_t>((i + 1) % hole.vertices.size());
      const std::uint32_t face = sides.at(key(i, next));
      if (parents[face] == NO_INDEX) {
        parents[face] = hole.faces[i];
        queue.push_back(face);
      }
    }
    for (std::size_t at = 0; at < queue.size(); ++at) {
      const HolePatch::Face& face = patch.faces[queue[at]];
      for (std::size_t k = 0; k < 3; ++k) {
        const auto other = sides.find(key(face[(k + 1) % 3], face[k]));
        if (other != sides.end() && parents[other->second] == NO_INDEX) {
          parents[other->second] = parents[queue[at]];
          queue.push_back(other->second);
        }
      }
    }
    return parents;
  }

  MeshView mesh_;
  HoleLimits limits_;
  unsigned threads_;
  Topology topology_;
  HoleFilling result_;
  std::vector<Vector3> normals_;    // of the best planes, one per loop
  std::vector<Hole> holes_;         // those that are to be closed
  std::vector<HolePatch> patches_;  // of them; without faces where that does not go
  std::vector<Box> boxes_;          // of them
  std::vector<std::vector<std::uint32_t>> near_faces_;
  std::unordered_set<std::uint64_t> new_edges_;
  std::unordered_set<std::uint32_t> accepted_;
};

}  // namespace

HoleFilling fillHoles(const MeshView& mesh, const HoleLimits& limits, unsigned threads)
{
  return HoleFiller(mesh, limits, threads).fill();
}

}  // namespace mesh_map
