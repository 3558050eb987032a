#include "mesh/neighborhood_group.h"

#include <algorithm>

#include "base/simd.h"
#include "mesh/packed_position.h"

namespace mesh_map {

namespace {

/// More than the relative error of a squared distance in single precision.
constexpr double SLACK = 1e-6;

}  // namespace

NeighborhoodGroup::NeighborhoodGroup(const std::vector<PackedPosition>& positions,
                                     const RowsView& neighbors, double radius)
    : positions_(positions.data()),
      offsets_(neighbors.offsets.data()),
      neighbors_(neighbors.values.data()),
      squared_radius_(radius * radius),
      surely_within_(static_cast<float>(squared_radius_ * (1.0 - SLACK))),
      maybe_within_(static_cast<float>(squared_radius_ * (1.0 + SLACK))),
      seen_(positions.size(), Seen{}),
      found_(AT_MOST)
{
}

void NeighborhoodGroup::find(ArrayView<std::uint32_t> centers)
{
  centers_ = centers;
  for (unsigned k = 0; k < AT_MOST; ++k) {
    const PackedPosition& at = positions_[centers[k < centers.size() ? k : 0]];
    x_[k] = at.x;
    y_[k] = at.y;
    z_[k] = at.z;
  }
  ++searches_;
  open_.clear();
  for (std::size_t k = 0; k < centers.size(); ++k) {
    // Edges lead from each center to the others by way of the first one.
    const std::uint32_t center = centers[k];
    found_[k] = center;
    const auto near = static_cast<Bits>(within(center) | 1u << k);
    seen_[center] = {searches_, 0, near, near};
  }
  std::size_t first = 0, count = centers.size();
  while (first < count) {
    const std::size_t ring = first;
    first = count;
    count = addRing(ring, count);
  }
  passOn();
  found_in_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    found_in_[i] = seen_[found_[i]].in;
  }
}

ArrayView<std::uint32_t> NeighborhoodGroup::around(unsigned number)
{
  const std::size_t size = found_in_.size();
  members_.resize(std::max(members_.size(), size + 1));
  const std::uint32_t* const found = found_.data();
  const Bits* const in = found_in_.data();
  std::uint32_t* const members = members_.data();
  std::size_t count = 0;
  for (std::size_t i = 0; i < size; ++i) {
    members[count] = found[i];
    count += in[i] >> number & 1u;
  }
  return {members, count};
}

NeighborhoodGroup::Bits NeighborhoodGroup::within(std::uint32_t v) const
{
  const PackedPosition at = positions_[v];
  unsigned surely = 0, maybe = 0;
  for (unsigned k = 0; k < AT_MOST; k += 4) {
    const Floats4 x = at.x - load4(x_ + k), y = at.y - load4(y_ + k), z = at.z - load4(z_ + k);
    const Floats4 squared = x * x + y * y + z * z;
    surely |= bits(squared < surely_within_) << k;
    maybe |= bits(squared <= maybe_within_) << k;
  }
  const unsigned all = (1u << centers_.size()) - 1u;
  if (((maybe & ~surely) & all) != 0) {
    surely |= exactlyWithin(v, maybe & ~surely & all);
  }
  return static_cast<Bits>(surely & all);
}

NeighborhoodGroup::Bits NeighborhoodGroup::exactlyWithin(std::uint32_t v, unsigned centers) const
{
  unsigned result = 0;
  for (; centers != 0; centers &= centers - 1u) {
    const unsigned k = lowestBit(centers);
    const Vector3 way = between(positions_[centers_[k]], positions_[v]);
    result |= dot(way, way) < squared_radius_ ? 1u << k : 0u;
  }
  return static_cast<Bits>(result);
}

/// Adds to found_[0, count) what its end, from `first` on, leads to; returns the new count.
std::size_t NeighborhoodGroup::addRing(std::size_t first, std::size_t count)
{
  // Local copies: what is written below could be a member, as far as the compiler knows.
  const std::uint32_t* const offsets = offsets_;
  const std::uint32_t* const neighbors = neighbors_;
  Seen* const seen = seen_.data();
  std::uint32_t* found = found_.data();
  const std::uint32_t search = searches_;

  std::size_t end = count;
  for (std::size_t i = first; i < count; ++i) {
    const std::uint32_t from = found[i], row_begin = offsets[from], row_end = offsets[from + 1];
    const Bits in = seen[from].in;
    if (end + (row_end - row_begin) > found_.size()) {
      found_.resize(2 * (end + (row_end - row_begin)));
      found = found_.data();
    }
    for (std::uint32_t k = row_begin; k < row_end;
         ++k) {  // without a branch: a wrong guess is dear
      const std::uint32_t to = neighbors[k];
      Seen& of = seen[to];
      const bool is_new = of.search != search;
      found[end] = to;
      end += is_new;
      of.search = search;
      of.led_to = static_cast<Bits>(in | (of.led_to & (static_cast<unsigned>(is_new) - 1u)));
    }
  }
  std::size_t kept = count;
  for (std::size_t i = count; i < end; ++i) {
    const std::uint32_t to = found[i];
    Seen& of = seen[to];
    of.within = within(to);
    of.in = of.within & of.led_to;
    if (of.in != of.within) {
      open_.push_back(to);
    }
    found[kept] = to;
    kept += of.within != 0;
  }
  return kept;
}

/// Where edges led past a vertex before its neighbors knew whose neighborhoods they are in.
void NeighborhoodGroup::passOn()
{
  for (std::size_t i = 0; i < open_.size(); ++i) {
    const std::uint32_t v = open_[i];
    Bits around = 0;
    for (std::uint32_t k = offsets_[v]; k < offsets_[v + 1]; ++k) {
      const Seen& of = seen_[neighbors_[k]];
      around |= of.search == searches_ ? of.in : Bits{0};
    }
    const Bits in = seen_[v].in | (around & seen_[v].within);
    if (in == seen_[v].in) {
      continue;
    }
    seen_[v].in = in;
    for (std::uint32_t k = offsets_[v]; k < offsets_[v + 1]; ++k) {
      const Seen& of = seen_[neighbors_[k]];
      if (of.search == searches_ && (of.within & in & ~of.in) != 0) {
        open_.push_back(neighbors_[k]);
      }
    }
  }
}

}  // namespace mesh_map
