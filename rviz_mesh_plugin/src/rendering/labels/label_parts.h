#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <vector>

#include <OgreHardwareIndexBuffer.h>

#include "base/mesh_data.h"
#include "level_of_detail/overlay_levels.h"
#include "rendering/labels/label_vertices.h"

namespace rviz_mesh_plugin {

/// So many faces are drawn, looked for and changed at once within a few milliseconds. Where there
/// are more, that is done on a thread, and they are drawn in levels of detail.
constexpr std::size_t MANY_FACES = 100000;

/// The index buffers of some faces of a mesh, part by part, each in levels of detail. What they
/// contain is made on the thread of the vertices, in portions, and uploaded by the GUI thread, to
/// which all of this belongs. Of faces that are set faster than that, the last ones follow.
class LabelParts
{
 public:
  /// Made on the thread. @throw std::bad_alloc
  using MakeFaces = std::function<FaceBits()>;

  /// @param vertices outlive it, and keep their mesh as long
  /// @param changing whether faces will be set often: then a bit of each is kept, and only parts
  /// in which one changes are made anew
  LabelParts(LabelVertices& vertices, bool changing) : vertices_(vertices), changing_(changing) {}
  ~LabelParts() { *dropped_ = true; }
  LabelParts(const LabelParts&) = delete;
  LabelParts& operator=(const LabelParts&) = delete;

  void setFaces(MakeFaces faces);

  /// All is uploaded: of the faces that were set last.
  bool isComplete() const { return !wanted_ && !isMaking() && coming_.empty() && last_; }
  /// Some set of faces has been complete, so that there is something to be drawn.
  bool isDrawable() const { return drawable_; }
  /// Nothing can be done at the moment but by the thread.
  bool isWaiting() const { return coming_.empty() && (isMaking() ? !isMade() : !wanted_ && last_); }

  /// Uploads at most @a left bytes (but one part at least, if there is one), and takes that off it;
  /// returns how many. @throw Ogre::Exception, and what the thread has thrown: std::bad_alloc,
  /// Canceled
  std::size_t upload(std::size_t& left);

  std::size_t gpuBytes() const;

  /// What is drawn of a part of levels().
  struct Part
  {
    Ogre::HardwareIndexBufferSharedPtr buffer;
    std::vector<IndexRange> levels;  ///< the full one first
    bool whole = false;              ///< all of its faces
  };
  /// By number.
  const std::map<std::size_t, Part>& parts() const { return parts_; }
  /// Null before anything is drawable.
  const OverlayLevelsConstPtr& levels() const { return levels_; }

 private:
  struct Portion
  {
    OverlayLevelsConstPtr levels;
    std::vector<PartFaces> parts;
    bool last = true;
  };
  struct Work;

  bool isMaking() const { return portion_.valid(); }
  bool isMade() const;
  void start();
  void take();
  std::size_t upload(const PartFaces& faces);

  LabelVertices& vertices_;
  const bool changing_;
  const std::shared_ptr<std::atomic<bool>> dropped_ = std::make_shared<std::atomic<bool>>(false);
  MakeFaces wanted_;              ///< null: those that the thread has
  std::shared_ptr<Work> work_;    ///< the thread's while it is making, and else nobody's
  std::future<Portion> portion_;  ///< being made
  std::deque<PartFaces> coming_;
  bool last_ = true;  ///< no portion is left to be made after the one that was taken
  bool drawable_ = false;
  OverlayLevelsConstPtr levels_;
  std::map<std::size_t, Part> parts_;
};

}  // namespace rviz_mesh_plugin
