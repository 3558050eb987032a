#include <mesh_map/paths/walk.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/require.h"
#include "paths/vertex_turn.h"
#include "paths/walk_face.h"

namespace mesh_map {

namespace {

void checkWalk(const WalkMesh& mesh, const WalkOptions& options)
{
  require(options.mask.empty() || options.mask.size() == mesh.mesh.faceCount(),
          "the mask needs one entry per face");
}

/// The same direction, times a power of two such that its largest number is 1 to 2: no product of
/// such is too large or too small. 0 of 0.
Vector3 ofSizeOne(const Vector3& direction)
{
  const double largest =
      std::max({std::abs(direction[0]), std::abs(direction[1]), std::abs(direction[2])});
  if (!(largest > 0.0) || !isFinite(direction)) {
    return direction;
  }
  const int exponent = -std::ilogb(largest);
  return {std::scalbn(direction[0], exponent), std::scalbn(direction[1], exponent),
          std::scalbn(direction[2], exponent)};
}

/// Whether there is such a face, the weights of its corners are those of a point in it, up to some
/// rounding, and `up` is finite.
bool canStart(const WalkMesh& mesh, const WalkPose& start)
{
  constexpr double rounding = 1e-6;
  const std::array<double, 3>& weights = start.barycentric;
  const double sum = weights[0] + weights[1] + weights[2];
  return start.face < mesh.mesh.faceCount() && std::abs(sum - 1.0) <= rounding &&
         weights[0] >= -rounding && weights[1] >= -rounding && weights[2] >= -rounding &&
         isFinite(start.up);
}

/// A face along its longest edge; from the side from which its corners run counter-clockwise, or
/// the other one.
FlatFace longestSideFirst(const WalkMesh& mesh, std::uint32_t face, bool reversed)
{
  std::size_t first = 0;
  double longest = -1.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 side = difference(position(mesh, cornerOf(mesh, face, (k + 1) % 3)),
                                    position(mesh, cornerOf(mesh, face, k)));
    if (dot(side, side) > longest) {
      longest = dot(side, side);
      first = k;
    }
  }
  return FlatFace(mesh, face, reversed ? (first + 1) % 3 : first, reversed);
}

/// The face of a start, seen from its side.
FlatFace startFace(const WalkMesh& mesh, const WalkPose& start)
{
  const FlatFace face = longestSideFirst(mesh, start.face, false);
  return dot(face.normal(), ofSizeOne(start.up)) < 0.0 ? longestSideFirst(mesh, start.face, true)
                                                       : face;
}

/// What is nearer to a vertex, of the longest edge of the face, may be at it.
constexpr double AT_VERTEX = 1e-9;

/// The place in a face of the corner that a start is at; 3 if it is at none.
std::size_t cornerAt(const FlatFace& face, const std::array<double, 3>& weights)
{
  const Vector2 point = face.point(weights);
  for (std::size_t k = 0; k < 3; ++k) {
    if (norm(point - face.corner(k)) <= AT_VERTEX * face.longest()) {
      return k;
    }
  }
  return 3;
}

/// An empty trace but for its first point.
void beginTrace(WalkTrace* trace, const Vector3& point)
{
  if (trace != nullptr) {
    trace->points.assign(point.begin(), point.end());
    trace->faces.clear();
  }
}

/// Somebody in a face who goes straight on.
struct Walker
{
  FlatFace face;
  Vector2 point, direction;
};

class StraightWalk
{
 public:
  StraightWalk(const WalkMesh& mesh, const WalkOptions& options, WalkTrace* trace)
      : mesh_(mesh), options_(options), trace_(trace)
  {
  }

