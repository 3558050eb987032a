#include "rviz_mesh_plugin/label_looks.h"

#include <cstring>

namespace rviz_mesh_plugin {
namespace {

rviz::Property* childOf(const rviz::Property& parent, const char* name)
{
  for (int i = 0; i < parent.numChildren(); ++i) {
    if (parent.childAt(i)->getName() == name) {
      return parent.childAt(i);
    }
  }
  return nullptr;
}

}  // namespace

void LabelLooks::setDisplay(rviz::Display* display)
{
  read_ = false;
  if (display != display_) {
    display_ = display;
    looks_.clear();
  }
}

void LabelLooks::read()
{
  looks_.clear();
  const rviz::Property* colors = display_ ? childOf(*display_, "Colors") : nullptr;
  const rviz::Property* classes = display_ ? childOf(*display_, "Visible Labels") : nullptr;
  for (int i = 0; colors && i < colors->numChildren(); ++i) {
    rviz::Property* color = colors->childAt(i);
    looks_[color->getNameStd()].color = dynamic_cast<rviz::ColorProperty*>(color);
  }
  for (int i = 0; classes && i < classes->numChildren(); ++i) {
    rviz::Property* label_class = classes->childAt(i);
    for (int j = 0; j < label_class->numChildren(); ++j) {
      Look& look = looks_[label_class->childAt(j)->getNameStd()];
      look.shown = dynamic_cast<rviz::BoolProperty*>(label_class->childAt(j));
      look.class_shown = dynamic_cast<rviz::BoolProperty*>(label_class);
    }
  }
}

/// The display makes and deletes properties a while after its labels have changed.
LabelLooks::Look* LabelLooks::find(const std::string& label)
{
  const auto known = [&]() -> Look* {
    const auto look = looks_.find(label);
    const bool complete = look != looks_.end() && look->second.color && look->second.shown &&
                          look->second.class_shown;
    return complete ? &look->second : nullptr;
  };
  if (!known() && !read_) {
    read_ = true;
    read();
  }
  return known();
}

QColor LabelLooks::color(const std::string& label)
{
  const Look* look = find(label);
  return look ? look->color->getColor() : QColor();
}

bool LabelLooks::isShown(const std::string& label)
{
  const Look* look = find(label);
  return !look || (look->shown->getBool() && look->class_shown->getBool());
}

void LabelLooks::setShown(const std::string& label, bool shown)
{
  if (Look* look = find(label)) {
    const QPointer<rviz::BoolProperty> label_class = look->class_shown;
    look->shown->setBool(shown);
    if (shown && label_class) {
      label_class->setBool(true);
    }
  }
}

}  // namespace rviz_mesh_plugin
