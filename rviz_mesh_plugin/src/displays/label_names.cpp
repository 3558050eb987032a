#include "displays/label_names.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <OgreCamera.h>
#include <OgreSceneNode.h>
#include <Eigen/Core>

#include "rendering/text/text_layout.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

/// So many faces are looked at between two looks at the cancel flag.
constexpr std::size_t FACES_PER_LOOK = 4096;

Eigen::Vector3d middleOf(const MeshData& mesh, std::uint32_t face)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const auto& position = mesh.vertices[mesh.indices[3 * std::size_t{face} + corner]].position;
    sum += Eigen::Vector3d(position[0], position[1], position[2]) / 3.0;
  }
  return sum;
}

}  // namespace

std::array<double, 3> placeOfName(const MeshData& mesh, const std::vector<std::uint32_t>& faces,
                                  const std::atomic<bool>* cancel)
{
  if (faces.empty()) {
    return {NAN, NAN, NAN};
  }
  const auto forEachMiddle = [&](const auto& visit) {
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (i % FACES_PER_LOOK == 0) {
        throwIfCanceled(cancel);
      }
      visit(middleOf(mesh, faces[i]));
    }
  };
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  forEachMiddle(
      [&](const Eigen::Vector3d& middle) { mean += middle / static_cast<double>(faces.size()); });
  Eigen::Vector3d place = mean;
  double nearest = std::numeric_limits<double>::infinity();
  forEachMiddle([&](const Eigen::Vector3d& middle) {
    const double distance = (middle - mean).squaredNorm();
    if (distance < nearest) {
      nearest = distance;
      place = middle;
    }
  });
  return {place.x(), place.y(), place.z()};
}

void LabelNames::setLabels(const MeshDataConstPtr& mesh, const LabelClusters& labels,
                           const LabelLooks& looks, const HiddenFacesConstPtr& hidden)
{
  if (hidden != hidden_) {
    hidden_ = hidden;
    places_.clear();
    task_.drop();
  }
  if (mesh != mesh_) {
    mesh_ = mesh;
    names_.clear();
    places_.clear();
    task_.drop();
  }
  std::vector<std::pair<std::size_t, LabelClusterConstPtr>> wanted;
  for (const auto& label : labels) {
    const auto look = looks.find(label.first);
    if (mesh && !label.second->faces.empty() && (look == looks.end() || look->second.visible)) {
      wanted.emplace_back(label.second->faces.size(), label.second);
    }
  }
  const std::size_t count = std::min(wanted.size(), MOST);
  left_out_ = wanted.size() - count;
  std::partial_sort(wanted.begin(), wanted.begin() + static_cast<std::ptrdiff_t>(count),
                    wanted.end(), [](const auto& a, const auto& b) {
                      return a.first != b.first ? a.first > b.first
                                                : a.second->label < b.second->label;
                    });
  wanted.resize(count);
  std::vector<Name> names;
  for (const auto& one : wanted) {
    Name name;
    const auto before = std::find_if(names_.begin(), names_.end(), [&](const Name& other) {
      return other.label && other.label->label == one.second->label;
    });
    if (before != names_.end()) {
      name = std::move(*before);
    }
    name.label = one.second;
    const auto look = looks.find(one.second->label);
    name.color = look == looks.end() ? LabelLook().color : look->second.color;
    names.push_back(std::move(name));
  }
  names_ = std::move(names);
  Places kept;
  for (const Name& name : names_) {
    const auto known = places_.find(name.label);
    if (known != places_.end()) {
      kept.insert(*known);
    }
  }
  places_ = std::move(kept);
  failed_ = false;
}

void LabelNames::findPlaces()
{
  if (auto outcome = task_.take()) {
    failed_ = !outcome->result;
    if (outcome->result) {
      places_.insert(outcome->result->begin(), outcome->result->end());
    }
  }
  if (failed_ || task_.isRunning()) {
    return;
  }
  std::vector<LabelClusterConstPtr> unknown;
  for (const Name& name : names_) {
    if (places_.count(name.label) == 0) {
      unknown.push_back(name.label);
    }
  }
  if (unknown.empty()) {
    return;
  }
  task_.start([mesh = mesh_, hidden = hidden_, unknown](const Cancellation& cancellation) {
    Places places;
    for (const LabelClusterConstPtr& label : unknown) {
      const auto faces = withoutHidden({label, &label->faces}, hidden);
      places[label] = placeOfName(*mesh, *faces, &cancellation.flag());
    }
    return places;
  });
}

bool LabelNames::update(const Ogre::Camera* camera, const Section& section)
{
  findPlaces();
  TextLayout layout(camera);
  bool changed = false;
  for (Name& name : names_) {
    const auto place = places_.find(name.label);
    bool drawn = place != places_.end() && section.contains(place->second);
    if (drawn) {
      const auto& p = place->second;
      const Ogre::Vector3 point(static_cast<float>(p[0]), static_cast<float>(p[1]),
                                static_cast<float>(p[2]));
      if (!name.text) {
        name.text = std::make_unique<SceneText>(node());
      }
      name.text->show({name.label->label}, name.color);
      name.text->setPosition(point);
      const auto offset = layout.add(node()->convertLocalToWorldPosition(point), name.text->width(),
                                     name.text->height());
      drawn = offset.has_value();
      if (drawn) {
        name.text->setOffset(offset->first, offset->second);
      }
    }
    if (name.text) {
      name.text->setVisible(drawn);
    }
    changed |= drawn != name.drawn;
    name.drawn = drawn;
  }
  return changed;
}

std::vector<std::string> LabelNames::drawn() const
{
  std::vector<std::string> names;
  for (const Name& name : names_) {
    if (name.drawn) {
      names.push_back(name.label->label);
    }
  }
  return names;
}

}  // namespace rviz_mesh_plugin