  Walk run(Walker walker, double length)
  {
    Walk walk;
    // Faces without area have no plane: what is told then is where the last other one was left.
    Walker told = walker;
    for (std::size_t steps = 0;; ++steps) {
      const FaceExit exit = exitOf(walker.face, walker.point, walker.direction);
      const bool arrives = length - walk.length <= exit.distance;
      if (arrives || steps >= options_.max_steps) {
        const double rest = arrives ? length - walk.length : 0.0;
        walker.point = walker.point + rest * walker.direction;
        walk.length = arrives ? length : walk.length;  // not off by rounding
        walk.end = arrives ? WalkEnd::ARRIVED : WalkEnd::STEPS;
        told = walker.face.hasArea() ? walker : told;
        follow(walker, rest);
        break;
      }
      walk.length += exit.distance;
      walker.point = pointOf(walker, exit);
      told = walker.face.hasArea() ? walker : told;
      follow(walker, exit.distance);
      walk.end = exit.kind == FaceExit::EDGE ? crossEdge(walker, exit) : turn(walker, exit.index);
      if (walk.end != WalkEnd::ARRIVED) {
        break;
      }
    }
    walk.pose.face = told.face.face();
    walk.pose.barycentric = told.face.barycentric(told.point);
    walk.pose.direction = told.face.inSpace(told.direction);
    walk.pose.up = told.face.normal();
    walk.position = told.face.positionOf(walk.pose.barycentric);
    return walk;
  }

 private:
  static Vector2 pointOf(const Walker& walker, const FaceExit& exit)
  {
    const Vector2& corner = walker.face.corner(exit.index);
    if (exit.kind != FaceExit::EDGE) {
      return corner;
    }
    return corner + exit.share * (walker.face.corner((exit.index + 1) % 3) - corner);
  }

  void follow(const Walker& walker, double distance)
  {
    if (trace_ != nullptr && distance > 0.0 && walker.face.hasArea()) {
      const Vector3 point = walker.face.positionOf(walker.face.barycentric(walker.point));
      trace_->points.insert(trace_->points.end(), point.begin(), point.end());
      trace_->faces.push_back(walker.face.face());
    }
  }

  WalkEnd crossEdge(Walker& walker, const FaceExit& exit) const
  {
    const std::size_t i = exit.index, j = (i + 1) % 3, opposite = (i + 2) % 3;
    const FlatFace& face = walker.face;
    const std::uint32_t next = faceAcross(mesh_, face.face(), face.slot(opposite));
    if (next == NO_INDEX) {
      return WalkEnd::BORDER;
    }
    if (!options_.mask.empty() && options_.mask[next] == 0) {
      return WalkEnd::BLOCKED;
    }
    const Vector2 side = face.corner(i) - face.corner(j);
    const double length = std::hypot(side[0], side[1]);
    const Vector2 unit = side / length;
    const Vector2 direction{dot(walker.direction, unit),
                            std::max(0.0, cross(unit, walker.direction))};
    const double size = std::hypot(direction[0], direction[1]);
    const FlatFace beyond = FlatFace::along(mesh_, next, face.vertex(j), face.vertex(i));
    walker = {beyond, {(1.0 - exit.share) * beyond.corner(1)[0], 0.0}, direction / size};
    return WalkEnd::ARRIVED;
  }

  WalkEnd turn(Walker& walker, std::size_t corner) const
  {
    const std::uint32_t vertex = walker.face.vertex(corner);
    const VertexTurn to = turnAt(mesh_, walker.face, corner, walker.direction, options_.mask);
    if (to.end == WalkEnd::ARRIVED) {
      walker = {FlatFace::along(mesh_, to.face, vertex, to.right),
                {0.0, 0.0},
                {std::cos(to.angle), std::sin(to.angle)}};
    }
    return to.end;
  }

  const WalkMesh& mesh_;
  const WalkOptions& options_;
  WalkTrace* trace_;
};

/// Of length 1; 0 if it is 0, not finite, or not along the face.
Vector2 unitAlong(const FlatFace& face, const Vector3& direction)
{
  const double largest =
      std::max({std::abs(direction[0]), std::abs(direction[1]), std::abs(direction[2])});
  if (!isFinite(direction) || !(largest > 0.0)) {
    return {0.0, 0.0};
  }
  const Vector2 flat = face.flat(direction / largest);
  const double size = std::hypot(flat[0], flat[1]);
  return size > 1e-9 ? flat / size : Vector2{0.0, 0.0};
}

}  // namespace

