#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#ifndef Q_MOC_RUN
#include "base/bounds.h"
#include "base/face_bits.h"
#include "base/hidden_faces.h"
#include "base/mesh_data.h"
#include "threads/background_task.h"
#endif

#include <QPushButton>

class QTimer;

namespace rviz {
class DisplayContext;
}

namespace rviz_mesh_plugin {

/// What there is to zoom to.
struct ZoomTarget
{
  MeshDataConstPtr mesh;  ///< null: none
  std::vector<LabelClusterConstPtr> labels;
  std::optional<FaceBits> faces;
  HiddenFacesConstPtr hidden;  ///< which do not have to be in the picture; null: none
};

/// A button with a menu: moves RViz's camera to the mesh, the labels chosen in the list, or what is
/// selected. Their faces are looked through on a thread.
class ZoomButton : public QPushButton
{
  Q_OBJECT

 public:
  /// @param target what there is now
  ZoomButton(std::function<ZoomTarget()> target, std::function<rviz::DisplayContext*()> context);

  /// @param has_mesh whether there is one to zoom to
  void allow(bool has_mesh);

 private:
  enum What
  {
    MESH,
    LABELS,
    SELECTION
  };
  void zoom(What what);
  void finish();
  void say(const QString& text);

  std::function<ZoomTarget()> target_;
  std::function<rviz::DisplayContext*()> context_;
  std::weak_ptr<const MeshData> mesh_;  ///< in which something is looked for
  BackgroundTask<Bounds> task_{"zoom"};
  QTimer* timer_;
};

}  // namespace rviz_mesh_plugin
