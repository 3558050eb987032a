#pragma once

#include <functional>
#include <memory>
#include <string>

#include <OgrePrerequisites.h>

#include "rviz_mesh_plugin/color_scale.h"

namespace rviz_mesh_plugin {

class MeshProperties;
class MeshStore;
class MeshVisual;

/// Makes a MeshVisual show what a MeshStore holds, in the way that MeshProperties ask for. GUI
/// thread only.
///
/// Where OGRE cannot take the data (memory), nothing is drawn and error() says why.
class MeshPainter
{
 public:
  /// All of them have to outlive the painter.
  MeshPainter(const MeshStore& store, const MeshProperties& properties,
              Ogre::SceneManager* scene_manager, Ogre::SceneNode* parent);
  ~MeshPainter();

  /// Uploads the mesh of the store with its colors; without a mesh, the same as clear(). What is
  /// new stays hidden until MeshVisual::setVisible().
  void paintGeometry();

  /// Uploads the colors that the properties ask for, or frees them where none are asked for or at
  /// hand.
  void paintColors();

  /// Applies what needs no colors.
  void paintStyle();

  void clear();

  /// Null where nothing is drawn.
  MeshVisual* visual() const { return visual_.get(); }

  /// Of the cost layer that was painted last, and the limits that its colors span.
  const CostSummary& costSummary() const { return cost_summary_; }
  const CostLimits& costLimits() const { return cost_limits_; }

  /// Empty where all went well.
  const std::string& error() const { return error_; }

 private:
  void attempt(const std::function<void()>& upload);
  bool uploadCosts();
  bool uploadColors();

  const MeshStore& store_;
  const MeshProperties& properties_;
  Ogre::SceneManager* scene_manager_;
  Ogre::SceneNode* parent_;
  std::unique_ptr<MeshVisual> visual_;
  CostSummary cost_summary_;
  CostLimits cost_limits_;
  bool colors_shown_ = false;
  std::string error_;
};

}  // namespace rviz_mesh_plugin
