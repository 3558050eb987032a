#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <OgreTextureManager.h>
#include <gtest/gtest.h>

#include "rendering/mesh_texture.h"
#include "visual_fixture.h"

using osmesa_harness::isNear;
using rviz_mesh_plugin::Material;
using rviz_mesh_plugin::MeshStyle;
using rviz_mesh_plugin::NONE;
using rviz_mesh_plugin::Rgba8;
using rviz_mesh_plugin::TextureImage;
using test_layouts::flat;
using test_layouts::grid;

namespace {

const Rgba8 RED{255, 0, 0, 255};
const Rgba8 BLUE{0, 0, 255, 255};
const Rgba8 WHITE{255, 255, 255, 255};

template <class Pixel>
std::shared_ptr<TextureImage> image(std::uint32_t index, std::uint32_t width, std::uint32_t height,
                                    const Pixel& pixel)
{
  auto texture = std::make_shared<TextureImage>();
  texture->index = index;
  texture->width = width;
  texture->height = height;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      texture->pixels.push_back(pixel(x, y));
      texture->translucent = texture->translucent || texture->pixels.back().alpha < 255;
    }
  }
  return texture;
}

std::shared_ptr<TextureImage> plain(std::uint32_t index, const Rgba8& color, std::uint32_t side = 4)
{
  return image(index, side, side, [&](std::uint32_t, std::uint32_t) { return color; });
}

}  // namespace

/// Four squares of a meter: lower left, lower right, upper left, upper right.
class VisualTextures : public VisualFixture
{
 protected:
  void SetUp() override
  {
    VisualFixture::SetUp();
    style.faces = MeshStyle::Faces::TEXTURES;
    visual->setStyle(style);
  }

  /// Middle of a square in the picture from above.
  static Rgb middle(const Image& picture, int square)
  {
    return picture.at(270 + square % 2 * 100, 290 - square / 2 * 100);
  }

  void draw(const std::vector<Material>& materials)
  {
    visual->setLayout(test_layouts::byMaterial(grid(2, flat), materials));
    uploadAll();
  }

  void setTexture(const rviz_mesh_plugin::TextureImageConstPtr& texture)
  {
    visual->setTexture(texture);
    uploadAll();
  }
};

TEST_F(VisualTextures, textures_colors_and_faces_without_a_material)
{
  draw({{RED, 0}, {BLUE, NONE}, {RED, 7}});
  Image seen = picture();
  EXPECT_EQ(middle(seen, 0), (Rgb{255, 0, 0})) << "in its color until the texture comes";
  EXPECT_EQ(middle(seen, 1), (Rgb{0, 0, 255}));
  EXPECT_EQ(middle(seen, 2), (Rgb{255, 0, 0}));
  EXPECT_EQ(middle(seen, 3), (Rgb{0, 255, 0})) << "no material: faces_color";
  setTexture(plain(7, {1, 2, 3, 255}));
  setTexture(plain(0, {4, 5, 6, 255}));
  seen = picture();
  EXPECT_EQ(seen.count({4, 5, 6}), 10000u);
  EXPECT_EQ(seen.count({0, 0, 255}), 10000u);
  EXPECT_EQ(seen.count({1, 2, 3}), 10000u);
  EXPECT_EQ(seen.count({0, 255, 0}), 10000u);
  setTexture(plain(0, {7, 8, 9, 255}));
  EXPECT_EQ(middle(picture(), 0), (Rgb{7, 8, 9})) << "replaced";
  style.faces = MeshStyle::Faces::FIXED_COLOR;
  visual->setStyle(style);
  EXPECT_EQ(picture().count({0, 255, 0}), 40000u);
  style.faces = MeshStyle::Faces::TEXTURES;
  visual->setStyle(style);
  EXPECT_EQ(picture().count({7, 8, 9}), 10000u) << "kept";
  visual->clearTextures();
  EXPECT_EQ(middle(picture(), 0), (Rgb{255, 0, 0}));
}

TEST_F(VisualTextures, the_first_row_of_the_image_is_at_v_0)
{
  draw({{WHITE, 0}});
  setTexture(image(0, 2, 2, [](std::uint32_t x, std::uint32_t y) {
    return Rgba8{static_cast<std::uint8_t>(255 * x), static_cast<std::uint8_t>(255 * y), 0, 255};
  }));
  const Image seen = picture();
  // The layout has v = 0 at the upper side. Textures are repeated: a bit of the other side is seen.
  EXPECT_TRUE(isNear(seen.at(245, 265), {0, 0, 0}, 4));
  EXPECT_TRUE(isNear(seen.at(295, 265), {255, 0, 0}, 4));
  EXPECT_TRUE(isNear(seen.at(245, 315), {0, 255, 0}, 4));
  EXPECT_TRUE(isNear(seen.at(295, 315), {255, 255, 0}, 4));
}

