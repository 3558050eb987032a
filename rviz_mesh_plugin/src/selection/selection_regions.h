#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include <mesh_map/bvh/selection/region.h>

#include "base/face_bits.h"
#include "base/mesh_data.h"
#include "mesh_view/shown_mesh.h"
#include "selection/face_selection.h"
#include "selection/selection_gestures.h"
#include "spatial/spatial_queries.h"

namespace Ogre {
class Camera;
class Viewport;
}  // namespace Ogre

namespace rviz_mesh_plugin {

class SelectableFaces;

/// What is selected in a picture, as parts of space, and the faces in them.

using PicturePoint = std::array<double, 2>;

/// A point of a picture, in pixels, in normalized device coordinates (y up).
/// @param viewport not empty
PicturePoint pointOf(const std::array<double, 2>& pixels, const Ogre::Viewport& viewport);
/// The middle of a pixel.
PicturePoint pointOf(const Pixel& pixel, const Ogre::Viewport& viewport);
std::vector<PicturePoint> pointsOf(const std::vector<Pixel>& pixels,
                                   const Ogre::Viewport& viewport);

/// What the camera sees between two corners in its picture.
/// @param mesh_to_clip see meshToClip()
mesh_map::ConvexRegion boxRegion(const PicturePoint& corner, const PicturePoint& opposite,
                                 const std::array<double, 16>& mesh_to_clip);

/// How many pixels a length has at a distance from the camera.
double pixelsOf(double length, double distance, const Ogre::Viewport& viewport);

/// In square meters.
double faceArea(const MeshData& mesh, std::uint32_t face);

/// Which faces of a mesh are to be found, of those that can be selected (SelectableFaces); owns
/// what it needs, for any thread.
struct FaceSearch
{
  ShownMesh shown;
  std::shared_ptr<const SpatialQueries> queries;
  std::vector<std::shared_ptr<const mesh_map::Region>> regions;  ///< what touches one of them
  std::array<double, 3> eye{};                                   ///< in the mesh
  bool visible_only = false;                                     ///< what the eye sees
  bool back_faces = true;                                        ///< false: not those from behind

  /// How many faces have to be looked at, at most; told in microseconds. Where each takes long (of
  /// a lasso, or to find out whether they are seen): the largest number there is.
  std::size_t most() const;

  /// A face that touches several regions is named for each.
  /// @throw Canceled (cancellation.h), std::bad_alloc
  FaceSelection::Faces operator()(const std::atomic<bool>* cancel = nullptr) const;
  /// The same as bits: takes no more memory where many regions lie on the same faces.
  FaceBits bits(const std::atomic<bool>* cancel = nullptr) const;

  /// Whether it depends on where one looks from.
  bool choosesBySight() const { return visible_only || !back_faces; }
  /// Of these faces (ascending) those that would be found: only the front ones, only what is seen
  /// in the regions, as it says. Where it chooses nothing by sight, all, wherever they are.
  /// @throw Canceled, std::bad_alloc
  FaceSelection::Faces chosenOf(FaceSelection::Faces faces,
                                const std::atomic<bool>* cancel = nullptr) const;

 private:
  FaceSelection::Faces selectableFacesIn(const mesh_map::Region& region,
                                         const SelectableFaces& selectable,
                                         const mesh_map::BvhOptions& run) const;
  FaceSelection::Faces facesIn(const mesh_map::Region& region,
                               const std::atomic<bool>* cancel) const;
  FaceSelection::Faces seenIn(const mesh_map::Region& region, FaceSelection::Faces faces,
                              const std::atomic<bool>* cancel) const;
};

}  // namespace rviz_mesh_plugin
