#include "measurement/section_islands.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "measurement/union_find.h"
#include "selection/face_neighbors.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

using Index = std::uint32_t;

/// A part of the section within the gap.
struct Candidate
{
  double distance;  ///< of its middle from the straight line over the gap
  SectionPath path;
};

class Islands
{
 public:
  Islands(const MeshData& mesh, const SectionGraph& graph, const SectionNode& begin,
          const SectionNode& end, const std::atomic<bool>* cancel)
      : mesh_(mesh),
        graph_(graph),
        nodes_(graph.nodes()),
        segments_(graph.segments()),
        begin_(begin),
        end_(end),
        cancel_(cancel)
  {
  }

  std::vector<SectionPath> find(const std::vector<Index>& faces,
                                const std::array<SectionPath, 2>& followed)
  {
    findWithin(followed);
    keepSurfaces(faces, followed);
    std::vector<Candidate> found = candidates();
    std::sort(found.begin(), found.end(),
              [](const auto& a, const auto& b) { return a.distance < b.distance; });
    std::vector<SectionPath> paths;
    for (Candidate& candidate : found) {
      const bool free = std::all_of(paths.begin(), paths.end(), [&](const SectionPath& other) {
        return last(candidate.path) <= first(other) + TOUCHING ||
               first(candidate.path) >= last(other) - TOUCHING;
      });
      if (free) {
        paths.push_back(std::move(candidate.path));
      }
    }
    std::sort(paths.begin(), paths.end(),
              [&](const auto& a, const auto& b) { return first(a) < first(b); });
    return joined(paths);
  }

 private:
  double first(const SectionPath& path) const { return nodes_[path.front().node].s; }
  double last(const SectionPath& path) const { return nodes_[path.back().node].s; }

  bool isInside(Index node) const
  {
    return nodes_[node].s >= begin_.s - graph_.tolerance() &&
           nodes_[node].s <= end_.s + graph_.tolerance();
  }

  double along(const SectionSegment& segment) const
  {
    return nodes_[segment.b].s - nodes_[segment.a].s;
  }

  /// What is a face in the gap, and looks to a side to which most of one of these paths looks.
  void findWithin(const std::array<SectionPath, 2>& followed)
  {
    bool up = false, down = false;
    for (const SectionPath& path : followed) {
      double most = 0.0;
      for (const SectionStep& step : path) {
        if (step.segment != NONE && isFace(step.segment) && !segments_[step.segment].two_sided) {
          most += along(segments_[step.segment]);
        }
      }
      up = up || most > graph_.tolerance();
      down = down || most < -graph_.tolerance();
    }
    within_.assign(segments_.size(), false);
    for (Index i = 0; i < segments_.size(); ++i) {
      const double s = along(segments_[i]);
      const bool looks = up == down || segments_[i].two_sided || (up ? s > 0.0 : s < 0.0);
      within_[i] = looks && isFace(i) && isInside(segments_[i].a) && isInside(segments_[i].b);
    }
  }

  bool isFace(Index segment) const { return segments_[segment].face != NONE; }

  /// Of what is within, that of the connected surfaces of these.
  void keepSurfaces(const std::vector<Index>& faces, const std::array<SectionPath, 2>& followed)
  {
    if (std::find(within_.begin(), within_.end(), true) == within_.end()) {
      return;
    }
    const std::vector<Index> corners = joinedCorners(mesh_);
    throwIfCanceled(cancel_);
    UnionFind surfaces(mesh_.vertexCount());
    for (std::size_t corner = 0; corner + 2 < corners.size(); corner += 3) {
      surfaces.unite(corners[corner], corners[corner + 1]);
      surfaces.unite(corners[corner], corners[corner + 2]);
    }
    throwIfCanceled(cancel_);
    const auto surface = [&](Index face) { return surfaces.find(corners[3 * std::size_t{face}]); };
    std::unordered_set<Index> kept;
    for (const Index face : faces) {
      kept.insert(surface(face));
    }
    for (const SectionPath& path : followed) {
      for (const SectionStep& step : path) {
        if (step.segment != NONE && isFace(step.segment)) {
          kept.insert(surface(segments_[step.segment].face));
        }
      }
    }
    for (Index i = 0; i < segments_.size(); ++i) {
      within_[i] = within_[i] && kept.count(surface(segments_[i].face)) != 0;
    }
  }

