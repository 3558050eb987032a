#include "paths/vertex_turn.h"

#include <mesh_map/mesh/topology.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace mesh_map {

namespace {

/// Radians that are nothing.
constexpr double NO_ANGLE = 1e-9;

/// A face at a vertex: the vertices on its right and its left, and the angle between them.
struct Sector
{
  std::uint32_t face, right, left;
  double angle;
};

/// The angle of a face at a vertex. Where an edge there has no length, that of a face in which it
/// is very short: faces at both ends of such an edge then go round together.
double angleAt(const WalkMesh& mesh, std::uint32_t vertex, std::uint32_t right, std::uint32_t left)
{
  const Vector3 u = difference(position(mesh, right), position(mesh, vertex));
  const Vector3 w = difference(position(mesh, left), position(mesh, vertex));
  return dot(u, u) == 0.0 || dot(w, w) == 0.0 ? PI / 2.0 : angleBetween(u, w);
}

/// The face beyond the left or right side of one, on the same side of the surface.
Sector beyond(const WalkMesh& mesh, std::uint32_t vertex, const Sector& at, bool to_left)
{
  const std::uint32_t opposite = to_left ? at.right : at.left;
  const std::uint32_t shared = to_left ? at.left : at.right;
  const std::uint32_t next = faceAcross(mesh, at.face, slotOf(mesh, at.face, opposite));
  if (next == NO_INDEX) {
    return {NO_INDEX, NO_INDEX, NO_INDEX, 0.0};
  }
  const std::size_t slot = 3 - slotOf(mesh, next, vertex) - slotOf(mesh, next, shared);
  const std::uint32_t other = cornerOf(mesh, next, slot);
  const double angle = angleAt(mesh, vertex, shared, other);
  return to_left ? Sector{next, shared, other, angle} : Sector{next, other, shared, angle};
}

/// The faces around a vertex to one side of a face, as far as they go.
struct Fan
{
  std::vector<Sector> sectors;
  double angle = 0.0;
  bool closed = false;  // all the way round
};

Fan fanAround(const WalkMesh& mesh, std::uint32_t vertex, const Sector& start, bool to_left)
{
  Fan fan;
  Sector at = start;
  // Where more than two faces meet in an edge, the way round may never come back to the start: it
  // then meets this one again, which is moved up ever more rarely (R. Brent's way to find a cycle).
  std::uint32_t met = NO_INDEX;
  std::size_t next_move = 1;
  while (true) {
    at = beyond(mesh, vertex, at, to_left);
    fan.closed = at.face == start.face;
    if (at.face == NO_INDEX || at.face == met || fan.closed) {
      return fan;
    }
    fan.sectors.push_back(at);
    fan.angle += at.angle;
    if (fan.sectors.size() == next_move) {
      met = at.face;
      next_move *= 2;
    }
  }
}

VertexTurn inSector(const Sector& sector, double angle)
{
  return {WalkEnd::ARRIVED, sector.face, sector.right,
          std::min(sector.angle, std::max(0.0, angle))};
}

/// Whether a face has no area at the vertex: its sides run the same way, or opposite ways.
bool isFlat(const Sector& sector)
{
  return sector.angle <= NO_ANGLE || sector.angle >= PI - NO_ANGLE;
}

/// So far around the vertex from the side of the start. A direction along a side of a face without
/// area is in the face beside it: there is nothing to walk on in the other one.
VertexTurn inFan(const Fan& fan, const Sector& start, double angle, bool to_left)
{
  const Sector* last = isFlat(start) ? nullptr : &start;
  double behind_last = 0.0;
  const auto endOfLast = [&]() -> VertexTurn {
    if (last == nullptr || behind_last > NO_ANGLE) {
      return {WalkEnd::BORDER};
    }
    return inSector(*last, to_left ? last->angle : 0.0);
  };
  for (const Sector& sector : fan.sectors) {
    const bool at_begin = angle <= NO_ANGLE, at_end = angle >= sector.angle - NO_ANGLE;
    if (angle <= sector.angle + NO_ANGLE) {
      if (!isFlat(sector) || (!at_begin && !at_end)) {
        return inSector(sector, to_left ? angle : sector.angle - angle);
      }
      if (at_begin && last != nullptr && behind_last <= NO_ANGLE) {
        return endOfLast();
      }
    }
    angle -= sector.angle;
    behind_last += sector.angle;
    if (!isFlat(sector)) {
      last = &sector;
      behind_last = 0.0;
    }
  }
  return endOfLast();
}

/// A corner of a face from which a direction points out of it. `ahead` is its angle to the right
/// side of the face, 0 to 2 pi.
struct Corner
{
  const WalkMesh& mesh;
  std::uint32_t vertex;
  Sector start;
  double ahead;

