#include "osmesa_harness/render_fixture.h"

#include <OgreRenderTarget.h>
#include <OgreRenderWindow.h>
#include <ros/this_node.h>
#include <rviz/display.h>
#include <rviz/display_group.h>
#include <rviz/failed_display.h>
#include <rviz/properties/property.h>
#include <rviz/render_panel.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/visualization_manager.h>

#include <algorithm>
#include <cmath>

#include <QApplication>
#include <QColor>
#include <QElapsedTimer>
#include <QThread>

namespace osmesa_harness {
namespace {

constexpr const char* FIXED_FRAME = "map";
const QColor BACKGROUND(48, 48, 48);  // RViz's own default
constexpr int PAUSE_MILLISECONDS = 2;
constexpr int RESIZE_TIMEOUT_MILLISECONDS = 10000;
constexpr int FRAME_TIMEOUT_MILLISECONDS = 30000;

void processEvents()
{
  QApplication::processEvents(QEventLoop::AllEvents, 20);
  QThread::msleep(PAUSE_MILLISECONDS);
}

}  // namespace

/// RViz without its main window. Destroyed in the order that RViz's own main window keeps.
struct RenderFixture::Stage
{
  Stage() : panel(new rviz::RenderPanel), manager(new rviz::VisualizationManager(panel.get()))
  {
    panel->resize(DEFAULT_WIDTH, DEFAULT_HEIGHT);
    panel->initialize(manager->getSceneManager(), manager.get());
    manager->initialize();
    panel->show();
    manager->startUpdate();
  }

  ~Stage()
  {
    manager->stopUpdate();
    manager->removeAllDisplays();
    panel.reset();
    manager.reset();
  }

  std::unique_ptr<rviz::RenderPanel> panel;
  std::unique_ptr<rviz::VisualizationManager> manager;
};

std::unique_ptr<RenderFixture::Stage> RenderFixture::stage_;

void RenderFixture::SetUpTestSuite()
{
  if (!stage_) {
    stage_ = std::make_unique<Stage>();
  }
}

void RenderFixture::close()
{
  stage_.reset();
}

void RenderFixture::SetUp()
{
  ASSERT_TRUE(stage_) << "RViz could not be set up, see above";
  manager()->setFixedFrame(FIXED_FRAME);
  manager()
      ->getRootDisplayGroup()
      ->subProp("Global Options")
      ->subProp("Background Color")
      ->setValue(BACKGROUND);
  resizePanel(DEFAULT_WIDTH, DEFAULT_HEIGHT);
  viewFromAbove();
}

void RenderFixture::TearDown()
{
  if (stage_) {
    manager()->removeAllDisplays();
  }
}

rviz::VisualizationManager* RenderFixture::manager()
{
  return stage_->manager.get();
}

rviz::RenderPanel* RenderFixture::panel()
{
  return stage_->panel.get();
}

Ogre::SceneManager* RenderFixture::sceneManager()
{
  return manager()->getSceneManager();
}

void RenderFixture::spin(int milliseconds)
{
  spinUntil([] { return false; }, milliseconds);
}

bool RenderFixture::spinUntil(const std::function<bool()>& done, int timeout_milliseconds)
{
  QElapsedTimer timer;
  timer.start();
  while (!done()) {
    if (timer.elapsed() >= timeout_milliseconds) {
      return false;
    }
    processEvents();
  }
  return true;
}

void RenderFixture::spinFrames(int frames)
{
  const auto last = manager()->getFrameCount() + static_cast<std::uint64_t>(std::max(frames, 0));
  if (!spinUntil([last] { return manager()->getFrameCount() >= last; },
                 FRAME_TIMEOUT_MILLISECONDS)) {
    throw std::runtime_error("RViz drew no " + std::to_string(frames) + " frames within " +
                             std::to_string(FRAME_TIMEOUT_MILLISECONDS / 1000) + " s");
  }
}

rviz::Display* RenderFixture::createDisplay(const std::string& class_id, const std::string& name,
                                            bool enabled)
{
  rviz::Display* display =
      manager()->createDisplay(QString::fromStdString(class_id),
                               QString::fromStdString(name.empty() ? class_id : name), enabled);
  if (auto* failed = dynamic_cast<rviz::FailedDisplay*>(display)) {
    throw std::runtime_error("no display " + class_id + ": " +
                             failed->getDescription().toStdString());
  }
  return display;
}

void RenderFixture::viewFromAbove(double x, double y, double pixels_per_meter)
{
  manager()->getViewManager()->setCurrentViewControllerType("rviz/TopDownOrtho");
  rviz::ViewController* view = manager()->getViewManager()->getCurrent();
  view->subProp("X")->setValue(x);
  view->subProp("Y")->setValue(y);
  view->subProp("Angle")->setValue(0.0);
  view->subProp("Scale")->setValue(pixels_per_meter);
}

void RenderFixture::lookAt(const Point& eye, const Point& target)
{
  const double x = eye.x - target.x;
  const double y = eye.y - target.y;
  const double z = eye.z - target.z;
  const double distance = std::sqrt(x * x + y * y + z * z);
  if (!(distance > 0.0) || !std::isfinite(distance)) {
    throw std::invalid_argument("lookAt() needs an eye apart from its target");
  }
  manager()->getViewManager()->setCurrentViewControllerType("rviz/Orbit");
  rviz::ViewController* view = manager()->getViewManager()->getCurrent();
  view->subProp("Distance")->setValue(distance);
  view->subProp("Yaw")->setValue(std::atan2(y, x));
  view->subProp("Pitch")->setValue(std::asin(z / distance));
  rviz::Property* focal_point = view->subProp("Focal Point");
  focal_point->subProp("X")->setValue(target.x);
  focal_point->subProp("Y")->setValue(target.y);
  focal_point->subProp("Z")->setValue(target.z);
}

void RenderFixture::resizePanel(int width, int height)
{
  panel()->resize(width, height);
  const int even_width = width + width % 2;
  const auto has_followed = [even_width, height] {
    const Ogre::RenderWindow* window = panel()->getRenderWindow();
    return window->getWidth() == static_cast<unsigned int>(even_width) &&
           window->getHeight() == static_cast<unsigned int>(height);
  };
  if (!spinUntil(has_followed, RESIZE_TIMEOUT_MILLISECONDS)) {
    throw std::runtime_error("the render window did not follow its panel to " +
                             std::to_string(width) + " x " + std::to_string(height));
  }
}

Image RenderFixture::grab()
{
  // The first update may have been under way with what was set before.
  spinFrames(2);
  return grab(panel()->getRenderWindow());
}

Image RenderFixture::grab(Ogre::RenderTarget* target)
{
  // Without a swap: what the back buffer holds afterwards would be undefined.
  target->update(false);
  Image image(static_cast<int>(target->getWidth()), static_cast<int>(target->getHeight()));
  const Ogre::PixelBox pixels(target->getWidth(), target->getHeight(), 1, Ogre::PF_BYTE_RGB,
                              image.data());
  target->copyContentsToMemory(Ogre::Box(0, 0, target->getWidth(), target->getHeight()), pixels,
                               Ogre::RenderTarget::FB_AUTO);
  return image;
}

SceneCounts RenderFixture::counts()
{
  return countScene(sceneManager());
}

}  // namespace osmesa_harness
