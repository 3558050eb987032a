#pragma once

#include <algorithm>

namespace rviz_mesh_plugin {

/// As std::erase_if() of C++20.
template <class Container, class IsGone>
void eraseIf(Container& container, const IsGone& is_gone)
{
  container.erase(std::remove_if(container.begin(), container.end(), is_gone), container.end());
}

}  // namespace rviz_mesh_plugin