  /// The angle of where it comes from; within the face if it leads through that to the vertex.
  double back() const { return ahead - PI; }
  bool comesThroughFace() const { return back() >= -NO_ANGLE && back() <= start.angle + NO_ANGLE; }
  double backInFace() const { return std::min(start.angle, std::max(0.0, back())); }
  double overLeft() const { return ahead - start.angle; }
  double overRight() const { return 2.0 * PI - ahead; }
};

VertexTurn turnInClosedFan(const Corner& corner, const Fan& left)
{
  const Sector& start = corner.start;
  if (corner.comesThroughFace()) {
    const double back = corner.backInFace(), on_left = start.angle - back;
    const double half = (start.angle + left.angle) / 2.0;
    if (half < on_left) {
      return inSector(start, back + half);
    }
    if (half - on_left > left.angle) {
      return inSector(start, back - half);
    }
    return inFan(left, start, half - on_left, true);
  }
  const double scale = left.angle / (2.0 * PI - start.angle);
  if (corner.overLeft() <= corner.overRight()) {
    return inFan(left, start, scale * corner.overLeft(), true);
  }
  const Fan right = fanAround(corner.mesh, corner.vertex, start, false);
  return inFan(right, start, scale * corner.overRight(), false);
}

/// As far as the faces unfolded on one side reach.
VertexTurn turnUnfolded(const Corner& corner, const Fan& left, const Fan& right)
{
  const Sector& start = corner.start;
  if (corner.comesThroughFace()) {
    const double back = corner.backInFace(), on_left = start.angle - back;
    if (on_left + left.angle >= PI - NO_ANGLE) {
      return inFan(left, start, PI - on_left, true);
    }
    if (back + right.angle >= PI - NO_ANGLE) {
      return inFan(right, start, PI - back, false);
    }
    return {WalkEnd::BORDER};
  }
  const bool left_first = corner.overLeft() <= corner.overRight();
  for (const bool to_left : {left_first, !left_first}) {
    const Fan& fan = to_left ? left : right;
    const double angle = to_left ? corner.overLeft() : corner.overRight();
    if (angle <= fan.angle + NO_ANGLE && !fan.sectors.empty()) {
      return inFan(fan, start, angle, to_left);
    }
  }
  return {WalkEnd::BORDER};
}

/// A direction from a vertex as it is seen along `up`.
class View
{
 public:
  /// How the direction lies in a face: as seen, it is `right` times the one side and `left` times
  /// the other one, both >= 0 (or a multiple of that).
  struct Shares
  {
    double right, left;
  };

  View(const Vector3& up, const Vector3& direction) : up_(up), direction_(flat(direction))
  {
    const double size = norm(direction_);
    direction_ = size > 0.0 ? direction_ / size : direction_;
  }

  /// The sine of the angle between two sides as seen; below 0 for a face that is seen from behind.
  double sineBetween(const Vector3& right, const Vector3& left) const
  {
    const double seen = norm(flat(right)) * norm(flat(left));
    const bool upright = seen <= NO_ANGLE * NO_ANGLE * norm(right) * norm(left);
    return upright ? 0.0 : dot(up_, cross(right, left)) / seen;
  }

  /// The cosine of the slope of a face.
  double flatness(const Vector3& right, const Vector3& left) const
  {
    const Vector3 normal = cross(right, left);
    return std::abs(dot(up_, normal)) / norm(normal);
  }

