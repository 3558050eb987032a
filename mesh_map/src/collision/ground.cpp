#include "collision/ground.h"

#include <algorithm>
#include <numeric>

namespace mesh_map {

namespace {

/// Bits of a corner.
constexpr unsigned LOW = 1, WITHIN = 2;

}  // namespace

std::vector<std::uint32_t> surfacesOf(const MeshView& mesh)
{
  std::vector<std::uint32_t> joined(mesh.vertexCount());
  std::iota(joined.begin(), joined.end(), 0u);
  const auto lowest = [&](std::uint32_t vertex) {
    while (joined[vertex] != vertex) {
      vertex = joined[vertex] = joined[joined[vertex]];
    }
    return vertex;
  };
  for (std::size_t i = 0; i < mesh.faces.size(); i += 3) {
    for (std::size_t k = 1; k < 3; ++k) {
      const std::uint32_t one = lowest(mesh.faces[i]), other = lowest(mesh.faces[i + k]);
      joined[std::max(one, other)] = std::min(one, other);
    }
  }
  for (std::uint32_t& vertex : joined) {
    vertex = joined[vertex];  // those before it are done
  }
  return joined;
}

Ground::Ground(const MeshView& mesh, const RowsView& vertex_faces,
               const std::vector<std::uint8_t>& covered, const std::vector<std::uint8_t>& closed,
               double rise)
    : mesh_(mesh),
      vertex_faces_(vertex_faces),
      covered_(covered),
      closed_(closed),
      rise_(rise),
      vertices_(mesh.vertexCount()),
      faces_(mesh.faceCount()),
      corners_(mesh.vertexCount(), 0)
{
}

void Ground::begin(std::uint32_t vertex, const VertexBand& body)
{
  vertex_ = vertex;
  body_ = &body;
  missing_ = 0;
  if (++round_ == 0) {  // after 2^32 of them
    std::fill(vertices_.begin(), vertices_.end(), Rounds());
    std::fill(faces_.begin(), faces_.end(), Rounds());
    round_ = 1;
  }
}

void Ground::want(std::uint32_t face)
{
  missing_ += faces_[face].known == round_ ? 0 : 1;
  faces_[face].known = round_;
}

bool Ground::isLow(const float* corners) const
{
  return isLowPoint(corners) && isLowPoint(corners + 3) && isLowPoint(corners + 6);
}

bool Ground::hasAllWanted()
{
  reached_.assign(1, vertex_);
  vertices_[vertex_].reached = round_;
  for (std::size_t i = 0; missing_ > 0 && i < reached_.size(); ++i) {
    const std::size_t from = reached_[i];
    for (std::size_t j = vertex_faces_.offsets[from];
         missing_ > 0 && j < vertex_faces_.offsets[from + 1]; ++j) {
      const std::uint32_t face = vertex_faces_.values[j];
      if (faces_[face].reached != round_ &&
          (closed_[from] == 0 || (covered_[face] & HAS_CELLS) != 0)) {
        faces_[face].reached = round_;
        if (isGround(face)) {
          missing_ -= faces_[face].known == round_ ? 1 : 0;
          reachCorners(face);
        }
      }
    }
  }
  return missing_ == 0;
}

unsigned Ground::cornerOf(std::uint32_t vertex)
{
  if (vertices_[vertex].known != round_) {
    vertices_[vertex].known = round_;
    const float* const point = mesh_.vertex(vertex);
    corners_[vertex] = static_cast<std::uint8_t>((isLowPoint(point) ? LOW : 0u) |
                                                 (body_->isWithin(point) ? WITHIN : 0u));
  }
  return corners_[vertex];
}

bool Ground::isGround(std::size_t face)
{
  const std::uint32_t* const of = &mesh_.faces[3 * face];
  const unsigned a = cornerOf(of[0]), b = cornerOf(of[1]), c = cornerOf(of[2]);
  if ((a & b & c & LOW) == 0) {
    return false;
  }
  if (((a | b | c) & WITHIN) != 0) {
    return true;
  }
  float corners[9];
  for (std::size_t k = 0; k < 3; ++k) {
    const float* const corner = mesh_.corner(face, k);
    std::copy(corner, corner + 3, corners + 3 * k);
  }
  return body_->isNear(corners);
}

void Ground::reachCorners(std::size_t face)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t corner = mesh_.faces[3 * face + k];
    if (vertices_[corner].reached != round_) {
      vertices_[corner].reached = round_;
      reached_.push_back(corner);
    }
  }
}

}  // namespace mesh_map