Walk walkStraight(const WalkMesh& mesh, const WalkPose& start, double length,
                  const WalkOptions& options, WalkTrace* trace)
{
  checkWalk(mesh, options);
  Walk walk;
  walk.pose = start;
  if (!canStart(mesh, start) || std::isnan(length)) {
    return walk;
  }
  const FlatFace face = startFace(mesh, start);
  Vector2 direction = face.hasArea() ? unitAlong(face, start.direction) : Vector2{0.0, 0.0};
  if (direction == Vector2{0.0, 0.0}) {
    return walk;
  }
  const bool backwards = length < 0.0;
  if (backwards) {
    direction = -direction;
  }
  beginTrace(trace, face.positionOf(face.barycentric(face.point(start.barycentric))));
  const auto walkFrom = [&](const Vector2& point) {
    return StraightWalk(mesh, options, trace).run({face, point, direction}, std::abs(length));
  };
  walk = walkFrom(face.point(start.barycentric));
  if (walk.end == WalkEnd::BORDER && walk.length <= AT_VERTEX * face.longest()) {
    const std::size_t corner = cornerAt(face, start.barycentric);
    if (corner < 3) {
      beginTrace(trace,
                 face.inSpace(face.corner(corner)) + pointOf(position(mesh, face.vertex(0))));
      walk = walkFrom(face.corner(corner));
    }
  }
  walk.pose.direction = backwards ? -walk.pose.direction : walk.pose.direction;
  return walk;
}

namespace {

/// How far the start is moved into its face, so that the plane cuts that.
constexpr double INTO_FACE = 1e-9;

/// The cut of a surface with a plane. A vertex is on one side or the other, always the same one, so
/// that each face that the plane enters through an edge, it leaves through another: no rounding can
/// lose the way.
class Cut
{
 public:
  Cut(const WalkMesh& mesh, const FlatFace& face, const Vector2& start, const Vector3& up,
      const std::array<double, 3>& target)
      : mesh_(mesh), origin_(position(mesh, face.vertex(0)))
  {
    start_ = face.inSpace(start);  // from corner 0: small numbers, wherever the mesh is
    const Vector3 way = target - pointOf(origin_) - start_;
    const Vector3 along = ofSizeOne(way);
    normal_ = mesh_map::cross(up, along);
    forward_ = mesh_map::cross(normal_, up);
    const double size = norm(forward_);
    if (size > 1e-12 * dot(up, up) * norm(along)) {
      forward_ = forward_ / size;
      goal_ = dot(forward_, way);
    }
  }

  /// How far along the way the target is; 0 if it is just above or below the start.
  double goal() const { return goal_; }

  /// Of a point as it comes from the functions below.
  double progress(const Vector3& point) const { return dot(forward_, point - start_); }
  const Vector3& start() const { return start_; }

  /// Whether the plane passes through a vertex, up to a distance.
  bool passes(std::uint32_t vertex, double within) const
  {
    return std::abs(height(vertex)) <= within * norm(normal_);
  }

  bool isLeft(std::uint32_t vertex) const { return height(vertex) >= 0.0; }

  /// Where the plane cuts an edge with corners on both sides. The same from both faces.
  Vector3 crossing(std::uint32_t a, std::uint32_t b) const
  {
    const std::uint32_t low = std::min(a, b), high = std::max(a, b);
    const double from = height(low), to = height(high);
    const double share = from / (from - to);
    return local(low) + share * (local(high) - local(low));
  }

  Vector3 local(std::uint32_t vertex) const { return difference(position(mesh_, vertex), origin_); }

  Vector3 inSpace(const Vector3& point) const { return pointOf(origin_) + point; }

 private:
  double height(std::uint32_t vertex) const { return dot(normal_, local(vertex) - start_); }

  const WalkMesh& mesh_;
  const float* origin_;
  Vector3 start_{}, normal_{}, forward_{};
  double goal_ = 0.0;
};

/// Somebody in a face who goes along the cut.
struct Place
{
  std::uint32_t face;
  bool reversed;          // whether he is on the side from which the corners run clockwise
  Vector3 point;          // relative to the origin of the cut
  std::size_t entry = 3;  // slot of the corner opposite to the edge where he came in
};

/// Where the cut leaves a face.
struct CutExit
{
  std::size_t slot = 3;  // of the corner opposite to the edge; 3: nowhere
  Vector3 point{};
};

/// Of two edges with corners on both sides, the one that was not the entry, or leads on.
CutExit exitOf(const WalkMesh& mesh, const Cut& cut, const Place& place)
{
  CutExit exit;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = cornerOf(mesh, place.face, (k + 1) % 3);
    const std::uint32_t b = cornerOf(mesh, place.face, (k + 2) % 3);
    if (k == place.entry || cut.isLeft(a) == cut.isLeft(b)) {
      continue;
    }
    const Vector3 point = cut.crossing(a, b);
    if (exit.slot == 3 || cut.progress(point) > cut.progress(exit.point)) {
      exit = {k, point};
    }
  }
  return exit;
}

