#include <mesh_map/base/run_options.h>
#include <mesh_map/paths/field_trace.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "base/require.h"
#include "paths/field_surface.h"

namespace mesh_map {

namespace {

/// One leg of a way: straight in `face` to a place.
struct FieldLeg
{
  FieldPlace to;
  std::uint32_t face;
};

/// Added to the slowness, so that of ways that cost nothing the shorter one counts.
constexpr double LEAST_SLOWNESS = 1e-9;

/// How a vertex was reached.
struct Reached
{
  double distance;
  std::uint32_t from;  // a vertex; NO_INDEX from the place where all began
  std::uint32_t face;
};

/// The shortest way along edges from a place to a vertex whose label is below `potential`, or to
/// the goal, however much it climbs in between; empty if there is none, or it was canceled.
std::vector<FieldLeg> findDetour(const FieldSurface& surface, const FieldPlace& from,
                                 double potential, const std::atomic<bool>* cancel)
{
  using Entry = std::tuple<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
  std::unordered_map<std::uint32_t, Reached> reached;
  std::vector<FieldOffer> offers;
  const auto relax = [&](const FieldPlace& place, double distance_here) {
    surface.collectOffers(place, offers);
    for (const FieldOffer& offer : offers) {
      if (offer.to.kind != FieldPlace::VERTEX) {
        continue;
      }
      const double length = distance(place.position, offer.to.position);
      const double there = distance_here + offer.step + LEAST_SLOWNESS * length;
      const std::uint32_t origin = place.kind == FieldPlace::VERTEX ? place.a : NO_INDEX;
      const auto [entry, is_new] =
          reached.try_emplace(offer.to.a, Reached{there, origin, offer.face});
      if (is_new || there < entry->second.distance) {
        entry->second = {there, origin, offer.face};
        queue.emplace(there, offer.to.a);
      }
    }
  };
  const auto vertexPlace = [&surface](std::uint32_t v, std::uint32_t face) {
    FieldPlace place;
    place.kind = FieldPlace::VERTEX;
    place.face = face;
    place.a = v;
    place.position = surface.position(v);
    return place;
  };

  std::vector<FieldLeg> legs;
  relax(from, 0.0);
  if (from.kind == FieldPlace::VERTEX) {
    reached[from.a] = {0.0, NO_INDEX, NO_INDEX};
  }
  while (!queue.empty() && !isSet(cancel)) {
    const auto [here, v] = queue.top();
    queue.pop();
    if (here > reached[v].distance) {
      continue;
    }
    const FieldPlace place = vertexPlace(v, NO_INDEX);
    const bool is_lower = surface.label(v) < potential;
    std::uint32_t goal_face = NO_INDEX;
    if (!is_lower && surface.hasGoal()) {
      surface.forFacesAt(place, [&](std::uint32_t face) {
        goal_face = goal_face == NO_INDEX && surface.isGoalIn(face) ? face : goal_face;
      });
    }
    if (is_lower || goal_face != NO_INDEX) {
      if (goal_face != NO_INDEX) {
        legs.push_back({surface.goal(), goal_face});
      }
      for (std::uint32_t w = v; w != NO_INDEX && reached[w].face != NO_INDEX; w = reached[w].from) {
        legs.push_back({vertexPlace(w, reached[w].face), reached[w].face});
      }
      std::reverse(legs.begin(), legs.end());
      return legs;
    }
    relax(place, here);
  }
  return legs;
}

/// Points nearer to each other than this part of the faces there are one point.
constexpr double SAME_POINT = 1e-9;

/// A potential has to be lower by this part of it: less is rounding.
constexpr double LOWER = 1e-12;

/// How many points the way may go on without a lower one, before it is looked for along edges.
constexpr std::size_t MAX_CLIMB = 4;

/// How often an edge may be crossed.
constexpr unsigned MAX_CROSSINGS = 4;

/// The way that grows, against the gradient of the potential: a characteristic of the eikonal
/// equation (Kimmel and Sethian: Computing Geodesic Paths on Manifolds, 1998).
class Descent
{
 public:
  Descent(const FieldSurface& surface, const FieldPlace& start, const std::atomic<bool>* cancel)
      : surface_(&surface), cancel_(cancel), here_(start), lowest_place_(start)
  {
    points_.push_back(start.position);
    potentials_.push_back(surface.value(start));
    lowest_ = potentials_.back();
  }

