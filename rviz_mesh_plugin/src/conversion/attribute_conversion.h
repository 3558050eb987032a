#pragma once

#include <memory>
#include <string>
#include <vector>

#include <mesh_msgs/LayerInfoArray.h>
#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshFaceCostsStamped.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>

#include "base/layer_info.h"
#include "base/mesh_data.h"
#include "conversion/validation.h"

namespace rviz_mesh_plugin {

/// The number of costs is compared with the geometry later, which may not have arrived; so are
/// indices. @throw RejectedMessage
std::shared_ptr<CostLayer> convert(const mesh_msgs::MeshVertexCostsStamped& message);
std::shared_ptr<CostLayer> convert(const mesh_msgs::MeshFaceCostsStamped& message);
CostUpdateConstPtr convert(const mesh_msgs::MeshVertexCostsSparseStamped& message);

/// As for costs. @throw RejectedMessage
ColorLayerConstPtr convert(const mesh_msgs::MeshVertexColorsStamped& message);

/// One label of the only mesh. @throw RejectedMessage
LabelSetConstPtr convert(const mesh_msgs::MeshFaceCluster& message);

/// Clusters of the same label are joined; those without a usable label are left out.
/// @param left_out why, and how many; empty if none is
LabelSetConstPtr convertLabels(const std::string& uuid,
                               const std::vector<mesh_msgs::MeshFaceCluster>& clusters, bool all,
                               std::string& left_out);

/// What is said of a layer twice counts as it is said first.
LayerInfos convert(const mesh_msgs::LayerInfoArray& message);

/// 0..1 to 0..255.
Rgba8 toRgba8(const std_msgs::ColorRGBA& color);

}  // namespace rviz_mesh_plugin
