#include "tools/selection/selection_properties.h"

#include <cmath>

#include "base/qt_colors.h"
#include "selection/selection_visual.h"

namespace rviz_mesh_plugin {
namespace {

const std::vector<const char*> TECHNIQUES = {"Box", "Lasso", "Flood", "Label"};
const std::vector<const char*> SEEN = {"Through", "Visible Only"};

/// Of the brush, in meters.
constexpr float MIN_RADIUS = 1e-4f;
constexpr float MAX_RADIUS = 1e4f;

}  // namespace

SelectionProperties::SelectionProperties(rviz::Property* parent, const PropertyMaker& make)
{
  technique_ = settings_.bind(
      make.choice("Mode", TECHNIQUES[0],
                  "What a drag or click selects: a box, a lasso, the connected region around a "
                  "face, or the faces of a label that is there already. Keys 1 to 4.",
                  parent, TECHNIQUES),
      &SelectionSettings::technique);
  seen_ = settings_.bind(
      make.choice("Selection", SEEN[0],
                  "Whether box, lasso and brush take all faces in them, or only those that can be "
                  "seen from here. Flood and Label take only what is seen, too: Flood then goes "
                  "from one face that is seen to the next. Ctrl+T.",
                  parent, SEEN),
      &SelectionSettings::visible_only);
  back_faces_ = settings_.bind(
      make.box("Back Faces", true,
               "Whether faces that are seen from behind are selected, too. Ctrl+B.", parent),
      &SelectionSettings::back_faces);
  radius_ = settings_.bind(
      make.number("Brush Radius", 1.0f, "Radius of the brush, in meters. Ctrl + wheel.", parent,
                  MIN_RADIUS, MAX_RADIUS),
      &SelectionSettings::radius);
  flood_angle_ = make.number(
      "Flood Angle", 15.0f,
      "Flood goes on from a face to its neighbor where they are bent against each other by at most "
      "this angle, in degrees.",
      parent, 0.0f, 180.0f);
  color_ = make.color("Highlight Color", toQColor(SelectionVisual::COLOR),
                      "Color of the faces that are selected.", parent);
}

SelectionSettings SelectionProperties::settings() const
{
  SelectionSettings settings = settings_.get();
  settings.flood_angle = static_cast<double>(flood_angle_->getFloat()) * M_PI / 180.0;
  return settings;
}

Rgba8 SelectionProperties::color() const
{
  Rgba8 color = toRgba8(color_->getColor());
  color.alpha = SelectionVisual::COLOR.alpha;
  return color;
}

void SelectionProperties::setTechnique(SelectionTechnique technique)
{
  technique_->setString(TECHNIQUES[static_cast<std::size_t>(technique)]);
}

void SelectionProperties::toggleVisibleOnly()
{
  seen_->setString(SEEN[seen_->getOptionInt() == 0 ? 1 : 0]);
}

void SelectionProperties::scaleRadius(double factor)
{
  radius_->setFloat(static_cast<float>(static_cast<double>(radius_->getFloat()) * factor));
}

}  // namespace rviz_mesh_plugin
