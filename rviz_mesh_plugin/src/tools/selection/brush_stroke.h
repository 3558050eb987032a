#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/mesh_data.h"
#include "picking/surface_picker.h"
#include "selection/selection_gestures.h"
#include "selection/selection_regions.h"
#include "tools/selection/frozen_view.h"
#include "tools/selection/selection_properties.h"

namespace rviz_mesh_plugin {

/// From one place of the cursor to the next, with the brush.
struct BrushMove
{
  std::shared_ptr<const FrozenView> view;
  Gesture gesture;
  SelectionSettings settings;
};

/// What the brush touches from the press of a button to its release: one mesh, the first that it
/// is on. GUI thread only.
class BrushStroke
{
 public:
  /// Adds what the brush touches on a move to a search, or returns why that is nothing. Moves are
  /// followed in their order. @param selected the mesh that has the selection
  std::string follow(const BrushMove& move, const SurfacePicker& picker,
                     const MeshDataConstPtr& selected, FaceSearch& search);

  /// Null: it has not touched any.
  const MeshDataConstPtr& mesh() const { return mesh_; }
  /// Where the last move has ended; none where no surface is there.
  const std::optional<SurfaceHit>& last() const { return last_; }

 private:
  MeshDataConstPtr mesh_;
  std::optional<SurfaceHit> last_;
};

/// Moves of one stroke whose faces are looked for together, so that no more than one search waits,
/// however long the stroke.
class BrushMoves
{
 public:
  BrushMoves(std::shared_ptr<BrushStroke> stroke, BrushMove first);

  /// Takes a move of that stroke, unless its faces have to be looked for by themselves.
  bool add(const std::shared_ptr<BrushStroke>& stroke, const BrushMove& move);

  /// Follows them for some milliseconds, one at least. Returns whether all have been.
  bool follow(const SurfacePicker& picker, const MeshDataConstPtr& selected);
  /// Of what has been followed; without regions: reason() says why.
  FaceSearch& search() { return search_; }
  const std::string& reason() const { return reason_; }

 private:
  std::shared_ptr<BrushStroke> stroke_;
  std::vector<BrushMove> moves_;
  std::size_t followed_ = 0;
  FaceSearch search_;
  std::string reason_;
};

}  // namespace rviz_mesh_plugin
