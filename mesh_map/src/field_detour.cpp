#include "field_detour.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <tuple>
#include <unordered_map>

namespace mesh_map {
namespace {

/// Added to the slowness, so that of ways that cost nothing the shorter one counts.
constexpr double LEAST_SLOWNESS = 1e-9;

/// How a vertex was reached.
struct Reached
{
  double distance;
  std::uint32_t from;  // a vertex; NO_INDEX from the place where all began
  std::uint32_t face;
};

}  // namespace

std::vector<FieldLeg> findDetour(const FieldSurface& surface, const FieldPlace& from,
                                 double potential, const std::atomic<bool>* cancel)
{
  using Entry = std::tuple<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
  std::unordered_map<std::uint32_t, Reached> reached;
  std::vector<FieldOffer> offers;
  const auto spread = [&](const FieldPlace& place, double distance_here) {
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
  spread(from, 0.0);
  if (from.kind == FieldPlace::VERTEX) {
    reached[from.a] = {0.0, NO_INDEX, NO_INDEX};
  }
  while (!queue.empty() && !(cancel != nullptr && cancel->load(std::memory_order_relaxed))) {
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
    spread(place, here);
  }
  return legs;
}

}  // namespace mesh_map
