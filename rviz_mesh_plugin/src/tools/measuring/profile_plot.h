#pragma once

#include <QWidget>

#include "measurement/surface_profile.h"

namespace rviz_mesh_plugin {

/// A height profile: the distance along the line to the right, z upwards, each in its own scale;
/// gaps are shaded.
class ProfilePlot : public QWidget
{
 public:
  explicit ProfilePlot(QWidget* parent = nullptr);

  void show(const SurfaceProfile& profile);
  QSize sizeHint() const override { return {240, 150}; }

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  SurfaceProfile profile_;
};

}  // namespace rviz_mesh_plugin
