// Windows and textures other than the panel in its first size.
#include <osmesa_harness/back_end.h>
#include <osmesa_harness/render_fixture.h>

#include <OgreCamera.h>
#include <OgreHardwarePixelBuffer.h>
#include <OgreRenderTexture.h>
#include <OgreRenderWindow.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTextureManager.h>
#include <OgreViewport.h>
#include <rviz/display.h>
#include <rviz/properties/property.h>
#include <rviz/render_panel.h>
#include <rviz/visualization_manager.h>

#include <dlfcn.h>

#include <memory>

#include <QColor>
#include <QGuiApplication>
#include <QPixmap>
#include <QScreen>

using osmesa_harness::Image;
using osmesa_harness::Rgb;

namespace {

const Rgb BACKGROUND{48, 48, 48};
const Rgb ORANGE{255, 128, 0};
const Rgb BLUE{0, 0, 255};

class Targets : public osmesa_harness::RenderFixture
{
 protected:
  // An orange cross in the origin, its bars 20 cm wide.
  void SetUp() override
  {
    RenderFixture::SetUp();
    rviz::Display* grid = createDisplay("rviz/Grid");
    grid->subProp("Plane Cell Count")->setValue(2);
    grid->subProp("Line Style")->setValue("Billboards");
    grid->subProp("Line Style")->subProp("Line Width")->setValue(0.2);
    grid->subProp("Color")->setValue(QColor(255, 128, 0));
    grid->subProp("Alpha")->setValue(1.0);
  }

  // A camera 10 m above the origin, looking down.
  static Ogre::Camera* createCamera(const std::string& name, float aspect_ratio)
  {
    Ogre::Camera* camera = sceneManager()->createCamera(name);
    camera->setProjectionType(Ogre::PT_ORTHOGRAPHIC);
    camera->setAspectRatio(aspect_ratio);
    camera->setOrthoWindowHeight(4.0F);
    camera->setNearClipDistance(0.1F);
    Ogre::SceneNode* node = sceneManager()->getRootSceneNode()->createChildSceneNode();
    node->setPosition(0.0F, 0.0F, 10.0F);
    node->attachObject(camera);
    return camera;
  }

  static void destroyCamera(Ogre::Camera* camera)
  {
    Ogre::SceneNode* node = camera->getParentSceneNode();
    node->detachAllObjects();
    sceneManager()->destroySceneNode(node);
    sceneManager()->destroyCamera(camera);
  }
};

TEST_F(Targets, a_resized_window_is_drawn_in_its_new_size)
{
  for (const auto& size : {std::make_pair(800, 600), std::make_pair(322, 243)}) {
    resizePanel(size.first, size.second);
    const Image image = grab();
    ASSERT_EQ(image.width(), size.first);
    ASSERT_EQ(image.height(), size.second);
    // The cross is still in the middle, as wide as before, and reaches 1 m in each direction.
    EXPECT_EQ(image.center(), ORANGE);
    EXPECT_EQ(image.at(size.first / 2 + 95, size.second / 2), ORANGE);
    EXPECT_EQ(image.at(size.first / 2, size.second / 2 - 95), ORANGE);
    EXPECT_EQ(image.at(size.first - 1, size.second - 1), BACKGROUND);
    EXPECT_EQ(image.at(0, 0), BACKGROUND);
    EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("resized_" + std::to_string(size.first), image));
  }
}

TEST_F(Targets, the_very_next_frame_after_a_resize_has_its_size)
{
  spinFrames();
  panel()->getRenderWindow()->resize(400, 300);
  const Image image = grab(panel()->getRenderWindow());
  ASSERT_EQ(image.width(), 400);
  ASSERT_EQ(image.height(), 300);
  EXPECT_EQ(image.center(), ORANGE);
  EXPECT_EQ(image.at(399, 299), BACKGROUND);
  panel()->getRenderWindow()->resize(DEFAULT_WIDTH, DEFAULT_HEIGHT);
}

TEST_F(Targets, drawing_and_reading_leave_no_error)
{
  grab();
  const auto get_error = reinterpret_cast<unsigned int (*)()>(dlsym(RTLD_DEFAULT, "glGetError"));
  ASSERT_TRUE(get_error);
  while (get_error() != 0) {  // what RViz itself has left
  }
  grab(panel()->getRenderWindow());
  EXPECT_EQ(get_error(), 0u);
}

