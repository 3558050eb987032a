#include "mesh_view/seen_faces.h"

#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "conversion/mesh_conversion.h"
#include "support/meshes.h"

using rviz_mesh_plugin::FaceBits;
using rviz_mesh_plugin::HiddenFaces;
using rviz_mesh_plugin::HiddenFacesConstPtr;
using rviz_mesh_plugin::MeshDataConstPtr;
using rviz_mesh_plugin::Section;
using rviz_mesh_plugin::SeenFaces;

namespace {

/// Once it is known.
bool anySeen(SeenFaces& seen, const MeshDataConstPtr& mesh, const Section& section,
             const HiddenFacesConstPtr& hidden)
{
  bool any = seen.any(mesh, section, hidden);
  while (!seen.isKnown()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    any = seen.any(mesh, section, hidden);
  }
  return any;
}

}  // namespace

/// A square from -1 to 1 at the height 0, of two faces, and one above it at 2.
TEST(SeenFacesTest, tells_what_sections_and_hidden_faces_leave)
{
  auto message = test_meshes::square();
  auto& geometry = message.mesh_geometry;
  const std::vector<geometry_msgs::Point> below = geometry.vertices;
  for (geometry_msgs::Point point : below) {
    point.z += 2.0;
    geometry.vertices.push_back(point);
  }
  geometry.vertex_normals.clear();
  for (std::size_t face = 0; face < 2; ++face) {
    auto above = geometry.faces[face];
    for (auto& vertex : above.vertex_indices) {
      vertex += static_cast<std::uint32_t>(below.size());
    }
    geometry.faces.push_back(above);
  }
  const auto mesh = rviz_mesh_plugin::convert(message);
  ASSERT_EQ(mesh->faceCount(), 4u);
  SeenFaces seen;
  EXPECT_TRUE(anySeen(seen, nullptr, {}, nullptr));
  EXPECT_TRUE(anySeen(seen, mesh, {}, nullptr));
  Section between;
  between.lower[2] = 0.5f;
  between.upper[2] = 1.5f;
  EXPECT_FALSE(anySeen(seen, mesh, between, nullptr)) << "within the bounds of the mesh";
  Section above = between;
  above.upper[2] = 2.0f;
  EXPECT_TRUE(anySeen(seen, mesh, above, nullptr));
  const auto hide = [](const FaceBits::Faces& faces) {
    return std::make_shared<const HiddenFaces>(FaceBits(4, faces));
  };
  EXPECT_TRUE(anySeen(seen, mesh, above, hide({0, 1, 2})));
  EXPECT_FALSE(anySeen(seen, mesh, above, hide({2, 3})));
  EXPECT_TRUE(anySeen(seen, mesh, {}, hide({2, 3})));
  EXPECT_FALSE(anySeen(seen, mesh, {}, hide({0, 1, 2, 3})));
  EXPECT_TRUE(anySeen(seen, mesh, {}, nullptr)) << "shown again";
}
