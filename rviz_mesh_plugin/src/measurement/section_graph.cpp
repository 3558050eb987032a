#include "measurement/section_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

namespace rviz_mesh_plugin {
namespace {

constexpr double UNREACHED = std::numeric_limits<double>::infinity();

/// How much longer a path below another part counts.
constexpr double COVERED_COST = 1e3;

}  // namespace

SectionRows::SectionRows(std::size_t node_count, const std::vector<SectionSegment>& segments)
    : offsets_(node_count + 1, 0), rows_(2 * segments.size())
{
  for (const SectionSegment& segment : segments) {
    ++offsets_[segment.a + 1];
    ++offsets_[segment.b + 1];
  }
  std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
  std::vector<std::size_t> next(offsets_.begin(), offsets_.end() - 1);
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    rows_[next[segments[i].a]++] = i;
    rows_[next[segments[i].b]++] = i;
  }
}

SectionGraph::SectionGraph(std::vector<SectionNode> nodes, std::vector<SectionSegment> segments,
                           double tolerance)
    : nodes_(std::move(nodes)),
      segments_(std::move(segments)),
      tolerance_(tolerance),
      rows_(nodes_.size(), segments_)
{
}

bool SectionGraph::Search::reaches(std::uint32_t node) const
{
  return lengths[node] < UNREACHED;
}

SectionGraph::Search SectionGraph::search(std::uint32_t start, const May& may) const
{
  Search found{std::vector<double>(nodes_.size(), UNREACHED),
               std::vector<std::uint32_t>(nodes_.size(), NONE)};
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  found.lengths[start] = 0.0;
  queue.push({0.0, start});
  while (!queue.empty()) {
    const double length = queue.top().first;
    const std::uint32_t node = queue.top().second;
    queue.pop();
    if (length > found.lengths[node]) {
      continue;
    }
    rows_.visit(node, [&](std::uint32_t i) {
      const std::uint32_t next = other(i, node);
      const double s = nodes_[next].s - nodes_[node].s;
      const double longer = length + (segments_[i].covered ? COVERED_COST : 1.0) *
                                         std::hypot(s, nodes_[next].z - nodes_[node].z);
      if (longer < found.lengths[next] && may(i, s)) {
        found.lengths[next] = longer;
        found.via[next] = i;
        queue.push({longer, next});
      }
    });
  }
  return found;
}

SectionPath SectionGraph::pathTo(const Search& search, std::uint32_t node) const
{
  SectionPath path;
  for (; search.via[node] != NONE; node = other(search.via[node], node)) {
    path.push_back({node, search.via[node]});
  }
  path.push_back({node, NONE});
  std::reverse(path.begin(), path.end());
  return path;
}

std::uint32_t SectionGraph::farthest(const Search& search, double sign) const
{
  std::uint32_t best = NONE;
  for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
    if (search.reaches(node)) {
      const double further = best == NONE ? UNREACHED : sign * (nodes_[node].s - nodes_[best].s);
      const bool nearer =
          best != NONE && further >= -tolerance_ && search.lengths[node] < search.lengths[best];
      best = further > tolerance_ || nearer ? node : best;
    }
  }
  return best;
}

}  // namespace rviz_mesh_plugin
