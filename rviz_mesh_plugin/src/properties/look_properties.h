#pragma once

#include <QObject>

#ifndef Q_MOC_RUN
#include "rendering/mesh_style.h"
#endif

namespace rviz {
class BoolProperty;
class ColorProperty;
class EnumProperty;
class FloatProperty;
class Property;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// The properties of a mesh display that are the same for all display types:
/// lines, culling, shading, level of detail. Names, types and defaults are a
/// file format.
class LookProperties : public QObject
{
  Q_OBJECT

 public:
  /// Adds the properties to @a parent, which owns them from then on.
  explicit LookProperties(rviz::Property* parent);

  void apply(MeshStyle& style) const;
  bool normalsShown() const;

 Q_SIGNALS:
  void styleChanged();

 private:
  void addLines(rviz::Property* parent);
  void addFaces(rviz::Property* parent);

  rviz::BoolProperty* show_wireframe_;
  rviz::ColorProperty* wireframe_color_;
  rviz::FloatProperty* wireframe_alpha_;
  rviz::BoolProperty* show_normals_;
  rviz::ColorProperty* normals_color_;
  rviz::FloatProperty* normals_alpha_;
  rviz::FloatProperty* normals_scale_;
  rviz::EnumProperty* culling_;
  rviz::EnumProperty* shading_;
  rviz::BoolProperty* level_of_detail_;
  rviz::FloatProperty* detail_pixels_;
};

/// A number from 0 (invisible) to 1 (opaque).
rviz::FloatProperty* makeAlpha(const char* name, const char* of_what, rviz::Property* parent,
                               const char* changed_slot, QObject* receiver);

}  // namespace rviz_mesh_plugin
