#include "measurement/surface_profile.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <unordered_map>

#include "base/vectors.h"
#include "measurement/section_contacts.h"
#include "measurement/section_copies.h"
#include "measurement/section_graph.h"
#include "measurement/section_islands.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

using Index = std::uint32_t;
using Node = SectionNode;
using Segment = SectionSegment;
constexpr double INF = std::numeric_limits<double>::infinity();

/// So many faces are looked at between two looks at the cancel flag.
constexpr std::size_t CUT_STRETCH = 1 << 16;

/// An edge of the mesh by its places, so that it is one for all faces at it, also at seams.
using EdgeKey = std::array<std::array<float, 3>, 2>;
struct EdgeHash
{
  std::size_t operator()(const EdgeKey& key) const { return hashOf(key[0]) * 31u + hashOf(key[1]); }
};

/// What an upright plane cuts out of a mesh, between two points: a graph in the plane, whose axes
/// are the distance along the line and z.
class Section
{
 public:
  Section(const MeshData& mesh, const SurfacePoint& from, const SurfacePoint& to,
          const std::atomic<bool>* cancel)
      : mesh_(mesh), from_(from), to_(to), cancel_(cancel)
  {
    const double x = to.position[0] - from.position[0], y = to.position[1] - from.position[1];
    length_ = std::hypot(x, y);
    double size = length_;
    for (const double coordinate : {from.position[0], from.position[1], to.position[0],
                                    to.position[1], from.position[2], to.position[2]}) {
      size = std::max(size, std::abs(coordinate));
    }
    tolerance_ = 1e-9 * size;
    if (length_ <= 1e3 * tolerance_) {
      throw std::invalid_argument("one point lies above the other: there is no line in plan");
    }
    direction_ = {x / length_, y / length_};
    cut();
    removeCopies(nodes_, segments_);
    clip();
    joinAndSplit();
  }

  SurfaceProfile profile()
  {
    SurfaceProfile profile;
    profile.length = length_;
    profile.from = {from_.position[0], from_.position[1]};
    profile.direction = direction_;
    if (begin_ != NONE && end_ != NONE) {
      const auto all = graph_.search(begin_);
      if (all.reaches(end_)) {
        profile.connected = true;
        profile.pieces.push_back(pieceOf(graph_.pathTo(all, end_)));
        return profile;
      }
    }
    const std::array<SectionPath, 2> followed{follow(begin_, 1.0), follow(end_, -1.0)};
    SurfaceProfile::Piece first = pieceOf(followed[0]), last = pieceOf(followed[1]);
    std::reverse(last.begin(), last.end());
    if (!first.empty() && !last.empty() && first.back().distance > last.front().distance) {
      // One above the other: from where the first has ended; where it has not, as a floor below a
      // box, from where the last begins, so that both points are in the profile.
      const double begin = last.front().distance, end = first.back().distance;
      const double change = end < length_ - TOUCHING ? end
                            : begin > TOUCHING       ? begin
                                                     : 0.5 * length_;
      last = behind(last, change);
      first = upTo(first, change);
    }
    std::vector<SurfaceProfile::Piece> pieces;
    pieces.push_back(first);
    const Node gap_begin =
        first.empty() ? Node{0.0, from_.position[2]} : Node{first.back().distance, first.back().z};
    const Node gap_end =
        last.empty() ? Node{length_, to_.position[2]} : Node{last.front().distance, last.front().z};
    if (gap_end.s - gap_begin.s > TOUCHING) {
      for (const auto& path :
           findIslands(mesh_, graph_, faces_, followed, gap_begin, gap_end, cancel_)) {
        pieces.push_back(pieceOf(path));
      }
    }
    pieces.push_back(last);
    for (auto& piece : pieces) {
      if (piece.size() >= 2) {
        profile.pieces.push_back(std::move(piece));
      }
    }
    return profile;
  }

 private:
  double along(const std::array<float, 3>& p) const
  {
    return (p[0] - from_.position[0]) * direction_[0] + (p[1] - from_.position[1]) * direction_[1];
  }
  double aside(const std::array<float, 3>& p) const
  {
    return (p[1] - from_.position[1]) * direction_[0] - (p[0] - from_.position[0]) * direction_[1];
  }

  void cut()
  {
    // A vertex in the plane counts as beside it: then it cuts two sides of a face, or none.
    std::vector<bool> left(mesh_.vertexCount());
    for (std::size_t i = 0; i < left.size(); ++i) {
      left[i] = aside(mesh_.vertices[i].position) >= 0.0;
    }
    std::unordered_map<EdgeKey, Index, EdgeHash> nodes;
    const auto face_count = static_cast<Index>(mesh_.faceCount());
    for (Index face = 0; face < face_count; ++face) {
      if (face % CUT_STRETCH == 0) {
        throwIfCanceled(cancel_);
      }
      const std::uint32_t* const v = &mesh_.indices[3 * std::size_t{face}];
      if (left[v[0]] == left[v[1]] && left[v[1]] == left[v[2]]) {
        continue;
      }
      Index begin = NONE, end = NONE;
      for (unsigned side = 0; side < 3; ++side) {
        const std::uint32_t a = v[side], b = v[(side + 1) % 3];
        if (left[a] != left[b]) {
          (left[a] ? begin : end) = nodeOn(nodes, a, b);
        }
      }
      segments_.push_back({begin, end, face});
    }
  }

