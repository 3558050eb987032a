#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/mesh_data.h"
#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {

/// Lines of text above a point of the scene, as large on the screen from wherever they are seen, on
/// translucent black. It is drawn over everything before and behind it, and nothing of it where its
/// point is outside of the picture. GUI thread only; needs a QGuiApplication, which has the fonts.
class SceneText
{
 public:
  /// @param parent outlives this; positions are those below it
  explicit SceneText(Ogre::SceneNode* parent);
  ~SceneText();
  SceneText(const SceneText&) = delete;
  SceneText& operator=(const SceneText&) = delete;

  /// Cheap where nothing has changed. @throw Ogre::Exception, std::bad_alloc
  /// @param frame of the color of what it names
  void show(const std::vector<std::string>& lines, const Rgba8& frame);
  void setPosition(const Ogre::Vector3& position);
  void setVisible(bool visible);
  /// From its place above the point, in pixels to the right and upwards.
  void setOffset(int right, int up);

  /// In pixels; 0 before something is shown.
  int width() const;
  int height() const;

 private:
  class Quad;
  Ogre::SceneNode* const node_;
  std::unique_ptr<Quad> quad_;
  std::vector<std::string> lines_;
  Rgba8 frame_;
};

}  // namespace rviz_mesh_plugin
