#include "mesh_view/mesh_status.h"

#include <set>
#include <sstream>

#include "conversion/validation.h"
#include "rendering/mesh_style.h"

namespace rviz_mesh_plugin {
namespace {

const char* const GREY = "; until then the mesh is drawn in grey";

template <class... Parts>
std::string text(const Parts&... parts)
{
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

std::string join(const std::vector<std::string>& names)
{
  std::string joined;
  for (const std::string& name : names) {
    joined += (joined.empty() ? "'" : ", '") + name + "'";
  }
  return joined;
}

/// "1 layer", "2 layers"
std::string counted(std::size_t count, const char* one, const char* many)
{
  return text(count, " ", count == 1 ? one : many);
}

std::string refusals(const Reception& reception)
{
  return reception.refused == 0
             ? std::string()
             : text("; ", reception.refused, " of ",
                    counted(reception.received(), "message", "messages"), " refused",
                    reception.last_refusal.empty() ? "" : ", the last one: ",
                    reception.last_refusal);
}

/// What is the same for costs and colors: nullopt where all is well so far.
OptionalStatus attributeProblem(const AttributeState& state, const char* what,
                                const char* topic_property,
                                const std::optional<Finding>& wrong_count)
{
  if (!state.subscription_error.empty()) {
    return StatusLine{StatusLine::ERROR, state.subscription_error};
  }
  if (!state.reception.refusal.empty()) {
    return StatusLine{StatusLine::ERROR, text("message ignored: ", state.reception.refusal)};
  }
  if (wrong_count) {
    return StatusLine{StatusLine::ERROR, wrong_count->sentence() + GREY};
  }
  if (!state.chosen || state.size || !state.mesh_shown) {
    return std::nullopt;
  }
  if (state.topic.empty() && state.reception.received() == 0 && !state.topic_given) {
    return StatusLine{StatusLine::WARN, text("no topic chosen: set '", topic_property, "'", GREY)};
  }
  if (state.reception.received() == 0) {
    return StatusLine{
        StatusLine::WARN,
        text("no ", what, " received", state.topic.empty() ? std::string() : " on " + state.topic,
             " yet", GREY)};
  }
  return std::nullopt;
}

std::string waitingText(std::size_t waiting, const char* one, const char* many)
{
  return counted(waiting, one, many) + (waiting == 1 ? " waits for a geometry with its uuid"
                                                     : " wait for a geometry with their uuid");
}

}  // namespace

StatusLine topicStatus(const std::string& topic, const std::string& subscription_error,
                       const Reception& reception)
{
  if (!subscription_error.empty()) {
    return {StatusLine::ERROR, text("cannot subscribe to '", topic, "': ", subscription_error)};
  }
  if (topic.empty() && reception.accepted > 0) {
    return {StatusLine::OK, "no topic chosen; a service has brought the mesh"};
  }
  if (topic.empty()) {
    return {StatusLine::WARN,
            "no topic chosen: set 'Geometry Topic' to one of "
            "type mesh_msgs/MeshGeometryStamped"};
  }
  if (reception.received() == 0) {
    return {StatusLine::WARN, text("no message received on ", topic,
                                   " yet; is it published, as mesh_msgs/MeshGeometryStamped?")};
  }
  return {StatusLine::OK,
          counted(reception.received(), "message", "messages") + " received" + refusals(reception)};
}

OptionalStatus geometryStatus(const GeometryState& state)
{
  const MeshDataConstPtr& mesh = state.mesh;
  if (!state.error.empty()) {
    return StatusLine{StatusLine::ERROR, text("the mesh cannot be drawn: ", state.error)};
  }
  if (!state.reception.refusal.empty()) {
    return StatusLine{StatusLine::ERROR, text("message ignored: ", state.reception.refusal,
                                              mesh ? "; the mesh before it stays" : "")};
  }
  const std::string working = state.working.empty() ? std::string() : "; " + state.working;
  if (!mesh) {
    return working.empty() ? OptionalStatus() : StatusLine{StatusLine::OK, state.working};
  }
  const std::size_t stride = normalStride(mesh->vertexCount());
  std::string line =
      text(mesh->vertexCount(), " vertices, ", counted(mesh->faceCount(), "face", "faces"),
           ", normals ", mesh->normals_given ? "given" : "computed",
           state.normals_shown && stride > 1 ? text(" (one in ", stride, " is drawn)") : "",
           ", uuid '", mesh->uuid, "'");
  if (state.others > 0) {
    line += "; " + counted(state.others, "older mesh is", "older meshes are") + " shown too";
  }
  if (!state.drawn) {
    line += "; not drawn yet";
  } else if (state.preview) {
    line += "; a coarse picture is shown so far";
  } else if (state.progress < 1.0f) {
    line += text("; ", 10 * static_cast<int>(10.0f * state.progress), " % uploaded");
  }
  return StatusLine{StatusLine::OK, line + working};
}

OptionalStatus colorsStatus(const AttributeState& state)
{
  const auto wrong_count = state.size && state.mesh_shown
                               ? checkColorCount(*state.size, state.vertex_count)
                               : std::nullopt;
  if (auto problem = attributeProblem(state, "colors", "Vertex Colors Topic", wrong_count)) {
    return problem;
  }
  if (state.size) {
    return StatusLine{StatusLine::OK,
                      text(counted(*state.size, "color", "colors"), refusals(state.reception))};
  }
  if (state.waiting == 0) {
    return std::nullopt;
  }
  const bool missed = state.chosen && state.mesh_shown;
  return StatusLine{
      missed ? StatusLine::WARN : StatusLine::OK,
      waitingText(state.waiting, "set of colors", "sets of colors") + (missed ? GREY : "")};
}

OptionalStatus costsStatus(const CostsState& state)
{
  std::optional<Finding> wrong_count;
  if (state.size && state.mesh_shown) {
    wrong_count = state.on_faces ? checkFaceCostCount(*state.size, state.face_count)
                                 : checkCostCount(*state.size, state.vertex_count);
  }
  if (auto problem = attributeProblem(state, "costs", "Vertex Costs Topic", wrong_count)) {
    if (wrong_count && problem->level == StatusLine::ERROR) {
      problem->text = text("layer '", state.type, "': ", problem->text);
    }
    return problem;
  }
  if (!state.update_problem.empty()) {
    return StatusLine{StatusLine::ERROR, "update ignored: " + state.update_problem};
  }
  const std::string waiting =
      state.waiting > 0 ? "; " + waitingText(state.waiting, "layer", "layers") : "";
  if (!state.chosen || !state.mesh_shown) {
    if (state.types.empty() && state.waiting == 0) {
      return std::nullopt;
    }
    return StatusLine{StatusLine::OK, text(counted(state.types.size(), "layer", "layers"),
                                           state.types.empty() ? "" : ": ", join(state.types),
                                           waiting, refusals(state.reception))};
  }
  if (state.types.empty()) {
    return StatusLine{StatusLine::WARN, text("no layer of this mesh received", waiting, GREY)};
  }
  if (state.type.empty()) {
    return StatusLine{StatusLine::WARN, text("no layer chosen: set 'Vertex Costs Type' to one of ",
                                             join(state.types), GREY)};
  }
  if (!state.size) {
    return StatusLine{StatusLine::WARN, text("layer '", state.type, "' has not arrived; there are ",
                                             join(state.types), waiting, GREY)};
  }
  const CostSummary& summary = state.summary;
  std::string line =
      text("'", state.type, "': ", summary.finite, " costs from ", summary.limits.lower, " to ",
           summary.limits.upper, ", ", summary.lethal, " lethal, ", summary.unknown, " unknown",
           state.on_faces ? " (of faces)" : "");
  if (!state.note.empty()) {
    line += "; " + state.note;
  }
  if (state.stale_updates > 0) {
    line += "; " + counted(state.stale_updates, "update is", "updates are") +
            " left out, older by the stamp than what is shown";
  }
  if (state.limits.lower > state.limits.upper) {
    return StatusLine{StatusLine::WARN,
                      text(line, "; the lower limit ", state.limits.lower, " is above the upper ",
                           state.limits.upper, ": the scale runs backwards")};
  }
  return StatusLine{StatusLine::OK,
                    text(line, "; colors from ", state.limits.lower, " to ", state.limits.upper,
                         refusals(state.reception), refusals(state.updates_reception))};
}

OptionalStatus texturesStatus(const TexturesState& state)
{
  if (!state.subscription_error.empty()) {
    return StatusLine{StatusLine::ERROR, state.subscription_error};
  }
  for (const Reception* reception : {&state.materials_reception, &state.textures_reception}) {
    if (!reception->refusal.empty()) {
      return StatusLine{StatusLine::ERROR, text("message ignored: ", reception->refusal)};
    }
  }
  if (!state.materials) {
    return state.chosen && state.mesh_shown
               ? StatusLine{StatusLine::WARN, text("no materials of this mesh yet: set "
                                                   "'Materials Topic', or "
                                                   "'Material Service Name' to a service that "
                                                   "has them",
                                                   GREY)}
               : OptionalStatus();
  }
  const Materials& materials = *state.materials;
  if (state.mesh_shown) {
    if (const auto misfit = checkMaterialsFit(materials, state.vertex_count, state.face_count)) {
      return StatusLine{StatusLine::ERROR, misfit->sentence() + (state.chosen ? GREY : "")};
    }
  }
  std::set<std::uint32_t> named;
  for (const Material& material : materials.materials) {
    if (material.texture_index != NONE) {
      named.insert(material.texture_index);
    }
  }
  std::string line = text(counted(materials.materials.size(), "material", "materials"), " on ",
                          counted(materials.faces.size(), "face", "faces"), ", ", state.textures,
                          " of ", counted(named.size(), "texture", "textures"), " received");
  if (!named.empty() && materials.texture_coordinates.empty()) {
    return StatusLine{StatusLine::WARN,
                      line + "; without texture coordinates they cannot be drawn"};
  }
  if (state.textures < named.size()) {
    line += "; until the others come their faces have the color of the material";
  }
  const bool incomplete = state.textures < named.size();
  return StatusLine{
      incomplete && state.chosen ? StatusLine::WARN : StatusLine::OK,
      line + refusals(state.materials_reception) + refusals(state.textures_reception)};
}

OptionalStatus labelsStatus(const LabelsState& state)
{
  if (!state.error.empty()) {
    return StatusLine{StatusLine::ERROR, text("the labels cannot be drawn: ", state.error)};
  }
  if (!state.subscription_error.empty()) {
    return StatusLine{StatusLine::ERROR, state.subscription_error};
  }
  if (!state.reception.refusal.empty()) {
    return StatusLine{StatusLine::ERROR, text("message ignored: ", state.reception.refusal)};
  }
  if (!state.chosen || !state.mesh_shown) {
    return std::nullopt;
  }
  if (state.labels == 0) {
    return StatusLine{StatusLine::OK, "no label of this mesh received yet"};
  }
  const std::string line = counted(state.labels, "label", "labels");
  if (state.left_out > 0) {
    return StatusLine{StatusLine::WARN,
                      text(line, "; ",
                           counted(state.left_out, "face that the mesh does not have is",
                                   "faces that "
                                   "the mesh does not have are"),
                           " left out: were they labelled on "
                           "another mesh?")};
  }
  return StatusLine{StatusLine::OK, line + refusals(state.reception)};
}

}  // namespace rviz_mesh_plugin
