#pragma once

#include <mesh_map/mesh/topology.h>
#include <mesh_map/paths/field_trace.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vector3.h"

namespace mesh_map {

/// A point of a surface, and what it lies on.
struct FieldPlace
{
  enum Kind : std::uint8_t
  {
    FACE,    ///< inside `face`
    EDGE,    ///< between the vertices `a` and `b`
    VERTEX,  ///< `a`
    GOAL     ///< where the front came from
  };
  Kind kind = FACE;
  std::uint32_t face = NO_INDEX, a = NO_INDEX, b = NO_INDEX;
  std::uint32_t own = NO_INDEX;  ///< a face through which it may be left even if that is closed
  Vector3 position{};

  /// Are both on the same edge, or vertex?
  bool sameAs(const FieldPlace& other) const
  {
    return kind == other.kind && a == other.a && b == other.b;
  }
};

/// A straight way in `face` to another place.
struct FieldOffer
{
  FieldPlace to;
  std::uint32_t face;
  double step;   ///< what the way there costs
  double value;  ///< the potential there
  bool sure;     ///< else `value` is only what the two ends of the edge say

  double total() const { return step + value; }
};

/// A field on a mesh: what lies around places on it, and the potential there.
class FieldSurface
{
 public:
  /// Both have to outlive it. One thread at a time.
  FieldSurface(const TraceMesh& mesh, const SurfaceField& field);

  /// Throws std::invalid_argument for a point that is not on the face; `name` says which.
  FieldPlace placeOf(std::uint32_t face, const Vector3& position, const char* name) const;

  /// All ways from a place through the faces that it is on, straight to where one leaves them.
  void collectOffers(const FieldPlace& from, std::vector<FieldOffer>& offers) const;

  /// The offer of the least total, of those that `counts(offer)` accepts, with the value that
  /// `potential(place)` says; it is asked for as few of them as that needs. nullptr if there is
  /// none.
  template <class Counts, class Potential>
  static const FieldOffer* best(std::vector<FieldOffer>& offers, const Counts& counts,
                                const Potential& potential)
  {
    for (;;) {
      FieldOffer* found = nullptr;
      for (FieldOffer& offer : offers) {
        if (counts(offer) && (found == nullptr || offer.total() < found->total())) {
          found = &offer;
        }
      }
      if (found == nullptr || found->sure) {
        return found;
      }
      found->value = potential(found->to);
      found->sure = true;
    }
  }

  /// The potential at a place, by the ways from there on; at a vertex, its label.
  double value(const FieldPlace& place) const;

  /// Does the best way on from a reached vertex lead to where the potential is below its label?
  bool leadsLower(const FieldPlace& vertex) const;

  double label(std::uint32_t v) const { return field_->labels[v]; }
  Vector3 position(std::uint32_t v) const { return pointOf(mesh_->mesh.vertex(v)); }
  std::uint32_t corner(std::uint32_t face, std::size_t k) const
  {
    return mesh_->mesh.faces[3 * std::size_t{face} + k];
  }

  /// Not closed.
  bool isOpen(std::uint32_t v) const { return std::isfinite(slowness(v)); }
  /// Open, and the front came there (the value need not be final: that of what is beyond the limit
  /// may be needed for the lower end of an edge).
  bool isReached(std::uint32_t v) const
  {
    return label(v) >= 0.0 && std::isfinite(label(v)) && isOpen(v);
  }
  /// Has the face a corner that is reached, with a final value?
  bool isFaceReached(std::uint32_t face) const;
  /// Are all corners of a face open? Else it is not crossed.
  bool isFaceOpen(std::uint32_t face) const
  {
    return isOpen(corner(face, 0)) && isOpen(corner(face, 1)) && isOpen(corner(face, 2));
  }

  /// Is the vertex, or are both ends of the edge, open?
  bool isOpenAt(const FieldPlace& place) const
  {
    return (place.a == NO_INDEX || isOpen(place.a)) && (place.b == NO_INDEX || isOpen(place.b));
  }
  /// Is the potential there known without looking around?
  bool isSure(const FieldPlace& place) const
  {
    return place.kind == FieldPlace::GOAL ||
           (place.kind == FieldPlace::VERTEX && isReached(place.a));
  }
  /// Open, or that of the goal.
  bool mayEnter(std::uint32_t face) const
  {
    return isSameFace(face, field_->goal_face) || isFaceOpen(face);
  }

  double slowness(std::uint32_t v) const
  {
    return field_->slowness.empty() ? 1.0 : double{field_->slowness[v]};
  }
  /// In between it is linear; what closed corners leave open is the mean of the others.
  double slownessAt(const FieldPlace& place, std::uint32_t face) const;

  /// Of the corners that are open.
  double meanSlowness(std::uint32_t face) const;
  /// That at the goal, in a face that it is in.
  double goalSlowness(std::uint32_t face) const { return slownessAt(goal_place_, face); }

  bool hasGoal() const { return field_->goal_face != NO_INDEX; }
  const FieldPlace& goal() const { return goal_; }
  bool isGoalIn(std::uint32_t face) const;

  /// Calls body(face) for all faces that the place is on, in ascending order; of those with the
  /// same corners, for the first.
  template <class Body>
  void forFacesAt(const FieldPlace& place, const Body& body) const
  {
    if (place.kind != FieldPlace::EDGE && place.kind != FieldPlace::VERTEX) {
      body(place.face);
      return;
    }
    std::uint32_t v = place.a;
    if (place.kind == FieldPlace::EDGE && rowSize(place.b) < rowSize(v)) {
      v = place.b;
    }
    const RowsView& rows = mesh_->vertex_faces;
    for (std::size_t i = rows.offsets[v]; i < rows.offsets[v + 1]; ++i) {
      const std::uint32_t face = rows.values[i];
      if ((mesh_->face_flags[face] & FACE_DUPLICATE) == 0 &&
          (place.kind == FieldPlace::VERTEX || (has(face, place.a) && has(face, place.b)))) {
        body(face);
      }
    }
  }

 private:
  std::size_t rowSize(std::uint32_t v) const
  {
    return mesh_->vertex_faces.offsets[v + 1] - mesh_->vertex_faces.offsets[v];
  }
  bool has(std::uint32_t face, std::uint32_t v) const
  {
    return corner(face, 0) == v || corner(face, 1) == v || corner(face, 2) == v;
  }
  /// Are these one face, or duplicates?
  bool isSameFace(std::uint32_t face, std::uint32_t other) const
  {
    return face == other || (face != NO_INDEX && other != NO_INDEX && has(face, corner(other, 0)) &&
                             has(face, corner(other, 1)) && has(face, corner(other, 2)) &&
                             has(other, corner(face, 0)) && has(other, corner(face, 1)) &&
                             has(other, corner(face, 2)));
  }
  template <class Sink>
  void offersIn(std::uint32_t face, const FieldPlace& from, const Sink& sink) const;
  template <class Sink>
  void edgeOffer(std::uint32_t face, std::size_t k, const FieldPlace& from, double slowness_here,
                 const Sink& sink) const;

  /// Makes the range reach all slowness of the corners that are open.
  void widen(std::uint32_t face, double& low, double& high) const;
  double firstValue(const FieldPlace& place) const;
  const FieldOffer* nextOffer(const FieldPlace& place) const;

  const TraceMesh* mesh_;
  const SurfaceField* field_;
  FieldPlace goal_, goal_place_;  // goal_place_: what the goal lies on
  mutable std::vector<FieldOffer> scratch_;
};

}  // namespace mesh_map