TEST_F(Targets, an_odd_width_is_made_even_by_rviz)
{
  resizePanel(401, 300);
  EXPECT_EQ(grab().width(), 402);
}

TEST_F(Targets, a_texture_is_drawn_into)
{
  auto texture = Ogre::TextureManager::getSingleton().createManual(
      "osmesa_harness_target", Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME,
      Ogre::TEX_TYPE_2D, 256, 128, 0, Ogre::PF_BYTE_RGBA, Ogre::TU_RENDERTARGET);
  Ogre::RenderTarget* target = texture->getBuffer()->getRenderTarget();
  Ogre::Camera* camera = createCamera("osmesa_harness_camera", 2.0F);
  Ogre::Viewport* viewport = target->addViewport(camera);
  viewport->setBackgroundColour(Ogre::ColourValue::Blue);
  viewport->setOverlaysEnabled(false);
  spinFrames();

  const Image image = grab(target);
  ASSERT_EQ(image.width(), 256);
  ASSERT_EQ(image.height(), 128);
  // 32 pixels a meter: the cross reaches 32 pixels, and 6 of width.
  EXPECT_EQ(image.center(), ORANGE);
  EXPECT_EQ(image.at(128 + 30, 64), ORANGE);
  EXPECT_EQ(image.at(128, 64 + 30), ORANGE);
  EXPECT_EQ(image.at(128 + 16, 64 + 16), BLUE);
  EXPECT_EQ(image.at(0, 0), BLUE);
  EXPECT_EQ(image.count(ORANGE) + image.count(BLUE), 256u * 128u);
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("texture", image));

  // The window is as it was.
  EXPECT_EQ(grab().at(0, 0), BACKGROUND);
  target->removeAllViewports();
  Ogre::TextureManager::getSingleton().remove(texture);
  destroyCamera(camera);
}

TEST_F(Targets, two_panels_show_one_scene)
{
  auto second = std::make_unique<rviz::RenderPanel>();
  second->resize(320, 240);
  second->initialize(sceneManager(), manager());
  Ogre::Camera* camera = createCamera("osmesa_harness_second_camera", 320.0F / 240.0F);
  second->setCamera(camera);
  second->setOrthoScale(60.0F);  // pixels a meter
  second->setBackgroundColor(Ogre::ColourValue::Blue);
  second->show();
  spinFrames();

  const Image small = grab(second->getRenderWindow());
  ASSERT_EQ(small.width(), 320);
  ASSERT_EQ(small.height(), 240);
  EXPECT_EQ(small.center(), ORANGE);
  EXPECT_EQ(small.at(160 + 50, 120), ORANGE);
  EXPECT_EQ(small.at(160 + 30, 120 + 30), BLUE);
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("second_panel", small));

  const Image large = grab();
  EXPECT_EQ(large.center(), ORANGE);
  EXPECT_EQ(large.at(320 + 50, 240 + 50), BACKGROUND);
  EXPECT_EQ(large.width(), DEFAULT_WIDTH);

  second.reset();
  destroyCamera(camera);
  EXPECT_EQ(grab(), large);
}

TEST_F(Targets, the_screen_shows_the_frame)
{
  if (QGuiApplication::platformName() != "xcb") {
    GTEST_SKIP() << "there is no screen without an X server";
  }
  viewFromAbove(0.5, 0.75);  // neither side like the other
  const Image drawn = grab();
  Image seen;
  spinUntil([&] {
    const QImage shot = QGuiApplication::primaryScreen()
                            ->grabWindow(panel()->winId())
                            .toImage()
                            .convertToFormat(QImage::Format_RGB888);
    seen = Image(shot.width(), shot.height());
    for (int y = 0; y < shot.height(); ++y) {
      for (int x = 0; x < shot.width(); ++x) {
        const QColor color = shot.pixelColor(x, y);
        seen.set(
            x, y,
            Rgb{static_cast<std::uint8_t>(color.red()), static_cast<std::uint8_t>(color.green()),
                static_cast<std::uint8_t>(color.blue())});
      }
    }
    return seen == drawn;
  });
  EXPECT_TRUE(osmesa_harness::imagesMatch("screen", seen, drawn));
}

}  // namespace
