#include "tools/selection/selection_properties.h"

#include <cmath>
#include <cstdint>

#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>

#include "selection/selection_visual.h"

namespace rviz_mesh_plugin {
namespace {

constexpr const char* TECHNIQUES[] = {"Box", "Lasso", "Flood", "Label"};
constexpr const char* SEEN[] = {"Through", "Visible Only"};

/// Of the brush, in meters.
constexpr float MIN_RADIUS = 1e-4f;
constexpr float MAX_RADIUS = 1e4f;

}  // namespace

SelectionProperties::SelectionProperties(rviz::Property* parent, QObject* owner)
    : QObject(owner),
      technique_(new rviz::EnumProperty(
          "Mode", TECHNIQUES[0],
          "What a drag or click selects: a box, a lasso, the connected region around a face, or "
          "the faces of a label that is there already. Keys 1 to 4.",
          parent)),
      seen_(new rviz::EnumProperty(
          "Selection", SEEN[0],
          "Whether box, lasso and brush take all faces in them, or only those that can be seen "
          "from here. Ctrl+T.",
          parent)),
      back_faces_(new rviz::BoolProperty(
          "Back Faces", true, "Whether faces that are seen from behind are selected, too. Ctrl+B.",
          parent)),
      radius_(new rviz::FloatProperty("Brush Radius", 1.0f,
                                      "Radius of the brush, in meters. Ctrl + wheel.", parent)),
      flood_angle_(new rviz::FloatProperty(
          "Flood Angle", 15.0f,
          "Flood goes on from a face to its neighbor where they are bent against each other by at "
          "most this angle, in degrees.",
          parent)),
      color_(
          new rviz::ColorProperty("Highlight Color",
                                  QColor(SelectionVisual::COLOR.red, SelectionVisual::COLOR.green,
                                         SelectionVisual::COLOR.blue),
                                  "Color of the faces that are selected.", parent))
{
  for (int i = 0; i < 4; ++i) {
    technique_->addOption(TECHNIQUES[i], i);
  }
  for (int i = 0; i < 2; ++i) {
    seen_->addOption(SEEN[i], i);
  }
  radius_->setMin(MIN_RADIUS);
  radius_->setMax(MAX_RADIUS);
  flood_angle_->setMin(0.0f);
  flood_angle_->setMax(180.0f);
  for (int i = 0; i < parent->numChildren(); ++i) {
    connect(parent->childAt(i), &rviz::Property::changed, this, &SelectionProperties::changed);
  }
}

SelectionSettings SelectionProperties::settings() const
{
  SelectionSettings settings;
  settings.technique = static_cast<SelectionTechnique>(technique_->getOptionInt());
  settings.visible_only = seen_->getOptionInt() != 0;
  settings.back_faces = back_faces_->getBool();
  const double radius = static_cast<double>(radius_->getFloat());
  settings.radius = std::isfinite(radius) ? radius : settings.radius;
  settings.flood_angle = static_cast<double>(flood_angle_->getFloat()) * M_PI / 180.0;
  return settings;
}

Rgba8 SelectionProperties::color() const
{
  const QColor color = color_->getColor();
  return {static_cast<std::uint8_t>(color.red()), static_cast<std::uint8_t>(color.green()),
          static_cast<std::uint8_t>(color.blue()), SelectionVisual::COLOR.alpha};
}

void SelectionProperties::setTechnique(SelectionTechnique technique)
{
  technique_->setString(TECHNIQUES[static_cast<int>(technique)]);
}

void SelectionProperties::toggleVisibleOnly()
{
  seen_->setString(SEEN[seen_->getOptionInt() == 0 ? 1 : 0]);
}

void SelectionProperties::toggleBackFaces()
{
  back_faces_->setBool(!back_faces_->getBool());
}

void SelectionProperties::setRadius(float meters)
{
  radius_->setFloat(meters);
}

void SelectionProperties::scaleRadius(double factor)
{
  radius_->setFloat(static_cast<float>(static_cast<double>(radius_->getFloat()) * factor));
}

}  // namespace rviz_mesh_plugin
