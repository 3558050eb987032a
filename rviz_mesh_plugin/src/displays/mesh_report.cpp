#include "displays/mesh_report.h"

#include <set>

#include "incoming/mesh_store.h"
#include "legend/legend.h"
#include "mesh_view/mesh_appearance.h"
#include "properties/cost_properties.h"
#include "properties/mesh_properties.h"
#include "rendering/mesh_visual.h"

namespace rviz_mesh_plugin {
namespace {

std::string firstOf(const std::string& a, const std::string& b)
{
  return a.empty() ? b : a;
}

Reception sum(const Reception& a, const Reception& b)
{
  return {a.accepted + b.accepted,
          a.refused + b.refused,
          firstOf(a.refusal, b.refusal),
          firstOf(a.last_refusal, b.last_refusal),
          a.answers + b.answers,
          firstOf(a.service, b.service),
          a.refusal.empty() ? b.refused_of : a.refused_of};
}

void setWaiting(const MeshStore::Waiting& waiting, AttributeState& state)
{
  state.waiting = waiting.count;
  state.waiting_uuid = waiting.uuid;
}

}  // namespace

void MeshReport::report(const QueuedAttributes& queue, const std::string& working,
                        StatusLines& lines)
{
  findSilentTopics(queue);
  const Reception& reception = queue.receptions[MeshMember::GEOMETRY];
  lines.report("Topic", topic(reception));
  lines.report("Geometry", geometryStatus(geometry(reception, working)));
  lines.report("Costs", costsStatus(costs(queue)));
  lines.report("Colors", colorsStatus(colors(queue)));
  lines.report("Textures", texturesStatus(textures(queue)));
  reportSeen(lines);
  lines.report("Labels", labelsStatus(labels(queue)));
  lines.report("Services", sources_.services().report().status(ServiceReport::State::FAILED));
}

/// What is left by section and hidden faces.
void MeshReport::reportSeen(StatusLines& lines)
{
  const MeshDataConstPtr mesh = store_.newest();
  const Section section = properties_.section();
  const bool alone = store_.meshes().size() == 1;  // else others may be seen
  const bool in_section = in_section_.any(mesh, section, nullptr);
  const bool seen = seen_.any(mesh, section, mesh ? hiddenFaces(*mesh) : nullptr);
  lines.report("Section", sectionStatus(properties_.sectionShown(), section, mesh.get(),
                                        alone && !in_section));
  lines.report("Hidden",
               hiddenStatus(store_.meshes(), alone && section.cuts() && in_section && !seen));
}

void MeshReport::findSilentTopics(const QueuedAttributes& queue)
{
  std::vector<std::string> silent;
  for (const MeshMember part : MESH_MEMBERS) {
    const std::string& topic = sources_.resolvedTopic(part);
    if (!topic.empty() && queue.receptions[part].received() == 0) {
      silent.push_back(topic);
    }
  }
  directory_.update(TopicDirectory::Clock::now(), silent);
}

std::string MeshReport::problem(MeshMember part) const
{
  const std::string& error = sources_.error(part);
  return error.empty() ? directory_.problem(sources_.resolvedTopic(part), MeshSources::type(part))
                       : error;
}

StatusLine MeshReport::topic(const Reception& reception) const
{
  const std::string& topic = sources_.topic(MeshMember::GEOMETRY);
  const std::string& error = sources_.error(MeshMember::GEOMETRY);
  if (topic.empty() && properties_.sourceGiven()) {
    return noMapOpen();
  }
  const std::string problem = this->problem(MeshMember::GEOMETRY);
  return error.empty() && !problem.empty() ? StatusLine::error(problem)
                                           : topicStatus(topic, error, reception);
}

GeometryState MeshReport::geometry(const Reception& reception, const std::string& working) const
{
  GeometryState state;
  state.mesh = store_.newest();
  state.reception = reception;
  state.working = working;
  state.normals_shown = properties_.normalsShown();
  state.others = store_.meshes().empty() ? 0 : store_.meshes().size() - 1;
  if (const MeshAppearance* newest = appearances_.newest()) {
    state.error = newest->error();
    const MeshVisual* visual = newest->visual();
    state.drawn = visual && visual->shownLayout();
    state.preview = state.drawn && visual->shownLayout()->preview;
    state.progress = visual ? visual->progress() : 0.0f;
  }
  return state;
}

template <class State>
State MeshReport::attribute(bool chosen, const Reception& reception,
                            std::initializer_list<MeshMember> parts) const
{
  State state;
  state.chosen = chosen;
  state.reception = reception;
  for (const MeshMember part : parts) {
    state.subscription_error = firstOf(state.subscription_error, problem(part));
  }
  if (const MeshDataConstPtr mesh = store_.newest()) {
    state.mesh_shown = true;
    state.uuid = mesh->uuid;
    state.vertex_count = mesh->vertexCount();
    state.face_count = mesh->faceCount();
  }
  return state;
}

CostsState MeshReport::costs(const QueuedAttributes& queue) const
{
  auto state = attribute<CostsState>(
      properties_.displayType() == DisplayType::VERTEX_COSTS,
      sum(queue.receptions[MeshMember::COSTS], queue.receptions[MeshMember::FACE_COSTS]),
      {MeshMember::COSTS, MeshMember::FACE_COSTS, MeshMember::UPDATES});
  state.topic_given = properties_.sourceGiven();
  state.topic = firstOf(sources_.topic(MeshMember::COSTS), sources_.topic(MeshMember::FACE_COSTS));
  state.updates_reception = queue.receptions[MeshMember::UPDATES];
  state.update_problem = queue.receptions[MeshMember::UPDATES].refusal;
  state.stale_updates = queue.stale;
  setWaiting(store_.waitingCosts(), state);
  state.type = properties_.costs().costsType();
  if (state.mesh_shown) {
    state.left_out = store_.attributes().costs_left_out.size();
    state.chosen_left_out = store_.attributes().leftOut(state.type);
  }
  state.types = store_.costTypes();
  const CostLayerConstPtr layer = state.mesh_shown ? store_.attributes().cost(state.type) : nullptr;
  if (layer) {
    state.size = layer->costs.size();
    state.on_faces = layer->on_faces;
    state.summary = layer->summary;
    state.info = store_.layerInfo(layer->uuid, state.type);
    const CostColoring coloring = properties_.costs().coloring();
    // As drawn: one scale for all meshes.
    state.limits = limitsOf(commonColoring(store_, state.type, coloring), layer->summary);
    state.note = coloringNote(coloring, layer->summary);
    const std::string legend = legend_.error();
    if (!legend.empty()) {
      state.note += (state.note.empty() ? "" : "; ") + ("the legend is left out: " + legend);
    }
  }
  return state;
}

ColorsState MeshReport::colors(const QueuedAttributes& queue) const
{
  auto state = attribute<ColorsState>(properties_.displayType() == DisplayType::VERTEX_COLOR,
                                      queue.receptions[MeshMember::COLORS], {MeshMember::COLORS});
  state.topic_given = properties_.sourceGiven();
  state.topic = sources_.topic(MeshMember::COLORS);
  setWaiting(store_.waitingColors(), state);
  const ColorLayerConstPtr layer = state.mesh_shown ? store_.attributes().colors : nullptr;
  if (layer) {
    state.size = layer->colors.size();
  }
  return state;
}

TexturesState MeshReport::textures(const QueuedAttributes& queue) const
{
  auto state = attribute<TexturesState>(properties_.displayType() == DisplayType::TEXTURES,
                                        queue.receptions[MeshMember::MATERIALS],
                                        {MeshMember::MATERIALS, MeshMember::TEXTURES});
  state.textures_reception = queue.receptions[MeshMember::TEXTURES];
  const MeshAttributes& attributes = store_.attributes();
  if (state.mesh_shown && attributes.materials) {
    state.materials = attributes.materials;
    std::set<std::uint32_t> received;
    std::set<std::uint32_t> left_out;
    for (const Material& material : state.materials->materials) {
      if (attributes.textures.count(material.texture_index) != 0) {
        received.insert(material.texture_index);
      } else if (attributes.textures_left_out.count(material.texture_index) != 0) {
        left_out.insert(material.texture_index);
      }
    }
    state.textures = received.size();
    state.textures_left_out = left_out.size();
  }
  return state;
}

LabelsState MeshReport::labels(const QueuedAttributes& queue) const
{
  auto state = attribute<LabelsState>(properties_.labelsShown(),
                                      queue.receptions[MeshMember::LABELS], {MeshMember::LABELS});
  setWaiting(store_.waitingLabels(), state);
  if (const MeshAppearance* newest = appearances_.newest()) {
    state.labels = newest->labels().count();
    state.left_out = newest->labels().leftOut();
    state.error = newest->labelsError();
  }
  return state;
}

}  // namespace rviz_mesh_plugin
