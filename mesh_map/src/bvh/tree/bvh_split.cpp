#include "bvh/tree/bvh_split.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mesh_map {

namespace {

/// Twice the center of an item's box; 0 where that is no number, and in the fourth place.
Floats4 center(const BvhItem& item)
{
  // The numbers in the fourth place would be denormal, with which processors are slow.
  const Ints4 three = {-1, -1, -1, 0};
  const Floats4 sum = (Floats4)((Ints4)item.lower & three) + (Floats4)((Ints4)item.upper & three);
  return sum == sum ? sum : all4(0.0f);
}

/// Which bin a center is in.
struct Binning
{
  Floats4 origin, scale;

  Floats4 operator()(Floats4 center) const { return (center - origin) * scale; }
};

/// Half of the items: full leaves, where these are triangles.
std::uint32_t evenShare(const BvhSpan& span)
{
  if (span.count > span.items() || span.count <= BVH_LEAF_SIZE) {
    return span.items() / 2;
  }
  return (leafBlocks(span.count) + 1) / 2 * BVH_LEAF_SIZE;
}

template <unsigned BINS>
struct Bins
{
  FloatBox boxes[3][BINS];
  std::uint32_t counts[3][BINS] = {};
};

struct Cut
{
  float cost = std::numeric_limits<float>::infinity();
  int axis = -1;
  unsigned bin = 0;  // the first one on the right
};

/// The cut of the least surfaces times leaves: the surface area heuristic (J. MacDonald, K. Booth:
/// Heuristics for Ray Tracing Using Space Subdivision, 1990) over bins (Wald 2007).
template <unsigned BINS>
Cut bestCut(const Bins<BINS>& bins, std::uint32_t total)
{
  Cut best;
  for (int axis = 0; axis < 3; ++axis) {
    float right_costs[BINS];
    FloatBox box;
    std::uint32_t count = 0;
    for (unsigned bin = BINS - 1; bin > 0; --bin) {
      box.add(bins.boxes[axis][bin]);
      count += bins.counts[axis][bin];
      right_costs[bin] = count > 0 ? halfArea(box) * static_cast<float>(leafBlocks(count))
                                   : std::numeric_limits<float>::infinity();
    }
    box = FloatBox();
    count = 0;
    for (unsigned bin = 1; bin < BINS; ++bin) {
      box.add(bins.boxes[axis][bin - 1]);
      count += bins.counts[axis][bin - 1];
      const float cost = halfArea(box) * static_cast<float>(leafBlocks(count)) + right_costs[bin];
      if (cost < best.cost && count > 0 && count < total) {
        best = {cost, axis, bin};
      }
    }
  }
  return best;
}

}  // namespace

BvhSpan BvhSplitter::measured(std::uint32_t begin, std::uint32_t end, std::uint32_t buffer) const
{
  BvhSpan span = {begin, end, buffer, 0, {}};
  for (const BvhItem* item = buffers_[buffer] + begin; item < buffers_[buffer] + end; ++item) {
    span.box.add(*item);
    span.count += item->count();
  }
  return span;
}

template <unsigned BINS>
std::pair<BvhSpan, BvhSpan> BvhSplitter::binnedSplit(const BvhSpan& span,
                                                     const FloatBox& centers) const
{
  // A little less than BINS, so that the highest center is in the last one.
  const Floats4 extent = centers.upper - centers.lower;
  Binning binning = {centers.lower, all4(0.0f)};
  for (int axis = 0; axis < 3; ++axis) {
    const float scale = 0.99999f * static_cast<float>(BINS) / extent[axis];
    binning.scale[axis] = scale < std::numeric_limits<float>::infinity() ? scale : 0.0f;
  }

  const BvhItem* const from = buffers_[span.buffer];
  Bins<BINS> bins;
  for (std::uint32_t i = span.begin; i < span.end; ++i) {
    const Floats4 last = all4(static_cast<float>(BINS - 1));
    const Floats4 place = minimum(maximum(binning(center(from[i])), all4(0.0f)), last);
    for (int axis = 0; axis < 3; ++axis) {
      const auto bin = static_cast<unsigned>(static_cast<int>(place[axis]));
      bins.boxes[axis][bin].add(from[i]);
      bins.counts[axis][bin] += from[i].count();
    }
  }
  const Cut cut = bestCut(bins, span.count);
  if (cut.axis < 0 || !(cut.cost > 0.0f)) {  // no surface, or no numbers: all cuts are alike
    const std::uint32_t middle = span.begin + evenShare(span);
    return {measured(span.begin, middle, span.buffer), measured(middle, span.end, span.buffer)};
  }

  BvhSpan left = {span.begin, span.begin, 1 - span.buffer, 0, {}}, right = left;
  for (unsigned bin = 0; bin < BINS; ++bin) {
    BvhSpan& side = bin < cut.bin ? left : right;
    side.box.add(bins.boxes[cut.axis][bin]);
    side.count += bins.counts[cut.axis][bin];
  }
  BvhItem* const to = buffers_[1 - span.buffer];
  const auto border = static_cast<float>(cut.bin);
  std::uint32_t places[2] = {span.begin, span.end};  // an array: no branch to be mispredicted
  for (std::uint32_t i = span.begin; i < span.end; ++i) {
    const bool is_right = binning(center(from[i]))[cut.axis] >= border;
    places[1] -= is_right ? 1 : 0;
    to[places[is_right ? 1 : 0]] = from[i];
    places[0] += is_right ? 0 : 1;
  }
  left.end = right.begin = places[0];
  right.end = span.end;
  return {left, right};
}

std::pair<BvhSpan, BvhSpan> BvhSplitter::split(const BvhSpan& span) const
{
  FloatBox centers;
  const BvhItem* const from = items(span);
  for (const BvhItem* item = from; item < from + span.items(); ++item) {
    centers.add(center(*item));
  }
  return span.items() > 128 ? binnedSplit<16>(span, centers) : binnedSplit<8>(span, centers);
}

std::pair<BvhSpan, BvhSpan> BvhSplitter::halve(const BvhSpan& span) const
{
  FloatBox centers;
  BvhItem* const from = buffers_[span.buffer] + span.begin;
  for (const BvhItem* item = from; item < from + span.items(); ++item) {
    centers.add(center(*item));
  }
  const Floats4 extent = centers.upper - centers.lower;
  int axis = extent[1] > extent[0] ? 1 : 0;
  axis = extent[2] > extent[axis] ? 2 : axis;
  const std::uint32_t half = evenShare(span);
  if (extent[axis] > 0.0f) {
    std::nth_element(from, from + half, from + span.items(),
                     [axis](const BvhItem& a, const BvhItem& b) {
                       const float ca = center(a)[axis], cb = center(b)[axis];
                       return ca < cb || (ca == cb && a.index() < b.index());
                     });
  }
  const std::uint32_t middle = span.begin + half;
  return {measured(span.begin, middle, span.buffer), measured(middle, span.end, span.buffer)};
}

}  // namespace mesh_map
