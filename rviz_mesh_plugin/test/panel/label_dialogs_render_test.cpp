// Labels or the mesh change while a dialog is open, or are not known yet.
#include <string>

#include <QColorDialog>
#include <QComboBox>
#include <QFileDialog>
#include <QInputDialog>
#include <QLineEdit>
#include <QTemporaryDir>

#include <gtest/gtest.h>

#include "label_panel_fixture.h"

class LabelDialogsTest : public LabelPanelFixture
{
 protected:
  testing::AssertionResult asks(const QString& text)
  {
    if (!spinUntil([&] { return open<QMessageBox>() != nullptr; })) {
      return testing::AssertionFailure() << "nothing is asked; " << this->text();
    }
    const QString asked = open<QMessageBox>()->text();
    return asked.contains(text) ? testing::AssertionSuccess()
                                : testing::AssertionFailure() << asked.toStdString();
  }

  void chooseFile(const QString& button, const QString& path)
  {
    click(button);
    auto* file = dialog<QFileDialog>();
    file->selectFile(path);
    static_cast<QDialog*>(file)->accept();
    ASSERT_TRUE(noDialog<QFileDialog>());
  }
};

TEST_F(LabelDialogsTest, a_name_that_has_come_meanwhile_is_asked_about)
{
  start();
  ASSERT_TRUE(select({100}));
  click("New…");
  auto* asked = dialog<QDialog>();
  asked->findChild<QComboBox*>()->setEditText("house");
  server->labels.publish(LabelServer::cluster("house_1", {150}));
  ASSERT_TRUE(spinUntil([&] { return list()->model()->rowCount() == 4; }));
  asked->accept();
  ASSERT_TRUE(asks("a label house_1 with faces already"));
  EXPECT_EQ(panel->session()->unstored(), 0u);
  answer("Add");
  ASSERT_TRUE(stores(1, "house_1", {100, 150}));
}

TEST_F(LabelDialogsTest, nothing_is_done_to_the_labels_of_another_mesh)
{
  start();
  choose({0, 1});
  click("Delete…");
  click("Color…");
  click("Merge…");
  ASSERT_TRUE(showGarden());
  answer("Delete");
  EXPECT_TRUE(shows("the mesh is another one now"));
  panel->session()->work(nullptr);
  EXPECT_EQ(panel->session()->unstored(), 0u);
  open<QColorDialog>()->accept();
  EXPECT_EQ(panel->session()->unstored(), 0u);
  open<QInputDialog>()->accept();
  EXPECT_EQ(panel->session()->unstored(), 0u);
  EXPECT_TRUE(server->edits().empty());
  EXPECT_TRUE(server->colorsSet().empty());
}

TEST_F(LabelDialogsTest, a_file_is_for_the_mesh_that_was_there)
{
  start();
  QTemporaryDir folder;
  chooseFile("Export…", folder.filePath("labels.json"));
  ASSERT_TRUE(shows("3 labels exported"));
  click("Import…");
  auto* file = dialog<QFileDialog>();
  file->selectFile(folder.filePath("labels.json"));
  ASSERT_TRUE(showGarden());
  static_cast<QDialog*>(file)->accept();
  EXPECT_TRUE(shows("the mesh is another one now"));
  EXPECT_EQ(panel->session()->unstored(), 0u);
  chooseFile("Import…", folder.filePath("labels.json"));
  ASSERT_TRUE(asks("made for another mesh"));
  ASSERT_TRUE(asks("not known yet"));
  answer("Cancel");
  EXPECT_EQ(panel->session()->unstored(), 0u);
}

TEST_F(LabelDialogsTest, labels_that_are_not_known_are_not_replaced_unasked)
{
  start();
  ASSERT_TRUE(showGarden());
  ASSERT_TRUE(select({100}));
  auto* name = panel->findChild<QLineEdit*>();
  name->setText("tree_1");
  refresh();
  click("Label Cluster");
  ASSERT_TRUE(spinUntil([&] { return server->edits().size() == 1; }));
  EXPECT_FALSE(server->edits()[0].override) << "what the label may have stays";
  EXPECT_TRUE(noDialog<QMessageBox>());
  ASSERT_TRUE(stores(1, "tree_1", {100}));
  choose({0});
  click("Rename…");
  dialog<QDialog>()->findChild<QComboBox*>()->setEditText("house");
  dialog<QDialog>()->accept();
  ASSERT_TRUE(asks("A label house_1 would be replaced"));
  answer("Rename");
  EXPECT_TRUE(panel->session()->isUnstored("house_1"));
}
