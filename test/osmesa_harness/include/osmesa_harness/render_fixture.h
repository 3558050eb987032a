#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "osmesa_harness/image.h"
#include "osmesa_harness/image_compare.h"
#include "osmesa_harness/scene_counts.h"

namespace Ogre {
class RenderTarget;
class SceneManager;
}  // namespace Ogre

namespace rviz {
class Display;
class RenderPanel;
class VisualizationManager;
}  // namespace rviz

namespace osmesa_harness {

/// Base of tests that draw with RViz's own classes, in this process.
///
/// All tests of a process share one RenderPanel and one VisualizationManager, because RViz does not
/// survive a second one: its materials have fixed names. Each test finds no displays, the fixed
/// frame "map", RViz's default background, a panel of the default size and the view from above of
/// 100 pixels a meter; there is no anti-aliasing. Tests use the GUI thread only. Needs a ROS master
/// and runTests().
class RenderFixture : public testing::Test
{
 public:
  static constexpr int DEFAULT_WIDTH = 640;
  static constexpr int DEFAULT_HEIGHT = 480;

  /// Destroys panel and manager; runTests() calls it after the last test.
  static void close();

 protected:
  static void SetUpTestSuite();
  void SetUp() override;
  void TearDown() override;

  static rviz::VisualizationManager* manager();
  static rviz::RenderPanel* panel();
  static Ogre::SceneManager* sceneManager();

  /// Lets Qt and RViz work for this long.
  static void spin(int milliseconds);

  /// Lets Qt and RViz work until @a done is true; false where it never was within the time.
  static bool spinUntil(const std::function<bool()>& done, int timeout_milliseconds = 10000);

  /// Lets RViz go through its update (displays, view, transforms) this many times, counted from
  /// now.
  static void spinFrames(int frames = 2);

  /// Creates a display as RViz does for its user, by class id as "rviz/Grid".
  /// @throw std::runtime_error with RViz's reason where the class cannot be loaded.
  static rviz::Display* createDisplay(const std::string& class_id, const std::string& name = "",
                                      bool enabled = true);

  /// The same, as the display's own class (its library linked into the test too).
  template <class DisplayClass>
  static DisplayClass* createDisplayAs(const std::string& class_id, const std::string& name = "",
                                       bool enabled = true)
  {
    auto* display = dynamic_cast<DisplayClass*>(createDisplay(class_id, name, enabled));
    if (!display) {
      throw std::runtime_error(class_id + " was loaded, but is not of the class the test expects");
    }
    return display;
  }

  /// Parallel projection from above, x to the right and y up; (x, y) in meters is the point in the
  /// middle of the window.
  static void viewFromAbove(double x = 0.0, double y = 0.0, double pixels_per_meter = 100.0);

  /// Perspective (45 degrees vertical, z up) from @a eye to @a target, both {x, y, z} in meters
  /// in the fixed frame.
  struct Point
  {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;
  };
  static void lookAt(const Point& eye, const Point& target);

  /// Resizes the panel and waits until its window follows. RViz makes odd widths even.
  static void resizePanel(int width, int height);

  /// Lets RViz update twice, draws one frame and reads the panel's window back.
  static Image grab();

  /// Draws one frame into a window or texture and reads it back.
  static Image grab(Ogre::RenderTarget* target);

  /// What OGRE holds now; call it after spinFrames() where displays have just changed.
  static SceneCounts counts();

 private:
  struct Stage;
  static std::unique_ptr<Stage> stage_;
};

}  // namespace osmesa_harness
