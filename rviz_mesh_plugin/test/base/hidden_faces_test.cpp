#include <memory>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "base/hidden_faces.h"

using namespace rviz_mesh_plugin;
using Faces = FaceBits::Faces;

namespace {

std::shared_ptr<MeshData> makeMesh(const std::string& uuid, std::size_t faces)
{
  auto mesh = std::make_shared<MeshData>();
  mesh->uuid = uuid;
  mesh->vertices.resize(3);
  for (std::size_t i = 0; i < faces; ++i) {
    mesh->indices.insert(mesh->indices.end(), {0, 1, 2});
  }
  return mesh;
}

HiddenFacesConstPtr hide(std::size_t count, const Faces& faces)
{
  return std::make_shared<const HiddenFaces>(FaceBits(count, faces));
}

}  // namespace

TEST(HiddenFaces, are_bits_and_a_mask)
{
  const auto hidden = hide(130, {0, 63, 64, 129});
  EXPECT_EQ(hidden->count(), 4u);
  ASSERT_EQ(hidden->mask().size(), 130u);
  for (std::uint32_t face = 0; face < 130; ++face) {
    const bool is_hidden = face == 0 || face == 63 || face == 64 || face == 129;
    EXPECT_EQ(hidden->contains(face), is_hidden);
    EXPECT_EQ(hidden->mask()[face], is_hidden ? 0 : 1);
  }
  EXPECT_FALSE(hidden->contains(130));
}

TEST(HiddenFaces, belong_to_a_mesh_also_when_it_comes_again)
{
  const auto mesh = makeMesh("registry", 10);
  EXPECT_EQ(hiddenFaces(*mesh), nullptr);
  const auto before = hiddenFacesRevision();
  const auto hidden = hide(10, {3});
  setHiddenFaces(*mesh, hidden);
  EXPECT_NE(hiddenFacesRevision(), before);
  EXPECT_EQ(hiddenFaces(*makeMesh("registry", 10)), hidden);
  EXPECT_EQ(hiddenFaces(*makeMesh("registry", 11)), nullptr) << "another mesh of that name";
  EXPECT_EQ(hiddenFaces(*makeMesh("another", 10)), nullptr);
  EXPECT_THROW(setHiddenFaces(*makeMesh("registry", 11), hidden), std::invalid_argument);
  EXPECT_EQ(hiddenFaces(*mesh), hidden);
  setHiddenFaces(*mesh, hide(10, {}));
  EXPECT_EQ(hiddenFaces(*mesh), nullptr) << "none is hidden";
}

TEST(HiddenFaces, of_too_many_meshes_are_shown_again)
{
  const auto hidden = hide(1, {0});
  for (std::size_t i = 0; i <= MOST_MESHES_WITH_HIDDEN_FACES; ++i) {
    setHiddenFaces(*makeMesh("mesh " + std::to_string(i), 1), hidden);
  }
  EXPECT_EQ(hiddenFaces(*makeMesh("mesh 0", 1)), nullptr);
  for (std::size_t i = 1; i <= MOST_MESHES_WITH_HIDDEN_FACES; ++i) {
    const auto mesh = makeMesh("mesh " + std::to_string(i), 1);
    EXPECT_EQ(hiddenFaces(*mesh), hidden);
    setHiddenFaces(*mesh, nullptr);
  }
}

TEST(HiddenFaces, are_left_out_of_lists)
{
  const auto faces = std::make_shared<const Faces>(Faces{1, 2, 5, 7});
  EXPECT_EQ(withoutHidden(faces, nullptr), faces) << "not copied";
  EXPECT_EQ(*withoutHidden(faces, hide(10, {0, 2, 7})), (Faces{1, 5}));
  EXPECT_TRUE(withoutHidden(faces, hide(10, {1, 2, 5, 7}))->empty());
}

TEST(FaceBits, are_united_and_removed)
{
  FaceBits faces(70, {0, 5, 69});
  faces.unite(FaceBits(70, {5, 6, 64}));
  EXPECT_EQ(faces.faces(), (Faces{0, 5, 6, 64, 69}));
  faces.remove(FaceBits(70, {0, 1, 69}));
  EXPECT_EQ(faces.faces(), (Faces{5, 6, 64}));
  EXPECT_THROW(faces.unite(FaceBits(71)), std::invalid_argument);
  EXPECT_THROW(faces.remove(FaceBits(69)), std::invalid_argument);
}
