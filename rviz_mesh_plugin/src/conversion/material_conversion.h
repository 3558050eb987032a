#pragma once

#include <cstdint>

#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>

#include "base/mesh_data.h"
#include "conversion/validation.h"

namespace rviz_mesh_plugin {

/// Each cluster gets the material that cluster_materials names; of a face in several clusters the
/// last one counts. A texture counts where has_texture is set, and its index is not that of "-1".
/// Indices of faces and the number of texture coordinates are compared with the geometry later, see
/// checkMaterialsFit(). @throw RejectedMessage
MaterialsConstPtr convert(const mesh_msgs::MeshMaterialsStamped& message);

/// Every OpenGL 3 driver takes textures of this width and height; larger images are halved.
constexpr std::uint32_t GREATEST_TEXTURE_SIDE = 8192;

/// From rgb8, rgba8, bgr8, bgra8, mono8, and what may stand for them: 8UC1, 8UC3 and 8UC4 (red
/// first), mono16, 16UC1, rgb16, rgba16 (their high bytes). @throw RejectedMessage
TextureImageConstPtr convert(const mesh_msgs::MeshTexture& message);

}  // namespace rviz_mesh_plugin
