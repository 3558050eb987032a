#pragma once

#include <QObject>

#ifndef Q_MOC_RUN
#include "base/mesh_data.h"
#include "selection/selection_gestures.h"
#endif

namespace rviz {
class BoolProperty;
class ColorProperty;
class EnumProperty;
class FloatProperty;
class Property;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// How faces are selected.
struct SelectionSettings
{
  SelectionTechnique technique = SelectionTechnique::BOX;
  bool visible_only = false;
  bool back_faces = true;
  double radius = 1.0;       ///< of the brush, in meters
  double flood_angle = 0.0;  ///< in radians
};

/// The properties of the tool, with which it is saved.
class SelectionProperties : public QObject
{
  Q_OBJECT

 public:
  /// @param parent owns the properties
  explicit SelectionProperties(rviz::Property* parent, QObject* owner);

  SelectionSettings settings() const;
  /// Of the highlight.
  Rgba8 color() const;

  void setTechnique(SelectionTechnique technique);
  void toggleVisibleOnly();
  void toggleBackFaces();
  void setRadius(float meters);
  void scaleRadius(double factor);

 Q_SIGNALS:
  void changed();

 private:
  rviz::EnumProperty* technique_;
  rviz::EnumProperty* seen_;
  rviz::BoolProperty* back_faces_;
  rviz::FloatProperty* radius_;
  rviz::FloatProperty* flood_angle_;
  rviz::ColorProperty* color_;
};

}  // namespace rviz_mesh_plugin
