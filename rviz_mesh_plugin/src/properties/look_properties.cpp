#include "properties/look_properties.h"

#include <QColor>
#include <QString>

#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>

namespace rviz_mesh_plugin {
namespace {

enum Shading
{
  SMOOTH = 0,
  FLAT = 1
};

Ogre::ColourValue color(const rviz::ColorProperty* property, const rviz::FloatProperty* alpha)
{
  Ogre::ColourValue value = property->getOgreColor();
  value.a = alpha->getFloat();
  return value;
}

}  // namespace

rviz::FloatProperty* makeAlpha(const char* name, const char* of_what, rviz::Property* parent,
                               const char* changed_slot, QObject* receiver)
{
  auto* alpha = new rviz::FloatProperty(
      name, 1.0f, QString("Opacity of the %1: 0 is invisible, 1 opaque.").arg(of_what), parent,
      changed_slot, receiver);
  alpha->setMin(0.0f);
  alpha->setMax(1.0f);
  return alpha;
}

LookProperties::LookProperties(rviz::Property* parent) : QObject(parent)
{
  addLines(parent);
  addFaces(parent);
}

void LookProperties::addLines(rviz::Property* parent)
{
  show_wireframe_ = new rviz::BoolProperty("Show Wireframe", true, "Draw the edges.", parent,
                                           SIGNAL(styleChanged()), this);
  show_wireframe_->setDisableChildrenIfFalse(true);
  wireframe_color_ = new rviz::ColorProperty("Wireframe Color", Qt::black, "Color of the edges.",
                                             show_wireframe_, SIGNAL(styleChanged()), this);
  wireframe_alpha_ =
      makeAlpha("Wireframe Alpha", "edges", show_wireframe_, SIGNAL(styleChanged()), this);
  show_normals_ =
      new rviz::BoolProperty("Show Normals", true, "Draw a line along the normal of each vertex.",
                             parent, SIGNAL(styleChanged()), this);
  show_normals_->setDisableChildrenIfFalse(true);
  normals_color_ =
      new rviz::ColorProperty("Normals Color", QColor(255, 0, 255), "Color of the normals.",
                              show_normals_, SIGNAL(styleChanged()), this);
  normals_alpha_ =
      makeAlpha("Normals Alpha", "normals", show_normals_, SIGNAL(styleChanged()), this);
  normals_scale_ =
      new rviz::FloatProperty("Normals Scaling Factor", 0.1f, "Length of the normals in meters.",
                              show_normals_, SIGNAL(styleChanged()), this);
}

void LookProperties::addFaces(rviz::Property* parent)
{
  culling_ = new rviz::EnumProperty("Culling Mode (HW)", "None",
                                    "Which faces are left out: none; those that are "
                                    "wound clockwise as seen from here (the backs "
                                    "of faces, for a look into closed rooms from "
                                    "outside: Anticlockwise); or the others.",
                                    parent, SIGNAL(styleChanged()), this);
  culling_->addOption("None", static_cast<int>(MeshStyle::Culling::NONE));
  culling_->addOption("Clockwise", static_cast<int>(MeshStyle::Culling::BACK));
  culling_->addOption("Anticlockwise", static_cast<int>(MeshStyle::Culling::FRONT));
  shading_ = new rviz::EnumProperty(
      "Shading", "Smooth", "Light faces by the normals of their vertices, or each by its plane.",
      parent, SIGNAL(styleChanged()), this);
  shading_->addOption("Smooth", SMOOTH);
  shading_->addOption("Flat", FLAT);
  level_of_detail_ = new rviz::BoolProperty(
      "Level of Detail", true, "Merge faces that are too small to be told apart from here.", parent,
      SIGNAL(styleChanged()), this);
  level_of_detail_->setDisableChildrenIfFalse(true);
  detail_pixels_ = new rviz::FloatProperty("Detail in pixels", MeshStyle().detail_pixels,
                                           "Faces smaller than this on the screen may be merged.",
                                           level_of_detail_, SIGNAL(styleChanged()), this);
  detail_pixels_->setMin(0.1f);
  detail_pixels_->setMax(100.0f);
}

bool LookProperties::normalsShown() const
{
  return show_normals_->getBool();
}

void LookProperties::apply(MeshStyle& style) const
{
  style.show_wireframe = show_wireframe_->getBool();
  style.wireframe_color = color(wireframe_color_, wireframe_alpha_);
  style.show_normals = show_normals_->getBool();
  style.normals_color = color(normals_color_, normals_alpha_);
  style.normals_length = normals_scale_->getFloat();
  style.culling = static_cast<MeshStyle::Culling>(culling_->getOptionInt());
  style.flat_shading = shading_->getOptionInt() == FLAT;
  style.level_of_detail = level_of_detail_->getBool();
  style.detail_pixels = detail_pixels_->getFloat();
}

}  // namespace rviz_mesh_plugin
