#include "measurement/section_contacts.h"

#include <array>
#include <cmath>

#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

/// Sine of the angle from which on two segments make a corner, and cosine of the one from which on
/// two faces look at each other.
constexpr double CORNER = 0.1;
constexpr double OPPOSITE = -0.99;

/// The direction to which a face looks, in the plane of the section.
std::array<double, 2> lookOf(const std::vector<SectionNode>& nodes, const SectionSegment& segment)
{
  const double s = nodes[segment.b].s - nodes[segment.a].s;
  const double z = nodes[segment.b].z - nodes[segment.a].z;
  const double length = std::hypot(s, z);
  return length > 0.0 ? std::array<double, 2>{-z / length, s / length} : std::array<double, 2>{};
}

}  // namespace

std::pair<double, double> nearestOn(const std::vector<SectionNode>& nodes,
                                    const SectionSegment& segment, const SectionNode& point)
{
  const SectionNode& a = nodes[segment.a];
  const SectionNode& b = nodes[segment.b];
  const double s = b.s - a.s, z = b.z - a.z;
  const double squared = s * s + z * z;
  const double share =
      squared > 0.0 ? std::clamp(((point.s - a.s) * s + (point.z - a.z) * z) / squared, 0.0, 1.0)
                    : 0.0;
  return {share, std::hypot(a.s + share * s - point.s, a.z + share * z - point.z)};
}

std::vector<bool> endsAndCorners(const std::vector<SectionNode>& nodes,
                                 const std::vector<SectionSegment>& segments)
{
  std::vector<unsigned> degrees(nodes.size(), 0);
  std::vector<std::array<double, 2>> first(nodes.size());  // direction of one of its segments
  std::vector<bool> found(nodes.size(), false);
  for (const SectionSegment& segment : segments) {
    const double s = nodes[segment.b].s - nodes[segment.a].s;
    const double z = nodes[segment.b].z - nodes[segment.a].z;
    const double length = std::hypot(s, z);
    for (const std::uint32_t node : {segment.a, segment.b}) {
      const bool small = length <= 2.0 * TOUCHING;
      if (degrees[node]++ == 0) {
        first[node] =
            small ? std::array<double, 2>{} : std::array<double, 2>{s / length, z / length};
      } else if (!small) {
        const double turn = first[node][0] * z / length - first[node][1] * s / length;
        found[node] = found[node] || std::abs(turn) > CORNER;
      }
    }
  }
  for (std::uint32_t node = 0; node < nodes.size(); ++node) {
    found[node] = (found[node] || degrees[node] == 1) && !nodes[node].cut;
  }
  return found;
}

void findCovered(double length, const std::vector<SectionNode>& nodes,
                 std::vector<SectionSegment>& segments, const std::atomic<bool>* cancel)
{
  const SectionColumns columns(nodes, segments, length);
  for (SectionSegment& segment : segments) {
    throwIfCanceled(cancel);
    if (segment.face == NONE) {
      continue;
    }
    const SectionNode &a = nodes[segment.a], &b = nodes[segment.b];
    const SectionNode middle{0.5 * (a.s + b.s), 0.5 * (a.z + b.z)};
    const auto look = lookOf(nodes, segment);
    columns.visit(middle.s, [&](std::uint32_t i) {
      const SectionSegment& other = segments[i];
      if (segment.covered || other.face == NONE || other.face == segment.face) {
        return;
      }
      const auto [share, distance] = nearestOn(nodes, other, middle);
      if (distance > TOUCHING) {
        return;
      }
      const SectionNode &c = nodes[other.a], &d = nodes[other.b];
      const auto look_of_other = lookOf(nodes, other);
      const double ahead = look[0] * (c.s + share * (d.s - c.s) - middle.s) +
                           look[1] * (c.z + share * (d.z - c.z) - middle.z);
      segment.covered = look[0] * look_of_other[0] + look[1] * look_of_other[1] < OPPOSITE &&
                        ahead > -0.1 * TOUCHING;
    });
  }
}

}  // namespace rviz_mesh_plugin