  TraceEnd run(double max_length, FieldPath& path)
  {
    while (length_ < max_length && !isArrived()) {
      if (isSet(cancel_)) {
        return TraceEnd::CANCELED;
      }
      if ((climbed_.size() >= MAX_CLIMB || !goOn()) && !climb()) {
        return isSet(cancel_) ? TraceEnd::CANCELED : TraceEnd::NOT_REACHED;
      }
    }
    if (length_ > max_length) {
      cutAt(max_length);
    }
    write(path);
    return TraceEnd::ARRIVED;
  }

 private:
  /// At the goal; or, where the front came from vertices, at one from which no way leads lower.
  bool isArrived()
  {
    if (here_.kind == FieldPlace::GOAL) {
      return true;
    }
    if (surface_->hasGoal() || here_.kind != FieldPlace::VERTEX || !climbed_.empty()) {
      return false;
    }
    return !(surface_->label(here_.a) > 0.0) || !surface_->leadsLower(here_);
  }

  bool goOn()
  {
    const auto counts = [this](const FieldOffer& offer) {
      for (const FieldPlace& place : climbed_) {
        if (offer.to.sameAs(place)) {
          return false;
        }
      }
      if (offer.to.kind != FieldPlace::EDGE) {
        return true;
      }
      const auto found = crossings_.find(edgeKey(offer.to));
      return found == crossings_.end() || found->second < MAX_CROSSINGS;
    };
    surface_->collectOffers(here_, offers_);
    const FieldOffer* const found = FieldSurface::best(
        offers_, counts, [this](const FieldPlace& to) { return surface_->value(to); });
    if (found == nullptr || !std::isfinite(found->total())) {
      return false;
    }
    const FieldOffer offer = *found;
    append(offer.to, offer.face, offer.value);
    return true;
  }

  /// From the lowest point along edges to a lower one.
  bool climb()
  {
    points_.resize(potentials_.size());
    faces_.resize(points_.size() - 1);
    here_ = lowest_place_;
    climbed_.clear();
    const double below = lowest_ * (1.0 - LOWER);
    const std::vector<FieldLeg> legs = findDetour(*surface_, here_, below, cancel_);
    for (std::size_t i = 0; i < legs.size(); ++i) {
      const FieldPlace& to = legs[i].to;
      const bool is_last = i + 1 == legs.size();
      const double value = to.kind == FieldPlace::GOAL ? 0.0 : surface_->label(to.a);
      append(to, legs[i].face, is_last ? value : lowest_);
    }
    return !legs.empty();
  }

  void append(const FieldPlace& to, std::uint32_t face, double value)
  {
    if (to.kind == FieldPlace::EDGE) {
      ++crossings_[edgeKey(to)];
    }
    double size = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      size = std::max(size, distance(surface_->position(surface_->corner(face, k)),
                                     surface_->position(surface_->corner(face, (k + 1) % 3))));
    }
    if (distance(points_.back(), to.position) <= SAME_POINT * size) {
      here_ = to;
      here_.position = points_.back();
      if (to.kind == FieldPlace::GOAL) {
        points_.back() = to.position;
      }
    } else {
      points_.push_back(to.position);
      faces_.push_back(face);
      here_ = to;
    }
    if (value < lowest_ * (1.0 - LOWER) || to.kind == FieldPlace::GOAL) {
      settle(points_.size(), value);
    } else {
      climbed_.push_back(to);
    }
  }

