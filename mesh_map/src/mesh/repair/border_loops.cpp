#include "mesh/repair/border_loops.h"

#include <unordered_map>
#include <utility>

namespace mesh_map {
namespace {

std::uint32_t nextSide(std::uint32_t side)
{
  return side % 3 == 2 ? side - 2 : side + 1;
}

/// The sides of faces that lie on the border, and which of them follow each other.
class Border
{
 public:
  Border(ArrayView<std::uint32_t> faces, const Topology& topology)
      : topology_(topology), sides_of_edges_(2 * topology.edgeCount(), NO_INDEX)
  {
    for (std::uint32_t side = 0; side < faces.size(); ++side) {
      const std::uint32_t edge = topology.face_edges[side];
      if (isDegenerate(side) || topology.edge_face_counts[edge] > 2) {
        continue;
      }
      std::uint32_t* const pair = sides_of_edges_.data() + 2 * std::size_t{edge};
      pair[pair[0] != NO_INDEX] = side;
    }
  }

  bool has(std::uint32_t side) const
  {
    return !isDegenerate(side) && topology_.edge_face_counts[topology_.face_edges[side]] == 1;
  }

  /// The side of the border where that of `side` goes on, or NO_INDEX.
  std::uint32_t after(std::uint32_t side) const
  {
    for (std::uint32_t next = nextSide(side);;) {
      const std::uint32_t edge = topology_.face_edges[next];
      const std::uint32_t count = topology_.edge_face_counts[edge];
      if (count == 1) {
        return next;
      }
      if (count != 2 || (topology_.edge_flags[edge] & EDGE_INCONSISTENT) != 0) {
        return NO_INDEX;
      }
      const std::uint32_t* const pair = sides_of_edges_.data() + 2 * std::size_t{edge};
      next = nextSide(pair[pair[0] == next]);
    }
  }

 private:
  bool isDegenerate(std::uint32_t side) const
  {
    return (topology_.face_flags[side / 3] & FACE_DEGENERATE) != 0;
  }

  const Topology& topology_;
  std::vector<std::uint32_t> sides_of_edges_;  // the two of each edge of at most two faces
};

/// Cuts closed ways into simple loops.
class LoopCutter
{
 public:
  LoopCutter(ArrayView<std::uint32_t> faces, BorderLoops& loops) : faces_(faces), loops_(loops) {}

  void cut(const std::vector<std::uint32_t>& way)
  {
    open_.clear();
    places_.clear();
    for (const std::uint32_t side : way) {
      const std::uint32_t vertex = faces_[side];
      const auto seen = places_.find(vertex);
      if (seen != places_.end()) {
        close(seen->second);
      }
      places_[vertex] = open_.size();
      open_.push_back(side);
    }
    close(0);
  }

 private:
  void close(std::size_t begin)
  {
    for (std::size_t i = begin; i < open_.size(); ++i) {
      loops_.vertices.push_back(faces_[open_[i]]);
      loops_.faces.push_back(open_[i] / 3);
      places_.erase(faces_[open_[i]]);
    }
    open_.resize(begin);
    loops_.offsets.push_back(static_cast<std::uint32_t>(loops_.vertices.size()));
  }

  ArrayView<std::uint32_t> faces_;
  BorderLoops& loops_;
  std::vector<std::uint32_t> open_;
  std::unordered_map<std::uint32_t, std::size_t> places_;
};

}  // namespace

BorderLoops borderLoops(ArrayView<std::uint32_t> faces, const Topology& topology)
{
  const Border border(faces, topology);
  BorderLoops loops;
  loops.offsets.assign(1, 0);
  LoopCutter cutter(faces, loops);
  std::vector<std::uint8_t> done(faces.size(), 0);
  std::vector<std::uint32_t> way;
  for (std::uint32_t start = 0; start < faces.size(); ++start) {
    if (done[start] != 0 || !border.has(start)) {
      continue;
    }
    way.clear();
    std::uint32_t side = start;
    do {
      done[side] = 1;
      way.push_back(side);
      side = border.after(side);
    } while (side != NO_INDEX && done[side] == 0);
    if (side == start) {
      cutter.cut(way);
    } else {
      loops.open_edges += way.size();
    }
  }
  return loops;
}

}  // namespace mesh_map
