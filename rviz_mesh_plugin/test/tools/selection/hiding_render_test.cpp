// Hidden faces are neither drawn nor pointed at nor selected, and hide nothing.
#include <cmath>
#include <numeric>

#include <mesh_msgs/MeshFaceCostsStamped.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <osmesa_harness/image.h>

#include "base/hidden_faces.h"
#include "selection/selection_visual.h"
#include "selection_tool_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::Rgb;
using rviz_mesh_plugin::hiddenFaces;
using rviz_mesh_plugin::HiddenFacesConstPtr;
using rviz_mesh_plugin::SurfaceIndex;

namespace {

constexpr std::uint32_t STOREY = 800;  ///< faces

}  // namespace

class HidingTest : public SelectionToolFixture
{
 protected:
  void TearDown() override
  {
    if (mesh) {
      rviz_mesh_plugin::setHiddenFaces(*mesh, nullptr);
    }
    mesh.reset();
    SelectionToolFixture::TearDown();
  }

  /// The floor is red, the roof above it blue.
  Display* showStoreys()
  {
    Display* display = of_storeys = createMeshDisplay();
    set(display, {"Display Type"}, "Vertex Color");
    const std::size_t count = storeys().mesh_geometry.vertices.size();
    std::vector<std_msgs::ColorRGBA> values(count / 2, test_meshes::color(1, 0, 0));
    values.resize(count, test_meshes::color(0, 0, 1));
    colors.publish(test_meshes::colors(values));
    EXPECT_TRUE(show(display, storeys()));
    waitUntilPrepared();
    EXPECT_TRUE(spinUntil([&] { return display->attributes(*display->mesh()).colors != nullptr; }));
    mesh = shown().mesh;
    EXPECT_TRUE(spinUntil(
        [&] { return SurfaceIndex::instance().findNeighbors(mesh).neighbors != nullptr; }));
    viewFromAbove();
    tool->update(0.03f, 0.03f);
    spinFrames();
    return display;
  }

  void selectRoof()
  {
    Faces roof(STOREY);
    std::iota(roof.begin(), roof.end(), STOREY);
    ASSERT_EQ(tool->select(mesh, roof), "");
    ASSERT_TRUE(settle());
  }

  void hideRoof()
  {
    selectRoof();
    key(Qt::Key_H);
    ASSERT_TRUE(settle());
    ASSERT_TRUE(drawn(STOREY));
  }

  std::size_t hidden() const
  {
    const HiddenFacesConstPtr faces = hiddenFaces(*mesh);
    return faces ? faces->count() : 0;
  }

  /// So many faces are, once the thread has laid them out.
  testing::AssertionResult drawn(std::size_t count)
  {
    std::size_t now = 0;
    const bool is = spinUntil([&] {
      grab();
      now = of_storeys->visual()->facesDrawn();
      return now == count;
    });
    return is ? testing::AssertionSuccess() : testing::AssertionFailure() << now << " are drawn";
  }

  static int pixels(const Image& image, bool blue)
  {
    int count = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const Rgb at = image.at(x, y);
        count += blue ? (at.blue > at.red + 60 ? 1 : 0) : (at.red > at.blue + 60 ? 1 : 0);
      }
    }
    return count;
  }

  std::size_t ofRoof() const
  {
    const Faces faces = selected();
    return static_cast<std::size_t>(faces.end() -
                                    std::lower_bound(faces.begin(), faces.end(), STOREY));
  }

  Display* of_storeys = nullptr;
  rviz_mesh_plugin::MeshDataConstPtr mesh;
  const Pixel A{180, 110}, B{430, 350};
};

