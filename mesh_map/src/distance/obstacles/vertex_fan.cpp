#include "distance/obstacles/vertex_fan.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <tuple>

#include "base/unique.h"

namespace mesh_map {

void VertexFan::gather(const FastMarchingMesh& mesh, std::uint32_t middle)
{
  is_fan_ = mesh.isFan(middle);
  is_closed_ = mesh.isClosed(middle);
  if (!is_fan_) {
    gatherAny(mesh, middle);
    return;
  }
  const ArrayView<FastMarchingCorner> corners = mesh.corners(middle);
  const std::size_t turns = corners.size();
  const std::size_t count = is_closed_ ? turns : turns + 1;
  nodes_.resize(count);
  turns_.resize(turns);
  const PackedPosition from = mesh.position(middle);
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t vertex = k < turns ? corners[k].a : corners[k - 1].b;
    nodes_[k] = node(from, mesh.position(vertex), vertex);
  }
  for (std::size_t k = 0; k + 1 < count; ++k) {
    turns_[k] = turn(nodes_[k], nodes_[k + 1]);
  }
  if (is_closed_) {
    turns_[count - 1] = turn(nodes_[count - 1], nodes_[0]);
  }
}

void VertexFan::gatherAny(const FastMarchingMesh& mesh, std::uint32_t middle)
{
  std::vector<std::uint32_t> vertices;
  for (const FastMarchingCorner& corner : mesh.corners(middle)) {
    vertices.push_back(corner.a);
    vertices.push_back(corner.b);
  }
  makeUnique(vertices);
  nodes_.clear();
  for (const std::uint32_t vertex : vertices) {
    if (vertex != middle) {
      nodes_.push_back(node(mesh.position(middle), mesh.position(vertex), vertex));
    }
  }
  arcs_.clear();
  for (const FastMarchingCorner& corner : mesh.corners(middle)) {
    if (corner.a != corner.b) {
      const std::size_t a = find(corner.a), b = find(corner.b);
      const Turn by = turn(nodes_[a], nodes_[b]);
      const double angle = std::atan2(by.sine, by.cosine);
      arcs_.push_back({a, b, angle});
      arcs_.push_back({b, a, angle});
    }
  }
  std::sort(arcs_.begin(), arcs_.end(), [](const Arc& p, const Arc& q) {
    return std::tie(p.from, p.to) < std::tie(q.from, q.to);
  });
  const auto same = [](const Arc& p, const Arc& q) { return p.from == q.from && p.to == q.to; };
  arcs_.erase(std::unique(arcs_.begin(), arcs_.end(), same), arcs_.end());
  arc_starts_.assign(nodes_.size() + 1, 0);
  for (const Arc& arc : arcs_) {
    ++arc_starts_[arc.from + 1];
  }
  std::partial_sum(arc_starts_.begin(), arc_starts_.end(), arc_starts_.begin());
}

std::size_t VertexFan::find(std::uint32_t vertex) const
{
  if (is_fan_) {
    std::size_t k = 0;
    while (k < nodes_.size() && nodes_[k].vertex != vertex) {
      ++k;
    }
    return k;
  }
  const auto below = [](const Node& node, std::uint32_t v) { return node.vertex < v; };
  const auto found = std::lower_bound(nodes_.begin(), nodes_.end(), vertex, below);
  const bool is_here = found != nodes_.end() && found->vertex == vertex;
  return is_here ? static_cast<std::size_t>(found - nodes_.begin()) : nodes_.size();
}

void VertexFan::startAny(std::size_t axis, std::size_t side, bool toward)
{
  reached_.assign(nodes_.size(), false);
  reached_[axis] = true;
  places_.clear();
  for (std::size_t i = arc_starts_[axis]; i < arc_starts_[axis + 1]; ++i) {
    if ((arcs_[i].to == side) == toward) {
      places_.push_back({arcs_[i].angle, arcs_[i].to, axis});
    }
  }
  std::make_heap(places_.begin(), places_.end(), std::greater<Place>());
}

bool VertexFan::nextAny(Place& place)
{
  while (!places_.empty()) {
    place = places_.front();
    std::pop_heap(places_.begin(), places_.end(), std::greater<Place>());
    places_.pop_back();
    if (!reached_[place.node]) {
      reached_[place.node] = true;
      return true;
    }
  }
  return false;
}

void VertexFan::leaveAny(const Place& place)
{
  for (std::size_t i = arc_starts_[place.node]; i < arc_starts_[place.node + 1]; ++i) {
    if (!reached_[arcs_[i].to]) {
      places_.push_back({place.angle + arcs_[i].angle, arcs_[i].to, place.node});
      std::push_heap(places_.begin(), places_.end(), std::greater<Place>());
    }
  }
}

}  // namespace mesh_map
