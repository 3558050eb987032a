#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <QString>

#include "rviz_mesh_plugin/selection_properties.h"

namespace rviz_mesh_plugin {

/// What the status bar says while faces are being selected.
struct SelectionState
{
  std::size_t count = 0;       ///< of the faces
  std::optional<double> area;  ///< in square meters
  bool busy = false;
  bool brush = false;   ///< it is in use
  std::string message;  ///< what happened last; may be empty
};

/// As rich text.
QString selectionHint(const SelectionState& state, const SelectionSettings& settings);

}  // namespace rviz_mesh_plugin
