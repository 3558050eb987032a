#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/cost_summary.h"
#include "base/layer_info.h"
#include "base/mesh_data.h"
#include "base/section.h"
#include "base/status_lines.h"
#include "incoming/reception.h"

namespace rviz_mesh_plugin {

/// What the line about the geometry is made of.
struct GeometryState
{
  MeshDataConstPtr mesh;  ///< the newest; null: there is none
  Reception reception;
  std::string working;         ///< what the loader is doing; empty: nothing
  std::string error;           ///< why the mesh cannot be drawn
  bool normals_shown = false;  ///< large meshes have them thinned out
  bool drawn = true;           ///< there is a picture
  bool preview = false;        ///< a coarse one
  float progress = 1.0f;       ///< of the upload
  std::size_t others = 0;      ///< older meshes that are shown too
};

/// What the lines about costs, colors, textures and labels have in common.
struct AttributeState
{
  bool chosen = false;             ///< it is to be seen
  std::string subscription_error;  ///< why the topic could not be subscribed to
  Reception reception;
  bool mesh_shown = false;       ///< there is a geometry
  std::string uuid;              ///< of it
  std::size_t waiting = 0;       ///< of other geometries
  std::string waiting_uuid;      ///< of one of those
  std::size_t vertex_count = 0;  ///< of the geometry
  std::size_t face_count = 0;
};

/// What the line about colors is made of.
struct ColorsState : AttributeState
{
  bool topic_given = false;  ///< by another display, so that there is no property for it
  std::string topic;         ///< empty: none chosen
  /// Number of values of the layer in question, if it has arrived.
  std::optional<std::size_t> size;
};

/// What the line about costs is made of.
struct CostsState : ColorsState
{
  std::string type;  ///< chosen; empty: none
  std::vector<std::string> types;
  bool on_faces = false;  ///< the layer in question
  CostSummary summary;
  CostLimits limits;              ///< that the scale spans
  std::string note;               ///< what is done with costs that cannot be shown as asked
  std::size_t stale_updates = 0;  ///< older than their layer
  std::size_t left_out = 0;       ///< layers that have come and did not fit
  bool chosen_left_out = false;   ///< the chosen one is among them
  LayerInfo info;
  std::string update_problem;  ///< why the newest update could not be applied
  Reception updates_reception;
};

/// What the map remarks of itself; nothing where that is empty.
OptionalStatus remarkStatus(const std::string& remark);

/// What the line about textures is made of; the reception is that of materials.
struct TexturesState : AttributeState
{
  Reception textures_reception;
  MaterialsConstPtr materials;        ///< of the mesh; null: not there
  std::size_t textures = 0;           ///< of those that the materials name: how many have arrived
  std::size_t textures_left_out = 0;  ///< and how many of the others did, and did not fit
};

/// What the line about labels is made of.
struct LabelsState : AttributeState
{
  std::size_t labels = 0;
  std::size_t left_out = 0;  ///< faces that the mesh does not have
  std::string error;         ///< why they cannot be drawn
};

StatusLine topicStatus(const std::string& topic, const std::string& subscription_error,
                       const Reception& reception);
OptionalStatus geometryStatus(const GeometryState& state);
OptionalStatus colorsStatus(const ColorsState& state);
OptionalStatus costsStatus(const CostsState& state);
OptionalStatus texturesStatus(const TexturesState& state);
/// @param mesh the newest; null: there is none
/// @param empty no face of it is in the section
OptionalStatus sectionStatus(bool shown, const Section& section, const MeshData* mesh,
                             bool empty = false);

/// How many of their faces are hidden; none where none is.
/// @param section_hidden what there is in the section is hidden, all of it
OptionalStatus hiddenStatus(const std::vector<MeshDataConstPtr>& meshes,
                            bool section_hidden = false);
OptionalStatus labelsStatus(const LabelsState& state);

}  // namespace rviz_mesh_plugin
