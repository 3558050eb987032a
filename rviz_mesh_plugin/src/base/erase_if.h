#pragma once

#include <algorithm>
#include <iterator>
#include <type_traits>

namespace rviz_mesh_plugin {

/// As std::erase_if() of C++20.
template <class Container, class IsGone>
void eraseIf(Container& container, const IsGone& is_gone)
{
  using Category = typename std::iterator_traits<typename Container::iterator>::iterator_category;
  if constexpr (std::is_same_v<Category, std::random_access_iterator_tag>) {
    container.erase(std::remove_if(container.begin(), container.end(), is_gone), container.end());
  } else {
    for (auto item = container.begin(); item != container.end();) {
      item = is_gone(*item) ? container.erase(item) : std::next(item);
    }
  }
}

}  // namespace rviz_mesh_plugin
