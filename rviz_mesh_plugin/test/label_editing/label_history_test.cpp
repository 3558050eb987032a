#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "label_editing/label_history.h"

using rviz_mesh_plugin::LabelHistory;
using rviz_mesh_plugin::LabelStep;
using rviz_mesh_plugin::MeshId;

namespace {

MeshId meshOf(std::size_t number)
{
  return {"mesh " + std::to_string(number), 10};
}

LabelStep step(const MeshId& mesh, std::uint64_t order)
{
  LabelStep step;
  step.order = order;
  step.mesh = mesh;
  return step;
}

}  // namespace

/// Else whoever looks at one map after the other keeps the labels of all of them in memory.
TEST(LabelHistory, forgets_meshes_that_were_edited_before_many_others)
{
  LabelHistory history;
  std::uint64_t order = 0;
  for (std::size_t number = 0; number < LabelHistory::MESHES; ++number) {
    history.addDone(step(meshOf(number), ++order));
  }
  history.addUndone(step(meshOf(0), ++order));
  history.addDone(step(meshOf(0), ++order));  // is edited again
  EXPECT_EQ(history.undoOrder(meshOf(1)), 2u);

  history.addDone(step(meshOf(LabelHistory::MESHES), ++order));
  EXPECT_EQ(history.undoOrder(meshOf(1)), 0u);
  EXPECT_EQ(history.undoOrder(meshOf(2)), 3u);
  EXPECT_EQ(history.undoOrder(meshOf(0)), LabelHistory::MESHES + 2);
  EXPECT_EQ(history.redoOrder(meshOf(0)), LabelHistory::MESHES + 1);
  for (std::size_t number = 10; number < 10 + LabelHistory::MESHES; ++number) {
    history.addUndone(step(meshOf(number), ++order));
  }
  EXPECT_EQ(history.undoOrder(meshOf(0)), 0u);
  EXPECT_EQ(history.redoOrder(meshOf(0)), 0u);
  EXPECT_EQ(history.redoOrder(meshOf(10)), order - LabelHistory::MESHES + 1);
}