  Index nodeOn(std::unordered_map<EdgeKey, Index, EdgeHash>& nodes, std::uint32_t a,
               std::uint32_t b)
  {
    EdgeKey key{mesh_.vertices[a].position, mesh_.vertices[b].position};
    for (auto& place : key) {
      for (float& coordinate : place) {
        coordinate += 0.0f;  // -0 is 0
      }
    }
    if (key[1] < key[0]) {
      std::swap(key[0], key[1]);
    }
    const auto place = nodes.emplace(key, static_cast<Index>(nodes_.size()));
    if (place.second) {
      const double d0 = aside(key[0]), d1 = aside(key[1]);
      const double share = d0 / (d0 - d1);
      const double s0 = along(key[0]);
      nodes_.push_back(
          {s0 + share * (along(key[1]) - s0), key[0][2] + share * (double{key[1][2]} - key[0][2])});
    }
    return place.first->second;
  }

  /// Keeps what is between the two points.
  void clip()
  {
    const double low = -tolerance_, high = length_ + tolerance_;
    const auto end = [&](Index node, const Node& one, const Node& other) {
      if (one.s >= low && one.s <= high) {
        return node;
      }
      const double limit = one.s < low ? 0.0 : length_;
      const double share = (limit - one.s) / (other.s - one.s);
      nodes_.push_back({limit, one.z + share * (other.z - one.z), true});
      return static_cast<Index>(nodes_.size() - 1);
    };
    std::vector<Segment> kept;
    for (Segment segment : segments_) {
      const Node a = nodes_[segment.a], b = nodes_[segment.b];
      if (std::max(a.s, b.s) >= low && std::min(a.s, b.s) <= high) {
        segment.a = end(segment.a, a, b);
        segment.b = end(segment.b, b, a);
        kept.push_back(segment);
      }
    }
    segments_ = std::move(kept);
  }

  struct Split
  {
    Index segment;
    double share;
    Index node;
  };

  /// The two points become nodes, and ends and corners that touch other segments are joined to
  /// them, but not where the line ends: the surface goes on there.
  void joinAndSplit()
  {
    std::vector<Split> splits;
    begin_ = place({0.0, from_.position[2]}, from_.face, splits);
    end_ = place({length_, to_.position[2]}, to_.face, splits);
    const std::vector<bool> ends = endsAndCorners(nodes_, segments_, cancel_);
    const SectionColumns columns(nodes_, segments_, length_);
    for (Index node = 0; node < ends.size(); ++node) {
      if (!ends[node]) {
        continue;
      }
      throwIfCanceled(cancel_);
      const Node point = nodes_[node];
      columns.visit(point.s, [&](Index i) {
        const Segment segment = segments_[i];
        if (segment.a != node && segment.b != node) {
          const auto [share, distance] = nearestOn(nodes_, segment, point);
          if (distance <= TOUCHING) {
            join(i, share, node, splits);
          }
        }
      });
    }
    split(splits);
  }

  void join(Index segment, double share, Index node, std::vector<Split>& splits)
  {
    Index other = share <= 0.0 ? segments_[segment].a : segments_[segment].b;
    if (share > 0.0 && share < 1.0) {
      const Node a = nodes_[segments_[segment].a], b = nodes_[segments_[segment].b];
      other = static_cast<Index>(nodes_.size());
      nodes_.push_back({a.s + share * (b.s - a.s), a.z + share * (b.z - a.z)});
      splits.push_back({segment, share, other});
    }
    joints_.push_back({node, other, NONE});
  }

  /// The node of a point that is in the section, in this face where it can be; NONE where it is
  /// not.
  Index place(const Node& point, Index face, std::vector<Split>& splits)
  {
    Split best{NONE, 0.0, static_cast<Index>(nodes_.size())};
    double least = TOUCHING;
    bool in_face = false;
    for (Index i = 0; i < segments_.size(); ++i) {
      const auto [share, distance] = nearestOn(nodes_, segments_[i], point);
      const bool better = segments_[i].face == face && distance <= 1e3 * tolerance_;
      if (!in_face && (better || distance < least)) {
        best.segment = i;
        best.share = share;
        least = distance;
        in_face = better;
      }
    }
    if (best.segment == NONE) {
      return NONE;
    }
    faces_.push_back(segments_[best.segment].face);
    nodes_.push_back(point);
    splits.push_back(best);
    return best.node;
  }