  /// The last point is the lowest so far: gives potentials to those that lead there.
  void settle(std::size_t end, double value)
  {
    const std::size_t begin = potentials_.size();
    double length = 0.0, done = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      length += distance(points_[i - 1], points_[i]);
    }
    for (std::size_t i = begin; i + 1 < end; ++i) {
      done += distance(points_[i - 1], points_[i]);
      potentials_.push_back(lowest_ + (value - lowest_) * (done / length));
    }
    if (begin < end) {
      potentials_.push_back(value);
    } else if (here_.kind == FieldPlace::GOAL) {
      potentials_.back() = value;
    }
    length_ += length;
    lowest_ = value;
    lowest_place_ = here_;
    climbed_.clear();
  }

  void cutAt(double max_length)
  {
    double before = 0.0;
    for (std::size_t i = 1; i < points_.size(); ++i) {
      const double step = distance(points_[i - 1], points_[i]);
      if (step > 0.0 && before + step >= max_length) {
        const double share = (max_length - before) / step;
        points_[i] = points_[i - 1] + share * (points_[i] - points_[i - 1]);
        potentials_[i] = potentials_[i - 1] + share * (potentials_[i] - potentials_[i - 1]);
        points_.resize(i + 1);
        potentials_.resize(i + 1);
        faces_.resize(i);
        return;
      }
      before += step;
    }
  }

  void write(FieldPath& path) const
  {
    path.faces = faces_;
    path.potentials = potentials_;
    path.points.clear();
    for (const Vector3& point : points_) {
      path.points.insert(path.points.end(), point.begin(), point.end());
    }
  }

  static std::uint64_t edgeKey(const FieldPlace& edge)
  {
    return std::uint64_t{edge.a} << 32 | edge.b;
  }

  const FieldSurface* surface_;
  const std::atomic<bool>* cancel_;
  std::vector<Vector3> points_;
  std::vector<std::uint32_t> faces_;
  std::vector<double> potentials_;  // of the points up to the lowest one
  double length_ = 0.0;             // up to there
  FieldPlace here_;
  FieldPlace lowest_place_;
  double lowest_;
  std::vector<FieldPlace> climbed_;  // places since then, through which the way does not go again
  std::vector<FieldOffer> offers_;
  std::unordered_map<std::uint64_t, unsigned> crossings_;
};

}  // namespace

TraceEnd tracePath(const TraceMesh& mesh, const SurfaceField& field, std::uint32_t face,
                   const std::array<double, 3>& start, const std::atomic<bool>* cancel,
                   FieldPath& path, double max_length)
{
  require(max_length >= 0.0, "the length of a way has to be >= 0");
  const FieldSurface surface(mesh, field);
  const FieldPlace place = surface.placeOf(face, start, "the start");
  if (!surface.isFaceReached(face)) {
    return TraceEnd::NOT_REACHED;
  }
  return Descent(surface, place, cancel).run(max_length, path);
}

double fieldValue(const TraceMesh& mesh, const SurfaceField& field, std::uint32_t face,
                  const std::array<double, 3>& point)
{
  const FieldSurface surface(mesh, field);
  const FieldPlace place = surface.placeOf(face, point, "the point");
  return surface.isFaceReached(face) ? surface.value(place)
                                     : std::numeric_limits<double>::infinity();
}

void checkField(const TraceMesh& mesh, const SurfaceField& field)
{
  const std::size_t count = mesh.mesh.vertexCount();
  require(mesh.vertex_faces.rowCount() == count, "vertex_faces need one row per vertex");
  require(mesh.face_flags.size() == mesh.mesh.faceCount(), "face_flags need one value per face");
  require(
      field.labels.size() == count && (field.slowness.empty() || field.slowness.size() == count),
      "the field is of another mesh");
  require(field.goal_face == NO_INDEX || field.goal_face < mesh.mesh.faceCount(),
          "the face of the goal does not exist");
}

}  // namespace mesh_map
