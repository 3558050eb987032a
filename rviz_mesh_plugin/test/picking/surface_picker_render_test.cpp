#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <rviz/display_group.h>

#include "support/tool_fixture.h"

using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::Pick;
using rviz_mesh_plugin::ShownMesh;

class SurfacePickerTest : public ToolFixture
{
 protected:
  struct Placed
  {
    Display* display;
    rviz_mesh_plugin::MeshDataConstPtr mesh;
    FixedPose pose;
  };

  struct Found
  {
    const Placed* placed = nullptr;
    std::uint32_t face = 0;
    double distance = std::numeric_limits<double>::infinity();
    bool sure = true;  ///< not close to an edge, and nothing else as near
  };

  static mesh_msgs::MeshGeometryStamped hills(std::uint32_t cells, double phase,
                                              const std::string& name)
  {
    auto message = test_meshes::terrain(cells, [phase](double x, double y) {
      return 0.3 * std::sin(4 * x + phase) * std::cos(3 * y - phase);
    });
    message.uuid = name;
    message.header.frame_id = name;
    return message;
  }

  /// A display on a topic of its own, with a mesh in a frame of its own.
  Placed& place(const std::string& name, std::uint32_t cells, double phase, const FixedPose& pose)
  {
    const std::string topic = geometry_topic + "/" + name;
    publishers_.push_back(node.advertise<mesh_msgs::MeshGeometryStamped>(topic, 1, true));
    auto* display = createMeshDisplay();
    display->setName(QString::fromStdString(name));
    set(display, {"Geometry Topic"}, topic.c_str());
    publishers_.back().publish(hills(cells, phase, name));
    putFrame(name, pose);
    EXPECT_TRUE(spinUntil([&] { return display->shownMeshes().size() == 1; })) << name;
    placed_.push_back({display, display->mesh(), pose});
    return placed_.back();
  }

  void move(Placed& placed, const FixedPose& pose)
  {
    placed.pose = pose;
    putFrame(placed.mesh->frame_id, pose);
  }

  /// The nearest of all faces, in the fixed frame.
  Found bruteForce(const mesh_map::Ray& ray) const
  {
    const Vector &origin = ray.origin, &direction = ray.direction;
    Found found;
    for (const Placed& placed : placed_) {
      for (std::uint32_t face = 0; face < placed.mesh->faceCount(); ++face) {
        Vector corners[3];
        for (unsigned i = 0; i < 3; ++i) {
          const auto& p = placed.mesh->vertices[placed.mesh->indices[3 * face + i]].position;
          corners[i] = placed.pose({p[0], p[1], p[2]});
        }
        const Vector e1 = minus(corners[1], corners[0]), e2 = minus(corners[2], corners[0]);
        const Vector p = cross(direction, e2);
        const double determinant = dot(e1, p);
        const Vector from = minus(origin, corners[0]);
        const double u = dot(from, p) / determinant;
        const double v = dot(direction, cross(from, e1)) / determinant;
        const double distance = dot(e2, cross(from, e1)) / determinant;
        const double inside = std::min({u, v, 1.0 - u - v});
        if (determinant == 0.0 || inside < -1e-3 || distance < 0.0) {
          continue;
        }
        if (std::abs(distance - found.distance) < 1e-4) {
          found.sure = false;
        } else if (distance < found.distance) {
          found = {&placed, face, distance, inside > 1e-3};
        }
      }
    }
    return found;
  }

  /// Picks at many pixels and compares; how many hit.
  std::size_t comparePicks(unsigned seed)
  {
    std::mt19937 random(seed);
    std::size_t hits = 0, sure = 0;
    for (int i = 0; i < 150; ++i) {
      const auto event = mouse(random() % 640, random() % 480);
      const mesh_map::Ray ray = rviz_mesh_plugin::cursorRay(event);
      const Found expected = bruteForce(ray);
      if (!expected.sure) {
        continue;
      }
      ++sure;
      for (const Pick& pick : {picker.pick(event), picker.pick(ray)}) {
        EXPECT_EQ(pick.hit.has_value(), expected.placed != nullptr) << pick.reason;
        if (!pick.hit || !expected.placed) {
          EXPECT_EQ(pick.reason, "no surface under the cursor: point at a mesh");
          continue;
        }
        ++hits;
        EXPECT_EQ(pick.reason, "");
        EXPECT_EQ(pick.hit->mesh, expected.placed->mesh);
        EXPECT_EQ(pick.hit->display, expected.placed->display->getNameStd());
        EXPECT_EQ(pick.hit->face, expected.face);
        checkHit(pick, ray, *expected.placed, expected.distance);
      }
    }
    EXPECT_GT(sure, 100u);
    return hits;
  }

