#include "rviz_mesh_plugin/label_status.h"

namespace rviz_mesh_plugin {
namespace {

std::string counted(std::size_t count, const std::string& what, const std::string& plural)
{
  return std::to_string(count) + " " + (count == 1 ? what : plural);
}

}  // namespace

StatusLine labelGeometryStatus(const LabelDisplayState& state, const LabelStore& store)
{
  if (!state.subscription_error.empty()) {
    return {StatusLine::ERROR, state.subscription_error};
  }
  if (state.geometry_topic.empty() && state.source_given) {
    return noMapOpen();
  }
  if (state.geometry_topic.empty()) {
    return {StatusLine::ERROR,
            "there is no mesh to label: choose a 'Geometry Topic' and a 'Labels Topic', or add a "
            "Map3D display, which brings a display of labels of its own"};
  }
  if (!state.geometry.refusal.empty()) {
    return {StatusLine::ERROR, "the newest mesh on " + state.geometry_topic +
                                   " was refused: " + state.geometry.refusal};
  }
  if (!store.mesh()) {
    const std::string text = state.working.empty() ? "no mesh received on " + state.geometry_topic +
                                                         " yet: is its node running?"
                                                   : state.working;
    return {state.working.empty() ? StatusLine::WARN : StatusLine::OK, text};
  }
  return {StatusLine::OK,
          counted(store.mesh()->faceCount(), "face", "faces") + ", uuid " + store.mesh()->uuid};
}

OptionalStatus labelsStatus(const LabelDisplayState& state, const LabelStore& store)
{
  if (!store.mesh()) {
    return std::nullopt;
  }
  if (!state.labels.refusal.empty()) {
    return StatusLine{StatusLine::ERROR, "the newest labels were refused: " + state.labels.refusal};
  }
  if (state.labels_topic.empty()) {
    return StatusLine{StatusLine::WARN,
                      "no labels: choose a 'Labels Topic', as /new_cluster_label of "
                      "hdf5_map_server"};
  }
  if (state.label_count == 0) {
    if (store.waiting() > 0) {
      return StatusLine{StatusLine::WARN,
                        "labels of another mesh have arrived: both topics have "
                        "to be of one node"};
    }
    return StatusLine{StatusLine::OK, store.isComplete()
                                          ? "the mesh has no labels (yet)"
                                          : "no label received yet; those that change show here"};
  }
  std::string text = counted(state.label_count, "label", "labels") + " of " +
                     counted(state.class_count, "class", "classes") + " on " +
                     counted(store.faceCount(), "face", "faces");
  if (state.hidden > 0) {
    text += ", " + std::to_string(state.hidden) + " hidden";
  }
  if (state.to_show > 0) {
    text += ", " + std::to_string(state.to_show) + " to be shown yet";
  }
  if (store.facesBeyond() > 0) {
    return StatusLine{StatusLine::WARN,
                      text + "; " + counted(store.facesBeyond(), "index", "indices") +
                          " left out, which the mesh has no face for: the labels were made for "
                          "another one"};
  }
  return StatusLine{StatusLine::OK, text};
}

OptionalStatus servicesStatus(const MeshServices::Report& report)
{
  if (report.lines.empty()) {
    return std::nullopt;
  }
  const bool bad = report.worst() == MeshServices::Report::State::FAILED ||
                   report.worst() == MeshServices::Report::State::SEARCHING;
  return StatusLine{bad ? StatusLine::WARN : StatusLine::OK, report.text()};
}

}  // namespace rviz_mesh_plugin
