#include "properties/mesh_properties.h"

#include <algorithm>
#include <array>
#include <utility>

#include <QColor>

#include <rviz/config.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/int_property.h>

#include "properties/cost_properties.h"
#include "properties/look_properties.h"
#include "properties/source_properties.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::array<std::pair<const char*, DisplayType>, 5> DISPLAY_TYPES{
    {{"Fixed Color", DisplayType::FIXED_COLOR},
     {"Vertex Color", DisplayType::VERTEX_COLOR},
     {"Textures", DisplayType::TEXTURES},
     {"Vertex Costs", DisplayType::VERTEX_COSTS},
     {"Hide Faces", DisplayType::HIDE_FACES}}};

const Ogre::ColourValue MISSING_COLORS{0.6f, 0.6f, 0.6f, 1.0f};

}  // namespace

MeshProperties::MeshProperties(rviz::Property* parent) : QObject(parent)
{
  sources_ = new SourceProperties(this);
  sources_->addGeometry(parent);
  buffer_size_ = new rviz::IntProperty("Buffer Size", 1,
                                       "So many meshes (by their uuid) are shown, the newest ones.",
                                       parent, SIGNAL(contentChanged()), this);
  buffer_size_->setMin(1);
  display_type_ =
      new rviz::EnumProperty("Display Type", "Fixed Color", "What the faces are colored by.",
                             parent, SLOT(onDisplayType()), this);
  addFaces(display_type_);
  addTextures(display_type_);
  costs_ = new CostProperties(display_type_);
  sources_->addCosts(costs_);
  update_rate_ = new rviz::FloatProperty("Visualization Update Rate", 10.0f,
                                         "How often updates of costs become seen, in Hz; "
                                         "those that come in between are put together.",
                                         display_type_);
  update_rate_->setMin(1.0f);
  alpha_ = makeAlpha("Alpha", "faces", display_type_, SIGNAL(styleChanged()), this);
  look_ = new LookProperties(parent);
  addLabels(parent);
  connect(sources_, SIGNAL(changed()), SIGNAL(sourceChanged()));
  connect(costs_, SIGNAL(coloringChanged()), SIGNAL(contentChanged()));
  connect(costs_, SIGNAL(legendChanged()), SIGNAL(styleChanged()));
  connect(look_, SIGNAL(styleChanged()), SIGNAL(styleChanged()));
  onDisplayType();
}

void MeshProperties::addFaces(rviz::Property* parent)
{
  faces_color_ = new rviz::ColorProperty("Faces Color", QColor(0, 255, 0),
                                         "Color of the faces; with textures: of those without a "
                                         "material.",
                                         parent, SIGNAL(styleChanged()), this);
  faces_alpha_ = makeAlpha("Faces Alpha", "faces", parent, SIGNAL(styleChanged()), this);
  sources_->addColors(parent);
}

void MeshProperties::addTextures(rviz::Property* parent)
{
  only_textured_ = new rviz::BoolProperty("Show textured faces only", false,
                                          "Leave out the faces that have no texture.", parent,
                                          SIGNAL(styleChanged()), this);
  sources_->addTextures(parent);
}

void MeshProperties::addLabels(rviz::Property* parent)
{
  show_labels_ = new rviz::BoolProperty("Show Labels", false,
                                        "Draw labelled faces in the color of their label.", parent,
                                        SIGNAL(contentChanged()), this);
  show_labels_->setDisableChildrenIfFalse(true);
  sources_->addLabels(show_labels_);
  labels_alpha_ =
      makeAlpha("Labels Alpha", "labelled faces", show_labels_, SIGNAL(contentChanged()), this);
}

void MeshProperties::onDisplayType()
{
  const DisplayType type = displayType();
  const bool colors = type == DisplayType::VERTEX_COLOR;
  const bool textures = type == DisplayType::TEXTURES;
  const bool costs = type == DisplayType::VERTEX_COSTS;
  const std::pair<rviz::Property*, bool> seen[] = {
      {faces_color_, type == DisplayType::FIXED_COLOR || textures},
      {faces_alpha_, type == DisplayType::FIXED_COLOR},
      {only_textured_, textures},
      {update_rate_, costs},
      {alpha_, colors || textures || costs},
  };
  for (const auto& property : seen) {
    property.first->setHidden(!property.second);
  }
  sources_->show(colors, textures);
  costs_->setHidden(!costs);
  offerTypes();  // the one before is offered no longer where it has no data
  Q_EMIT contentChanged();
}

void MeshProperties::offerTypes()
{
  const bool own = !sources_->given();
  const bool offered[] = {true, own || available_.colors, own || available_.materials,
                          own || available_.costs, true};
  const QString chosen = display_type_->getString();
  display_type_->clearOptions();
  for (const auto& type : DISPLAY_TYPES) {
    const int number = static_cast<int>(type.second);
    // A choice from a file stays and waits for its data.
    if (offered[number] || chosen == type.first) {
      display_type_->addOption(type.first, number);
    }
  }
}

void MeshProperties::setAvailable(const AvailableData& available)
{
  if (available.colors == available_.colors && available.materials == available_.materials &&
      available.costs == available_.costs) {
    return;
  }
  available_ = available;
  offerTypes();
}

void MeshProperties::setSource(const MeshSource& source)
{
  sources_->give(source);
  buffer_size_->hide();
  onDisplayType();
  Q_EMIT sourceChanged();
}

std::size_t MeshProperties::bufferSize() const
{
  return sources_->given() ? 1 : static_cast<std::size_t>(std::max(1, buffer_size_->getInt()));
}

DisplayType MeshProperties::displayType() const
{
  const QString chosen = display_type_->getString();
  for (const auto& type : DISPLAY_TYPES) {
    if (chosen == type.first) {
      return type.second;
    }
  }
  return DisplayType::FIXED_COLOR;
}

float MeshProperties::updateRate() const
{
  return update_rate_->getFloat();
}

bool MeshProperties::labelsShown() const
{
  return show_labels_->getBool();
}

float MeshProperties::labelsAlpha() const
{
  return labels_alpha_->getFloat();
}

bool MeshProperties::normalsShown() const
{
  return look_->normalsShown();
}

MeshStyle MeshProperties::style(bool at_hand) const
{
  MeshStyle style;
  look_->apply(style);
  style.alpha = alpha_->getFloat();
  style.only_textured = only_textured_->getBool();
  style.faces_color = faces_color_->getOgreColor();
  switch (displayType()) {
    case DisplayType::FIXED_COLOR:
      style.faces_color.a = faces_alpha_->getFloat();
      return style;
    case DisplayType::HIDE_FACES:
      style.faces = MeshStyle::Faces::HIDDEN;
      return style;
    case DisplayType::TEXTURES:
      style.faces = MeshStyle::Faces::TEXTURES;
      style.faces_color.a = style.alpha;
      break;
    default:
      style.faces = MeshStyle::Faces::VERTEX_COLORS;
  }
  if (!at_hand) {
    style.faces = MeshStyle::Faces::FIXED_COLOR;
    style.faces_color = MISSING_COLORS;
  }
  return style;
}

void MeshProperties::loadOlderKeys(const rviz::Config& config)
{
  int size = 0;
  if (!config.mapGetInt("Buffer Size", &size) && config.mapGetInt("Mesh Buffer Size", &size)) {
    buffer_size_->setInt(size);
  }
}

}  // namespace rviz_mesh_plugin