  static void checkHit(const Pick& pick, const mesh_map::Ray& ray, const Placed& placed,
                       double distance)
  {
    const auto& hit = *pick.hit;
    const double scale = std::max(1.0, std::abs(distance)) * 1e-5;
    EXPECT_NEAR(hit.distance, distance, scale);
    EXPECT_NEAR(hit.barycentric[0] + hit.barycentric[1] + hit.barycentric[2], 1.0, 1e-12);
    const Vector point = placed.pose(hit.point);
    const Vector again = pointInFixedFrame(hit.point, hit);
    Vector expected;
    Vector corners[3];
    for (unsigned i = 0; i < 3; ++i) {
      expected[i] = ray.origin[i] + distance * ray.direction[i];
      EXPECT_NEAR(point[i], expected[i], 10 * scale);
      EXPECT_NEAR(point[i], again[i], scale);
      const auto& p = hit.mesh->vertices[hit.mesh->indices[3 * hit.face + i]].position;
      corners[i] = {p[0], p[1], p[2]};
    }
    const Vector edge = minus(corners[1], corners[0]), other = minus(corners[2], corners[0]);
    EXPECT_NEAR(dot(hit.normal, hit.normal), 1.0, 1e-12);
    EXPECT_NEAR(dot(hit.normal, edge), 0.0, 1e-12);
    EXPECT_NEAR(dot(hit.normal, other), 0.0, 1e-12);
    EXPECT_GT(dot(hit.normal, cross(edge, other)), 0.0);
    // What was clicked at is drawn under the cursor.
    const auto clip = meshToClip(*camera(), hit);
    Vector seen;
    const double w =
        clip[12] * hit.point[0] + clip[13] * hit.point[1] + clip[14] * hit.point[2] + clip[15];
    for (unsigned i = 0; i < 3; ++i) {
      seen[i] = (clip[4 * i] * hit.point[0] + clip[4 * i + 1] * hit.point[1] +
                 clip[4 * i + 2] * hit.point[2] + clip[4 * i + 3]) /
                w;
    }
    const Ogre::Vector3 ndc = camera()->getProjectionMatrix() *
                              (camera()->getViewMatrix() * rviz_mesh_plugin::ogreVector(expected));
    EXPECT_NEAR(seen[0], ndc.x, 1e-3);
    EXPECT_NEAR(seen[1], ndc.y, 1e-3);
    EXPECT_GE(seen[2], -1.0);
    EXPECT_LE(seen[2], 1.0);
  }

  std::vector<ros::Publisher> publishers_;
  std::vector<Placed> placed_;
};

TEST_F(SurfacePickerTest, the_nearest_face_of_all_meshes_wherever_they_lie)
{
  placed_.reserve(3);
  place("a", 12, 0.0, {});
  auto& b = place("b", 10, 1.0, {{0.5, -0.4, 0.6}, {0.9, 0.3, -0.2, 0.4}});
  auto& c = place("c", 8, 2.0, {{-0.8, 0.7, -0.5}, {0.2, -0.7, 0.6, 0.1}});
  auto* group = dynamic_cast<rviz::DisplayGroup*>(createDisplay("rviz/Group"));
  ASSERT_TRUE(group);
  manager()->getRootDisplayGroup()->takeDisplay(b.display);
  group->addDisplay(b.display);
  spinFrames();
  ASSERT_EQ(picker.meshes().size(), 3u);
  waitUntilPrepared();
  lookAt({3, -2, 2}, {0, 0, 0});
  spinFrames();
  EXPECT_GT(comparePicks(1), 60u);
  lookAt({-1, 2, -3}, {0, 0, 0});
  spinFrames();
  EXPECT_GT(comparePicks(2), 60u) << "from below";
  viewFromAbove(0.1, -0.2, 130.0);
  spinFrames();
  EXPECT_GT(comparePicks(3), 60u) << "in parallel projection";
  move(b, {{-0.3, 0.2, 1.5}, {0.5, 0.5, 0.1, -0.6}});
  move(c, {{0.9, -0.9, 0.5}, {1, 0.1, 0, 0}});
  EXPECT_GT(comparePicks(4), 60u) << "moved";
  resizePanel(501, 333);
  lookAt({2, 2, 2.5}, {0, 0, 0});
  spinFrames();
  EXPECT_GT(comparePicks(5), 40u) << "in another window";
  resizePanel(DEFAULT_WIDTH, DEFAULT_HEIGHT);
  group->setEnabled(false);
  spinFrames();
  EXPECT_EQ(picker.meshes().size(), 2u) << "hidden with the group";
  EXPECT_TRUE(picker.exists(b.mesh));
}

