#pragma once

#include <cstddef>
#include <vector>

#include <QObject>
#include <QString>

#ifndef Q_MOC_RUN
#include "rendering/mesh_style.h"
#include "sources/mesh_source.h"
#endif

namespace rviz {
class BoolProperty;
class ColorProperty;
class Config;
class EnumProperty;
class FloatProperty;
class IntProperty;
class Property;
}  // namespace rviz

namespace rviz_mesh_plugin {

class CostProperties;
class LookProperties;
class SourceProperties;

/// Numbers and names as in .rviz files (property "Display Type").
enum class DisplayType
{
  FIXED_COLOR = 0,
  VERTEX_COLOR = 1,
  TEXTURES = 2,
  VERTEX_COSTS = 3,
  HIDE_FACES = 4
};

/// For which display types there are data.
struct AvailableData
{
  bool colors = false;
  bool materials = false;
  bool costs = false;
};

/// The properties of a mesh display. Names, types, defaults and nesting of
/// those that the released rviz_map_plugin/Mesh has are the same: .rviz files
/// in the field depend on them.
class MeshProperties : public QObject
{
  Q_OBJECT

 public:
  /// Adds the properties to @a parent, which owns them from then on.
  explicit MeshProperties(rviz::Property* parent);

  SourceProperties& sources() const { return *sources_; }
  /// Hides the properties for topics and services; display types are offered
  /// once there are data for them.
  void setSource(const MeshSource& source);
  void setAvailable(const AvailableData& available);

  std::size_t bufferSize() const;
  DisplayType displayType() const;
  CostProperties& costs() const { return *costs_; }
  /// In Hz: how often updates of costs become seen.
  float updateRate() const;

  bool labelsShown() const;
  float labelsAlpha() const;
  bool normalsShown() const;

  /// @param at_hand whether the colors or textures that the display type asks
  /// for are there; grey
  ///   if not
  MeshStyle style(bool at_hand) const;

  /// Reads what has had another name in older versions.
  void loadOlderKeys(const rviz::Config& config);

 Q_SIGNALS:
  void sourceChanged();   ///< topics and services
  void contentChanged();  ///< what each vertex's color is, how many meshes, labels
  void styleChanged();    ///< everything else

 private Q_SLOTS:
  void onDisplayType();

 private:
  void addFaces(rviz::Property* parent);
  void addTextures(rviz::Property* parent);
  void addLabels(rviz::Property* parent);
  void offerTypes();

  SourceProperties* sources_;
  rviz::IntProperty* buffer_size_;
  rviz::EnumProperty* display_type_;
  rviz::ColorProperty* faces_color_;
  rviz::FloatProperty* faces_alpha_;
  rviz::BoolProperty* only_textured_;
  CostProperties* costs_;
  rviz::FloatProperty* update_rate_;
  rviz::FloatProperty* alpha_;
  LookProperties* look_;
  rviz::BoolProperty* show_labels_;
  rviz::FloatProperty* labels_alpha_;
  AvailableData available_;
};

}  // namespace rviz_mesh_plugin
