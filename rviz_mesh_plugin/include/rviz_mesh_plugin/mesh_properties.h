#pragma once

#include <string>
#include <vector>

#include <QObject>
#include <QString>

#ifndef Q_MOC_RUN
#include "rviz_mesh_plugin/color_scale.h"
#include "rviz_mesh_plugin/mesh_style.h"
#endif

namespace rviz {
class BoolProperty;
class ColorProperty;
class EnumProperty;
class FloatProperty;
class Property;
class RosTopicProperty;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// Numbers and names as in .rviz files (property "Display Type").
enum class DisplayType
{
  FIXED_COLOR = 0,
  VERTEX_COLOR = 1,
  TEXTURES = 2,
  VERTEX_COSTS = 3,
  HIDE_FACES = 4
};

/// The properties of a mesh display. Their names, types, defaults and nesting are those of the
/// released rviz_map_plugin/Mesh: .rviz files in the field depend on them.
class MeshProperties : public QObject
{
  Q_OBJECT

 public:
  /// Adds the properties to @a parent, which owns them from then on.
  explicit MeshProperties(rviz::Property* parent);

  std::string geometryTopic() const;
  std::string colorsTopic() const;
  std::string costsTopic() const;
  void setGeometryTopic(const QString& topic);

  DisplayType displayType() const;
  ColorScale colorScale() const;

  /// Name of the chosen cost layer, empty for "-- None --".
  std::string costsType() const;

  /// Fills the list of "Vertex Costs Type"; the choice stays, even if it is not among them (yet).
  void setCostsTypes(const std::vector<std::string>& types);

  bool customLimits() const;
  CostLimits limits() const;

  /// @param colors_at_hand whether the colors that the display type asks for are there; grey if not
  MeshStyle style(bool colors_at_hand) const;

 Q_SIGNALS:
  void geometryTopicChanged();
  void colorsTopicChanged();
  void costsTopicChanged();
  void coloringChanged();  ///< what each vertex's color is
  void styleChanged();     ///< everything else

 private Q_SLOTS:
  void onDisplayType();

 private:
  void addFaces(rviz::Property* parent);
  void addCosts(rviz::Property* parent);
  void addLines(rviz::Property* parent);

  rviz::RosTopicProperty* geometry_topic_;
  rviz::EnumProperty* display_type_;
  rviz::ColorProperty* faces_color_;
  rviz::FloatProperty* faces_alpha_;
  rviz::RosTopicProperty* colors_topic_;
  rviz::EnumProperty* color_scale_;
  rviz::RosTopicProperty* costs_topic_;
  rviz::EnumProperty* costs_type_;
  rviz::BoolProperty* custom_limits_;
  rviz::FloatProperty* lower_limit_;
  rviz::FloatProperty* upper_limit_;
  rviz::BoolProperty* show_wireframe_;
  rviz::ColorProperty* wireframe_color_;
  rviz::FloatProperty* wireframe_alpha_;
  rviz::BoolProperty* show_normals_;
  rviz::ColorProperty* normals_color_;
  rviz::FloatProperty* normals_alpha_;
  rviz::FloatProperty* normals_scale_;
};

}  // namespace rviz_mesh_plugin
