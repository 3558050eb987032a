#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "picking/surface_paths.h"
#include "properties/published_topic.h"
#include "threads/background_task.h"
#include "tools/surface_tool.h"

namespace rviz {
class FloatProperty;
}

namespace rviz_mesh_plugin {

class SurfaceMarks;

/// Says what is known of the point under the cursor. A click publishes it as
/// geometry_msgs/PointStamped and marks it; the second measures the way between the two along the
/// surface; the third begins anew.
class MeshInspectTool : public SurfaceTool
{
 public:
  MeshInspectTool();
  ~MeshInspectTool() override;

 protected:
  void initializeTool() override;
  void begin() override;
  void end() override;
  void work() override;
  int mouse(rviz::ViewportMouseEvent& event) override;

 private:
  using Clock = std::chrono::steady_clock;

  void hover(const mesh_map::Ray& ray);
  void click(const SurfaceHit& hit);
  /// @return what has become of it
  std::string publish(const SurfaceHit& hit);
  void measure(const SurfaceHit& hit);
  void takeResult();
  void clearMarks();
  void showSize();
  void tell();

  PublishedTopic topic_;
  rviz::FloatProperty* size_;
  std::unique_ptr<SurfaceMarks> marks_;
  BackgroundTask<SurfacePath> measurement_{"surface ways"};
  std::optional<SurfaceHit> first_;
  std::optional<SurfaceHit> second_;
  std::string clicked_;  ///< what is said of the clicks
  std::string pointed_;  ///< what is said of the point under the cursor
  Clock::time_point last_hover_;
  std::optional<mesh_map::Ray> next_hover_;  ///< waits until it is time
};

}  // namespace rviz_mesh_plugin
