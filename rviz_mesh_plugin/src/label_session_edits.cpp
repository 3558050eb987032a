#include "rviz_mesh_plugin/label_session.h"

#include <algorithm>
#include <iterator>

#include <ros/exceptions.h>
#include <rviz/properties/property.h>

#include "rviz_mesh_plugin/label_faces.h"
#include "rviz_mesh_plugin/label_name.h"
#include "rviz_mesh_plugin/map3d_display.h"
#include "rviz_mesh_plugin/map_server.h"

namespace rviz_mesh_plugin {

std::string labelNamespace(const ClusterLabelDisplay& display)
{
  MeshSource source;
  const auto* map = dynamic_cast<const Map3DDisplay*>(display.getParent());
  if (map && map->labelDisplay() == &display) {
    const MapServer* server = map->session().server();
    return server ? labelNamespace(server->source(std::string())) : std::string();
  }
  for (int i = 0; i < display.numChildren(); ++i) {
    if (display.childAt(i)->getName() == "Labels Topic") {
      source.labels_topic = display.childAt(i)->getValue().toString().toStdString();
    }
  }
  return labelNamespace(source);
}

LabelEdit LabelSession::edit(const std::string& label) const
{
  const MeshDataConstPtr mesh = this->mesh();
  LabelEdit edit;
  edit.uuid = mesh ? mesh->uuid : std::string();
  edit.face_count = mesh ? mesh->faceCount() : 0;
  edit.label = label;
  return edit;
}

/// Clears a label whose faces another one gets.
LabelEdit LabelSession::clearing(const std::string& label, const std::string& after) const
{
  LabelEdit clear = edit(label);
  clear.faces = std::make_shared<Faces>();
  clear.after = after;
  // What is on its way may have been sent, or not.
  clear.based_on.push_back(std::make_shared<Faces>(faces(label)));
  const auto stored = labels().find(label);
  clear.based_on.push_back(
      stored == labels().end() ? clear.faces : std::make_shared<Faces>(stored->second->faces));
  return clear;
}

/// Checks what is to be kept until it is stored.
std::string LabelSession::put(LabelEdit edit)
{
  const MeshDataConstPtr mesh = this->mesh();
  if (!mesh) {
    return "there is no mesh to label: add a Map3D display, or one of labels with its topics";
  }
  std::string reason = whyNoLabel(edit.label);
  if (reason.empty() && edit.faces && !edit.faces->empty() &&
      edit.faces->back() >= mesh->faceCount()) {
    reason = "these faces are not of the mesh '" + mesh->uuid + "', whose labels are edited";
  }
  if (reason.empty()) {
    edits_.add(std::move(edit));
    ++revision_;
  }
  return reason;
}

std::string LabelSession::assign(const std::string& label, const Faces& faces)
{
  auto sorted = std::make_shared<Faces>(faces);
  sortFaces(*sorted);
  LabelEdit change = edit(label);
  change.faces = std::move(sorted);
  return put(std::move(change));
}

std::string LabelSession::add(const std::string& label, const Faces& faces)
{
  if (faces.empty()) {
    return {};
  }
  const LabelEdit* pending = edits_.find(id(), label);
  LabelEdit change = pending ? *pending : edit(label);
  change.adds = !pending || pending->adds;
  auto all = std::make_shared<Faces>(faces);
  if (pending) {
    all->insert(all->end(), pending->faces->begin(), pending->faces->end());
  }
  sortFaces(*all);
  change.faces = std::move(all);
  return put(std::move(change));
}

std::string LabelSession::takeAway(const std::string& label, const Faces& faces)
{
  Faces sorted = faces;
  sortFaces(sorted);
  const Faces before = this->faces(label);
  Faces rest;
  std::set_difference(before.begin(), before.end(), sorted.begin(), sorted.end(),
                      std::back_inserter(rest));
  return assign(label, rest);
}

std::string LabelSession::rename(const std::string& from, const std::string& to)
{
  const std::vector<std::string> known = names();
  if (std::find(known.begin(), known.end(), to) != known.end()) {
    return "there is a label '" + to + "' already: merge them, or take another name";
  }
  const OwnColorsConstPtr own = ownColors();
  const auto color = own ? own->find(from) : OwnColors::const_iterator();
  std::string reason = assign(to, faces(from));
  if (reason.empty() && own && color != own->end()) {
    reason = setColor({to}, color->second);
  }
  if (reason.empty()) {
    reason = put(clearing(from, to));
  }
  return reason;
}

std::string LabelSession::merge(const std::vector<std::string>& labels, const std::string& into)
{
  Faces all;
  for (const std::string& label : labels) {
    const Faces faces = label == into ? Faces() : this->faces(label);
    all.insert(all.end(), faces.begin(), faces.end());
  }
  std::string reason = add(into, all);
  for (const std::string& label : labels) {
    if (reason.empty() && label != into) {
      reason = put(clearing(label, into));
    }
  }
  return reason;
}

std::string LabelSession::remove(const std::vector<std::string>& labels)
{
  std::string reason;
  for (const std::string& label : labels) {
    reason = reason.empty() ? assign(label, {}) : reason;
  }
  return reason;
}

std::string LabelSession::setColor(const std::vector<std::string>& labels,
                                   const std::optional<Rgba8>& color)
{
  std::string reason;
  for (const std::string& label : labels) {
    LabelEdit change = edit(label);
    change.color = color;
    reason = reason.empty() ? put(std::move(change)) : reason;
  }
  return reason;
}

std::string LabelSession::import(const FileLabels& labels)
{
  std::string reason;
  for (const auto& label : labels) {
    if (label.second.faces.empty() && faceCount(label.first) == 0) {
      continue;  // it is not there
    }
    reason = reason.empty() ? assign(label.first, label.second.faces) : reason;
    if (reason.empty() && label.second.color && !label.second.faces.empty()) {
      reason = setColor({label.first}, label.second.color);
    }
  }
  return reason;
}

FileLabels LabelSession::content() const
{
  const OwnColorsConstPtr own = ownColors();
  FileLabels content;
  for (const std::string& name : names()) {
    FileLabel label;
    label.faces = faces(name);
    if (own && own->count(name) != 0) {
      label.color = own->at(name);
    }
    if (!label.faces.empty()) {
      content.emplace(name, std::move(label));
    }
  }
  return content;
}

}  // namespace rviz_mesh_plugin
