#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "measurement/section_graph.h"

namespace rviz_mesh_plugin {

/// Segments by where they are along the line.
class SectionColumns
{
 public:
  SectionColumns(const std::vector<SectionNode>& nodes, const std::vector<SectionSegment>& segments,
                 double length)
      : columns_(std::clamp<std::size_t>(segments.size(), 1, 1 << 12)),
        width_(length / static_cast<double>(columns_.size()))
  {
    for (std::uint32_t i = 0; i < segments.size(); ++i) {
      const double a = nodes[segments[i].a].s;
      const double b = nodes[segments[i].b].s;
      const std::size_t last = columnOf(std::max(a, b) + TOUCHING);
      for (std::size_t column = columnOf(std::min(a, b) - TOUCHING); column <= last; ++column) {
        columns_[column].push_back(i);
      }
    }
  }

  /// Those that may touch a point there.
  template <class Visit>
  void visit(double s, const Visit& visit) const
  {
    for (const std::uint32_t i : columns_[columnOf(s)]) {
      visit(i);
    }
  }

 private:
  std::size_t columnOf(double s) const
  {
    const double column = std::max(0.0, s) / width_;
    return std::min(columns_.size() - 1, static_cast<std::size_t>(column));
  }

  std::vector<std::vector<std::uint32_t>> columns_;
  double width_;
};

/// Where on a segment a point is nearest, and how near.
std::pair<double, double> nearestOn(const std::vector<SectionNode>& nodes,
                                    const SectionSegment& segment, const SectionNode& point);

/// Which nodes are ends of surfaces, or corners: from where they do not lead straight on to both
/// sides. What is smaller than what touches, as a chamfer, does not count: the surface is seen from
/// a node where it is farther away. Not where the line ends.
/// @throw Canceled (cancellation.h)
std::vector<bool> endsAndCorners(const std::vector<SectionNode>& nodes,
                                 const std::vector<SectionSegment>& segments,
                                 const std::atomic<bool>* cancel);

/// Marks what another part lies on, such as a floor below a box.
/// @throw Canceled (cancellation.h)
void findCovered(double length, const std::vector<SectionNode>& nodes,
                 std::vector<SectionSegment>& segments, const std::atomic<bool>* cancel);

}  // namespace rviz_mesh_plugin