  /// In a face that is seen from the front; nothing if the direction is not in it.
  std::optional<Shares> sharesIn(const Vector3& right, const Vector3& left) const
  {
    const Vector3 r = flat(right), l = flat(left);
    const double from_right = dot(up_, cross(r, direction_)), r_size = norm(r);
    const double from_left = dot(up_, cross(direction_, l)), l_size = norm(l);
    if (from_right < -NO_ANGLE * r_size || from_left < -NO_ANGLE * l_size ||
        dot(direction_, r) * l_size + dot(direction_, l) * r_size <= 0.0) {
      return std::nullopt;
    }
    return Shares{std::max(0.0, from_left), std::max(0.0, from_right)};
  }

 private:
  Vector3 flat(const Vector3& way) const { return way - dot(way, up_) * up_; }

  Vector3 up_, direction_;
};

/// The faces at a vertex as they are seen.
class SeenFaces
{
 public:
  SeenFaces(const WalkMesh& mesh, std::uint32_t vertex, const View& view,
            ArrayView<std::uint8_t> mask)
      : mesh_(mesh), vertex_(vertex), view_(view), mask_(mask)
  {
  }

  /// The face of the start (which may be stayed in), and those that edges connect with it there.
  void addConnected(const Sector& start, const Fan& left, const Fan& right)
  {
    addConnected(start, 0, true);
    for (const Fan& fan : {std::cref(left), std::cref(right)}) {
      for (std::size_t i = 0; i < fan.sectors.size(); ++i) {
        addConnected(fan.sectors[i], i + 1, false);
      }
    }
  }

  /// All other faces at the vertex, whichever side of them is seen; flat ones before steep ones.
  void addOthers()
  {
    std::sort(connected_.begin(), connected_.end());
    const RowsView& rows = mesh_.vertex_faces;
    for (std::uint32_t i = rows.offsets[vertex_]; i < rows.offsets[vertex_ + 1]; ++i) {
      const std::uint32_t face = rows.values[i];
      if (mesh_.face_flags[face] != 0 ||
          std::binary_search(connected_.begin(), connected_.end(), face)) {
        continue;
      }
      const std::size_t slot = slotOf(mesh_, face, vertex_);
      std::uint32_t right = cornerOf(mesh_, face, (slot + 1) % 3);
      std::uint32_t left = cornerOf(mesh_, face, (slot + 2) % 3);
      const double sine = view_.sineBetween(side(right), side(left));
      if (sine < 0.0) {
        std::swap(right, left);
      }
      if (std::abs(sine) > LEAST_SINE) {
        add({face, right, left, 0.0},
            {!isOpen(face), 1.0, -view_.flatness(side(right), side(left))});
      }
    }
  }

  /// Whether edges lead from the start to faces of which the view does not tell where they are.
  bool isFolded() const { return is_folded_; }

  /// The first one that contains the direction; BORDER if there is none.
  const VertexTurn& best() const { return best_; }

 private:
  /// What comes first: whether it must not be entered, is not connected, and is far away or steep.
  using Order = std::tuple<bool, double, double>;

  static constexpr double LEAST_SINE = 4.0 * NO_ANGLE;

  void addConnected(const Sector& sector, std::size_t steps, bool may_stay)
  {
    connected_.push_back(sector.face);
    if (view_.sineBetween(side(sector.right), side(sector.left)) > LEAST_SINE) {
      add(sector, {!may_stay && !isOpen(sector.face), 0.0, static_cast<double>(steps)});
    } else {
      is_folded_ = true;
    }
  }

  void add(const Sector& sector, const Order& order)
  {
    const Vector3 right = side(sector.right), left = side(sector.left);
    const auto shares = view_.sharesIn(right, left);
    if (!shares || (best_.end == WalkEnd::ARRIVED && !(order < best_order_))) {
      return;
    }
    best_order_ = order;
    const double angle = angleBetween(right, left);
    const double along = shares->right * norm(right), over = shares->left * norm(left);
    const double own = std::atan2(over * std::sin(angle), along + over * std::cos(angle));
    best_ = {WalkEnd::ARRIVED, sector.face, sector.right, std::min(own, angle)};
  }

