#include "displays/textured_mesh_display.h"

#include <algorithm>
#include <utility>

#include <rviz/config.h>
#include <rviz/display_context.h>

#include "conversion/attribute_conversion.h"
#include "mesh_view/frame_pose.h"
#include "properties/cost_properties.h"
#include "properties/mesh_properties.h"
#include "rendering/mesh_visual.h"

namespace rviz_mesh_plugin {
namespace {

/// An update uploads until it has taken so long in all, so that the GUI stays fluid.
constexpr std::chrono::milliseconds UPDATE_BUDGET{32};

}  // namespace

void PendingCosts::take(const std::vector<ChangedCosts>& costs, MeshStore& store)
{
  for (const ChangedCosts& taken : costs) {
    if (!store.changeCosts(taken.layer)) {
      continue;
    }
    Changed& changed = changed_[{taken.layer->uuid, taken.layer->type}];
    changed.layer = taken.layer;
    auto& vertices = changed.vertices;
    for (const CostUpdateConstPtr& update : taken.updates) {
      vertices.insert(vertices.end(), update->vertices.begin(), update->vertices.end());
    }
    changed.all |= taken.updates.empty() || vertices.size() > taken.layer->costs.size();
    if (changed.all) {
      vertices = std::vector<std::uint32_t>();
    }
  }
}

bool PendingCosts::show(Clock::time_point now, float rate, MeshAppearances& appearances)
{
  const std::chrono::duration<float> interval(1.0f / rate);
  if (changed_.empty() || now - shown_ < interval) {
    return false;
  }
  shown_ = now;
  for (const auto& changed : changed_) {
    appearances.updateCosts(changed.second.layer, changed.second.vertices);
  }
  changed_.clear();
  return true;
}

TexturedMeshDisplay::TexturedMeshDisplay()
    : properties_(new MeshProperties(this)), requests_(sources_, *properties_, store_), lines_(this)
{
}

void TexturedMeshDisplay::onInitialize()
{
  lines_.attempt([this] {
    appearances_ = std::make_unique<MeshAppearances>(
        MeshAppearance::Context{store_, *properties_, sources_.loader(), scene_node_});
    report_ = std::make_unique<MeshReport>(sources_, *properties_, store_, *appearances_, legend_,
                                           directory_);
    if (getClassId() == "rviz_mesh_plugin/TexturedMesh") {
      properties_->setAutomatic(true);  // until a file is loaded
    }
    connect(properties_, SIGNAL(sourceChanged()), SLOT(onSource()));
    connect(properties_, SIGNAL(contentChanged()), SLOT(onContent()));
    connect(properties_, SIGNAL(styleChanged()), SLOT(onContent()));
  });
}

void TexturedMeshDisplay::setSource(const MeshSource& source)
{
  lines_.attempt([&] { properties_->setSource(source); });
}

void TexturedMeshDisplay::beginAsReleased()
{
  properties_->setAutomatic(false);
}

MeshDataConstPtr TexturedMeshDisplay::mesh() const
{
  const MeshAppearance* newest = appearances_ ? appearances_->newest() : nullptr;
  return newest ? newest->mesh() : nullptr;
}

std::vector<ShownMesh> TexturedMeshDisplay::shownMeshes() const
{
  std::vector<ShownMesh> shown;
  if (isEnabled() && appearances_) {
    for (const MeshAppearance& appearance : appearances_->appearances()) {
      if (appearance.mesh() && appearance.pose()) {
        shown.push_back({*appearance.pose(), appearance.mesh(), getNameStd(), properties_->source(),
                         properties_->section(), hiddenFaces(*appearance.mesh())});
      }
    }
  }
  return shown;
}

bool TexturedMeshDisplay::has(const MeshDataConstPtr& mesh) const
{
  return mesh && appearances_ &&
         std::any_of(appearances_->appearances().begin(), appearances_->appearances().end(),
                     [&](const MeshAppearance& appearance) { return appearance.mesh() == mesh; });
}

MeshDataConstPtr TexturedMeshDisplay::drawn(const std::string& uuid) const
{
  if (appearances_) {
    for (const MeshAppearance& appearance : appearances_->appearances()) {
      if (appearance.mesh() && appearance.mesh()->uuid == uuid) {
        return appearance.mesh();
      }
    }
  }
  return nullptr;
}

Section TexturedMeshDisplay::section() const
{
  return properties_->section();
}

const MeshVisual* TexturedMeshDisplay::visual() const
{
  const MeshAppearance* newest = appearances_ ? appearances_->newest() : nullptr;
  return newest ? newest->visual() : nullptr;
}

void TexturedMeshDisplay::setTopic(const QString& topic, const QString& /*datatype*/)
{
  lines_.attempt([&] {
    properties_->setGeometryTopic(topic);
    directory_.propose(topic.toStdString());
  });
}

void TexturedMeshDisplay::load(const rviz::Config& config)
{
  lines_.attempt([&] {
    properties_->setAutomatic(false);  // what the file leaves out is what it always was
    const MeshProperties::Loading loading(*properties_);
    Display::load(config);
    properties_->loadOlderKeys(config);
  });
}

void TexturedMeshDisplay::onEnable()
{
  onSource();
  onContent();
}

void TexturedMeshDisplay::onDisable()
{
  lines_.attempt([this] {
    sources_.disconnect();
    label_colors_.disconnect();
    remark_.disconnect();
    layer_info_.disconnect();
    requests_.restart();
    legend_.hide();
    clearStatuses();
    lines_.forget();
  });
}

void TexturedMeshDisplay::reset()
{
  lines_.attempt([this] {
    Display::reset();
    lines_.forget();
    sources_.clear();
    label_colors_.clear();
    remark_.disconnect();
    layer_info_.disconnect();
    requests_.restart();
    costs_tell_ = false;
    store_.clear();
    pending_costs_.clear();
    if (appearances_) {
      appearances_->clear();
    }
    legend_.hide();
    received_ = QueuedAttributes();
  });
  onSource();
  onContent();
}

void TexturedMeshDisplay::onSource()
{
  source_changed_ = true;
  queueRender();
}

void TexturedMeshDisplay::onContent()
{
  content_changed_ = true;
  queueRender();
}

void TexturedMeshDisplay::update(float /*wall_dt*/, float /*ros_dt*/)
{
  lines_.repeat([this] { work(); });
}

void TexturedMeshDisplay::work()
{
  if (!report_) {
    return;  // onInitialize() has failed, and said why
  }
  const Clock::time_point end = Clock::now() + UPDATE_BUDGET;
  if (const auto topics = directory_.takeProposal()) {
    properties_->proposeTopics(QString::fromStdString(topics->costs),
                               QString::fromStdString(topics->colors));
  }
  if (source_changed_) {
    source_changed_ = false;
    const std::string geometry = properties_->names().topics[MeshMember::GEOMETRY];
    remark_.connect(threaded_nh_, geometry);
    layer_info_.connect(threaded_nh_, geometry);
    for (const MeshMember part : sources_.connect(threaded_nh_, properties_->names())) {
      store_.forget(part);
      content_changed_ = true;
    }
    requests_.restart();
  }
  takeMessages();
  requests_.update(Clock::now());
  offerChoices();
  if (const std::uint64_t revision = hiddenFacesRevision(); revision != hidden_revision_) {
    hidden_revision_ = revision;
    content_changed_ = true;
  }
  if (content_changed_) {
    content_changed_ = false;
    store_.setCapacity(properties_->bufferSize());
    appearances_->paint();
    uploading_ = true;
  }
  if (pending_costs_.show(Clock::now(), properties_->updateRate(), *appearances_)) {
    uploading_ = true;
  }
  followLabelColors();
  upload(end);
  updatePoses();
  updateLegend();
  report_->report(received_, working_, lines_);
  const auto remark = remark_.newest();
  lines_.report("Map", remarkStatus(remark ? remark->data : std::string()));
}

void TexturedMeshDisplay::takeMessages()
{
  const MeshLoader::Content loaded = sources_.loader().take();
  working_ = loaded.working;
  for (const MeshDataConstPtr& mesh : loaded.meshes) {
    if (store_.mesh(mesh->uuid) != mesh) {
      store_.addMesh(mesh);
      content_changed_ = true;
    }
  }
  QueuedAttributes content = sources_.queue().take();
  content.receptions[MeshMember::GEOMETRY] = loaded.reception;
  // Only the receptions are looked at later on.
  const auto take_all = [&](auto& items, auto add) {
    for (const auto& item : items) {
      (store_.*add)(item);
    }
    content_changed_ |= !items.empty();
    items.clear();
  };
  take_all(content.costs, &MeshStore::addCosts);
  take_all(content.colors, &MeshStore::addColors);
  take_all(content.materials, &MeshStore::addMaterials);
  take_all(content.textures, &MeshStore::addTexture);
  take_all(content.labels, &MeshStore::addLabels);
  pending_costs_.take(std::exchange(content.changed_costs, {}), store_);
  if (const auto info = layer_info_.newest(); info != shown_info_) {
    shown_info_ = info;
    store_.setLayerInfos(info ? info->uuid : std::string(), info ? convert(*info) : LayerInfos());
    content_changed_ = true;
  }
  if (!loaded.layouts.empty()) {
    appearances_->paint();  // there is an appearance for each mesh then
    appearances_->setLayouts(loaded.layouts);
    content_changed_ = true;
  }
  received_ = std::move(content);
}

void TexturedMeshDisplay::offerChoices()
{
  std::vector<std::string> types = store_.costTypes();
  if (const MeshDataConstPtr newest = store_.newest()) {
    for (const std::string& layer : sources_.services().layers(newest->uuid)) {
      if (std::find(types.begin(), types.end(), layer) == types.end()) {
        types.push_back(layer);
      }
    }
  }
  const MeshAttributes& attributes = store_.attributes();
  // Automatic goes to costs that tell something, and not away from them where all becomes free.
  if (attributes.uuid != costs_tell_of_) {
    costs_tell_of_ = attributes.uuid;
    costs_tell_ = false;
  }
  costs_tell_ |= std::any_of(attributes.costs.begin(), attributes.costs.end(),
                             [](const auto& layer) { return !layer->summary.isAllFree(); });
  const bool all_known = !attributes.costs.empty() && attributes.costs.size() >= types.size();
  properties_->setAvailable(attributes.colors != nullptr, attributes.materials != nullptr,
                            !types.empty(), costs_tell_ || !all_known);
  properties_->costs().setCostsTypes(types);
  cost_types_ = std::move(types);
}

void TexturedMeshDisplay::followLabelColors()
{
  if (!properties_->labelsShown()) {
    label_colors_.disconnect();
    lines_.report("Label colors", std::nullopt);
    return;
  }
  label_colors_.connect(threaded_nh_, labelNamespace(properties_->source()));
  for (const MeshDataConstPtr& mesh : store_.meshes()) {
    label_colors_.request(mesh->uuid);
  }
  uploading_ |= appearances_->colorLabels(label_colors_);
  lines_.report("Label colors", label_colors_.status());
}

void TexturedMeshDisplay::upload(Clock::time_point end)
{
  const auto left = std::chrono::duration_cast<std::chrono::microseconds>(end - Clock::now());
  const bool done = appearances_->upload(std::max(left, std::chrono::microseconds(0)));
  if (uploading_ || !done) {
    setVisibilityBits(getVisibilityBits());  // for the objects that are new
    queueRender();
  }
  uploading_ = !done;
}

void TexturedMeshDisplay::updatePoses()
{
  std::optional<StatusLine> line;
  appearances_->setPoses([&](const std::string& frame) {
    const std::string given = properties_->source().frame;
    StatusLine found;
    const auto pose =
        findPose(*context_->getFrameManager(), given.empty() ? frame : given, "the mesh is", found);
    if (!line || found.level > line->level) {
      line = found;
    }
    return pose;
  });
  lines_.report("Transform", line);
}

/// It is there while a cost layer, or heights, are drawn and the properties ask for it.
void TexturedMeshDisplay::updateLegend()
{
  const CostProperties& properties = properties_->costs();
  const auto& appearances = appearances_->appearances();
  const auto drawn = std::find_if(appearances.begin(), appearances.end(), [](const auto& each) {
    return each.costs() != nullptr || each.showsHeights();
  });
  if (drawn == appearances.end() || !properties.legend()) {
    legend_.hide();
    return;
  }
  const CostColoring& coloring = drawn->coloring();
  if (drawn->showsHeights()) {
    legend_.show({"Height", "m", coloring, coloring.limits, {}, false});
    return;
  }
  LegendContent content{properties.costsType(),
                        properties.unit(),
                        coloring,
                        limitsOf(coloring, drawn->costs()->summary),
                        {}};
  content.info = store_.layerInfo(drawn->costs()->uuid, content.layer);
  if (content.unit.empty()) {
    content.unit = content.info.unit;
  }
  legend_.show(content);
}

}  // namespace rviz_mesh_plugin
