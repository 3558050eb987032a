#include "tools/selection/selection_session.h"

#include <algorithm>
#include <utility>

#include <OgreSceneManager.h>

#include "base/geometry_identity.h"
#include "selection/selection_regions.h"

namespace rviz_mesh_plugin {
namespace {

/// Faces whose areas are added up at once.
constexpr std::size_t COUNT_SLICE = 50000;

}  // namespace

SelectionSession::SelectionSession(Ogre::SceneManager* scene_manager,
                                   const std::function<void()>& on_change)
    : on_change_(on_change), visual_(scene_manager->getRootSceneNode())
{
}

void SelectionSession::setMesh(const MeshDataConstPtr& mesh)
{
  if (mesh == mesh_) {
    return;
  }
  bool changes = !selection_.empty();
  if (mesh && isAwaited(*mesh)) {
    selection_ = std::move(awaited_selection_);
    changes = true;
  } else {
    selection_.reset(mesh ? mesh->faceCount() : 0);
  }
  if (mesh) {
    forgetAwaited();
  }
  mesh_ = mesh;
  counted_ = 0;
  count();
  visual_failed_ = true;  // until it has been told
  visual_.setMesh(mesh);
  if (!selection_.empty()) {
    visual_.setSelection(selection_);
  }
  visual_failed_ = false;
  if (changes) {
    on_change_();
  }
}

void SelectionSession::setAside()
{
  MeshDataConstPtr mesh;
  FaceSelection selection;
  const bool worth_it = !selection_.empty() || selection_.canUndo() || selection_.canRedo();
  if (mesh_ && worth_it) {
    mesh = mesh_;
    selection = selection_;
  }
  setMesh(nullptr);
  awaited_ = std::move(mesh);
  awaited_selection_ = std::move(selection);
}

bool SelectionSession::isAwaited(const MeshData& mesh) const
{
  return awaited_ && identityOf(mesh) == identityOf(*awaited_);
}

void SelectionSession::forgetAwaited()
{
  awaited_.reset();
  awaited_selection_ = FaceSelection();
}

bool SelectionSession::change(const Make& make)
{
  const FaceSelection::Change& change = make(selection_);
  if (change.empty()) {
    return false;
  }
  try {
    countChange(change);
    showChange(change);
  } catch (...) {
    visual_failed_ = true;
    on_change_();
    throw;
  }
  on_change_();
  return true;
}

std::string SelectionSession::undo()
{
  change(&FaceSelection::undo);
  return {};
}

std::string SelectionSession::redo()
{
  change(&FaceSelection::redo);
  return {};
}

std::optional<double> SelectionSession::area() const
{
  return counted_ < selection_.size() ? std::nullopt : std::optional<double>(area_);
}

/// Large changes are counted later: the highlight comes first.
void SelectionSession::countChange(const FaceSelection::Change& change)
{
  if (!area() || selection_.empty() || change.count() > COUNT_SLICE) {
    counted_ = 0;
    return;
  }
  for (const auto face : change.added()) {
    area_ += faceArea(*mesh_, face);
  }
  for (const auto face : change.removed()) {
    area_ -= faceArea(*mesh_, face);
  }
}

/// Adds up the area of some faces.
void SelectionSession::count()
{
  area_ = counted_ == 0 ? 0.0 : area_;
  const auto size = static_cast<std::uint32_t>(selection_.size());
  std::size_t left = COUNT_SLICE;
  for (; counted_ < size && left > 0; counted_ = std::min(size, counted_ + FaceBits::BITS)) {
    const FaceBits::Word word = selection_.bits().word(counted_ / FaceBits::BITS);
    FaceBits::visitBits(word, counted_,
                        [&](std::uint32_t face) { area_ += faceArea(*mesh_, face); });
    left -= std::min(left, FaceBits::countOf(word));
  }
}

void SelectionSession::showChange(const FaceSelection::Change& change)
{
  if (!visual_failed_) {
    visual_.apply(selection_, change);
    return;
  }
  if (visual_.mesh() != mesh_) {
    visual_.setMesh(mesh_);
  }
  visual_.setSelection(selection_);
  visual_failed_ = false;
}

void SelectionSession::follow(const std::vector<ShownMesh>& shown)
{
  if (!area()) {
    count();
  }
  try {
    visual_.follow(shown, selection_);
    visual_.upload();
  } catch (...) {
    visual_failed_ = true;
    throw;
  }
}

}  // namespace rviz_mesh_plugin
