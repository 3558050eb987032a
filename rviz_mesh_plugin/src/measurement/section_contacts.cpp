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
                                 const std::vector<SectionSegment>& segments,
                                 const std::atomic<bool>* cancel)
{
  const SectionRows rows(nodes.size(), segments);
  std::vector<bool> found(nodes.size(), false);
  std::vector<std::uint32_t> seen_from(nodes.size(), NONE);  // from which node last
  std::vector<std::uint32_t> near;
  for (std::uint32_t node = 0; node < nodes.size(); ++node) {
    throwIfCanceled(cancel);
    if (rows.isEmpty(node) || nodes[node].cut) {
      continue;
    }
    std::array<double, 2> first{};  // direction of one way
    bool corner = false, straight_on = false, at_end_of_line = false;
    near.assign(1, node);
    seen_from[node] = node;
    for (std::size_t next = 0; next < near.size(); ++next) {
      rows.visit(near[next], [&](std::uint32_t i) {
        const std::uint32_t other = segments[i].a == near[next] ? segments[i].b : segments[i].a;
        if (seen_from[other] == node) {
          return;
        }
        seen_from[other] = node;
        const double s = nodes[other].s - nodes[node].s, z = nodes[other].z - nodes[node].z;
        const double length = std::hypot(s, z);
        at_end_of_line = at_end_of_line || (nodes[other].cut && length <= 1e-3 * TOUCHING);
        if (length <= 2.0 * TOUCHING && !nodes[other].cut) {
          near.push_back(other);
        } else if (first == std::array<double, 2>{}) {
          first = {s / length, z / length};
        } else {
          corner = corner || std::abs(first[0] * z - first[1] * s) > CORNER * length;
          straight_on = straight_on || first[0] * s + first[1] * z < 0.0;
        }
      });
    }
    found[node] = (corner || !straight_on) && !at_end_of_line;
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
      const double to_s = c.s + share * (d.s - c.s) - middle.s;
      const double to_z = c.z + share * (d.z - c.z) - middle.z;
      const double ahead = look[0] * to_s + look[1] * to_z;
      const double aside = look[1] * to_s - look[0] * to_z;
      // As what goes on in the same direction where this one ends.
      const bool beside = (share <= 0.0 || share >= 1.0) && std::abs(aside) > 1e-3 * TOUCHING;
      const auto look_of_other = lookOf(nodes, other);
      const double facing = look[0] * look_of_other[0] + look[1] * look_of_other[1];
      const bool any_side = segment.two_sided || other.two_sided;
      segment.covered = !beside && (any_side ? std::abs(facing) > -OPPOSITE : facing < OPPOSITE) &&
                        (segment.two_sided || ahead > -0.1 * TOUCHING);
    });
  }
}

}  // namespace rviz_mesh_plugin
