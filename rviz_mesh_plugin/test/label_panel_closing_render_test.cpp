// What becomes of labels that are not saved where the panel, its window, display or tool goes.
#include <gtest/gtest.h>
#include <QComboBox>
#include <QTimer>

#include "label_panel_fixture.h"
#include "save_server.h"

using test_labels::rows;

class LabelPanelClosingTest : public LabelPanelFixture
{
};

TEST_F(LabelPanelClosingTest, closing_with_unsaved_labels_asks)
{
  start();
  EXPECT_TRUE(window->close()) << "nothing has changed";
  window->show();
  ASSERT_TRUE(select({100}));
  choose({0});
  click("Add");
  Faces faces = rows(10, 0, 1);
  faces.push_back(100);
  ASSERT_TRUE(stores(1, "tree_1", faces));
  EXPECT_FALSE(window->close());
  EXPECT_FALSE(window->close()) << "twice";
  EXPECT_EQ(panel->findChildren<QMessageBox*>().size(), 1) << "is asked once";
  keep(dialog<QMessageBox>(), "panel_closing");
  answer("Cancel");
  refresh();
  EXPECT_TRUE(window->isVisible());
  SaveServer saver(name_space);
  saver.refusal = "the disk is full";
  EXPECT_FALSE(window->close());
  answer("Save");
  EXPECT_TRUE(dialog<QMessageBox>()->text().contains("the disk is full"));
  EXPECT_TRUE(window->isVisible());
  saver.refusal.clear();
  answer("Save");
  EXPECT_TRUE(spinUntil([&] { return !window->isVisible(); }));
  EXPECT_EQ(saver.calls, 2);
  window->show();
  click("Take Away");
  EXPECT_FALSE(window->close());
  EXPECT_TRUE(dialog<QMessageBox>()->text().contains("1 edit is not stored"));
  answer("Discard");
  EXPECT_TRUE(spinUntil([&] { return !window->isVisible(); }));
}

TEST_F(LabelPanelClosingTest, display_and_tool_may_go_at_any_time)
{
  start(false);
  ASSERT_TRUE(select({100}));
  choose({0});
  click("Add");
  EXPECT_TRUE(shows("nobody stores labels"));
  click("Rename…");
  delete display;
  tool.reset();
  dialog<QDialog>()->findChild<QComboBox*>()->setEditText("house");
  dialog<QDialog>()->accept();
  EXPECT_TRUE(shows("there is no mesh to label"));
  EXPECT_FALSE(button("Assign")->isEnabled());
  click("Send Again");
  EXPECT_TRUE(shows("no display shows the labels of its mesh"));
  click("Give Up");
  EXPECT_EQ(panel->session()->unstored(), 0u);
  EXPECT_TRUE(shows("No labels to edit"));
  EXPECT_TRUE(window->close());
}

TEST_F(LabelPanelClosingTest, a_panel_that_is_removed_asks_and_can_still_save)
{
  start();
  ASSERT_TRUE(select({100}));
  choose({0});
  click("Assign");
  ASSERT_TRUE(spinUntil([&] { return server->edits().size() == 1; }));
  delete panel;
  panel = nullptr;
  auto* asked = window->findChild<QMessageBox*>();
  ASSERT_TRUE(asked);
  EXPECT_TRUE(asked->text().contains("1 edit is not stored")) << asked->text().toStdString();
  for (QAbstractButton* button : asked->buttons()) {
    if (button->text().remove('&') == "Save") {
      button->click();
    }
  }
  SaveServer saver(name_space);
  server->labels.publish(server->edits()[0].cluster);
  EXPECT_TRUE(spinUntil([&] { return saver.calls == 1; }));
  EXPECT_TRUE(spinUntil([&] { return window->findChild<QTimer*>() == nullptr; }));
}