  void split(std::vector<Split>& splits)
  {
    std::sort(splits.begin(), splits.end(), [](const Split& a, const Split& b) {
      return std::tie(a.segment, a.share) < std::tie(b.segment, b.share);
    });
    for (std::size_t i = 0; i < splits.size(); ++i) {
      // What is left of it, to be cut by the next one.
      Segment rest = segments_[splits[i].segment];
      rest.a = segments_[splits[i].segment].b = splits[i].node;
      for (; i + 1 < splits.size() && splits[i + 1].segment == splits[i].segment; ++i) {
        segments_.push_back(rest);
        rest.a = segments_.back().b = splits[i + 1].node;
      }
      segments_.push_back(rest);
    }
    findCovered(length_, nodes_, segments_, cancel_);
    segments_.insert(segments_.end(), joints_.begin(), joints_.end());
    graph_ = SectionGraph(std::move(nodes_), std::move(segments_), tolerance_);
  }

  SurfaceProfile::Piece pieceOf(const SectionPath& path) const
  {
    SurfaceProfile::Piece piece;
    for (const SectionStep& step : path) {
      const Node& node = graph_.nodes()[step.node];
      const SurfaceProfile::Point point{std::clamp(node.s, 0.0, length_), node.z};
      if (piece.empty() || std::hypot(point.distance - piece.back().distance,
                                      point.z - piece.back().z) > tolerance_) {
        piece.push_back(point);
      }
    }
    return piece;
  }

  SectionPath follow(Index start, double sign) const
  {
    if (start == NONE) {
      return {};
    }
    const auto search = graph_.search(start);
    return graph_.pathTo(search, graph_.farthest(search, sign));
  }

  /// What of a piece is behind this place for good: overhangs may lead back before it.
  SurfaceProfile::Piece behind(const SurfaceProfile::Piece& piece, double distance) const
  {
    const auto begin =
        std::find_if(piece.rbegin(), piece.rend(), [&](const SurfaceProfile::Point& point) {
          return point.distance < distance - tolerance_;
        }).base();
    SurfaceProfile::Piece rest(begin, piece.end());
    if (begin != piece.begin() && begin != piece.end() && begin->distance > distance) {
      const SurfaceProfile::Point& before = *(begin - 1);
      const double share = (distance - before.distance) / (begin->distance - before.distance);
      rest.insert(rest.begin(), {distance, before.z + share * (begin->z - before.z)});
    }
    return rest;
  }

  SurfaceProfile::Piece upTo(SurfaceProfile::Piece piece, double distance) const
  {
    const auto back = [](SurfaceProfile::Piece& points) {
      for (auto& point : points) {
        point.distance = -point.distance;
      }
      std::reverse(points.begin(), points.end());
    };
    back(piece);
    piece = behind(piece, -distance);
    back(piece);
    return piece;
  }

  const MeshData& mesh_;
  const SurfacePoint& from_;
  const SurfacePoint& to_;
  const std::atomic<bool>* cancel_;
  double length_ = 0.0;
  double tolerance_ = 0.0;
  std::array<double, 2> direction_{};
  std::vector<Node> nodes_;
  std::vector<Segment> segments_;
  std::vector<Segment> joints_;
  Index begin_ = NONE;  ///< nodes of the two points
  Index end_ = NONE;
  std::vector<Index> faces_;  ///< of the two points
  SectionGraph graph_;        ///< of these, once it is complete
};

}  // namespace

std::vector<SurfaceProfile::Gap> SurfaceProfile::gaps() const
{
  std::vector<Gap> gaps;
  double known = 0.0;  // up to there
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Point& begin = pieces[i].front();
    const double step = i > 0 ? begin.z - pieces[i - 1].back().z : 0.0;
    if (begin.distance > known + TOUCHING || std::abs(step) > TOUCHING) {
      gaps.push_back({known, std::max(known, begin.distance), step});
    }
    known = pieces[i].back().distance;
  }
  if (known < length - TOUCHING) {
    gaps.push_back({known, length, 0.0});
  }
  return gaps;
}

SurfaceProfile::Heights SurfaceProfile::heights() const
{
  Heights heights;
  if (pieces.empty()) {
    return heights;
  }
  heights.lowest = INF;
  heights.highest = -INF;
  for (const Piece& piece : pieces) {
    for (std::size_t i = 0; i < piece.size(); ++i) {
      heights.lowest = std::min(heights.lowest, piece[i].z);
      heights.highest = std::max(heights.highest, piece[i].z);
      if (i > 0) {
        const double rise = piece[i].z - piece[i - 1].z;
        (rise > 0.0 ? heights.ascent : heights.descent) += std::abs(rise);
        heights.surface += std::hypot(rise, piece[i].distance - piece[i - 1].distance);
      }
    }
  }
  return heights;
}

SurfaceProfile findProfile(const MeshData& mesh, const SurfacePoint& from, const SurfacePoint& to,
                           const std::atomic<bool>* cancel)
{
  throwIfCanceled(cancel);
  return Section(mesh, from, to, cancel).profile();
}

}  // namespace rviz_mesh_plugin
