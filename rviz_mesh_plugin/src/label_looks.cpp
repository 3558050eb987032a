#include "rviz_mesh_plugin/label_looks.h"

#include <algorithm>

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

/// The colors, and the labels that can be hidden.
std::size_t countProperties(const rviz::Property* display)
{
  const rviz::Property* colors = display ? childOf(*display, "Colors") : nullptr;
  const rviz::Property* classes = display ? childOf(*display, "Visible Labels") : nullptr;
  int count = colors ? colors->numChildren() : 0;
  for (int i = 0; classes && i < classes->numChildren(); ++i) {
    count += classes->childAt(i)->numChildren();
  }
  return static_cast<std::size_t>(count);
}

}  // namespace

/// The display makes and deletes properties a while after its labels have changed.
bool LabelLooks::refresh(rviz::Display* display)
{
  if (display != display_ || !isRead()) {
    display_ = display;
    read();
  }
  std::vector<std::pair<QColor, bool>> seen;
  seen.reserve(looks_.size());
  for (const auto& look : looks_) {
    const bool known = look.second.isComplete();
    seen.emplace_back(known ? look.second.color->getColor() : QColor(),
                      known && look.second.isShown());
  }
  seen.swap(seen_);
  return seen != seen_;
}

bool LabelLooks::isRead() const
{
  return countProperties(display_) == properties_ &&
         std::all_of(looks_.begin(), looks_.end(),
                     [](const auto& look) { return look.second.isComplete(); });
}

void LabelLooks::read()
{
  looks_.clear();
  properties_ = countProperties(display_);
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

const LabelLooks::Look* LabelLooks::find(const std::string& label) const
{
  const auto look = looks_.find(label);
  return look != looks_.end() && look->second.isComplete() ? &look->second : nullptr;
}

QColor LabelLooks::color(const std::string& label) const
{
  const Look* look = find(label);
  return look ? look->color->getColor() : QColor();
}

bool LabelLooks::isShown(const std::string& label) const
{
  const Look* look = find(label);
  return !look || look->isShown();
}

void LabelLooks::setShown(const std::string& label, bool shown)
{
  if (const Look* look = find(label)) {
    const QPointer<rviz::BoolProperty> label_class = look->class_shown;
    look->shown->setBool(shown);
    if (shown && label_class) {
      label_class->setBool(true);
    }
  }
}

}  // namespace rviz_mesh_plugin
