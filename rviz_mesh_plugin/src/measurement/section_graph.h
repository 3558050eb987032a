#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Surfaces of a section touch up to this distance, in meters.
constexpr double TOUCHING = 1e-3;

/// Of what an upright plane cuts out of a mesh: s is the distance along the line.
struct SectionNode
{
  double s;
  double z;
  bool cut = false;  ///< the surface goes on beyond the line
};

/// What is cut out of a face: from a to b the front of the face is to the left, that is above where
/// s grows.
struct SectionSegment
{
  std::uint32_t a;
  std::uint32_t b;
  std::uint32_t face;      ///< NONE: a joint of two surfaces
  bool two_sided = false;  ///< it is a sheet that has a front on either side
  bool covered = false;    ///< another part lies on it
};

/// Which segments are at each node.
class SectionRows
{
 public:
  SectionRows() = default;
  SectionRows(std::size_t node_count, const std::vector<SectionSegment>& segments);

  /// Calls back with their indices.
  template <class Visit>
  void visit(std::uint32_t node, const Visit& visit) const
  {
    for (std::size_t i = offsets_[node]; i < offsets_[node + 1]; ++i) {
      visit(rows_[i]);
    }
  }
  bool isEmpty(std::uint32_t node) const { return offsets_[node] == offsets_[node + 1]; }

 private:
  std::vector<std::size_t> offsets_;
  std::vector<std::uint32_t> rows_;
};

/// A node on a path, and the segment that leads to it (NONE: it begins there).
struct SectionStep
{
  std::uint32_t node;
  std::uint32_t segment;
};
using SectionPath = std::vector<SectionStep>;

/// Nodes and segments of a section with shortest paths along them.
class SectionGraph
{
 public:
  SectionGraph() = default;
  /// @param tolerance places that are no farther from each other are one, in meters
  SectionGraph(std::vector<SectionNode> nodes, std::vector<SectionSegment> segments,
               double tolerance);

  const std::vector<SectionNode>& nodes() const { return nodes_; }
  const std::vector<SectionSegment>& segments() const { return segments_; }
  double tolerance() const { return tolerance_; }

  /// Paths from one node.
  struct Search
  {
    std::vector<double> lengths;     ///< to each node; infinity: there is none
    std::vector<std::uint32_t> via;  ///< by which segment the shortest one comes
    bool reaches(std::uint32_t node) const;
  };
  /// Whether a segment, by its index, is used, which leads so far along the line.
  using May = std::function<bool(std::uint32_t segment, double s)>;
  static bool any(std::uint32_t, double) { return true; }
  /// Dijkstra, 1959: shortest paths within the section, not below other parts where that can be.
  Search search(std::uint32_t start, const May& may = any) const;

  /// The shortest path to a node, from where the search has begun.
  SectionPath pathTo(const Search& search, std::uint32_t node) const;

  /// To where the line has been followed farthest, of several there the nearest.
  /// @param sign -1: backwards
  std::uint32_t farthest(const Search& search, double sign) const;

 private:
  /// End of a segment.
  std::uint32_t other(std::uint32_t segment, std::uint32_t node) const
  {
    const SectionSegment& at = segments_[segment];
    return at.a == node ? at.b : at.a;
  }

  std::vector<SectionNode> nodes_;
  std::vector<SectionSegment> segments_;
  double tolerance_ = 0.0;
  SectionRows rows_;
};

}  // namespace rviz_mesh_plugin
