#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshFaceCostsStamped.h>
#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// One broken rule in a message.
struct Finding
{
  std::string rule;       ///< name of the rule, the same as in mesh_msgs.validation
  std::string what;       ///< what is wrong, with the numbers, of the first offending element
  std::string hint;       ///< the way out
  std::size_t count = 1;  ///< how many elements break the rule

  /// All of it in one line.
  std::string sentence() const;
};

/// Empty: the message may be used. Numbers are checked as the float32 that OGRE gets. An empty @a
/// uuid means that any geometry is welcome.
std::vector<Finding> check(const mesh_msgs::MeshGeometryStamped& message,
                           const std::string& uuid = "");

/// Without @a vertex_count the length is not checked: the geometry is not known yet.
std::vector<Finding> check(const mesh_msgs::MeshVertexCostsStamped& message,
                           std::optional<std::size_t> vertex_count = std::nullopt,
                           const std::string& uuid = "");
std::vector<Finding> check(const mesh_msgs::MeshVertexColorsStamped& message,
                           std::optional<std::size_t> vertex_count = std::nullopt,
                           const std::string& uuid = "");

std::vector<Finding> check(const mesh_msgs::MeshFaceCostsStamped& message,
                           std::optional<std::size_t> face_count = std::nullopt,
                           const std::string& uuid = "");
std::vector<Finding> check(const mesh_msgs::MeshVertexCostsSparseStamped& message,
                           std::optional<std::size_t> vertex_count = std::nullopt,
                           const std::string& uuid = "");
std::vector<Finding> check(const mesh_msgs::MeshMaterialsStamped& message,
                           std::optional<std::size_t> vertex_count = std::nullopt,
                           std::optional<std::size_t> face_count = std::nullopt,
                           const std::string& uuid = "");
/// One set of faces; an empty label is none.
std::vector<Finding> check(const mesh_msgs::MeshFaceCluster& message,
                           std::optional<std::size_t> face_count = std::nullopt);
std::vector<Finding> check(const mesh_msgs::MeshTexture& message, const std::string& uuid = "");

/// An encoding that images of textures may have.
struct PixelEncoding
{
  const char* name;
  std::size_t depth;  ///< of a channel, in bytes
  std::size_t channels;
  int red, green, blue;  ///< which of the channels
  int alpha;             ///< -1: none

  constexpr std::size_t bytes() const { return depth * channels; }  ///< of a pixel
};
/// Null where images of textures may not have it.
const PixelEncoding* findEncoding(const std::string& name);

/// The rules on lengths and indices alone, for attributes that arrived before their geometry.
std::optional<Finding> checkUpdateFits(const CostUpdate& update, std::size_t vertex_count);
std::optional<Finding> checkMaterialsFit(const Materials& materials, std::size_t vertex_count,
                                         std::size_t face_count);
std::optional<Finding> checkCostCount(std::size_t cost_count, std::size_t count, bool on_faces);
std::optional<Finding> checkColorCount(std::size_t color_count, std::size_t vertex_count);

/// The sentence of the first finding, and how many more there are; empty without findings.
std::string summarize(const std::vector<Finding>& findings);

/// A message that cannot be shown; what() is one sentence for the status line.
class RejectedMessage : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// @throw RejectedMessage unless @a findings is empty
inline void refuse(const std::vector<Finding>& findings)
{
  if (!findings.empty()) {
    throw RejectedMessage(summarize(findings));
  }
}

}  // namespace rviz_mesh_plugin
