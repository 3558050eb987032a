#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "rviz_mesh_plugin/color_scale.h"
#include "rviz_mesh_plugin/mesh_inbox.h"

namespace rviz_mesh_plugin {

/// One line of the status tree: a sentence with the numbers and the way out. Levels are those of
/// RViz.
struct StatusLine
{
  enum Level
  {
    OK = 0,
    WARN = 1,
    ERROR = 2
  };
  Level level = OK;
  std::string text;
};

/// No line at all where there is nothing to say.
using OptionalStatus = std::optional<StatusLine>;

/// What the lines about costs and colors are made of.
struct AttributeState
{
  bool chosen = false;             ///< the display type asks for it
  std::string topic;               ///< empty: none chosen
  std::string subscription_error;  ///< why the topic could not be subscribed to
  Reception reception;
  bool mesh_shown = false;       ///< there is a geometry
  std::size_t vertex_count = 0;  ///< of the geometry
  std::size_t waiting = 0;       ///< layers of other geometries
  /// Number of values of the layer in question, if it has arrived.
  std::optional<std::size_t> size;
};

struct CostsState : AttributeState
{
  std::string type;  ///< chosen; empty: none
  std::vector<std::string> types;
  CostSummary summary;
  CostLimits limits;  ///< that the scale spans
};

StatusLine topicStatus(const std::string& topic, const std::string& subscription_error,
                       const Reception& reception);
/// @param normals_shown whether they are drawn, which large meshes have thinned out
OptionalStatus geometryStatus(const MeshDataConstPtr& mesh, const Reception& reception,
                              bool normals_shown);
OptionalStatus colorsStatus(const AttributeState& state);
OptionalStatus costsStatus(const CostsState& state);

}  // namespace rviz_mesh_plugin
