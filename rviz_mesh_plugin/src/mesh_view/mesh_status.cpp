#include "mesh_view/mesh_status.h"

#include <set>

#include "conversion/validation.h"
#include "rendering/mesh_style.h"

namespace rviz_mesh_plugin {
namespace {

const char* const GREY = "; until then the mesh is drawn in grey";

/// A UUID has 36; this is far more than anybody reads.
constexpr std::size_t MOST_UUID_CHARACTERS = 200;

std::string listed(const std::vector<std::string>& names)
{
  std::string list;
  for (const std::string& name : names) {
    list += (list.empty() ? "'" : ", '") + name + "'";
  }
  return list;
}

std::string refusals(const Reception& reception)
{
  return reception.refused == 0
             ? std::string()
             : joined("; ", reception.refused, " of ",
                      counted(reception.received(), "message", "messages"), " refused",
                      reception.last_refusal.empty() ? "" : ", the last one: ",
                      reception.last_refusal);
}

/// Why nothing comes, or what came last is not used.
OptionalStatus receptionProblem(const AttributeState& state)
{
  if (!state.subscription_error.empty()) {
    return StatusLine::error(state.subscription_error);
  }
  if (!state.reception.refusal.empty()) {
    return StatusLine::error(state.reception.ignored());
  }
  return std::nullopt;
}

/// What is the same for costs and colors: nullopt where all is well so far.
OptionalStatus layerProblem(const ColorsState& state, const char* what, const char* topic_property,
                            const std::optional<Finding>& wrong_count)
{
  if (const OptionalStatus problem = receptionProblem(state)) {
    return problem;
  }
  if (wrong_count) {
    return StatusLine::error(wrong_count->sentence(), GREY);
  }
  if (!state.chosen || state.size || !state.mesh_shown || !state.reception.isEmpty()) {
    return std::nullopt;
  }
  if (state.topic.empty() && !state.topic_given) {
    return StatusLine::warn("no topic chosen: set '", topic_property, "'", GREY);
  }
  return StatusLine::warn("no ", what, " received", state.topic.empty() ? "" : " on ", state.topic,
                          " yet", GREY);
}

/// How many values are lethal, and why.
std::string lethalText(const CostsState& state)
{
  const std::string infinite = joined(state.summary.lethal, " ", state.info.infinity);
  if (state.info.comparison == LayerInfo::OTHER) {
    return joined(state.info.lethal, " lethal by a rule of the layer's own");
  }
  return state.info.hasThreshold()
             ? joined(state.info.lethal, " lethal (", lethalRule(state.info), ")")
             : infinite;
}

std::string waitingText(std::size_t waiting, const char* one, const char* many)
{
  return counted(waiting, one, many) + (waiting == 1 ? " waits for a geometry with its uuid"
                                                     : " wait for a geometry with their uuid");
}

/// What did not fit, and why; empty where all did.
std::string leftOutText(std::size_t count, const char* one, const char* many)
{
  return count == 0 ? std::string()
                    : joined("; ", counted(count, one, many), count == 1 ? " is" : " are",
                             " left out: those of a mesh take more than ",
                             MAX_ATTRIBUTE_BYTES >> 30, " GiB");
}

/// Where nothing of what has come belongs to the mesh that is shown: the way out.
std::string otherGeometry(const AttributeState& state)
{
  return "; that is " + quotedName(state.waiting_uuid) + ", but " + quotedName(state.uuid) +
         " is shown: choose topics of the same map, or have both published with the same uuid";
}

/// Why a mesh is not seen or told as it should be; else empty.
std::string geometryRemark(const MeshData& mesh)
{
  if (!mesh.remark.empty() || mesh.uuid.size() <= MOST_UUID_CHARACTERS) {
    return mesh.remark;
  }
  return joined("the uuid has ", mesh.uuid.size(), " characters, more than ", MOST_UUID_CHARACTERS,
                ", and is copied with each layer: give the map a UUID, which has 36");
}

}  // namespace

StatusLine topicStatus(const std::string& topic, const std::string& subscription_error,
                       const Reception& reception)
{
  if (!subscription_error.empty()) {
    return StatusLine::error("cannot subscribe to '", topic, "': ", subscription_error);
  }
  const std::string service =
      reception.answers == 0 ? "" : "the service " + reception.service + " has brought the mesh";
  if (topic.empty() && !service.empty()) {
    return StatusLine::ok("no topic chosen; ", service);
  }
  if (topic.empty()) {
    return StatusLine::warn(
        "no topic chosen: set 'Geometry Topic' to one of type mesh_msgs/MeshGeometryStamped");
  }
  if (reception.received() == 0 && !service.empty()) {
    return StatusLine::ok("no message received on ", topic, " yet; ", service);
  }
  if (reception.received() == 0) {
    return StatusLine::warn("no message received on ", topic,
                            " yet; is it published, as mesh_msgs/MeshGeometryStamped?");
  }
  return StatusLine::ok(counted(reception.received(), "message", "messages"), " received",
                        refusals(reception), service.empty() ? "" : "; before, " + service);
}

OptionalStatus geometryStatus(const GeometryState& state)
{
  const MeshDataConstPtr& mesh = state.mesh;
  if (!state.error.empty()) {
    return StatusLine::error("the mesh cannot be drawn: ", state.error);
  }
  if (!state.reception.refusal.empty()) {
    return StatusLine::error(state.reception.ignored(), mesh ? "; the mesh before it stays" : "");
  }
  const std::string working = state.working.empty() ? std::string() : "; " + state.working;
  if (!mesh) {
    return working.empty() ? OptionalStatus() : StatusLine::ok(state.working);
  }
  const std::size_t stride = normalStride(mesh->vertexCount());
  std::string line =
      joined(mesh->vertexCount(), " vertices, ", counted(mesh->faceCount(), "face", "faces"),
             ", normals ", mesh->normals_given ? "given" : "computed",
             state.normals_shown && stride > 1 ? joined(" (one in ", stride, " is drawn)") : "",
             ", uuid ", quotedName(mesh->uuid));
  if (state.others > 0) {
    line += "; " + counted(state.others, "older mesh is", "older meshes are") + " shown too";
  }
  if (!state.drawn) {
    line += "; not drawn yet";
  } else if (state.preview) {
    line += "; a coarse picture is shown so far";
  } else if (state.progress < 1.0f) {
    line += joined("; ", 10 * static_cast<int>(10.0f * state.progress), " % uploaded");
  }
  const std::string remark = geometryRemark(*mesh);
  return remark.empty() ? StatusLine::ok(line, working)
                        : StatusLine::warn(remark, "; ", line, working);
}

OptionalStatus colorsStatus(const ColorsState& state)
{
  const auto wrong_count = state.size && state.mesh_shown
                               ? checkColorCount(*state.size, state.vertex_count)
                               : std::nullopt;
  if (auto problem = layerProblem(state, "colors", "Vertex Colors Topic", wrong_count)) {
    return problem;
  }
  if (state.size) {
    return StatusLine::ok(counted(*state.size, "color", "colors"), refusals(state.reception));
  }
  if (state.waiting == 0) {
    return std::nullopt;
  }
  const std::string waiting = waitingText(state.waiting, "set of colors", "sets of colors");
  return state.mesh_shown
             ? StatusLine::warn(waiting, otherGeometry(state), state.chosen ? GREY : "")
             : StatusLine::ok(waiting);
}

OptionalStatus remarkStatus(const std::string& remark)
{
  return remark.empty() ? OptionalStatus() : StatusLine::warn(shortened(remark, 500));
}

OptionalStatus costsStatus(const CostsState& state)
{
  std::optional<Finding> wrong_count;
  if (state.size && state.mesh_shown) {
    wrong_count = checkCostCount(
        *state.size, state.on_faces ? state.face_count : state.vertex_count, state.on_faces);
  }
  if (auto problem = layerProblem(state, "costs", "Vertex Costs Topic", wrong_count)) {
    if (wrong_count && problem->level == StatusLine::ERROR) {
      problem->text = joined("layer '", state.type, "': ", problem->text);
    }
    return problem;
  }
  if (!state.update_problem.empty()) {
    return StatusLine::error("update ignored: ", state.update_problem);
  }
  const std::string waiting =
      state.waiting > 0 ? "; " + waitingText(state.waiting, "layer", "layers") : "";
  const std::string left_out = leftOutText(state.left_out, "layer", "layers");
  if (!state.chosen || !state.mesh_shown) {
    if (state.types.empty() && state.waiting == 0) {
      return std::nullopt;
    }
    if (state.types.empty() && state.mesh_shown) {
      return StatusLine::warn("no layer of this mesh received", waiting, otherGeometry(state));
    }
    return StatusLine::ok(counted(state.types.size(), "layer", "layers"),
                          state.types.empty() ? "" : ": ", listed(state.types), waiting, left_out,
                          refusals(state.reception));
  }
  if (state.types.empty()) {
    return StatusLine::warn("no layer of this mesh received", waiting,
                            state.waiting > 0 ? otherGeometry(state) : "", GREY);
  }
  if (state.type.empty()) {
    return StatusLine::warn("no layer chosen: set 'Vertex Costs Type' to one of ",
                            listed(state.types), GREY);
  }
  if (!state.size) {
    return StatusLine::warn(
        "layer '", state.type,
        state.chosen_left_out ? "' has given way to newer ones" + left_out : "' has not arrived",
        "; there are ", listed(state.types), waiting, GREY);
  }
  const CostSummary& summary = state.summary;
  std::string line =
      joined("'", state.type, "': ", summary.finite, " costs from ", summary.limits.lower, " to ",
             summary.limits.upper, ", ", lethalText(state), ", ", summary.unknown, " unknown",
             state.on_faces ? " (of faces)" : "");
  if (!state.note.empty()) {
    line += "; " + state.note;
  }
  if (state.stale_updates > 0) {
    line += "; " + counted(state.stale_updates, "update is", "updates are") +
            " left out, older by the stamp than what is shown";
  }
  if (state.limits.lower > state.limits.upper) {
    return StatusLine::warn(line, "; the lower limit ", state.limits.lower, " is above the upper ",
                            state.limits.upper, ": the scale runs backwards");
  }
  line += joined("; colors from ", state.limits.lower, " to ", state.limits.upper);
  return StatusLine{left_out.empty() ? StatusLine::OK : StatusLine::WARN,
                    line + left_out + (left_out.empty() ? "" : "; have fewer published") +
                        refusals(state.reception) + refusals(state.updates_reception)};
}

OptionalStatus texturesStatus(const TexturesState& state)
{
  if (const OptionalStatus problem = receptionProblem(state)) {
    return problem;
  }
  if (!state.textures_reception.refusal.empty()) {
    return StatusLine::error(state.textures_reception.ignored());
  }
  if (!state.materials) {
    if (!state.chosen || !state.mesh_shown) {
      return std::nullopt;
    }
    return StatusLine::warn(
        "no materials of this mesh yet: set 'Materials Topic', or 'Material Service Name' to a "
        "service that has them",
        GREY);
  }
  const Materials& materials = *state.materials;
  if (state.mesh_shown) {
    if (const auto misfit = checkMaterialsFit(materials, state.vertex_count, state.face_count)) {
      return StatusLine::error(misfit->sentence(), state.chosen ? GREY : "");
    }
  }
  std::set<std::uint32_t> named;
  for (const Material& material : materials.materials) {
    if (material.texture_index != NONE) {
      named.insert(material.texture_index);
    }
  }
  std::string line = joined(counted(materials.materials.size(), "material", "materials"), " on ",
                            counted(materials.faces.size(), "face", "faces"), ", ", state.textures,
                            " of ", counted(named.size(), "texture", "textures"), " received");
  if (!named.empty() && materials.texture_coordinates.empty()) {
    return StatusLine::warn(line, "; without texture coordinates they cannot be drawn");
  }
  const bool incomplete = state.textures < named.size();
  if (state.textures + state.textures_left_out < named.size()) {
    line += "; until the others come their faces have the color of the material";
  }
  if (state.textures_left_out > 0) {
    line += leftOutText(state.textures_left_out, "texture", "textures") +
            "; have smaller images published; " + (state.textures_left_out == 1 ? "its" : "their") +
            " faces have the color of the material";
  }
  return StatusLine{incomplete && state.chosen ? StatusLine::WARN : StatusLine::OK,
                    line + refusals(state.reception) + refusals(state.textures_reception)};
}

OptionalStatus sectionStatus(bool shown, const Section& section, const MeshData* mesh, bool empty)
{
  if (!shown) {
    return std::nullopt;
  }
  constexpr struct
  {
    const char* name;
    std::size_t axis;
  } SIDES[] = {{"height", 2}, {"x", 0}, {"y", 1}};
  std::string reach, kept, turned;
  for (const auto& side : SIDES) {
    const float lower = section.lower[side.axis], upper = section.upper[side.axis];
    const std::string name = side.name;
    if (mesh) {
      reach += (reach.empty() ? "; the mesh reaches from " : ", ") + name + " " +
               joined(mesh->lower[side.axis], " to ", mesh->upper[side.axis], " m");
    }
    if (lower > upper) {
      turned += (turned.empty() ? "" : ", ") + name + " from " + joined(lower, " to ", upper, " m");
    } else if (std::isfinite(lower) || std::isfinite(upper)) {
      kept += (kept.empty() ? "" : ", ") + name;
      kept += std::isfinite(lower) ? joined(" from ", lower, std::isfinite(upper) ? "" : " m") : "";
      kept += std::isfinite(upper) ? joined(" to ", upper, " m") : "";
    }
  }
  if (!turned.empty()) {
    return StatusLine::warn("nothing is drawn: no ", turned, ": turn the limits round", reach);
  }
  if (kept.empty()) {
    return StatusLine::ok("nothing is cut away: no limit is set", reach);
  }
  if (mesh && !section.touches(*mesh)) {
    return StatusLine::warn("all of the mesh is cut away but ", kept, reach);
  }
  if (mesh && empty) {
    return StatusLine::warn("nothing is drawn: no face of the mesh is at ", kept, reach);
  }
  return StatusLine::ok("the mesh is cut: what is drawn, pointed at and selected is ", kept, reach);
}

OptionalStatus hiddenStatus(const std::vector<MeshDataConstPtr>& meshes, bool section_hidden)
{
  std::size_t hidden = 0, all = 0;
  for (const MeshDataConstPtr& mesh : meshes) {
    const HiddenFacesConstPtr of_mesh = hiddenFaces(*mesh);
    hidden += of_mesh ? of_mesh->count() : 0;
    all += mesh->faceCount();
  }
  if (hidden == 0) {
    return std::nullopt;
  }
  const std::string way_out =
      ": 'Show All' in the panel ClusterLabel, or Ctrl+H with its tool, shows them";
  if (hidden == all) {
    return StatusLine::warn("nothing is drawn: all ", counted(all, "face is", "faces are"),
                            " hidden", way_out);
  }
  const std::string some = joined(hidden, " of ", counted(all, "face is", "faces are"), " hidden");
  return section_hidden
             ? StatusLine::warn("nothing is drawn: ", some, ", all of the section", way_out)
             : StatusLine::ok(some, way_out);
}

OptionalStatus labelsStatus(const LabelsState& state)
{
  if (!state.error.empty()) {
    return StatusLine::error("the labels cannot be drawn: ", state.error);
  }
  if (const OptionalStatus problem = receptionProblem(state)) {
    return problem;
  }
  if (!state.chosen || !state.mesh_shown) {
    return std::nullopt;
  }
  if (state.labels == 0 && state.waiting > 0) {
    return StatusLine::warn("no label of this mesh received; ",
                            waitingText(state.waiting, "label", "labels"), otherGeometry(state));
  }
  if (state.labels == 0) {
    return StatusLine::ok("no label of this mesh received yet");
  }
  const std::string line = counted(state.labels, "label", "labels");
  if (state.left_out > 0) {
    return StatusLine::warn(line, "; ",
                            counted(state.left_out, "face that the mesh does not have is",
                                    "faces that the mesh does not have are"),
                            " left out: were they labelled on another mesh?");
  }
  return StatusLine::ok(line, refusals(state.reception));
}

}  // namespace rviz_mesh_plugin