  /// Two of them are one where what is upright, or touches, leads from the end of the first to the
  /// begin of the second: risers look to neither side.
  std::vector<SectionPath> joined(std::vector<SectionPath>& paths) const
  {
    std::vector<SectionPath> joined;
    for (SectionPath& path : paths) {
      throwIfCanceled(cancel_);
      if (!joined.empty() && first(path) - last(joined.back()) <= TOUCHING) {
        SectionPath& before = joined.back();
        const double at = last(before);
        const auto search = graph_.search(before.back().node, [&](Index i, double) {
          return std::abs(nodes_[segments_[i].a].s - at) <= TOUCHING &&
                 std::abs(nodes_[segments_[i].b].s - at) <= TOUCHING;
        });
        if (search.reaches(path.front().node)) {
          const SectionPath riser = graph_.pathTo(search, path.front().node);
          before.insert(before.end(), riser.begin() + 1, riser.end());
          before.insert(before.end(), path.begin() + 1, path.end());
          continue;
        }
      }
      joined.push_back(std::move(path));
    }
    return joined;
  }

  /// One for each connected part that is within.
  std::vector<Candidate> candidates() const
  {
    UnionFind groups(nodes_.size());
    for (Index i = 0; i < segments_.size(); ++i) {
      if (within_[i]) {
        groups.unite(segments_[i].a, segments_[i].b);
      }
    }
    std::unordered_map<Index, Index> first_nodes;  // of each group the first along the line
    for (Index i = 0; i < segments_.size(); ++i) {
      for (const Index node : {segments_[i].a, segments_[i].b}) {
        if (within_[i]) {
          Index& first = first_nodes.emplace(groups.find(node), node).first->second;
          first = nodes_[node].s < nodes_[first].s ? node : first;
        }
      }
    }
    std::vector<Candidate> found;
    for (const auto& [group, first_node] : first_nodes) {
      throwIfCanceled(cancel_);
      const auto search = graph_.search(first_node, [&](Index segment, double s) {
        return within_[segment] && s >= -graph_.tolerance();
      });
      SectionPath path = graph_.pathTo(search, graph_.farthest(search, 1.0));
      // It must not be what the gap begins or ends at: a storey that goes on beyond it.
      if (path.size() < 2 || first(path) <= begin_.s + graph_.tolerance() ||
          last(path) >= end_.s - graph_.tolerance()) {
        continue;
      }
      const double share = (0.5 * (first(path) + last(path)) - begin_.s) / (end_.s - begin_.s);
      const double z = 0.5 * (nodes_[path.front().node].z + nodes_[path.back().node].z);
      const double distance = std::abs(z - (begin_.z + share * (end_.z - begin_.z)));
      found.push_back({distance, std::move(path)});
    }
    return found;
  }

  const MeshData& mesh_;
  const SectionGraph& graph_;
  const std::vector<SectionNode>& nodes_;
  const std::vector<SectionSegment>& segments_;
  SectionNode begin_;
  SectionNode end_;
  const std::atomic<bool>* cancel_;
  std::vector<bool> within_;  ///< segments that may be of an island
};

}  // namespace

std::vector<SectionPath> findIslands(const MeshData& mesh, const SectionGraph& graph,
                                     const std::vector<std::uint32_t>& faces,
                                     const std::array<SectionPath, 2>& followed,
                                     const SectionNode& begin, const SectionNode& end,
                                     const std::atomic<bool>* cancel)
{
  return Islands(mesh, graph, begin, end, cancel).find(faces, followed);
}

}  // namespace rviz_mesh_plugin
