#include "displays/label_properties.h"

#include <algorithm>
#include <iterator>

#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshGeometryStamped.h>

namespace rviz_mesh_plugin {
namespace {

const char* const NEW_LABEL = "__NEW__";

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

/// Of children in the order of their names: that of this name, or null; @a place is where it is, or
/// belongs.
rviz::Property* childNamed(const rviz::Property* parent, const std::string& name, int& place)
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
  if (rviz::Property* box = parent ? childNamed(parent, label, place) : nullptr) {
    box->setValue(shown);
    if (shown) {
      parent->setValue(true);
    }
  }
}

rviz::Property* LabelVisibility::classBox(const std::string& label_class) const
{
  int place = 0;
  return childNamed(this, label_class, place);
}

/// @param hidden the names of those that are not drawn
void LabelVisibility::addBox(const std::string& name, const char* what,
                             std::set<std::string>& hidden, rviz::Property* parent)
{
  int place = 0;
  if (childNamed(parent, name, place)) {
    return;
  }
  auto* box = new rviz::BoolProperty(QString::fromStdString(name), hidden.count(name) == 0,
                                     QString("Whether this %1 is drawn.").arg(what));
  box->setDisableChildrenIfFalse(true);
  parent->addChild(box, place);
  connect(box, &rviz::Property::changed, this, [this, box, name, &hidden] {
    if (box->getBool()) {
      hidden.erase(name);
    } else {
      hidden.insert(name);
    }
    Q_EMIT changed();
  });
}

void LabelVisibility::addLabel(const std::string& label)
{
  const std::string label_class = labelClass(label);
  addBox(label_class, "class", hidden_classes_, this);
  addBox(label, "label", hidden_labels_, classBox(label_class));
}

void LabelVisibility::removeLabel(const std::string& label)
{
  rviz::Property* parent = classBox(labelClass(label));
  int place = 0;
  if (!parent || !childNamed(parent, label, place)) {
    return;
  }
  delete parent->takeChildAt(place);
  if (parent->numChildren() == 0) {
    childNamed(this, labelClass(label), place);
    delete takeChildAt(place);
  }
}

void LabelVisibility::load(const rviz::Config& config)
{
  hidden_classes_ = readNames(config.mapGetChild(CLASSES));
  hidden_labels_ = readNames(config.mapGetChild(LABELS));
  // Those whose value changes edit them.
  const auto classes = hidden_classes_;
  const auto labels = hidden_labels_;
  blockSignals(true);  // to tell it once
  for (int i = 0; i < numChildren(); ++i) {
    rviz::Property* parent = childAt(i);
    for (int j = 0; j < parent->numChildren(); ++j) {
      rviz::Property* box = parent->childAt(j);
      box->setValue(labels.count(box->getNameStd()) == 0);
    }
    parent->setValue(classes.count(parent->getNameStd()) == 0);
  }
  blockSignals(false);
  Q_EMIT changed();
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

LabelProperties::LabelProperties(rviz::Property* parent) : QObject(parent)
{
  const PropertyMaker topics(this, [this] { Q_EMIT topicsChanged(); });
  const PropertyMaker looks(this, [this] { Q_EMIT lookChanged(); });
  geometry_topic_ = topics.topic<mesh_msgs::MeshGeometryStamped>(
      "Geometry Topic", "The mesh that is labelled.", parent);
  labels_topic_ = topics.topic<mesh_msgs::MeshFaceCluster>(
      "Labels Topic",
      "Labels as they change, as /new_cluster_label of hdf5_map_server. The services beside it are "
      "asked for all labels.",
      parent);
  active_label_ = new rviz::EnumProperty(
      "Active label", NEW_LABEL, "The label that tools edit; __NEW__ is one that is not there yet.",
      parent);
  active_label_->addOption(NEW_LABEL);
  transparency_ = looks.alpha("Transparency", "labels", parent);
  color_group_ = new rviz::Property(
      "Colors", QVariant(),
      "The labels have the color of their class. One that is chosen here is the label's own and is "
      "stored with the map; the color of the class takes it away again.",
      parent);
  color_group_->setShouldBeSaved(false);
  visibility_ = new LabelVisibility(parent);
  connect(visibility_, &rviz::Property::changed, this, &LabelProperties::visibilityChanged);
  brush_size_ = new rviz::FloatProperty(
      "Brush Size", 1.0f, "Radius of the brush of the label tool, in meters.", parent);
  brush_size_->setMin(0.0f);
  phantom_ = looks.box("Show Phantom", false, "Draw the whole mesh as a shade.", parent);
  names_ =
      looks.box("Show Names", false,
                "Draw the names over the labels that are shown: of the 50 with the most faces, "
                "where no other name is.",
                parent);
}

void LabelProperties::setTopic(const QString& topic, bool of_labels)
{
  (of_labels ? labels_topic_ : geometry_topic_)->setString(topic);
}

void LabelProperties::setTopicsHidden(bool hidden)
{
  geometry_topic_->setHidden(hidden);
  labels_topic_->setHidden(hidden);
}

void LabelProperties::setLabels(const std::vector<std::string>& labels)
{
  const LabelLess less;
  std::vector<std::string> wanted = labels;
  std::sort(wanted.begin(), wanted.end(), less);
  std::vector<std::string> present;
  for (int i = 0; i < color_group_->numChildren(); ++i) {
    present.push_back(color_group_->childAtUnchecked(i)->getNameStd());
  }
  to_add_.clear();
  to_remove_.clear();
  std::set_difference(wanted.begin(), wanted.end(), present.begin(), present.end(),
                      std::back_inserter(to_add_), less);
  std::set_difference(present.begin(), present.end(), wanted.begin(), wanted.end(),
                      std::back_inserter(to_remove_), less);
  // What has been chosen stays, even if it is not among them (yet).
  active_label_->clearOptions();
  active_label_->addOption(NEW_LABEL);
  for (const std::string& label : wanted) {
    active_label_->addOptionStd(label);
  }
}

void LabelProperties::setColor(const std::string& label, const Rgba8& color)
{
  wanted_colors_[label] = color;
  int place = 0;
  if (rviz::Property* property = childNamed(color_group_, label, place)) {
    setting_color_ = true;
    static_cast<rviz::ColorProperty*>(property)->setColor(toQColor(color));
    setting_color_ = false;
  }
}

bool LabelProperties::work(std::chrono::microseconds budget)
{
  const auto end = std::chrono::steady_clock::now() + budget;
  while (!to_remove_.empty() || !to_add_.empty()) {
    if (std::chrono::steady_clock::now() >= end) {
      return false;
    }
    if (!to_remove_.empty()) {
      removeLabel(to_remove_.front());
      to_remove_.pop_front();
    } else {
      addLabel(to_add_.front());
      to_add_.pop_front();
    }
  }
  return true;
}

void LabelProperties::addLabel(const std::string& label)
{
  int place = 0;
  childNamed(color_group_, label, place);
  auto* property = new rviz::ColorProperty(QString::fromStdString(label),
                                           toQColor(wanted_colors_[label]), "Color of this label.");
  color_group_->addChild(property, place);
  connect(property, &rviz::Property::changed, this, [this, property] {
    if (!setting_color_) {
      Q_EMIT colorChosen(property->getName(), property->getColor());
    }
  });
  visibility_->addLabel(label);
}

void LabelProperties::removeLabel(const std::string& label)
{
  int place = 0;
  if (childNamed(color_group_, label, place)) {
    delete color_group_->takeChildAt(place);
  }
  wanted_colors_.erase(label);
  visibility_->removeLabel(label);
}

}  // namespace rviz_mesh_plugin
