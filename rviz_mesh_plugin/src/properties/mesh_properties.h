#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include <QObject>
#include <QString>

#ifndef Q_MOC_RUN
#include "properties/property_maker.h"
#include "rendering/mesh_style.h"
#include "sources/mesh_source.h"
#include "sources/mesh_sources.h"
#endif

namespace rviz {
class Config;
class IntProperty;
}  // namespace rviz

namespace rviz_mesh_plugin {

class CostProperties;

/// Numbers and names as in .rviz files (property "Display Type").
enum class DisplayType
{
  FIXED_COLOR = 0,
  VERTEX_COLOR = 1,
  TEXTURES = 2,
  VERTEX_COSTS = 3,
  HIDE_FACES = 4,
  HEIGHT = 5,
  CONTOUR_LINES = 6,  ///< heights with lines
  AUTOMATIC = 7       ///< of the others the best that there are data for
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

  /// Where everything comes from: as chosen, or as another display has given it.
  MeshSource source() const;
  /// Whether another display has.
  bool sourceGiven() const { return given_.has_value(); }
  /// Hides the properties for topics and services; display types are offered
  /// once there are data for them.
  void setSource(const MeshSource& source);
  /// All topics and services.
  MeshSources::Names names() const;
  void setGeometryTopic(const QString& topic) { geometry_topic_->setString(topic); }
  /// For those that have not been chosen yet.
  void proposeTopics(const QString& costs, const QString& colors);

  /// @param costs_tell false: all of them are free, which heights tell more than
  void setAvailable(bool colors, bool materials, bool costs, bool costs_tell);

  /// What a display begins with that no file says anything of: the best that the map has, in a
  /// perceptual scale, without lines; else the defaults of .rviz files in the field.
  void setAutomatic(bool automatic);
  /// While there is one, a file is loaded: nothing is chosen that it does not name.
  class Loading
  {
   public:
    explicit Loading(MeshProperties& properties) : properties_(properties)
    {
      properties_.loading_ = true;
    }
    ~Loading() { properties_.loading_ = false; }
    Loading(const Loading&) = delete;
    Loading& operator=(const Loading&) = delete;

   private:
    MeshProperties& properties_;
  };

  std::size_t bufferSize() const;
  /// What is drawn: never AUTOMATIC.
  DisplayType displayType() const;
  /// Whether it depends on which data there are.
  bool isAutomatic() const { return chosenType() == DisplayType::AUTOMATIC; }
  CostProperties& costs() const { return *costs_; }
  /// In Hz: how often updates of costs become seen.
  float updateRate() const { return update_rate_->getFloat(); }

  bool sectionShown() const { return show_section_->getBool(); }
  /// What is drawn of the meshes.
  Section section() const;

  bool labelsShown() const { return show_labels_->getBool(); }
  float labelsAlpha() const { return labels_alpha_->getFloat(); }
  bool normalsShown() const { return show_normals_->getBool(); }

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
  void onColoring();

 private:
  DisplayType chosenType() const;
  void choose(DisplayType type);
  void addFaces(const PropertyMaker& sources, const PropertyMaker& styles, rviz::Property* parent);
  void addTextures(const PropertyMaker& sources, const PropertyMaker& styles,
                   rviz::Property* parent);
  void addSection(const PropertyMaker& make, rviz::Property* parent);
  void addLook(const PropertyMaker& make, rviz::Property* parent);
  void offerTypes();

  bool loading_ = false;
  PropertyValue<MeshSource> source_;
  PropertyValue<ServiceNames> services_;
  PropertyValue<MeshStyle> style_;
  PropertyValue<Section> section_;
  std::optional<MeshSource> given_;
  bool costs_tell_ = true;
  /// Data for the display types.
  std::array<bool, 8> available_{true, false, false, false, true, true, true, true};
  CostProperties* costs_;
  rviz::RosTopicProperty* geometry_topic_;
  rviz::IntProperty* buffer_size_;
  rviz::EnumProperty* display_type_;
  rviz::ColorProperty* faces_color_;
  rviz::FloatProperty* faces_alpha_;
  rviz::RosTopicProperty* colors_topic_;
  rviz::StringProperty* colors_service_;
  rviz::BoolProperty* only_textured_;
  rviz::StringProperty* materials_service_;
  rviz::StringProperty* texture_service_;
  rviz::RosTopicProperty* materials_topic_;
  rviz::RosTopicProperty* textures_topic_;
  rviz::FloatProperty* update_rate_;
  rviz::FloatProperty* alpha_;
  rviz::FloatProperty* contour_interval_;
  rviz::BoolProperty* show_wireframe_;
  rviz::BoolProperty* show_normals_;
  rviz::BoolProperty* show_section_;
  rviz::BoolProperty* show_labels_;
  rviz::RosTopicProperty* labels_topic_;
  rviz::FloatProperty* labels_alpha_;
};

}  // namespace rviz_mesh_plugin
