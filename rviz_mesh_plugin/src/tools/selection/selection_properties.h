#pragma once

#include "base/mesh_data.h"
#include "properties/property_maker.h"
#include "selection/selection_gestures.h"

namespace rviz_mesh_plugin {

/// How faces are selected.
struct SelectionSettings
{
  SelectionTechnique technique = SelectionTechnique::BOX;
  bool visible_only = false;
  bool back_faces = true;
  float radius = 1.0f;       ///< of the brush, in meters
  double flood_angle = 0.0;  ///< in radians
};

/// The properties of the tool, with which it is saved.
class SelectionProperties
{
 public:
  /// @param parent owns the properties
  SelectionProperties(rviz::Property* parent, const PropertyMaker& make);

  SelectionSettings settings() const;
  /// Of the highlight.
  Rgba8 color() const;

  void setTechnique(SelectionTechnique technique);
  void toggleVisibleOnly();
  void toggleBackFaces() { back_faces_->setBool(!back_faces_->getBool()); }
  void setRadius(float meters) { radius_->setFloat(meters); }
  void scaleRadius(double factor);

 private:
  PropertyValue<SelectionSettings> settings_;
  rviz::EnumProperty* technique_;
  rviz::EnumProperty* seen_;
  rviz::BoolProperty* back_faces_;
  rviz::FloatProperty* radius_;
  rviz::FloatProperty* flood_angle_;
  rviz::ColorProperty* color_;
};

}  // namespace rviz_mesh_plugin
