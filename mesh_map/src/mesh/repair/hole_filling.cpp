#include "mesh/repair/hole_filling.h"

#include <mesh_map/base/parallel.h>
#include <mesh_map/mesh/topology.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "mesh/repair/box_grid.h"
#include "mesh/repair/hole_patch.h"
#include "mesh/repair/triangle_crossing.h"

namespace mesh_map {
namespace {

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
    LoopShapes shapes = loopShapes(mesh_, topology_, result_.loops, limits_, threads_);
    result_.fates = std::move(shapes.fates);
    result_.perimeters = std::move(shapes.perimeters);
    result_.deviations = std::move(shapes.deviations);
    normals_ = std::move(shapes.normals);
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
    write(i, loop);
  }

  void write(std::size_t i, std::uint32_t loop)
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
    result_.face_loops.insert(result_.face_loops.end(), parents.size(), loop);
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
