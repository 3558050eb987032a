#include "displays/label_visibility.h"

#include <rviz/properties/bool_property.h>

#include "labels/label_name.h"

namespace rviz_mesh_plugin {
namespace {

const char* const CLASSES = "Hidden Classes";
const char* const LABELS = "Hidden Labels";

std::set<std::string> readNames(const rviz::Config& config)
{
  std::set<std::string> names;
  for (int i = 0; i < config.listLength(); ++i) {
    names.insert(config.listChildAt(i).getValue().toString().toStdString());
  }
  return names;
}

void writeNames(rviz::Config config, const std::set<std::string>& names)
{
  for (const std::string& name : names) {
    config.listAppendNew().setValue(QString::fromStdString(name));
  }
}

/// The child of that name, or null; @a place is where it is, or belongs.
rviz::Property* findBox(const rviz::Property* parent, const std::string& name, int& place)
{
  const LabelLess less;
  int end = parent->numChildren();
  place = 0;
  while (place < end) {
    const int middle = (place + end) / 2;
    if (less(parent->childAtUnchecked(middle)->getNameStd(), name)) {
      place = middle + 1;
    } else {
      end = middle;
    }
  }
  if (place == parent->numChildren()) {
    return nullptr;
  }
  rviz::Property* child = parent->childAtUnchecked(place);
  return child->getNameStd() == name ? child : nullptr;
}

}  // namespace

LabelVisibility::LabelVisibility(rviz::Property* parent)
    : rviz::Property("Visible Labels", QVariant(), "Which classes and labels are drawn.", parent)
{
}

bool LabelVisibility::isShown(const std::string& label) const
{
  return hidden_labels_.count(label) == 0 && hidden_classes_.count(labelClass(label)) == 0;
}

void LabelVisibility::setShown(const std::string& label, bool shown)
{
  int place = 0;
  rviz::Property* parent = classBox(labelClass(label));
  if (rviz::Property* box = parent ? findBox(parent, label, place) : nullptr) {
    box->setValue(shown);
    if (shown) {
      parent->setValue(true);
    }
  }
}

rviz::Property* LabelVisibility::classBox(const std::string& label_class) const
{
  int place = 0;
  return findBox(this, label_class, place);
}

rviz::BoolProperty* LabelVisibility::addBox(const std::string& name, const char* what, bool shown,
                                            rviz::Property* parent)
{
  auto* box = new rviz::BoolProperty(QString::fromStdString(name), shown,
                                     QString("Whether this %1 is drawn.").arg(what));
  int place = 0;
  findBox(parent, name, place);
  parent->addChild(box, place);
  return box;
}

void LabelVisibility::addLabel(const std::string& label)
{
  const std::string label_class = labelClass(label);
  rviz::Property* parent = classBox(label_class);
  if (!parent) {
    auto* box = addBox(label_class, "class", hidden_classes_.count(label_class) == 0, this);
    box->setDisableChildrenIfFalse(true);
    connect(box, &rviz::Property::changed, this, [this, box, label_class] {
      choose(hidden_classes_, label_class, box->getBool());
      Q_EMIT classChanged(QString::fromStdString(label_class));
    });
    parent = box;
  }
  int place = 0;
  if (findBox(parent, label, place)) {
    return;
  }
  auto* box = addBox(label, "label", hidden_labels_.count(label) == 0, parent);
  connect(box, &rviz::Property::changed, this, [this, box, label] {
    choose(hidden_labels_, label, box->getBool());
    Q_EMIT labelChanged(QString::fromStdString(label));
  });
}

void LabelVisibility::removeLabel(const std::string& label)
{
  rviz::Property* parent = classBox(labelClass(label));
  int place = 0;
  if (!parent || !findBox(parent, label, place)) {
    return;
  }
  delete parent->takeChildAt(place);
  if (parent->numChildren() == 0) {
    findBox(this, labelClass(label), place);
    delete takeChildAt(place);
  }
}

void LabelVisibility::choose(std::set<std::string>& hidden, const std::string& name, bool shown)
{
  if (shown) {
    hidden.erase(name);
  } else {
    hidden.insert(name);
  }
}

void LabelVisibility::load(const rviz::Config& config)
{
  hidden_classes_ = readNames(config.mapGetChild(CLASSES));
  hidden_labels_ = readNames(config.mapGetChild(LABELS));
  // Those whose value changes tell it.
  const auto classes = hidden_classes_;
  const auto labels = hidden_labels_;
  for (int i = 0; i < numChildren(); ++i) {
    rviz::Property* parent = childAt(i);
    for (int j = 0; j < parent->numChildren(); ++j) {
      rviz::Property* box = parent->childAt(j);
      box->setValue(labels.count(box->getNameStd()) == 0);
    }
    parent->setValue(classes.count(parent->getNameStd()) == 0);
  }
}

void LabelVisibility::save(rviz::Config config) const
{
  if (!hidden_classes_.empty()) {
    writeNames(config.mapMakeChild(CLASSES), hidden_classes_);
  }
  if (!hidden_labels_.empty()) {
    writeNames(config.mapMakeChild(LABELS), hidden_labels_);
  }
}

}  // namespace rviz_mesh_plugin
