#pragma once

#include <cstddef>
#include <vector>

#include "measurement/section_graph.h"

namespace rviz_mesh_plugin {

/// Keeps one of several segments that run from the same node to the same node: faces in the same
/// places. A part that is there a second time as a whole, turned round, as modelers write sheets
/// that are seen from both sides, stays once, and is two-sided. (Where only some of its faces are,
/// as between boxes one on the other, all stay.) To be called before segments are cut.
void removeCopies(const std::vector<SectionNode>& nodes, std::vector<SectionSegment>& segments);

}  // namespace rviz_mesh_plugin