TEST_F(VisualTextures, only_textured_leaves_out_the_rest_but_not_its_edges)
{
  draw({{RED, 0}, {BLUE, NONE}, {RED, 7}});
  setTexture(plain(0, {4, 5, 6, 255}));
  style.only_textured = true;
  visual->setStyle(style);
  const Image seen = picture();
  EXPECT_EQ(middle(seen, 0), (Rgb{4, 5, 6}));
  EXPECT_EQ(middle(seen, 1), BACKGROUND);
  EXPECT_EQ(middle(seen, 2), (Rgb{255, 0, 0})) << "its texture is expected";
  EXPECT_EQ(middle(seen, 3), BACKGROUND);
  style.show_wireframe = true;
  style.wireframe_color = Ogre::ColourValue::White;
  visual->setStyle(style);
  EXPECT_NEAR(picture().count({255, 255, 255}), 6 * 200 + 4 * 100, 20);
}

TEST_F(VisualTextures, translucent_textures_colors_and_alpha_blend)
{
  draw({{RED, 0}, {{0, 0, 255, 128}, NONE}, {RED, NONE}});
  setTexture(plain(0, {255, 255, 255, 128}));
  Image seen = picture();
  EXPECT_TRUE(isNear(middle(seen, 0), {152, 152, 152}, 1)) << middle(seen, 0);
  EXPECT_TRUE(isNear(middle(seen, 1), {24, 24, 152}, 1)) << middle(seen, 1);
  EXPECT_EQ(middle(seen, 2), (Rgb{255, 0, 0}));
  style.alpha = 0.5f;
  visual->setStyle(style);
  seen = picture();
  EXPECT_TRUE(isNear(middle(seen, 0), {100, 100, 100}, 1)) << middle(seen, 0);
  EXPECT_TRUE(isNear(middle(seen, 1), {36, 36, 100}, 1)) << middle(seen, 1);
  EXPECT_TRUE(isNear(middle(seen, 2), {152, 24, 24}, 1)) << middle(seen, 2);
}

TEST_F(VisualTextures, images_of_any_size_keep_their_mean_from_far)
{
  for (const auto& size : std::vector<std::array<std::uint32_t, 2>>{
           {1, 1}, {1, 7}, {3, 1}, {64, 64}, {100, 30}, {257, 2}, {2000, 1500}}) {
    draw({{WHITE, 0}});
    // Stripes whose mean is grey; the last one of an odd number is left out of the mipmaps.
    setTexture(image(0, size[0], size[1], [&](std::uint32_t x, std::uint32_t y) {
      const std::uint8_t value = (size[0] > 1 ? x : y) % 2 == 0 ? 0 : 200;
      return size == std::array<std::uint32_t, 2>{1, 1} ? Rgba8{100, 100, 100, 255}
                                                        : Rgba8{value, value, value, 255};
    }));
    const Image seen = picture(4.0);
    if (size[0] * size[1] > 64) {  // smaller ones are not reduced to one color
      EXPECT_TRUE(isNear(seen.at(318, 242), {100, 100, 100}, 2))
          << size[0] << "x" << size[1] << ": " << seen.at(318, 242);
    }
    EXPECT_EQ(seen.at(322, 242), (Rgb{0, 255, 0}));
  }
}

TEST_F(VisualTextures, from_twice_as_far_each_pixel_is_the_mean_of_four)
{
  draw({{WHITE, 0}});
  std::uint32_t state = 1;
  const auto noise = image(0, 200, 200, [&state](std::uint32_t, std::uint32_t) {
    state = state * 1664525u + 1013904223u;
    return Rgba8{static_cast<std::uint8_t>(state >> 24), static_cast<std::uint8_t>(state >> 16), 0,
                 255};
  });
  const auto pixels = noise->pixels;  // which it has not any more then
  setTexture(noise);
  const Image seen = picture();
  for (int row = 1; row < 99; ++row) {
    for (int column = 1; column < 99; ++column) {
      int red = 2;
      int green = 2;
      for (const int i : {0, 1, 200, 201}) {
        red += pixels[400 * row + 2 * column + i].red;
        green += pixels[400 * row + 2 * column + i].green;
      }
      const Rgb expected{static_cast<std::uint8_t>(red / 4), static_cast<std::uint8_t>(green / 4),
                         0};
      ASSERT_TRUE(isNear(seen.at(220 + column, 240 + row), expected, 2)) << column << " " << row;
    }
  }
}