TEST_F(SurfacePickerTest, what_is_drawn_in_the_middle_of_a_pixel_is_picked_there)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  waitUntilPrepared();
  const std::vector<std::function<void()>> views{
      [] { viewFromAbove(0.003, 0.002, 101.3); },
      [] {
        lookAt({1.3, -2.1, 1.7}, {0.1, 0.1, 0.0});
      },
  };
  for (std::size_t view = 0; view < views.size(); ++view) {
    views[view]();
    spinFrames();
    const auto image = grab();
    const auto background = image.at(1, 1);
    std::size_t border = 0, wrong = 0;
    for (int y = 1; y + 1 < image.height(); ++y) {
      for (int x = 1; x + 1 < image.width(); ++x) {
        const bool drawn = image.at(x, y) != background;
        if (drawn == (image.at(x - 1, y) != background) &&
            drawn == (image.at(x, y - 1) != background) &&
            drawn == (image.at(x + 1, y) != background) &&
            drawn == (image.at(x, y + 1) != background)) {
          continue;
        }
        ++border;
        wrong += drawn != picker.pick(mouse(x, y)).hit.has_value();
      }
    }
    EXPECT_GT(border, 500u);
    // OpenGL rounds corners to parts of a pixel.
    EXPECT_LT(wrong, border / 25) << "view " << view;
  }
}

TEST_F(SurfacePickerTest, projection_is_that_of_ogre)
{
  placed_.reserve(1);
  auto& placed = place("a", 5, 0.5, {{0.5, -0.4, 0.6}, {0.9, 0.3, -0.2, 0.4}});
  for (const bool parallel : {false, true}) {
    for (const double away : {0.0, 300.0}) {
      move(placed, {{0.5 + away, -0.4, 0.6}, {0.9, 0.3, -0.2, 0.4}});
      if (parallel) {
        viewFromAbove(away, 0.2, 120.0);
      } else {
        lookAt({3 + away, 1, 2}, {away, 0, 0});
      }
      spinFrames();
      const ShownMesh shown = picker.meshes().at(0);
      const auto clip = meshToClip(*camera(), shown);
      const Ogre::Matrix4 view = camera()->getViewMatrix();
      for (const auto& vertex : placed.mesh->vertices) {
        const auto& p = vertex.position;
        const Vector fixed = placed.pose({p[0], p[1], p[2]});
        const Ogre::Vector4 expected =
            camera()->getProjectionMatrix() *
            (view * Ogre::Vector4(static_cast<float>(fixed[0]), static_cast<float>(fixed[1]),
                                  static_cast<float>(fixed[2]), 1.0f));
        double seen[4];
        for (unsigned i = 0; i < 4; ++i) {
          seen[i] = clip[4 * i] * p[0] + clip[4 * i + 1] * p[1] + clip[4 * i + 2] * p[2] +
                    clip[4 * i + 3];
        }
        // 1/320 is a pixel.
        EXPECT_NEAR(seen[0] / seen[3], expected.x / expected.w, 2e-4);
        EXPECT_NEAR(seen[1] / seen[3], expected.y / expected.w, 2e-4);
        EXPECT_NEAR(seen[2] / seen[3], expected.z / expected.w, 1e-4);
        EXPECT_LE(std::abs(seen[2]), seen[3]);
      }
      const Vector eye = eyeInMesh(*camera(), shown);
      const Vector eye_in_map = placed.pose(eye);
      const Ogre::Vector3 position = camera()->getDerivedPosition();
      const Ogre::Vector3 forward = camera()->getDerivedDirection();
      for (const auto& vertex : placed.mesh->vertices) {
        const auto& p = vertex.position;
        Vector sight = minus(placed.pose({p[0], p[1], p[2]}), eye_in_map);
        const double length = std::sqrt(dot(sight, sight));
        const double along = dot(sight, {forward.x, forward.y, forward.z}) / length;
        if (parallel) {
          EXPECT_GT(along, 1.0 - 1e-7);
        } else {
          EXPECT_GT(along, 0.8);
        }
      }
      for (unsigned i = 0; i < 3 && !parallel; ++i) {
        EXPECT_NEAR(eye_in_map[i], position[i], 1e-4);
      }
    }
  }
}

