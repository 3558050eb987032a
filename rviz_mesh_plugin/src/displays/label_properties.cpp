#include "displays/label_properties.h"

#include <algorithm>
#include <iterator>

#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshGeometryStamped.h>

#include "displays/label_visibility.h"

namespace rviz_mesh_plugin {
namespace {

const char* const NEW_LABEL = "__NEW__";

}  // namespace

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
  connect(visibility_, &LabelVisibility::labelChanged, this,
          &LabelProperties::labelVisibilityChanged);
  connect(visibility_, &LabelVisibility::classChanged, this,
          &LabelProperties::classVisibilityChanged);
  brush_size_ = new rviz::FloatProperty(
      "Brush Size", 1.0f, "Radius of the brush of the label tool, in meters.", parent);
  brush_size_->setMin(0.0f);
  phantom_ = looks.box("Show Phantom", false, "Draw the whole mesh as a shade.", parent);
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

bool LabelProperties::isShown(const std::string& label) const
{
  return visibility_->isShown(label);
}

void LabelProperties::setShown(const std::string& label, bool shown)
{
  visibility_->setShown(label, shown);
}

void LabelProperties::setLabels(const std::vector<std::string>& labels)
{
  const LabelLess less;
  std::vector<std::string> wanted = labels;
  std::sort(wanted.begin(), wanted.end(), less);
  std::vector<std::string> present;
  for (const auto& color : colors_) {
    present.push_back(color.first);
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
  const auto property = colors_.find(label);
  if (property != colors_.end()) {
    setting_color_ = true;
    property->second->setColor(toQColor(color));
    setting_color_ = false;
  }
}

Rgba8 LabelProperties::chosenColor(const std::string& label) const
{
  const auto property = colors_.find(label);
  if (property == colors_.end()) {
    return {};
  }
  return toRgba8(property->second->getColor());
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
  const auto entry = colors_.emplace(label, nullptr).first;
  const int place = std::next(entry) == colors_.end()
                        ? color_group_->numChildren()
                        : static_cast<int>(std::distance(colors_.begin(), entry));
  auto* property = new rviz::ColorProperty(QString::fromStdString(label),
                                           toQColor(wanted_colors_[label]), "Color of this label.");
  entry->second = property;
  color_group_->addChild(property, place);
  connect(property, &rviz::Property::changed, this, [this, label] {
    if (!setting_color_) {
      Q_EMIT colorChosen(QString::fromStdString(label));
    }
  });
  visibility_->addLabel(label);
}

void LabelProperties::removeLabel(const std::string& label)
{
  const auto entry = colors_.find(label);
  if (entry != colors_.end()) {
    delete color_group_->takeChild(entry->second);
    colors_.erase(entry);
  }
  wanted_colors_.erase(label);
  visibility_->removeLabel(label);
}

}  // namespace rviz_mesh_plugin