TEST_F(VisualTextures, a_large_image_is_uploaded_in_slices)
{
  draw({{RED, 0}});
  visual->setTexture(plain(0, {4, 5, 6, 255}, 2048));
  const std::size_t slices = uploadAll();
  // Allocated; 16 MiB in four slices, then its mipmaps: 4 MiB and ten smaller ones.
  EXPECT_EQ(slices, 1u + 4u + 11u);
  EXPECT_EQ(middle(picture(), 0), (Rgb{4, 5, 6}));
}

TEST_F(VisualTextures, pixels_are_on_the_graphics_card_alone_and_outlive_the_layout)
{
  draw({{RED, 0}});
  const auto base = counts();
  auto texture = plain(0, {4, 5, 6, 255}, 2048);
  visual->setTexture(texture);
  EXPECT_EQ(counts().textures, base.textures) << "allocated in a slice of its own";
  uploadAll();
  EXPECT_EQ(texture->pixels.capacity(), 0u);
  EXPECT_EQ(middle(picture(), 0), (Rgb{4, 5, 6}));
  draw({{RED, 0}, {BLUE, NONE}});
  visual->setTexture(texture);
  EXPECT_EQ(uploadAll(), 0u) << "it is there already, and drawn at once";
  EXPECT_EQ(middle(picture(), 0), (Rgb{4, 5, 6}));
  visual->clearTextures();
  EXPECT_EQ(counts().textures, base.textures + 1);
  texture.reset();
  EXPECT_EQ(counts().textures, base.textures) << "freed with the image";
}

TEST_F(VisualTextures, a_texture_whose_image_goes_with_another_thread_waits_for_this_one)
{
  auto last = plain(7, RED);
  auto texture = rviz_mesh_plugin::MeshTexture::of(*last);
  texture->uploadSlice();
  const std::string name = texture->get()->getName();
  const auto exists = [&] { return Ogre::TextureManager::getSingleton().resourceExists(name); };
  texture.reset();
  ASSERT_TRUE(exists());
  std::thread([&] { last.reset(); }).join();
  EXPECT_TRUE(exists());
  rviz_mesh_plugin::MeshTexture::destroyLeft();
  EXPECT_FALSE(exists());
  auto other = plain(7, RED);
  const std::string next = [&] {
    const auto made = rviz_mesh_plugin::MeshTexture::of(*other);
    made->uploadSlice();
    return made->get()->getName();
  }();
  other.reset();
  EXPECT_FALSE(Ogre::TextureManager::getSingleton().resourceExists(next)) << "at once, by its own";
}

TEST_F(VisualTextures, materials_share_textures_and_all_are_freed)
{
  const auto base = counts();
  draw({{RED, 0}, {BLUE, 0}, {RED, NONE}, {BLUE, 1}});
  const auto bare = counts();
  const std::size_t bytes = visual->gpuBytes();
  auto texture = plain(0, {4, 5, 6, 255});
  setTexture(texture);
  EXPECT_EQ(counts().textures, base.textures + 1);
  EXPECT_EQ(counts().materials, bare.materials + 1);
  EXPECT_EQ(visual->gpuBytes(), bytes + 4 * (16 + 4 + 1));
  EXPECT_EQ(picture().count({4, 5, 6}), 20000u);
  setTexture(texture);
  setTexture(plain(2, {4, 5, 6, 255}));
  EXPECT_EQ(counts().textures, base.textures + 1) << "nothing refers to texture 2";
  visual->clearTextures();
  texture.reset();
  EXPECT_EQ(counts(), bare);
  texture = plain(0, {4, 5, 6, 255});
  setTexture(texture);
  draw({{RED, 0}});
  EXPECT_EQ(counts().textures, base.textures + 1) << "not with the layout";
  for (int i = 0; i < 100; ++i) {
    draw({{RED, 0}, {BLUE, 1}});
    visual->setTexture(texture);
    setTexture(plain(1, RED, 16));
  }
  EXPECT_EQ(counts().textures, base.textures + 2);
  visual.reset();
  texture.reset();
  EXPECT_EQ(counts(), empty);
}

TEST_F(VisualTextures, looks_the_same_on_all_back_ends)
{
  draw({{RED, 0}, {BLUE, NONE}, {WHITE, 1}});
  visual->setTexture(image(0, 64, 64, [](std::uint32_t x, std::uint32_t y) {
    return (x / 8 + y / 8) % 2 == 0 ? RED : WHITE;
  }));
  setTexture(image(1, 100, 30, [](std::uint32_t x, std::uint32_t y) {
    return Rgba8{static_cast<std::uint8_t>(2 * x), static_cast<std::uint8_t>(8 * y), 100, 255};
  }));
  lookAt({1.5, -2.0, 1.5}, {0.0, 0.0, 0.0});
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("textures", grab(), 1e-4));
}