TEST_F(HidingTest, what_is_hidden_is_not_drawn_and_not_selected_any_more)
{
  showStoreys();
  EXPECT_GT(pixels(grab(), true), 30000);
  EXPECT_EQ(pixels(grab(), false), 0);
  selectRoof();
  key(Qt::Key_H);
  ASSERT_TRUE(settle());
  EXPECT_EQ(hidden(), STOREY);
  EXPECT_TRUE(selected().empty());
  EXPECT_TRUE(says("800 of 1600 faces are hidden: Ctrl+H shows them again")) << said.toStdString();
  ASSERT_TRUE(drawn(STOREY));
  EXPECT_EQ(pixels(grab(), true), 0);
  EXPECT_GT(pixels(grab(), false), 30000) << "the floor is seen";
  EXPECT_TRUE(spinUntil([&] {
    return status(of_storeys, "Hidden").find("800 of 1600 faces are hidden") != std::string::npos;
  })) << status(of_storeys, "Hidden");
  key(Qt::Key_H, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(hidden(), 0u);
  ASSERT_TRUE(drawn(2 * STOREY));
  EXPECT_GT(pixels(grab(), true), 30000);
  EXPECT_TRUE(spinUntil([&] { return status(of_storeys, "Hidden").empty(); }));
  key(Qt::Key_H, Qt::ControlModifier);
  EXPECT_TRUE(says("No face is hidden"));
}

TEST_F(HidingTest, isolate_hides_the_others_and_keeps_the_selection)
{
  showStoreys();
  click({320, 240});
  key(Qt::Key_Plus);
  ASSERT_TRUE(settle());
  const Faces few = selected();
  ASSERT_GT(few.size(), 1u);
  key(Qt::Key_H, Qt::ShiftModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected(), few);
  EXPECT_EQ(hidden(), 2 * STOREY - few.size());
  ASSERT_TRUE(drawn(few.size()));
  key(Qt::Key_H, Qt::ShiftModifier);
  ASSERT_TRUE(settle());
  EXPECT_TRUE(says("All other faces are hidden already")) << said.toStdString();
  key(Qt::Key_H);
  ASSERT_TRUE(settle());
  EXPECT_EQ(hidden(), 2 * STOREY);
  ASSERT_TRUE(drawn(0));
  EXPECT_TRUE(waitForStatus(of_storeys, "Hidden", "Warn", "nothing is drawn"));
  EXPECT_FALSE(picker.pick(mouse(320, 240)).hit);
  EXPECT_NE(picker.pick(mouse(320, 240)).reason.find("Ctrl+H"), std::string::npos);
  key(Qt::Key_A, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_TRUE(selected().empty()) << "there is nothing to be selected";
  key(Qt::Key_H);
  EXPECT_TRUE(says("Select faces first, to hide them")) << said.toStdString();
  key(Qt::Key_H, Qt::ShiftModifier);
  EXPECT_TRUE(says("Select faces first, to see them alone")) << said.toStdString();
}

TEST_F(HidingTest, a_click_goes_through)
{
  showStoreys();
  EXPECT_GE(picker.pick(mouse(320, 240)).hit->face, STOREY);
  const double above = picker.pick(mouse(320, 240)).hit->distance;
  hideRoof();
  const auto hit = picker.pick(mouse(320, 240)).hit;
  ASSERT_TRUE(hit);
  EXPECT_LT(hit->face, STOREY);
  EXPECT_NEAR(hit->distance, above + 1.0, 1e-6);
}

TEST_F(HidingTest, no_way_of_selecting_takes_it)
{
  Display* shown_by = showStoreys();
  choose("Brush Radius", 3.0f);
  hideRoof();
  const std::vector<std::function<void()>> ways{
      [&] {
        drag({A, B});
      },
      [&] {
        choose("Mode", "Lasso");
        drag(LASSO);
        choose("Mode", "Box");
      },
      [&] {
        drag({{300, 220}, {330, 250}}, Qt::LeftButton, Qt::ControlModifier);
      },
      [&] { key(Qt::Key_A, Qt::ControlModifier); },
      [&] { key(Qt::Key_I, Qt::ControlModifier); },
      [&] {
        tool->selectBy(mesh, rviz_mesh_plugin::HeightCriterion(),
                       rviz_mesh_plugin::Combination::REPLACE);
      },
      [&] {
        choose("Mode", "Flood");
        choose("Flood Angle", 90.0f);
        click({320, 240});
        choose("Mode", "Box");
      }};
  for (std::size_t way = 0; way < ways.size(); ++way) {
    key(Qt::Key_Delete);
    ways[way]();
    ASSERT_TRUE(settle());
    EXPECT_EQ(ofRoof(), 0u) << way;
    EXPECT_GT(selected().size(), 300u) << way;
  }
  key(Qt::Key_Plus);
  ASSERT_TRUE(settle());
  EXPECT_EQ(ofRoof(), 0u);
  EXPECT_EQ(selected().size(), STOREY);
  // With a section, too.
  set(shown_by, {"Section", "Max X"}, 0.0f);
  set(shown_by, {"Section"}, true);
  key(Qt::Key_Delete);
  key(Qt::Key_A, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(ofRoof(), 0u);
  EXPECT_NEAR(static_cast<double>(selected().size()), STOREY / 2, 45);
}

TEST_F(HidingTest, it_hides_nothing)
{
  showStoreys();
  choose("Selection", "Visible Only");
  drag({A, B});
  ASSERT_TRUE(settle());
  const std::size_t seen = selected().size();
  EXPECT_EQ(ofRoof(), seen) << "the roof hides the floor";
  hideRoof();
  for (const char* mode : {"Box", "Lasso"}) {
    choose("Mode", mode);
    key(Qt::Key_Delete);
    drag(std::string(mode) == "Box" ? std::vector<Pixel>{A, B} : LASSO);
    ASSERT_TRUE(settle());
    EXPECT_EQ(ofRoof(), 0u) << mode;
    EXPECT_GT(selected().size(), seen / 3) << mode;
  }
  choose("Mode", "Flood");
  choose("Flood Angle", 90.0f);
  key(Qt::Key_Delete);
  click({320, 240});
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected().size(), STOREY) << "all of the floor is seen";
}

TEST_F(HidingTest, flooding_and_growing_stop_at_it)
{
  showStoreys();
  hideRoof();
  drag({{320, 100}, {330, 380}});  // a wall of hidden faces through the floor
  ASSERT_TRUE(settle());
  const std::size_t wall = selected().size();
  key(Qt::Key_H);
  ASSERT_TRUE(settle());
  ASSERT_TRUE(drawn(STOREY - wall));
  choose("Mode", "Flood");
  choose("Flood Angle", 90.0f);
  click({280, 240});
  ASSERT_TRUE(settle());
  const std::size_t side = selected().size();
  EXPECT_LT(side, STOREY - wall);
  EXPECT_GT(side, STOREY / 3);
  key(Qt::Key_Plus);
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected().size(), side);
}

TEST_F(HidingTest, steps_are_undone_with_those_of_the_selection)
{
  showStoreys();
  selectRoof();
  const Faces roof = selected();
  key(Qt::Key_H);
  ASSERT_TRUE(settle());
  click({320, 240});
  ASSERT_TRUE(settle());
  ASSERT_EQ(selected().size(), 1u);
  key(Qt::Key_H, Qt::ShiftModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(hidden(), 2 * STOREY - 1);
  key(Qt::Key_H, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(hidden(), 0u);
  const auto undo = [&] {
    key(Qt::Key_Z, Qt::ControlModifier);
    ASSERT_TRUE(settle());
  };
  undo();
  EXPECT_EQ(hidden(), 2 * STOREY - 1) << "of all shown";
  undo();
  EXPECT_EQ(hidden(), STOREY) << "of isolate";
  EXPECT_EQ(selected().size(), 1u);
  undo();
  EXPECT_EQ(hidden(), STOREY);
  EXPECT_TRUE(selected().empty()) << "of the click";
  undo();
  EXPECT_EQ(hidden(), 0u);
  EXPECT_EQ(selected(), roof) << "one step: hidden, and not selected any more";
  ASSERT_TRUE(drawn(2 * STOREY));
  for (const std::size_t expected : {STOREY, STOREY, 2 * STOREY - 1, 0u}) {
    key(Qt::Key_Y, Qt::ControlModifier);
    ASSERT_TRUE(settle());
    EXPECT_EQ(hidden(), expected);
  }
  EXPECT_EQ(selected().size(), 1u);
  undo();
  click({10, 10});
  key(Qt::Key_Delete);
  key(Qt::Key_Y, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(hidden(), 2 * STOREY - 1) << "something else has been done since";
}

TEST_F(HidingTest, it_stays_so_in_all_displays_and_after_reset)
{
  Display* first = showStoreys();
  hideRoof();
  Display* second = createMeshDisplay();
  ASSERT_TRUE(spinUntil([&] {
    grab();
    return second->visual() && second->visual()->progress() >= 1.0f &&
           second->visual()->facesDrawn() == STOREY;
  })) << "one that is added later";
  first->reset();
  second->reset();
  EXPECT_EQ(first->mesh(), nullptr);
  colors.publish(test_meshes::colors(std::vector<std_msgs::ColorRGBA>(
      storeys().mesh_geometry.vertices.size(), test_meshes::color(0, 1, 0))));
  geometry.publish(storeys());
  ASSERT_TRUE(spinUntil([&] { return first->mesh() && second->mesh(); }));
  EXPECT_TRUE(drawn(STOREY));
  EXPECT_EQ(hidden(), STOREY);
  key(Qt::Key_H, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_TRUE(drawn(2 * STOREY));
  EXPECT_TRUE(spinUntil([&] {
    grab();
    return second->visual()->facesDrawn() == 2 * STOREY;
  }));
}

TEST_F(HidingTest, another_mesh_of_that_name_is_whole)
{
  Display* shown_by = showStoreys();
  hideRoof();
  auto other = storeys();
  other.mesh_geometry.faces.pop_back();
  geometry.publish(other);
  ASSERT_TRUE(spinUntil(
      [&] { return shown_by->mesh() && shown_by->mesh()->faceCount() == 2 * STOREY - 1; }));
  EXPECT_TRUE(drawn(2 * STOREY - 1));
  EXPECT_TRUE(spinUntil([&] { return status(shown_by, "Hidden").empty(); }));
}

/// Layouts that are split otherwise, and a hiding that comes while one is made.
TEST_F(HidingTest, all_ways_of_coloring_leave_it_out)
{
  Display* shown_by = showStoreys();
  hideRoof();
  for (const char* type : {"Fixed Color", "Height", "Vertex Color"}) {
    set(shown_by, {"Display Type"}, type);
    EXPECT_TRUE(drawn(STOREY)) << type;
  }
  mesh_msgs::MeshMaterialsStamped materials;  // of every other face
  materials.header.frame_id = "map";
  materials.uuid = "mesh";
  materials.mesh_materials.materials.resize(1);
  materials.mesh_materials.materials[0].color = test_meshes::color(1, 1, 0);
  materials.mesh_materials.clusters.resize(1);
  materials.mesh_materials.cluster_materials = {0};
  for (std::uint32_t face = 0; face < 2 * STOREY; face += 2) {
    materials.mesh_materials.clusters[0].face_indices.push_back(face);
  }
  auto of_materials =
      node.advertise<mesh_msgs::MeshMaterialsStamped>(geometry_topic + "_materials", 1, true);
  set(shown_by, {"Display Type", "Materials Topic"}, (geometry_topic + "_materials").c_str());
  of_materials.publish(materials);
  set(shown_by, {"Display Type"}, "Textures");
  ASSERT_TRUE(spinUntil([&] {
    return shown_by->visual()->shownLayout()->split == rviz_mesh_plugin::Split::BY_MATERIAL;
  })) << status(shown_by, "Textures");
  EXPECT_TRUE(drawn(STOREY));
  std::vector<float> costs(2 * STOREY, 0.0f);
  mesh_msgs::MeshFaceCostsStamped message;
  message.header.frame_id = "map";
  message.uuid = "mesh";
  message.type = "slope";
  message.mesh_face_costs.costs = costs;
  auto face_costs =
      node.advertise<mesh_msgs::MeshFaceCostsStamped>(geometry_topic + "_costs", 1, true);
  set(shown_by, {"Display Type", "Face Costs Topic"}, (geometry_topic + "_costs").c_str());
  face_costs.publish(message);
  set(shown_by, {"Display Type"}, "Vertex Costs");
  ASSERT_TRUE(spinUntil([&] {
    return shown_by->visual()->shownLayout()->split == rviz_mesh_plugin::Split::BY_FACE;
  })) << status(shown_by, "Costs");
  EXPECT_TRUE(drawn(STOREY));
  set(shown_by, {"Display Type"}, "Fixed Color");
  key(Qt::Key_H, Qt::ControlModifier);
  key(Qt::Key_Z, Qt::ControlModifier);
  key(Qt::Key_Y, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_TRUE(drawn(2 * STOREY));
}

/// Faces of labels, which may be assigned to these again, are not left out.
TEST_F(HidingTest, what_is_selected_by_label_is_all_of_it_and_highlighted_where_it_is_shown)
{
  showStoreys();
  hideRoof();
  Faces all(2 * STOREY);
  std::iota(all.begin(), all.end(), 0);
  ASSERT_EQ(tool->select(mesh, all), "");
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected(), all);
  const auto highlighted = [&](std::size_t count) {
    return spinUntil([&] {
      grab();
      return tool->visual()->isCurrent() && tool->visual()->facesDrawn() == count;
    });
  };
  EXPECT_TRUE(highlighted(STOREY)) << tool->visual()->facesDrawn();
  key(Qt::Key_H, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_TRUE(highlighted(2 * STOREY)) << tool->visual()->facesDrawn();
  EXPECT_EQ(selected(), all);
}

/// Whatever points at the mesh while edits wait finds what these leave shown.
TEST_F(HidingTest, what_is_pointed_at_is_found_when_its_turn_comes)
{
  showStoreys();
  choose("Flood Angle", 90.0f);
  choose("Brush Radius", 0.2f);
  struct Way
  {
    const char* mode;
    std::vector<Pixel> path;
    Qt::KeyboardModifiers modifiers;
    std::size_t of_roof;  ///< at least, where that is shown
  };
  const std::vector<Way> ways{{"Box", {A, B}, Qt::NoModifier, 300},
                              {"Lasso", LASSO, Qt::NoModifier, 100},
                              {"Box", {{320, 240}}, Qt::NoModifier, 1},
                              {"Flood", {{320, 240}}, Qt::NoModifier, STOREY},
                              {"Box", {{300, 220}, {320, 240}}, Qt::ControlModifier, 3}};
  for (const char* seen : {"Through", "Visible Only"}) {
    choose("Selection", seen);
    for (const Way& way : ways) {
      const auto select = [&](bool shown_again, bool one_by_one) {
        key(Qt::Key_H, Qt::ControlModifier);
        EXPECT_TRUE(settle());
        selectRoof();
        const auto wait = [&] { EXPECT_TRUE(!one_by_one || settle()); };
        key(Qt::Key_H);
        wait();
        if (shown_again) {
          EXPECT_TRUE(settle());
          key(Qt::Key_A, Qt::ControlModifier);  // of what is shown: takes its time
          wait();
          key(Qt::Key_H, Qt::ControlModifier);
          wait();
        }
        EXPECT_EQ(tool->busy(), !one_by_one);
        choose("Mode", way.mode);
        drag(way.path, Qt::LeftButton, way.modifiers);
        EXPECT_TRUE(settle());
        return selected();
      };
      const std::string name =
          std::string(seen) + ", " + way.mode + ", " + std::to_string(way.of_roof);
      EXPECT_EQ(select(true, false), select(true, true)) << name;
      EXPECT_GE(ofRoof(), way.of_roof) << name;
      EXPECT_EQ(select(false, false), select(false, true)) << name;
      EXPECT_EQ(ofRoof(), 0u) << name;
    }
  }
}

TEST_F(HidingTest, what_waits_is_found_in_the_picture_in_which_it_was_pointed_at)
{
  showStoreys();
  const std::vector<std::function<void()>> ways{
      [&] {
        drag({A, B});
      },
      [&] {
        click({320, 240});
      },
      [&] {
        drag({{300, 220}, {320, 240}}, Qt::LeftButton, Qt::ControlModifier);
      }};
  choose("Brush Radius", 0.2f);
  for (std::size_t way = 0; way < ways.size(); ++way) {
    const auto select = [&](bool one_by_one) {
      key(Qt::Key_H, Qt::ControlModifier);
      viewFromAbove();
      spinFrames();
      selectRoof();
      key(Qt::Key_H);
      EXPECT_TRUE(!one_by_one || settle());
      ways[way]();
      lookAt({3, -2, 2.5}, {0.3, -0.2, 0.4});
      EXPECT_TRUE(settle());
      return selected();
    };
    const Faces expected = select(true);
    EXPECT_FALSE(expected.empty());
    EXPECT_EQ(select(false), expected) << way;
  }
}

TEST_F(HidingTest, a_text_lasts_no_longer_than_what_it_says)
{
  showStoreys();
  selectRoof();
  key(Qt::Key_H);
  ASSERT_TRUE(tool->busy());
  key(Qt::Key_Z, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  spinFrames();
  EXPECT_EQ(hidden(), 0u);
  EXPECT_FALSE(says("are hidden")) << said.toStdString();
  EXPECT_TRUE(says("800 faces are selected")) << said.toStdString();
}

/// Rays that meet hidden faces go on; all else is as without any.
TEST_F(HidingTest, what_is_seen_does_not_depend_on_what_is_hidden_elsewhere)
{
  showStoreys();
  choose("Selection", "Visible Only");
  choose("Mode", "Lasso");
  drag(LASSO);
  ASSERT_TRUE(settle());
  const Faces seen = selected();
  ASSERT_GT(seen.size(), 100u);
  ASSERT_EQ(tool->select(mesh, {0}), "");  // of the floor, in a corner
  key(Qt::Key_H);
  ASSERT_TRUE(settle());
  ASSERT_EQ(hidden(), 1u);
  drag(LASSO);
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected(), seen);
}

TEST_F(HidingTest, a_step_is_not_undone_over_what_another_tool_has_hidden)
{
  showStoreys();
  hideRoof();
  const auto other = std::make_shared<const rviz_mesh_plugin::HiddenFaces>(
      rviz_mesh_plugin::FaceBits(mesh->faceCount(), {1, 2, 3}));
  rviz_mesh_plugin::setHiddenFaces(*mesh, other);
  key(Qt::Key_Z, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(hiddenFaces(*mesh), other);
  EXPECT_TRUE(says("with another tool: this step is forgotten")) << said.toStdString();
  key(Qt::Key_Y, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(hiddenFaces(*mesh), other);
}

TEST_F(HidingTest, undoing_it_on_a_mesh_that_is_not_shown_says_so)
{
  Display* shown_by = showStoreys();
  hideRoof();
  shown_by->setEnabled(false);
  key(Qt::Key_Z, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(hidden(), 0u);
  EXPECT_TRUE(says("Faces of a mesh that is not shown now are hidden or shown again"))
      << said.toStdString();
}
