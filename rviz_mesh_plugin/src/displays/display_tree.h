#pragma once

#include <rviz/display_group.h>

namespace rviz_mesh_plugin {

enum class DisplayChoice
{
  ALL,
  ENABLED  ///< with all groups that they are in
};

/// Calls back for each display of a kind in a group (null: none) and in the groups in it.
template <class Kind, class Visit>
void visitDisplays(const rviz::DisplayGroup* group, DisplayChoice choice, const Visit& visit)
{
  for (int i = 0; group && i < group->numDisplays(); ++i) {
    rviz::Display* display = group->getDisplayAt(i);
    if (choice == DisplayChoice::ENABLED && !display->isEnabled()) {
      continue;
    }
    if (auto* wanted = dynamic_cast<Kind*>(display)) {
      visit(*wanted);
    }
    visitDisplays<Kind>(dynamic_cast<const rviz::DisplayGroup*>(display), choice, visit);
  }
}

}  // namespace rviz_mesh_plugin
