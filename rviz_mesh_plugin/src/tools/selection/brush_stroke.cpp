#include "tools/selection/brush_stroke.h"

#include <chrono>
#include <utility>

#include "tools/selection/brush_path.h"
#include "tools/selection/search_target.h"

namespace rviz_mesh_plugin {
namespace {

/// So long moves are followed in one frame.
constexpr std::chrono::milliseconds FOLLOWING_BUDGET{15};

}  // namespace

std::string BrushStroke::follow(const BrushMove& move, const SurfacePicker& picker,
                                const MeshDataConstPtr& selected, FaceSearch& search)
{
  const auto& event = move.view->event();
  BrushPath path = followBrush(picker, move.view->viewport(), move.gesture,
                               std::exchange(last_, std::nullopt), move.settings);
  last_ = std::move(path.last);
  if (path.hits.empty()) {
    return picker.pick(event, move.settings.back_faces).reason;
  }
  if (!mesh_) {
    mesh_ = move.gesture.adding ? path.hits.front().mesh : selected;
  }
  bool is_on_it = false;
  for (const SurfaceHit& hit : path.hits) {
    if (hit.mesh != mesh_) {
      continue;
    }
    if (search.regions.empty()) {
      search = searchIn(hit, event, move.settings);
    }
    search.regions.push_back(
        std::make_shared<mesh_map::SphereRegion>(hit.point, move.settings.radius));
    is_on_it = true;
  }
  if (is_on_it) {
    return {};
  }
  return mesh_ ? "the brush stays on the mesh that it touched first"
               : "nothing is selected that could be deselected";
}

BrushMoves::BrushMoves(std::shared_ptr<BrushStroke> stroke, BrushMove first)
    : stroke_(std::move(stroke)), moves_{std::move(first)}
{
}

bool BrushMoves::add(const std::shared_ptr<BrushStroke>& stroke, const BrushMove& move)
{
  const BrushMove& last = moves_.back();
  if (stroke != stroke_ || move.settings.visible_only != last.settings.visible_only ||
      move.settings.back_faces != last.settings.back_faces || !move.view->looksAs(*last.view)) {
    return false;
  }
  moves_.push_back(move);
  return true;
}

bool BrushMoves::follow(const SurfacePicker& picker, const MeshDataConstPtr& selected)
{
  const auto end = std::chrono::steady_clock::now() + FOLLOWING_BUDGET;
  while (followed_ < moves_.size()) {
    reason_ = stroke_->follow(moves_[followed_++], picker, selected, search_);
    if (std::chrono::steady_clock::now() >= end) {
      break;
    }
  }
  return followed_ == moves_.size();
}

}  // namespace rviz_mesh_plugin
