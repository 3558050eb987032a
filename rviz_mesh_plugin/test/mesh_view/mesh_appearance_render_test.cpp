// What a TexturedMesh says of what cannot be drawn.
#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include <OgreTextureManager.h>
#include <gtest/gtest.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>

#include "base/hidden_faces.h"
#include "incoming/mesh_loader.h"
#include "incoming/mesh_store.h"
#include "mesh_view/mesh_appearance.h"
#include "properties/mesh_properties.h"
#include "rendering/ogre/ogre_compatibility.h"
#include "rendering/ogre/unique_name.h"
#include "rendering/visual_fixture.h"
#include "support/display_fixture.h"

namespace {

/// Textures with the names that the next ones would get, which OGRE refuses then.
class BlockedNames
{
 public:
  BlockedNames()
  {
    const std::string last = rviz_mesh_plugin::uniqueName("Texture");
    const std::size_t number = last.rfind(' ') + 1;
    for (unsigned long i = 1; i <= 1000; ++i) {
      textures_.push_back(Ogre::TextureManager::getSingleton().create(
          last.substr(0, number) + std::to_string(std::stoul(last.substr(number)) + i), "General"));
    }
  }

  ~BlockedNames()
  {
    for (auto& texture : textures_) {
      Ogre::TextureManager::getSingleton().remove(texture->getHandle());
    }
  }

 private:
  std::vector<decltype(Ogre::TextureManager::getSingleton().create("", ""))> textures_;
};

}  // namespace

class MeshAppearanceTest : public DisplayFixture
{
};

TEST_F(MeshAppearanceTest, an_error_is_said_until_what_failed_has_been_done)
{
  const ros::Publisher materials_publisher =
      node.advertise<mesh_msgs::MeshMaterialsStamped>(geometry_topic + "/materials", 10, true);
  const ros::Publisher textures =
      node.advertise<mesh_msgs::MeshTexture>(geometry_topic + "/textures", 10, true);
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Textures");
  set(display, {"Display Type", "Materials Topic"}, (geometry_topic + "/materials").c_str());
  set(display, {"Display Type", "Textures Topic"}, (geometry_topic + "/textures").c_str());
  ASSERT_TRUE(show(display, test_meshes::square()));
  mesh_msgs::MeshMaterialsStamped message;
  message.header.frame_id = "map";
  message.uuid = "mesh";
  auto& materials = message.mesh_materials;
  materials.materials.resize(1);
  materials.materials[0].color = test_meshes::color(1, 0, 0);
  materials.materials[0].has_texture = true;
  materials.materials[0].texture_index = 3;
  materials.clusters.resize(1);
  materials.clusters[0].face_indices = {0, 1};
  materials.cluster_materials = {0};
  materials.vertex_tex_coords.resize(4);
  materials_publisher.publish(message);
  ASSERT_TRUE(waitForStatus(display, "Textures", "Warn", "0 of 1 texture received"));
  ASSERT_TRUE(waitForStatus(display, "Geometry", "Ok", "2 faces"));
  mesh_msgs::MeshTexture texture;
  texture.uuid = "mesh";
  texture.texture_index = 3;
  texture.image.width = 1;
  texture.image.height = 1;
  texture.image.step = 3;
  texture.image.encoding = "rgb8";
  texture.image.data = {0, 0, 255};
  {
    const BlockedNames names;
    textures.publish(texture);
    ASSERT_TRUE(waitForStatus(display, "Geometry", "Error", "")) << status(display, "Geometry");
    spinFrames(5);
    EXPECT_EQ(status(display, "Geometry").rfind("Error", 0), 0u) << "nothing has been done since";
  }
  set(display, {"Culling Mode (HW)"}, "Clockwise");
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "2 faces")) << "the texture is drawn";
  viewFromAbove(0.0, 0.0, 100.0);
  spinFrames(3);
  EXPECT_EQ(grab().center(), (osmesa_harness::Rgb{0, 0, 255}));
}

TEST_F(MeshAppearanceTest, hidden_faces_go_before_the_mesh_has_been_laid_out_without_them)
{
  using namespace rviz_mesh_plugin;
  const std::atomic<bool> canceled{false};
  const MeshDataConstPtr mesh = test_layouts::grid(64, test_layouts::flat);
  rviz::Property root;
  const MeshProperties properties(&root);
  MeshStore store;
  MeshLoader loader;  // nobody takes what it has laid out
  store.addMesh(mesh);
  Ogre::SceneNode* parent = sceneManager()->getRootSceneNode()->createChildSceneNode();
  {
    MeshAppearance appearance({store, properties, loader, parent}, mesh->uuid);
    appearance.setLayout(layOut(mesh, Split::NONE, nullptr, canceled));
    appearance.setPose(FramePose{Ogre::Vector3::ZERO, Ogre::Quaternion::IDENTITY});
    const auto pixels = [&] {
      appearance.paint();
      while (!appearance.upload(std::chrono::milliseconds(1))) {
      }
      viewFromAbove(0.0, 0.0, 100.0);
      const osmesa_harness::Image image = grab();
      int count = 0;
      for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) {
          count += image.at(x, y) == image.at(0, 0) ? 0 : 1;
        }
      }
      return count;
    };
    const int all = pixels();
    EXPECT_NEAR(all, 40000, 1000);
    FaceBits half(mesh->faceCount());
    for (std::uint32_t face = 0; face < mesh->faceCount() / 2; ++face) {
      half.add(FaceBits::Faces{face});
    }
    const auto hidden = std::make_shared<const HiddenFaces>(half);
    setHiddenFaces(*mesh, hidden);
    EXPECT_NEAR(pixels(), all / 2, 500);
    EXPECT_EQ(appearance.visual()->layout()->hidden, nullptr) << "the layout is the one of before";
    appearance.setLayout(layOut(mesh, Split::NONE, nullptr, canceled, hidden));
    EXPECT_NEAR(pixels(), all / 2, 500);
    EXPECT_EQ(appearance.visual()->layout()->hidden, hidden);
    setHiddenFaces(*mesh, nullptr);
  }
  sceneManager()->destroySceneNode(parent);
}
