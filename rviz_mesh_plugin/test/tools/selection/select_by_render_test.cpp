#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <optional>
#include <thread>

#include "picking/view_geometry.h"
#include "selection_tool_fixture.h"
#include "tools/selection/selection_editor.h"

using rviz_mesh_plugin::Combination;
using rviz_mesh_plugin::FaceBits;
using rviz_mesh_plugin::HeightCriterion;
using rviz_mesh_plugin::LayerCriterion;
using rviz_mesh_plugin::SelectionEditor;
using rviz_mesh_plugin::upInMesh;

class SelectByTest : public SelectionToolFixture
{
 protected:
  /// Of the middles of faces, in the fixed frame.
  HeightCriterion heights(double lower, double upper) const
  {
    return {upInMesh(shown()), shown().position.z, {lower, upper}};
  }

  Faces expected(double lower, double upper) const
  {
    const FixedPose askew{{0.3, -0.2, 0.4}, {0.9, 0.2, -0.1, 0.3}};
    const auto mesh = shown().mesh;
    Faces faces;
    for (std::uint32_t face = 0; face < mesh->faceCount(); ++face) {
      double height = 0.0;
      const auto corners = cornersOf(*mesh, face);
      for (unsigned i = 0; i < 3; ++i) {
        height += askew({corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]})[2] / 3.0;
      }
      if (height >= lower && height <= upper) {
        faces.push_back(face);
      }
    }
    return faces;
  }
};

TEST_F(SelectByTest, heights_are_those_in_the_fixed_frame)
{
  showTerrain();
  EXPECT_EQ(tool->selectBy(shown().mesh, heights(0.35, 0.6), Combination::REPLACE), "");
  EXPECT_TRUE(tool->busy()) << "however few, they are looked for on the thread";
  ASSERT_TRUE(settle());
  const Faces faces = expected(0.35, 0.6);
  EXPECT_GT(faces.size(), 30u);
  EXPECT_LT(faces.size(), 700u);
  EXPECT_EQ(selected(), faces);
}

TEST_F(SelectByTest, each_combination_is_one_step_to_undo_in_its_order)
{
  showTerrain();
  const auto mesh = shown().mesh;
  const auto setOf = [](const Faces& faces) {
    return std::set<std::uint32_t>(faces.begin(), faces.end());
  };
  tool->selectBy(mesh, heights(0.2, 0.6), Combination::REPLACE);
  tool->selectBy(mesh, heights(0.5, 0.9), Combination::ADD);
  tool->selectBy(mesh, heights(0.4, 0.5), Combination::TAKE_AWAY);
  tool->selectBy(mesh, heights(0.3, 0.7), Combination::INTERSECT);
  EXPECT_EQ(tool->waiting(), 4u);
  EXPECT_TRUE(selected().empty()) << "nothing before its turn";
  ASSERT_TRUE(settle());
  auto all = setOf(expected(0.2, 0.9));
  const auto undone = all;
  for (const auto face : expected(0.4, 0.5)) {
    all.erase(face);
  }
  const auto taken = all;
  for (auto face = all.begin(); face != all.end();) {
    face = setOf(expected(0.3, 0.7)).count(*face) ? std::next(face) : all.erase(face);
  }
  EXPECT_FALSE(all.empty());
  EXPECT_EQ(setOf(selected()), all);
  key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(setOf(selected()), taken);
  key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(setOf(selected()), undone);
  key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(selected(), expected(0.2, 0.6));
  key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_TRUE(selected().empty());
  EXPECT_FALSE(tool->selection().canUndo());
}

TEST_F(SelectByTest, the_gui_thread_looks_for_nothing)
{
  showTerrain();
  SelectionEditor editor(manager(), picker, [] {});
  const auto mesh = shown().mesh;
  std::promise<void> go;
  std::atomic<std::thread::id> looked{};
  const std::string text = editor.combine(
      mesh, Combination::REPLACE, [&, wait = go.get_future().share()](const std::atomic<bool>&) {
        looked = std::this_thread::get_id();
        wait.wait_for(std::chrono::seconds(5));
        return FaceBits(mesh->faceCount(), {1, 2, 3});
      });
  EXPECT_EQ(text, "");
  for (int frame = 0; frame < 5; ++frame) {
    EXPECT_EQ(editor.frame().text, std::nullopt) << "it goes on while they are looked for";
  }
  EXPECT_TRUE(editor.busy());
  EXPECT_TRUE(editor.session().selection().empty());
  go.set_value();
  ASSERT_TRUE(spinUntil([&] {
    editor.frame();
    return !editor.busy();
  }));
  EXPECT_NE(looked.load(), std::thread::id());
  EXPECT_NE(looked.load(), std::this_thread::get_id());
  EXPECT_EQ(editor.session().selection().faces(), (Faces{1, 2, 3}));
}

TEST_F(SelectByTest, says_why_nothing_is_selected)
{
  Display* display = showTerrain();
  const auto mesh = shown().mesh;
  EXPECT_NE(tool->selectBy(mesh, heights(0, 1), Combination::INTERSECT).find("nothing is selected"),
            std::string::npos);
  tool->selectBy(mesh, heights(0.2, 0.9), Combination::REPLACE);
  ASSERT_TRUE(settle());
  ASSERT_FALSE(selected().empty());
  tool->selectBy(mesh, heights(100, 200), Combination::REPLACE);
  ASSERT_TRUE(settle());
  EXPECT_TRUE(selected().empty()) << "there are none instead of those before";
  EXPECT_TRUE(says("The mesh has no such faces")) << said.toStdString();
  auto layer = std::make_shared<rviz_mesh_plugin::CostLayer>();
  layer->type = "short";
  layer->costs = {1.0f};
  tool->selectBy(mesh, LayerCriterion{layer, {}}, Combination::ADD);
  ASSERT_TRUE(settle());
  EXPECT_TRUE(says("the layer 'short' has 1 values instead of")) << said.toStdString();
  key(Qt::Key_Z, Qt::ControlModifier);
  tool->selectBy(mesh, heights(0.2, 0.9), Combination::ADD);
  key(Qt::Key_Escape);
  EXPECT_FALSE(tool->busy()) << "given up";
  display->setEnabled(false);
  spinFrames();
  EXPECT_FALSE(tool->shownMesh()) << "it is hidden";
  delete display;
  spinFrames();
  EXPECT_NE(
      tool->selectBy(mesh, HeightCriterion(), Combination::ADD).find("no display has this mesh"),
      std::string::npos);
}

TEST_F(SelectByTest, layers_are_those_that_have_arrived)
{
  auto* display = showTerrain(3);
  EXPECT_TRUE(tool->layersOf(shown().mesh).empty());
  costs.publish(test_meshes::costs("slope", std::vector<float>(16, 0.5f)));
  costs.publish(test_meshes::costs("border", std::vector<float>(16, 0.25f)));
  costs.publish(test_meshes::costs("other", std::vector<float>(16, 0.25f), "another"));
  ASSERT_TRUE(spinUntil([&] { return display->costTypes().size() == 2; }));
  const auto layers = tool->layersOf(shown().mesh);
  ASSERT_EQ(layers.size(), 2u);
  EXPECT_EQ(layers[0].name, "slope");
  EXPECT_EQ(layers[1].layer->costs.at(0), 0.25f);
}