/// Over an edge, on the same side of the surface.
Place across(const WalkMesh& mesh, const Place& place, const CutExit& exit, std::uint32_t next)
{
  const std::uint32_t a = cornerOf(mesh, place.face, (exit.slot + 1) % 3);
  const std::uint32_t b = cornerOf(mesh, place.face, (exit.slot + 2) % 3);
  const std::size_t at_a = slotOf(mesh, next, a), at_b = slotOf(mesh, next, b);
  const bool turned = (at_a + 1) % 3 == at_b;  // both faces run along the edge the same way
  return {next, place.reversed != turned, exit.point, 3 - at_a - at_b};
}

class LineWalk
{
 public:
  /// `within` is how near the plane passes to a vertex through which it leads.
  LineWalk(const WalkMesh& mesh, const Cut& cut, double within, const WalkOptions& options,
           WalkTrace* trace)
      : mesh_(mesh), cut_(cut), within_(within), options_(options), trace_(trace)
  {
  }

  /// Faces that were crossed.
  std::size_t steps() const { return steps_; }

  /// Of a walk that ended at the border: its face, and the corner of it through which it led out, 3
  /// for none.
  const Place& last() const { return last_; }
  std::size_t lastCorner() const { return last_corner_; }

  Walk run(Place place)
  {
    walk_.end = WalkEnd::ARRIVED;
    Place told = place;  // the last place in a face that has a plane
    // Moved up ever more rarely: a way that is a loop meets it again (R. Brent's way to find one).
    Place met{NO_INDEX, false, {}};
    std::size_t next_move = 1;
    for (steps_ = 0; cut_.goal() > 0.0; ++steps_) {
      CutExit exit = exitOf(mesh_, cut_, place);
      if (exit.slot == 3) {
        walk_.end = WalkEnd::NOWHERE;
        break;
      }
      const double before = cut_.progress(place.point), after = cut_.progress(exit.point);
      const bool arrives = after >= cut_.goal();
      if (arrives && after > before) {
        const double share = (cut_.goal() - before) / (after - before);
        exit.point = place.point + share * (exit.point - place.point);
      }
      const std::uint32_t next = arrives ? NO_INDEX : faceAcross(mesh_, place.face, exit.slot);
      if (!arrives && next == NO_INDEX) {
        leaveThroughCorner(place, exit);
      }
      follow(place, exit.point);
      place.point = exit.point;
      told = longestSideFirst(mesh_, place.face, place.reversed).hasArea() ? place : told;
      if (arrives) {
        break;
      }
      walk_.end = endAt(next, steps_);
      if (walk_.end != WalkEnd::ARRIVED) {
        break;
      }
      place = across(mesh_, place, exit, next);
      if (place.face == met.face && place.entry == met.entry) {
        walk_.end = WalkEnd::LOOP;
        break;
      }
      if (steps_ + 1 == next_move) {
        met = place;
        next_move *= 2;
      }
    }
    stand(told);
    return walk_;
  }

 private:
  /// At a border: if the line leads through an end of the edge there, it leaves the face in that.
  void leaveThroughCorner(const Place& place, CutExit& exit)
  {
    last_ = place;
    double farthest = cut_.progress(exit.point);
    for (const std::size_t k : {(exit.slot + 1) % 3, (exit.slot + 2) % 3}) {
      const std::uint32_t vertex = cornerOf(mesh_, place.face, k);
      const Vector3 point = cut_.local(vertex);
      const double progress = cut_.progress(point);
      if (cut_.passes(vertex, within_) && progress < cut_.goal() &&
          progress >= farthest - 2.0 * within_) {
        last_corner_ = k;
        farthest = std::max(farthest, progress);
      }
    }
    if (last_corner_ != 3) {
      exit.point = cut_.local(cornerOf(mesh_, place.face, last_corner_));
    }
  }

