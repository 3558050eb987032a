#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <OgrePrerequisites.h>

#include "base/mesh_data.h"
#include "coloring/cost_coloring.h"
#include "level_of_detail/mesh_layout.h"
#include "mesh_view/mesh_labels.h"
#include "rendering/mesh_style.h"
#include "rendering/placed_visual.h"

namespace rviz_mesh_plugin {

class LabelColorSource;
class MeshLoader;
class MeshProperties;
class MeshStore;
class MeshVisual;

/// How a layer is colored on all meshes shown, so that one legend tells of all
/// of them: automatic limits span the costs of all, and are given as custom
/// ones.
CostColoring commonColoring(const MeshStore& store, const std::string& layer,
                            CostColoring coloring);
/// The same for heights.
CostColoring heightColoring(const MeshStore& store, CostColoring coloring);

/// Makes a MeshVisual show one mesh of a MeshStore in the way that
/// MeshProperties ask for; asks a MeshLoader for another layout where that
/// needs one, and goes on showing what it has until then. Draws its labels over
/// it. GUI thread only.
///
/// Where OGRE cannot take the data (memory), what is drawn stays and error()
/// says why; labels are taken away, and labelsError() says why.
class MeshAppearance
{
 public:
  /// All of them have to outlive the appearance.
  struct Context
  {
    const MeshStore& store;
    const MeshProperties& properties;
    MeshLoader& loader;
    Ogre::SceneNode* parent;
  };

  MeshAppearance(const Context& context, std::string uuid);
  ~MeshAppearance();

  const std::string& uuid() const { return uuid_; }

  /// Shows a layout of the mesh of this uuid, unless it is not (or no longer)
  /// asked for. What is new stays hidden until setPose().
  void setLayout(const MeshLayoutConstPtr& layout);

  /// Applies all that the properties ask for; colors that are the same as
  /// before are not uploaded.
  void paint();

  /// Follows a layer of the store in which the costs of some vertices have changed since it was
  /// painted. @param vertices colored anew, where the layer is shown; none: all
  void updateCosts(const CostLayerConstPtr& layer, const std::vector<std::uint32_t>& vertices);

  /// Gives labels the colors of their own that are known; returns whether one that is drawn
  /// changes.
  bool colorLabels(const LabelColorSource& sources);

  /// For about this long; true where nothing is left to upload.
  bool upload(std::chrono::microseconds budget);

  /// Where the mesh is drawn; not at all where that is not known.
  void setPose(const std::optional<FramePose>& pose);
  const std::optional<FramePose>& pose() const { return pose_; }

  /// The mesh whose picture is seen, which may be older than that of the store;
  /// null where there is none yet.
  MeshDataConstPtr mesh() const;
  MeshVisual* visual() const { return visual_.get(); }

  /// The cost layer that is drawn, null where none is, and how.
  const CostLayerConstPtr& costs() const { return costs_; }
  const CostColoring& coloring() const { return colors_.coloring; }

  /// Whether it is colored by its heights.
  bool showsHeights() const { return heights_; }

  /// Why the mesh, or its colors, cannot be drawn; empty where that went well since.
  const std::string& error() const
  {
    return geometry_error_.empty() ? colors_error_ : geometry_error_;
  }

  const MeshLabels& labels() const { return labels_; }
  /// Why they cannot be drawn; else empty.
  const std::string& labelsError() const { return labels_error_; }

 private:
  /// What the colors that have been uploaded were made from.
  struct Colors
  {
    const void* data = nullptr;
    const void* mesh = nullptr;
    CostColoring coloring;

    bool operator==(const Colors& other) const
    {
      return data == other.data && mesh == other.mesh && coloring == other.coloring;
    }
  };

  bool attempt(const std::function<void()>& work);
  void attemptLabels(const std::function<void()>& work);
  void paintMesh();
  void paintLabels();
  bool accepts(const MeshLayout& layout) const;
  bool requestLayout();
  bool paintAttributes();
  bool paintCosts();
  bool paintHeights();
  bool paintColors();
  bool paintTextures();
  void clearColors();

  const Context context_;
  const std::string uuid_;
  std::unique_ptr<MeshVisual> visual_;
  std::optional<FramePose> pose_;
  MeshStyle style_;
  MeshDataConstPtr requested_mesh_;
  MaterialsConstPtr requested_materials_;
  Split requested_split_ = Split::NONE;
  HiddenFacesConstPtr requested_hidden_;
  Colors colors_;
  CostLayerConstPtr costs_;
  bool heights_ = false;
  std::map<std::uint32_t, TextureImageConstPtr> textures_;  ///< that the visual has
  bool at_hand_ = false;
  std::string geometry_error_;  ///< of the layout that could not be drawn
  std::string colors_error_;
  bool painted_ = false;  ///< since the last error of colors
  /// Vertices that alone have to be colored anew if costs_ is shown as it was before.
  const std::vector<std::uint32_t>* updated_ = nullptr;
  MeshLabels labels_;
  std::string labels_error_;
};

/// Draws all meshes of a MeshStore, with their labels. GUI thread only.
///
/// A mesh that the store no longer has is seen until there is a picture of the
/// newest one.
class MeshAppearances
{
 public:
  explicit MeshAppearances(const MeshAppearance::Context& context) : context_(context) {}

  void setLayouts(const std::vector<MeshLayoutConstPtr>& layouts);

  /// Applies what store and properties say now.
  void paint();

  /// Gives labels the colors of their own that are known; returns whether one that is drawn
  /// changes.
  bool colorLabels(const LabelColorSource& sources);

  void updateCosts(const CostLayerConstPtr& layer, const std::vector<std::uint32_t>& vertices);

  /// For about this long; true where nothing is left to do.
  bool upload(std::chrono::microseconds budget);

  /// @param find_pose of a frame in the fixed frame, where it is known
  using FindPose = std::function<std::optional<FramePose>(const std::string& frame)>;
  void setPoses(const FindPose& find_pose);

  void clear() { appearances_.clear(); }

  /// Of each mesh, the newest first.
  const std::list<MeshAppearance>& appearances() const { return appearances_; }
  /// Null where there is none.
  const MeshAppearance* newest() const
  {
    return appearances_.empty() ? nullptr : &appearances_.front();
  }

 private:
  std::list<MeshAppearance>::iterator find(const std::string& uuid);
  void retire();

  const MeshAppearance::Context context_;
  std::list<MeshAppearance> appearances_;
};

}  // namespace rviz_mesh_plugin
