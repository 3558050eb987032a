#include <osmesa_harness/render_fixture.h>

#include <OgreEntity.h>
#include <OgreHardwareBufferManager.h>
#include <OgreManualObject.h>
#include <OgreMaterialManager.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <rviz/display.h>
#include <rviz/visualization_manager.h>

#include <sstream>

using osmesa_harness::SceneCounts;

namespace {

class Counts : public osmesa_harness::RenderFixture
{
};

TEST_F(Counts, a_manual_object_counts_with_all_it_holds)
{
  const SceneCounts before = counts();
  Ogre::SceneNode* node = sceneManager()->getRootSceneNode()->createChildSceneNode();
  Ogre::ManualObject* object = sceneManager()->createManualObject("osmesa_harness_object");
  object->begin("BaseWhiteNoLighting", Ogre::RenderOperation::OT_TRIANGLE_LIST);
  object->position(0.0F, 0.0F, 0.0F);
  object->position(1.0F, 0.0F, 0.0F);
  object->position(0.0F, 1.0F, 0.0F);
  object->triangle(0, 1, 2);
  object->end();

  SceneCounts with = counts();
  EXPECT_EQ(with.nodes, before.nodes + 1);
  EXPECT_EQ(with.movable("ManualObject"), before.movable("ManualObject") + 1);
  EXPECT_EQ(with.vertex_buffers, before.vertex_buffers + 1);
  EXPECT_EQ(with.index_buffers, before.index_buffers + 1);
  EXPECT_EQ(with.vertex_buffer_bytes, before.vertex_buffer_bytes + 3 * 3 * sizeof(float));
  EXPECT_EQ(with.index_buffer_bytes, before.index_buffer_bytes + 3 * 2);

  // Attached or not, it is one object.
  node->attachObject(object);
  EXPECT_EQ(counts(), with);

  sceneManager()->destroyManualObject(object);
  sceneManager()->destroySceneNode(node);
  EXPECT_EQ(counts(), before);
}

TEST_F(Counts, a_forgotten_material_is_noticed)
{
  const SceneCounts before = counts();
  const auto material = Ogre::MaterialManager::getSingleton().create(
      "osmesa_harness_material", Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME);
  EXPECT_EQ(counts().materials, before.materials + 1);
  EXPECT_NE(counts(), before);
  Ogre::MaterialManager::getSingleton().remove(material->getHandle());
  EXPECT_EQ(counts(), before);
}

TEST_F(Counts, nothing_is_left_of_a_display_that_cleans_up)
{
  // What RViz makes once and keeps is made by the first one.
  createDisplay("rviz/Grid");
  grab();
  manager()->removeAllDisplays();
  spinFrames();
  const SceneCounts before = counts();
  for (int round = 0; round < 3; ++round) {
    createDisplay("rviz/Grid");
    spinFrames();
    EXPECT_NE(counts(), before);
    manager()->removeAllDisplays();
    spinFrames();
    EXPECT_EQ(counts(), before) << "after round " << round;
  }
}

TEST_F(Counts, are_printed_with_their_names)
{
  std::ostringstream text;
  text << counts();
  EXPECT_NE(text.str().find("vertex buffers"), std::string::npos);
  EXPECT_NE(text.str().find("Light 1"), std::string::npos) << text.str();
}

}  // namespace
