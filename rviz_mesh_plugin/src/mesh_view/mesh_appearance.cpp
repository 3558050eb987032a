#include "mesh_view/mesh_appearance.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "conversion/validation.h"
#include "incoming/mesh_loader.h"
#include "incoming/mesh_store.h"
#include "properties/cost_properties.h"
#include "properties/mesh_properties.h"
#include "rendering/mesh_texture.h"
#include "rendering/mesh_visual.h"
#include "sources/label_color_source.h"

namespace rviz_mesh_plugin {
namespace {

/// Whether a layout has, for each of these attributes, a vertex (or face) to
/// color.
bool fits(const LayoutOutline& layout, std::size_t count, bool on_faces)
{
  return on_faces ? layout.split == Split::BY_FACE && count == layout.mesh->faceCount()
                  : layout.split != Split::BY_FACE && count == layout.mesh->vertexCount();
}

/// Reads nothing beyond the end: OGRE may ask for the colors of a mesh that is
/// just being replaced.
ColorSource guarded(ColorSource source, std::size_t size)
{
  return [source = std::move(source), size](const std::uint32_t* sources, std::size_t count,
                                            Rgba8* colors) {
    const bool inside = count == 0 || *std::max_element(sources, sources + count) < size;
    if (inside) {
      source(sources, count, colors);
    } else {
      std::fill(colors, colors + count, Rgba8{153, 153, 153, 255});
    }
  };
}

}  // namespace

CostColoring commonColoring(const MeshStore& store, const std::string& layer, CostColoring coloring)
{
  for (const MeshDataConstPtr& mesh : store.meshes()) {
    coloring.least_lethal =
        std::min(coloring.least_lethal, store.layerInfo(mesh->uuid, layer).leastLethal());
  }
  if (coloring.custom_limits) {
    return coloring;
  }
  std::optional<CostLimits> common;
  for (const MeshDataConstPtr& mesh : store.meshes()) {
    const CostLayerConstPtr costs = store.attributes(mesh->uuid).cost(layer);
    if (!costs || costs->summary.finite == 0) {
      continue;
    }
    const CostLimits limits = limitsOf(coloring, costs->summary);
    common = common ? CostLimits{std::min(common->lower, limits.lower),
                                 std::max(common->upper, limits.upper)}
                    : limits;
  }
  if (common) {
    coloring.custom_limits = true;
    coloring.limits = *common;
  }
  return coloring;
}

CostColoring heightColoring(const MeshStore& store, CostColoring coloring)
{
  coloring.logarithmic = false;  // heights have no zero
  if (!coloring.custom_limits && !store.meshes().empty()) {
    Bounds bounds = Bounds::none();
    for (const MeshDataConstPtr& mesh : store.meshes()) {
      bounds.enclose(*mesh);
    }
    coloring.custom_limits = true;
    coloring.limits = {bounds.lower[2], bounds.upper[2]};
  }
  return coloring;
}

MeshAppearance::MeshAppearance(const Context& context, std::string uuid)
    : context_(context), uuid_(std::move(uuid)), labels_(context.parent)
{
}

MeshAppearance::~MeshAppearance() = default;

MeshDataConstPtr MeshAppearance::mesh() const
{
  return visual_ && visual_->shownLayout() ? visual_->shownLayout()->mesh : nullptr;
}

bool MeshAppearance::accepts(const MeshLayout& layout) const
{
  const LayoutOutlineConstPtr drawn = visual_ ? visual_->layout() : nullptr;
  if (!drawn || drawn->preview || drawn->mesh != layout.mesh) {
    return layout.mesh == context_.store.mesh(uuid_);
  }
  return requested_mesh_ == layout.mesh && !layout.preview && layout.split == requested_split_ &&
         layout.materials == requested_materials_ && layout.hidden == requested_hidden_;
}

void MeshAppearance::setLayout(const MeshLayoutConstPtr& layout)
{
  if (!accepts(*layout)) {
    return;
  }
  const bool taken = attempt([&] {
    if (!visual_) {
      visual_ = std::make_unique<MeshVisual>(context_.parent);
      visual_->setVisible(false);
    }
    const LayoutOutlineConstPtr before = visual_->layout();
    visual_->setLayout(layout);
    // Another mesh does not wait in the colors of the one before.
    at_hand_ = at_hand_ && before && before->mesh == layout->mesh;
    textures_.clear();  // freed with the layout before
  });
  if (taken) {
    geometry_error_.clear();
  }
  if (!layout->preview && layout->hidden != requested_hidden_) {
    requested_mesh_.reset();  // laid out with what was hidden before
  }
  paintMesh();
  setPose(pose_);
}

void MeshAppearance::paint()
{
  paintMesh();
  paintLabels();
}

void MeshAppearance::paintMesh()
{
  const bool waits = requestLayout();
  if (!visual_ || !visual_->layout()) {
    return;
  }
  painted_ = attempt([&] {
    const bool ready = paintAttributes();
    // A picture that is only being laid out anew stays as it is until then.
    const DisplayType type = context_.properties.displayType();
    const bool keep = waits && !ready && at_hand_ && type != DisplayType::FIXED_COLOR &&
                      type != DisplayType::HIDE_FACES;
    at_hand_ = ready || keep;
    MeshStyle style = context_.properties.style(at_hand_);
    if (keep) {
      style.faces = style_.faces;
      style.faces_color = style_.faces_color;
    } else if (!ready) {
      clearColors();
    }
    style_ = style;
    visual_->setStyle(style);
  });
}

bool MeshAppearance::requestLayout()
{
  const MeshDataConstPtr mesh = context_.store.mesh(uuid_);
  if (!mesh) {
    return false;
  }
  const MeshAttributes& attributes = context_.store.attributes(uuid_);
  const DisplayType type = context_.properties.displayType();
  Split split = Split::NONE;
  MaterialsConstPtr materials;
  if (type == DisplayType::VERTEX_COSTS) {
    const CostLayerConstPtr layer = attributes.cost(context_.properties.costs().costsType());
    if (layer && layer->on_faces && layer->costs.size() == mesh->faceCount()) {
      split = Split::BY_FACE;
    }
  } else if (type == DisplayType::TEXTURES && attributes.materials &&
             !checkMaterialsFit(*attributes.materials, mesh->vertexCount(), mesh->faceCount())) {
    split = Split::BY_MATERIAL;
    materials = attributes.materials;
  }
  const HiddenFacesConstPtr hidden = hiddenFaces(*mesh);
  const LayoutOutlineConstPtr drawn = visual_ ? visual_->layout() : nullptr;
  if (drawn && drawn->mesh == mesh) {
    visual_->hide(hidden);  // soon, as far as that goes, and then in the layout
  }
  if (drawn && !drawn->preview && drawn->mesh == mesh) {
    // Vertices that are split by material can be colored as well as those that
    // are not.
    const bool same = drawn->split == split && drawn->materials == materials;
    if ((same || (split == Split::NONE && drawn->split == Split::BY_MATERIAL)) &&
        drawn->hidden == hidden) {
      requested_mesh_.reset();
      return false;
    }
  }
  if (requested_mesh_ != mesh) {  // its message is being laid out without a split
    const bool is_drawn = drawn && !drawn->preview && drawn->mesh == mesh;
    requested_mesh_ = mesh;
    requested_split_ = is_drawn ? drawn->split : Split::NONE;
    requested_materials_.reset();
    requested_hidden_ = is_drawn ? drawn->hidden : hidden;
  }
  if (requested_split_ != split || requested_materials_ != materials ||
      requested_hidden_ != hidden) {
    requested_split_ = split;
    requested_materials_ = materials;
    requested_hidden_ = hidden;
    context_.loader.layOut(mesh, split, materials);
  }
  return true;
}

bool MeshAppearance::paintAttributes()
{
  costs_.reset();
  heights_ = false;
  switch (context_.properties.displayType()) {
    case DisplayType::VERTEX_COSTS:
      return paintCosts();
    case DisplayType::VERTEX_COLOR:
      return paintColors();
    case DisplayType::TEXTURES:
      return paintTextures();
    case DisplayType::HEIGHT:
    case DisplayType::CONTOUR_LINES:
      return paintHeights();
    default:
      return false;
  }
}

bool MeshAppearance::paintCosts()
{
  const CostProperties& properties = context_.properties.costs();
  const std::string name = properties.costsType();
  const CostLayerConstPtr layer = context_.store.attributes(uuid_).cost(name);
  if (!layer || !fits(*visual_->layout(), layer->costs.size(), layer->on_faces)) {
    return false;
  }
  costs_ = layer;
  const CostColoring coloring = commonColoring(context_.store, name, properties.coloring());
  const Colors colors{layer.get(), visual_->layout()->mesh.get(), coloring};
  if (!(colors == colors_)) {
    const ColorSource source = guarded(colorSource(layer, coloring), layer->costs.size());
    const bool same_but_costs =
        colors == Colors{layer.get(), colors_.mesh, colors_.coloring} && colors_.data;
    if (updated_ && same_but_costs) {
      visual_->updateColors(source, *updated_);
    } else {
      visual_->setColors(source, coloring.lethal.alpha < 255 || coloring.unknown.alpha < 255);
    }
    colors_ = colors;
  }
  return true;
}

void MeshAppearance::updateCosts(const CostLayerConstPtr& layer,
                                 const std::vector<std::uint32_t>& vertices)
{
  if (!costs_ || costs_->type != layer->type || costs_->on_faces) {
    return;  // another layer is shown, which may have changed as well: its vertices come next
  }
  const bool same = costs_->costs.size() == layer->costs.size() && colors_.data == costs_.get();
  updated_ = same && !vertices.empty() ? &vertices : nullptr;
  paintMesh();
  updated_ = nullptr;
}

bool MeshAppearance::paintHeights()
{
  const MeshDataConstPtr& mesh = visual_->layout()->mesh;
  heights_ = true;
  const CostColoring coloring =
      heightColoring(context_.store, context_.properties.costs().coloring());
  const Colors colors{mesh.get(), mesh.get(), coloring};
  if (!(colors == colors_)) {
    visual_->setColors(guarded(heightSource(mesh, coloring), mesh->vertexCount()), false);
    colors_ = colors;
  }
  return true;
}

bool MeshAppearance::paintColors()
{
  const ColorLayerConstPtr layer = context_.store.attributes(uuid_).colors;
  if (!layer || !fits(*visual_->layout(), layer->colors.size(), false)) {
    return false;
  }
  const Colors colors{layer.get(), visual_->layout()->mesh.get(), CostColoring()};
  if (!(colors == colors_)) {
    const bool translucent = std::any_of(layer->colors.begin(), layer->colors.end(),
                                         [](const Rgba8& color) { return color.alpha < 255; });
    const auto source = [layer](const std::uint32_t* sources, std::size_t count, Rgba8* values) {
      for (std::size_t i = 0; i < count; ++i) {
        values[i] = layer->colors[sources[i]];
      }
    };
    visual_->setColors(guarded(source, layer->colors.size()), translucent);
    colors_ = colors;
  }
  return true;
}

bool MeshAppearance::paintTextures()
{
  const LayoutOutlineConstPtr& layout = visual_->layout();
  const MeshAttributes& attributes = context_.store.attributes(uuid_);
  if (layout->split != Split::BY_MATERIAL || layout->materials != attributes.materials) {
    return false;
  }
  clearColors();
  for (const Material& material : layout->materials->materials) {
    const auto found = attributes.textures.find(material.texture_index);
    if (found == attributes.textures.end()) {
      continue;  // its color until it comes
    }
    TextureImageConstPtr& drawn = textures_[material.texture_index];
    if (drawn != found->second) {
      visual_->setTexture(found->second);
      drawn = found->second;
    }
  }
  return true;
}

void MeshAppearance::clearColors()
{
  visual_->clearColors();
  colors_ = Colors();
  if (context_.properties.displayType() != DisplayType::TEXTURES && !textures_.empty()) {
    visual_->clearTextures();
    textures_.clear();
  }
}

void MeshAppearance::paintLabels()
{
  labels_error_.clear();
  attemptLabels([&] {
    if (context_.properties.labelsShown()) {
      labels_.show(context_.store.mesh(uuid_), context_.store.attributes(uuid_).labels,
                   context_.properties.labelsAlpha(), context_.properties.section());
    } else {
      labels_.clear();
    }
  });
}

bool MeshAppearance::colorLabels(const LabelColorSource& sources)
{
  bool changed = false;
  attemptLabels([&] { changed = labels_.setOwnColors(sources.colors(uuid_)); });
  return changed;
}

bool MeshAppearance::upload(std::chrono::microseconds budget)
{
  const auto start = std::chrono::steady_clock::now();
  bool done = true;
  if (visual_ && attempt([&] { done = visual_->upload(budget); }) && done && painted_) {
    colors_error_.clear();
  }
  const auto left = budget - std::chrono::duration_cast<std::chrono::microseconds>(
                                 std::chrono::steady_clock::now() - start);
  attemptLabels([&] { done &= left.count() > 0 && labels_.upload(left); });
  return done;
}

void MeshAppearance::setPose(const std::optional<FramePose>& pose)
{
  pose_ = pose;
  labels_.setPose(pose);
  if (visual_) {
    visual_->place(pose);
  }
}

bool MeshAppearance::attempt(const std::function<void()>& work)
{
  const LayoutOutlineConstPtr layout = visual_ ? visual_->layout() : nullptr;
  try {
    work();
    return true;
  } catch (const std::exception& error) {  // Ogre::Exception, std::bad_alloc
    // A layout that cannot be drawn is given up.
    const bool given_up = !visual_ || !visual_->layout() || visual_->layout() != layout;
    (given_up ? geometry_error_ : colors_error_) = error.what();
    colors_ = Colors();
    painted_ = false;
    return false;
  }
}

void MeshAppearance::attemptLabels(const std::function<void()>& work)
{
  try {
    work();
  } catch (const std::exception& error) {  // Ogre::Exception, std::bad_alloc
    labels_.clear();
    labels_error_ = error.what();
  }
}

std::list<MeshAppearance>::iterator MeshAppearances::find(const std::string& uuid)
{
  return std::find_if(appearances_.begin(), appearances_.end(),
                      [&](const MeshAppearance& appearance) { return appearance.uuid() == uuid; });
}

void MeshAppearances::setLayouts(const std::vector<MeshLayoutConstPtr>& layouts)
{
  for (const MeshLayoutConstPtr& layout : layouts) {
    const auto appearance = find(layout->mesh->uuid);
    if (appearance != appearances_.end()) {
      appearance->setLayout(layout);
    }
  }
}

void MeshAppearances::paint()
{
  // In the order of the store; those that it no longer has come last.
  std::list<MeshAppearance> ordered;
  for (const MeshDataConstPtr& data : context_.store.meshes()) {
    const auto found = find(data->uuid);
    if (found != appearances_.end()) {
      ordered.splice(ordered.end(), appearances_, found);
    } else {
      ordered.emplace_back(context_, data->uuid);
    }
  }
  ordered.splice(ordered.end(), appearances_);
  appearances_.swap(ordered);
  retire();
  for (MeshAppearance& appearance : appearances_) {
    appearance.paint();
  }
}

void MeshAppearances::retire()
{
  const bool replaced =
      !context_.store.newest() || (newest() && (newest()->mesh() || !newest()->error().empty()));
  appearances_.remove_if([&](const MeshAppearance& appearance) {
    return !context_.store.mesh(appearance.uuid()) && (replaced || !appearance.mesh());
  });
}

bool MeshAppearances::colorLabels(const LabelColorSource& sources)
{
  bool changed = false;
  for (MeshAppearance& appearance : appearances_) {
    changed |= appearance.colorLabels(sources);
  }
  return changed;
}

void MeshAppearances::updateCosts(const CostLayerConstPtr& layer,
                                  const std::vector<std::uint32_t>& vertices)
{
  const auto appearance = find(layer->uuid);
  if (appearance != appearances_.end()) {
    appearance->updateCosts(layer, vertices);
  }
}

bool MeshAppearances::upload(std::chrono::microseconds budget)
{
  const auto start = std::chrono::steady_clock::now();
  const auto left = [&] {
    return budget - std::chrono::duration_cast<std::chrono::microseconds>(
                        std::chrono::steady_clock::now() - start);
  };
  MeshTexture::destroyLeft();
  bool done = true;
  for (MeshAppearance& appearance : appearances_) {
    // At least one slice of one mesh, so that there is always some progress.
    if (!done && left().count() <= 0) {
      break;
    }
    done &= appearance.upload(std::max(left(), std::chrono::microseconds(1)));
  }
  retire();
  return done;
}

void MeshAppearances::setPoses(const FindPose& find_pose)
{
  for (MeshAppearance& appearance : appearances_) {
    const MeshDataConstPtr drawn = appearance.mesh();
    const MeshDataConstPtr data = drawn ? drawn : context_.store.mesh(appearance.uuid());
    appearance.setPose(data ? find_pose(data->frame_id) : std::nullopt);
  }
}

}  // namespace rviz_mesh_plugin
