#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "rviz_mesh_plugin/label_store.h"
#include "rviz_mesh_plugin/mesh_services.h"
#include "rviz_mesh_plugin/reception.h"
#include "rviz_mesh_plugin/status_lines.h"

namespace rviz_mesh_plugin {

/// What the status lines of a display of labels are made of.
struct LabelDisplayState
{
  bool source_given = false;  ///< another display decides what is shown
  std::string geometry_topic;
  std::string labels_topic;
  std::string subscription_error;
  Reception geometry;
  Reception labels;
  std::string working;  ///< on the mesh
  std::size_t label_count = 0;
  std::size_t class_count = 0;
  std::size_t hidden = 0;   ///< labels
  std::size_t to_show = 0;  ///< labels that are being uploaded
};

/// Which mesh is labelled, or why there is none.
StatusLine labelGeometryStatus(const LabelDisplayState& state, const LabelStore& store);

/// Which labels there are, or why there are none.
OptionalStatus labelsStatus(const LabelDisplayState& state, const LabelStore& store);

/// How it went with what was asked.
OptionalStatus servicesStatus(const MeshServices::Report& report);

}  // namespace rviz_mesh_plugin
