#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rviz_mesh_plugin/mesh_labels.h"
#include "rviz_mesh_plugin/mesh_painter.h"

namespace rviz_mesh_plugin {

class LabelColorFeed;

/// Draws all meshes of a MeshStore, with their labels. GUI thread only.
///
/// A mesh that the store no longer has is seen until there is a picture of the
/// newest one.
class MeshPainters
{
 public:
  explicit MeshPainters(const MeshPainter::Context& context) : context_(context) {}

  void setLayouts(const std::vector<MeshLayoutConstPtr>& layouts);

  /// Applies what store and properties say now.
  void paint();

  /// Gives labels the colors of their own that are known; returns whether one that is drawn
  /// changes.
  bool colorLabels(const LabelColorFeed& feed);

  void updateCosts(const CostLayerConstPtr& layer, const std::vector<std::uint32_t>& vertices);

  /// For about this long; true where nothing is left to do.
  bool upload(std::chrono::microseconds budget);

  /// @param find_pose of a frame in the fixed frame, where it is known
  using FindPose = std::function<std::optional<FramePose>(const std::string& frame)>;
  void setPoses(const FindPose& find_pose);

  void clear() { meshes_.clear(); }

  struct Mesh
  {
    std::unique_ptr<MeshPainter> painter;
    std::unique_ptr<MeshLabels> labels;
    std::string labels_error;  ///< why they cannot be drawn
  };
  /// The newest first.
  const std::list<Mesh>& meshes() const { return meshes_; }
  /// Null where there is none.
  const Mesh* newest() const { return meshes_.empty() ? nullptr : &meshes_.front(); }

 private:
  Mesh* find(const std::string& uuid);
  void retire();
  void paintLabels(Mesh& mesh);
  static void attempt(Mesh& mesh, const std::function<void()>& draw_labels);

  const MeshPainter::Context context_;
  std::list<Mesh> meshes_;
};

}  // namespace rviz_mesh_plugin
