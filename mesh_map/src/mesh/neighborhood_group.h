#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/mesh/neighborhood.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// Finds the connected neighborhoods N_r(v) (see neighborhood.h) of a few vertices beside each
/// other at once: most of what is around one of them is around the others, too. Owns scratch
/// memory: one per thread.
///
/// All that is within the radius of any of them is found from edge to edge, and each vertex passes
/// on whose neighborhoods it is in, one bit for each center, to those that are within the same
/// radii.
class NeighborhoodGroup
{
 public:
  static constexpr unsigned AT_MOST = 8;

  /// Whether squared distances around this radius are far from the limits of single precision.
  static bool fits(double radius) { return radius > 1e-15 && radius < 1e15; }

  /// The arrays have to outlive this object. The radius has to fit.
  NeighborhoodGroup(const std::vector<PackedPosition>& positions, const RowsView& neighbors,
                    double radius);

  /// 1 to AT_MOST vertices: an edge shorter than the radius leads from the first to each other one.
  void find(ArrayView<std::uint32_t> centers);

  /// The center of this number and the vertices of its neighborhood, each once, after find(). Valid
  /// until the next call.
  ArrayView<std::uint32_t> around(unsigned number);

 private:
  using Bits = std::uint8_t;  // one for each center

  /// What is known of a vertex, beside each other in memory.
  struct Seen
  {
    std::uint32_t search;  // the last one that saw it
    Bits led_to;           // the centers in whose neighborhoods the ring before it is
    Bits within;           // ... and that it is nearer to than the radius
    Bits in;               // ... and in whose neighborhoods it is
  };

  /// The centers that the vertex is nearer to than the radius.
  Bits within(std::uint32_t v) const;
  Bits exactlyWithin(std::uint32_t v, unsigned centers) const;
  std::size_t addRing(std::size_t first, std::size_t count);
  void passOn();

  const PackedPosition* positions_;
  const std::uint32_t* offsets_;
  const std::uint32_t* neighbors_;
  double squared_radius_;
  float surely_within_, maybe_within_;
  ArrayView<std::uint32_t> centers_;
  float x_[AT_MOST], y_[AT_MOST], z_[AT_MOST];  // of the centers; those of the first after them
  std::uint32_t searches_ = 0;
  std::vector<Seen> seen_;            // per vertex
  std::vector<std::uint32_t> found_;  // within the radius of any center
  std::vector<Bits> found_in_;
  std::vector<std::uint32_t> open_;  // may be in more neighborhoods than known so far
  std::vector<std::uint32_t> members_;
};

}  // namespace mesh_map