  WalkEnd endAt(std::uint32_t next, std::size_t steps) const
  {
    if (next == NO_INDEX) {
      return WalkEnd::BORDER;
    }
    if (!options_.mask.empty() && options_.mask[next] == 0) {
      return WalkEnd::BLOCKED;
    }
    return steps >= options_.max_steps ? WalkEnd::STEPS : WalkEnd::ARRIVED;
  }

  void follow(const Place& place, const Vector3& to)
  {
    const Vector3 step = to - place.point;
    const double length = norm(step);
    if (!(length > 0.0)) {
      return;
    }
    walk_.length += length;
    walk_.pose.direction = step / length;
    if (trace_ != nullptr) {
      const Vector3 point = cut_.inSpace(to);
      trace_->points.insert(trace_->points.end(), point.begin(), point.end());
      trace_->faces.push_back(place.face);
    }
  }

  void stand(const Place& place)
  {
    const FlatFace flat = longestSideFirst(mesh_, place.face, place.reversed);
    walk_.pose.face = place.face;
    walk_.pose.barycentric = flat.barycentric(flat.flat(place.point - cut_.local(flat.vertex(0))));
    walk_.pose.up = flat.normal();
    walk_.position = flat.positionOf(walk_.pose.barycentric);
  }

  const WalkMesh& mesh_;
  const Cut& cut_;
  double within_;
  const WalkOptions& options_;
  WalkTrace* trace_;
  Walk walk_;
  std::size_t steps_ = 0;
  Place last_{NO_INDEX, false, {}};
  std::size_t last_corner_ = 3;
};

/// A face from the side of the walker.
bool isReversed(const FlatFace& face)
{
  return (face.slot(0) + 1) % 3 != face.slot(1);
}

/// Where a line begins: a face, and weights of its corners.
struct LineStart
{
  FlatFace face;
  std::array<double, 3> weights;
};

/// At corner k of a face, in the face there into which the way to a target leads as seen along
/// `up`; nothing if it leads into none, or into one that must not be entered.
std::optional<LineStart> atCorner(const WalkMesh& mesh, const FlatFace& face, std::size_t k,
                                  const Vector3& up, const std::array<double, 3>& target,
                                  ArrayView<std::uint8_t> mask)
{
  const std::uint32_t vertex = face.vertex(k);
  const Vector3 way = ofSizeOne(target - pointOf(position(mesh, vertex)));
  const VertexTurn to = seenAhead(mesh, face, k, up / norm(up), way, mask);
  if (to.end != WalkEnd::ARRIVED) {
    return std::nullopt;
  }
  LineStart start{FlatFace::along(mesh, to.face, vertex, to.right), {}};
  start.weights[start.face.slot(0)] = 1.0;
  return start.face.hasArea() ? std::optional<LineStart>(start) : std::nullopt;
}

}  // namespace