TEST_F(SurfacePickerTest, back_faces_are_looked_through_on_demand)
{
  auto* display = createMeshDisplay();
  auto message = test_meshes::square(0.5);
  for (const double height : {0.0, 0.2}) {  // from above: a back, and then a front
    auto other = test_meshes::square(height);
    const auto first = static_cast<std::uint32_t>(message.mesh_geometry.vertices.size());
    for (const auto& vertex : other.mesh_geometry.vertices) {
      message.mesh_geometry.vertices.push_back(vertex);
    }
    for (auto face : other.mesh_geometry.faces) {
      for (auto& index : face.vertex_indices) {
        index += first;
      }
      message.mesh_geometry.faces.push_back(face);
    }
  }
  std::swap(message.mesh_geometry.faces[0].vertex_indices[1],
            message.mesh_geometry.faces[0].vertex_indices[2]);
  std::swap(message.mesh_geometry.faces[1].vertex_indices[1],
            message.mesh_geometry.faces[1].vertex_indices[2]);
  ASSERT_TRUE(show(display, message));
  viewFromAbove();
  spinFrames();
  waitUntilPrepared();
  const auto event = mouse(340, 250);
  ASSERT_TRUE(picker.pick(event).hit);
  EXPECT_LT(picker.pick(event).hit->face, 2u);
  EXPECT_NEAR(picker.pick(event).hit->normal[2], -1.0, 1e-12);
  EXPECT_NEAR(picker.pick(event).hit->point[2], 0.5, 1e-6);
  ASSERT_TRUE(picker.pick(event, false).hit);
  EXPECT_GE(picker.pick(event, false).hit->face, 4u);
  EXPECT_NEAR(picker.pick(event, false).hit->point[2], 0.2, 1e-6);
}

TEST_F(SurfacePickerTest, says_why_there_is_no_hit)
{
  const auto reason = [&](int x, int y) {
    const Pick pick = picker.pick(mouse(x, y));
    EXPECT_NE(pick.hit.has_value(), !pick.reason.empty());
    return pick.reason;
  };
  viewFromAbove();
  spinFrames();
  const std::string none =
      "no mesh is shown: add and enable a TexturedMesh or Map3D display, and look at its status";
  EXPECT_EQ(reason(320, 240), none);
  auto* display = createMeshDisplay();
  display->setName("my map");
  EXPECT_EQ(reason(320, 240), none) << "before there is a mesh";
  ASSERT_TRUE(show(display, test_meshes::terrain(200, [](double, double) { return 0.0; })));
  const std::string first = reason(325, 245);
  EXPECT_EQ(first.rfind("the mesh of 'my map' is being prepared (", 0), 0u) << first;
  EXPECT_NE(first.find(" %): try again in a moment"), std::string::npos) << first;
  EXPECT_EQ(reason(5, 5), "no surface under the cursor: point at a mesh") << "it is not there";
  waitUntilPrepared();
  EXPECT_EQ(reason(325, 245), "");
  EXPECT_EQ(reason(5, 5), "no surface under the cursor: point at a mesh");
  const Pick held = picker.pick(mouse(325, 245));
  display->setEnabled(false);
  EXPECT_EQ(reason(325, 245), none);
  EXPECT_TRUE(picker.exists(held.hit->mesh));
  display->setEnabled(true);
  spinFrames();
  EXPECT_EQ(reason(325, 245), "");
  auto lost = test_meshes::square();
  lost.header.frame_id = "nowhere";
  geometry.publish(lost);
  ASSERT_TRUE(waitForStatus(display, "Transform", "Error", "no transform"));
  EXPECT_TRUE(spinUntil([&] { return reason(325, 245) == none; })) << "where the mesh is unknown";
  delete display;
  EXPECT_EQ(reason(325, 245), none);
  EXPECT_FALSE(picker.exists(held.hit->mesh));
  EXPECT_EQ(held.hit->queries->castRay({{0.1, 0.1, 1}, {0, 0, -1}}).distance, 1.0)
      << "what was hit stays for those who hold it";
}

TEST_F(SurfacePickerTest, what_cannot_be_seen_does_not_hide_and_what_is_not_ready_does)
{
  placed_.reserve(2);
  auto& far = place("far", 4, 0.0, {});
  viewFromAbove();
  spinFrames();
  waitUntilPrepared();
  ASSERT_TRUE(picker.pick(mouse(325, 245)).hit);
  auto& near = place("near", 300, 1.0, {{0, 0, 2}, {1, 0, 0, 0}});
  const Pick pick = picker.pick(mouse(325, 245));  // the first that is asked about "near"
  EXPECT_FALSE(pick.hit);
  EXPECT_NE(pick.reason.find("'near' is being prepared"), std::string::npos) << pick.reason;
  waitUntilPrepared();
  EXPECT_EQ(picker.pick(mouse(325, 245)).hit->mesh, near.mesh);
  near.display->setEnabled(false);
  EXPECT_EQ(picker.pick(mouse(325, 245)).hit->mesh, far.mesh);
}

TEST_F(SurfacePickerTest, an_event_without_a_camera_hits_nothing)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  waitUntilPrepared();
  auto event = mouse(320, 240);
  event.viewport = nullptr;
  EXPECT_FALSE(picker.pick(event).hit);
}