  bool isOpen(std::uint32_t face) const { return mask_.empty() || mask_[face] != 0; }

  Vector3 side(std::uint32_t to) const
  {
    return difference(position(mesh_, to), position(mesh_, vertex_));
  }

  const WalkMesh& mesh_;
  std::uint32_t vertex_;
  const View& view_;
  ArrayView<std::uint8_t> mask_;
  std::vector<std::uint32_t> connected_;
  bool is_folded_ = false;
  VertexTurn best_{WalkEnd::BORDER};
  Order best_order_{};
};

Corner cornerOfFace(const WalkMesh& mesh, const FlatFace& face, std::size_t k)
{
  const std::uint32_t vertex = face.vertex(k), right = face.vertex((k + 1) % 3),
                      left = face.vertex((k + 2) % 3);
  return {mesh, vertex, {face.face(), right, left, angleAt(mesh, vertex, right, left)}, 0.0};
}

/// The turn, or that along the same edge on its other side, if its face may be entered.
VertexTurn allowed(const Corner& corner, const VertexTurn& to, ArrayView<std::uint8_t> mask)
{
  const auto isOpen = [&](std::uint32_t face) {
    return mask.empty() || face == corner.start.face || mask[face] != 0;
  };
  if (to.end != WalkEnd::ARRIVED || isOpen(to.face)) {
    return to;
  }
  const WalkMesh& mesh = corner.mesh;
  const std::size_t slot =
      3 - slotOf(mesh, to.face, corner.vertex) - slotOf(mesh, to.face, to.right);
  const std::uint32_t left = cornerOf(mesh, to.face, slot);
  const Sector sector{to.face, to.right, left, angleAt(mesh, corner.vertex, to.right, left)};
  for (const bool to_left : {false, true}) {
    if (to_left ? to.angle >= sector.angle - NO_ANGLE : to.angle <= NO_ANGLE) {
      const Sector beside = beyond(mesh, corner.vertex, sector, to_left);
      if (beside.face != NO_INDEX && isOpen(beside.face)) {
        return inSector(beside, to_left ? 0.0 : beside.angle);
      }
    }
  }
  return {WalkEnd::BLOCKED};
}

}  // namespace

VertexTurn turnAt(const WalkMesh& mesh, const FlatFace& face, std::size_t k,
                  const Vector2& direction, ArrayView<std::uint8_t> mask)
{
  Corner corner = cornerOfFace(mesh, face, k);
  const Vector2 side = face.corner((k + 1) % 3) - face.corner(k);
  const double ahead = std::atan2(cross(side, direction), dot(side, direction));  // -pi to pi
  corner.ahead = ahead < 0.0 ? ahead + 2.0 * PI : ahead;
  const Fan left = fanAround(mesh, corner.vertex, corner.start, true);
  if (left.closed) {
    return allowed(corner, turnInClosedFan(corner, left), mask);
  }
  const Fan right = fanAround(mesh, corner.vertex, corner.start, false);
  if (face.hasArea()) {
    const View view(face.normal(), face.inSpace(direction));
    SeenFaces seen(mesh, corner.vertex, view, mask);
    seen.addConnected(corner.start, left, right);
    seen.addOthers();
    if (seen.best().end == WalkEnd::ARRIVED || !seen.isFolded()) {
      return allowed(corner, seen.best(), mask);
    }
  }
  return allowed(corner, turnUnfolded(corner, left, right), mask);
}

VertexTurn seenAhead(const WalkMesh& mesh, const FlatFace& face, std::size_t k, const Vector3& up,
                     const Vector3& direction, ArrayView<std::uint8_t> mask)
{
  const Corner corner = cornerOfFace(mesh, face, k);
  const View view(up, direction);
  SeenFaces seen(mesh, corner.vertex, view, mask);
  seen.addConnected(corner.start, fanAround(mesh, corner.vertex, corner.start, true),
                    fanAround(mesh, corner.vertex, corner.start, false));
  seen.addOthers();
  return allowed(corner, seen.best(), mask);
}

}  // namespace mesh_map