Walk walkLine(const WalkMesh& mesh, const WalkPose& start, const std::array<double, 3>& target,
              const WalkOptions& options, WalkTrace* trace)
{
  checkWalk(mesh, options);
  Walk nowhere;
  nowhere.pose = start;
  if (!canStart(mesh, start) || !isFinite(target)) {
    return nowhere;
  }
  const FlatFace face = startFace(mesh, start);
  if (!face.hasArea()) {
    return nowhere;
  }
  const Vector3 up = start.up == Vector3{} ? face.normal() : ofSizeOne(start.up);
  std::optional<LineStart> from;
  if (const std::size_t k = cornerAt(face, start.barycentric); k < 3) {
    from = atCorner(mesh, face, k, up, target, options.mask);
  }
  from = from.value_or(LineStart{face, start.barycentric});
  WalkOptions rest = options;
  double length = 0.0, to_go = std::numeric_limits<double>::infinity();
  for (bool is_first = true;; is_first = false) {
    std::array<double, 3> inside;
    for (std::size_t k = 0; k < 3; ++k) {
      inside[k] = (1.0 - INTO_FACE) * from->weights[k] + INTO_FACE / 3.0;
    }
    const Cut cut(mesh, from->face, from->face.point(inside), up, target);
    if (is_first) {
      beginTrace(trace, cut.inSpace(cut.start()));
    }
    LineWalk line(mesh, cut, 2.0 * INTO_FACE * from->face.longest(), rest, trace);
    Walk walk = line.run({from->face.face(), isReversed(from->face), cut.start()});
    length = walk.length = length + walk.length;
    // Through a corner at the border it goes on in another face, nearer to the target each time.
    const bool is_nearer = cut.goal() < to_go;
    if (walk.end != WalkEnd::BORDER || line.lastCorner() == 3 || !is_nearer) {
      return walk;
    }
    to_go = cut.goal();
    rest.max_steps -= std::min(rest.max_steps, line.steps() + 1);
    const FlatFace last = longestSideFirst(mesh, line.last().face, line.last().reversed);
    const std::size_t k = last.slot(0) == line.lastCorner()   ? 0
                          : last.slot(1) == line.lastCorner() ? 1
                                                              : 2;
    const auto on = atCorner(mesh, last, k, up, target, options.mask);
    if (!on || on->face.face() == last.face()) {
      return walk;
    }
    from = on;
  }
}

namespace {

/// The vertices of a side of a face, the lower one first.
std::array<std::uint32_t, 2> sideOf(const WalkMesh& mesh, std::uint32_t face, std::size_t k)
{
  const std::uint32_t a = cornerOf(mesh, face, k), b = cornerOf(mesh, face, (k + 1) % 3);
  return {std::min(a, b), std::max(a, b)};
}

constexpr const char* OTHER_TOPOLOGY = "the topology is not that of the faces";

}  // namespace

void checkWalkMesh(const WalkMesh& mesh)
{
  const std::size_t face_count = mesh.mesh.faceCount();
  require(mesh.face_edges.size() == 3 * face_count && mesh.face_flags.size() == face_count,
          OTHER_TOPOLOGY);
  const RowsView& around = mesh.vertex_faces;
  require(around.rowCount() == mesh.mesh.vertexCount(), OTHER_TOPOLOGY);
  for (std::uint32_t vertex = 0; vertex < around.rowCount(); ++vertex) {
    for (std::uint32_t i = around.offsets[vertex]; i < around.offsets[vertex + 1]; ++i) {
      const std::uint32_t face = around.values[i];
      require(face < face_count && (i == around.offsets[vertex] || around.values[i - 1] < face) &&
                  cornerOf(mesh, face, slotOf(mesh, face, vertex)) == vertex,
              OTHER_TOPOLOGY);
    }
  }
  std::size_t sides = 0;
  for (std::size_t i = 0; i < mesh.face_edges.size(); i += 3) {
    sides += std::count(mesh.face_edges.data() + i, mesh.face_edges.data() + i + 3, NO_INDEX) == 0
                 ? 3
                 : 0;
  }
  require(mesh.edge_faces.values.size() == sides, OTHER_TOPOLOGY);
  for (std::uint32_t edge = 0; edge < mesh.edge_faces.rowCount(); ++edge) {
    const std::uint32_t begin = mesh.edge_faces.offsets[edge];
    std::array<std::uint32_t, 2> vertices{};
    for (std::uint32_t i = begin; i < mesh.edge_faces.offsets[edge + 1]; ++i) {
      const std::uint32_t face = mesh.edge_faces.values[i];
      require(face < face_count && (i == begin || mesh.edge_faces.values[i - 1] < face),
              OTHER_TOPOLOGY);
      const std::uint32_t* const edges = mesh.face_edges.data() + 3 * std::size_t{face};
      const std::size_t k = static_cast<std::size_t>(std::find(edges, edges + 3, edge) - edges);
      require(k < 3 && std::count(edges, edges + 3, NO_INDEX) == 0, OTHER_TOPOLOGY);
      vertices = i == begin ? sideOf(mesh, face, k) : vertices;
      require(vertices == sideOf(mesh, face, k) && vertices[0] != vertices[1], OTHER_TOPOLOGY);
    }
  }
}

}  // namespace mesh_map
