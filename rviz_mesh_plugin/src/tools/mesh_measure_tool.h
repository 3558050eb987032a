#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <QPointer>

#include "measurement/measurement_list.h"
#include "tools/surface_tool.h"

namespace rviz {
class BoolProperty;
class EnumProperty;
class FloatProperty;
}  // namespace rviz

namespace rviz_mesh_plugin {

class MeasurementMarks;
class MeasurementPane;

/// Measures distances, areas and height profiles on meshes by clicks, and keeps them: in a list in
/// a pane of RViz's window, drawn over the mesh, also while other tools are in use.
class MeshMeasureTool : public SurfaceTool
{
 public:
  MeshMeasureTool();
  ~MeshMeasureTool() override;

  int processKeyEvent(QKeyEvent* event, rviz::RenderPanel* panel) override;

  const MeasurementList& measurements() const { return list_; }
  /// Null before the tool has been used. It is gone with the tool.
  MeasurementPane* pane() const;

 protected:
  void initializeTool() override;
  void begin() override;
  void end() override;
  void work() override;
  int mouse(rviz::ViewportMouseEvent& event) override;

 private:
  using Clock = std::chrono::steady_clock;

  void keepUp();
  void createPane();
  MeasurementKind kind() const;
  void changeKind();
  void choose(MeasurementKind kind);
  void click(const rviz::ViewportMouseEvent& event, const SurfaceHit& hit);
  void addPoint(const SurfaceHit& hit);
  void finish();
  void takeBack();
  void giveUp();
  void hover(const mesh_map::Ray& ray);
  void showBegun(const std::array<double, 3>* next);
  std::string hint() const;
  bool isNear(const rviz::ViewportMouseEvent& event, const SurfacePoint& point) const;
  void listChanged();

  bool active_ = false;
  rviz::EnumProperty* kind_;
  rviz::FloatProperty* size_;
  rviz::BoolProperty* values_;
  MeasurementList list_;
  std::unique_ptr<MeasurementMarks> marks_;
  QPointer<MeasurementPane> pane_;
  QPointer<QWidget> dock_;
  std::optional<ShownMesh> mesh_;  ///< of the points; not kept longer than these
  std::vector<SurfacePoint> points_;
  Clock::time_point last_hover_;
  std::optional<mesh_map::Ray> next_hover_;  ///< waits until it is time
};

}  // namespace rviz_mesh_plugin
