#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rviz/config.h>
#include <QColorDialog>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QEvent>
#include <QFileDialog>
#include <QGuiApplication>
#include <QHeaderView>
#include <QInputDialog>
#include <QKeyEvent>
#include <QKeySequence>
#include <QLabel>
#include <QLayout>
#include <QLineEdit>
#include <QMouseEvent>
#include <QScreen>
#include <QShortcut>
#include <QTemporaryDir>

#include "base/grouped_number.h"
#include "conversion/mesh_conversion.h"
#include "label_editing/label_files.h"
#include "label_panel_fixture.h"
#include "selection/selection_regions.h"

using rviz_mesh_plugin::ClusterLabelPanel;
using rviz_mesh_plugin::readLabelFile;
using test_labels::rows;

class ClusterLabelPanelTest : public LabelPanelFixture
{
 protected:
  class PaintCount : public QObject
  {
   public:
    bool eventFilter(QObject* /*object*/, QEvent* event) override
    {
      paints += event->type() == QEvent::Paint ? 1 : 0;
      return false;
    }
    int paints = 0;
  };
};

TEST_F(ClusterLabelPanelTest, lists_the_labels)
{
  start();
  EXPECT_EQ(cell(0, 0), "tree");
  EXPECT_EQ(cell(1, 1), "2");
  EXPECT_EQ(cell(2, 2), "20");
  ASSERT_TRUE(spinUntil([&] { return cell(2, 3) == rviz_mesh_plugin::groupedNumber(0.4, 2); }));
  EXPECT_TRUE(shows("3 labels."));
  auto* model = list()->model();
  ASSERT_TRUE(spinUntil([&] { return model->index(0, 0).data(Qt::DecorationRole).isValid(); }));
  const QColor color = model->index(0, 0).data(Qt::DecorationRole).value<QColor>();
  EXPECT_EQ(color.red(), test_labels::colorOf("tree").red);
  EXPECT_EQ(model->index(0, 0).data(Qt::CheckStateRole).toInt(), Qt::Checked);
  ASSERT_TRUE(model->setData(model->index(0, 0), Qt::Unchecked, Qt::CheckStateRole));
  EXPECT_TRUE(says(display, "Labels", "1 hidden"));
  EXPECT_FALSE(find(display, {"Visible Labels", "tree", "tree_1"})->getValue().toBool());
  keep(window.get(), "panel");
}

TEST_F(ClusterLabelPanelTest, ten_labels_are_seen_and_nothing_of_them_is_cut_off)
{
  for (int i = 1; i <= 12; ++i) {
    server->addLabel("tree_" + std::to_string(1000 + i), {static_cast<std::uint32_t>(i)});
  }
  server->addLabel("a_class_of_a_long_name_123456", {13});
  createMeshDisplay();
  display = createLabels();
  publishMesh();
  createPanel();
  window->resize(300, 300);  // as small as the panel allows
  ASSERT_TRUE(spinUntil([&] { return list()->model()->rowCount() == 13; }));
  spinFrames(3);
  const auto* rows = list()->verticalHeader();
  const int least =
      ClusterLabelPanel::leastRows(QGuiApplication::primaryScreen()->availableSize().height());
  EXPECT_GE(list()->viewport()->height(), least * rows->defaultSectionSize());
  EXPECT_EQ(ClusterLabelPanel::leastRows(1000), 10);
  EXPECT_LT(ClusterLabelPanel::leastRows(768), 10);
  const auto* header = list()->horizontalHeader();
  for (int column = 0; column < list()->model()->columnCount(); ++column) {
    EXPECT_GE(header->sectionSize(column),
              static_cast<QAbstractItemView*>(list())->sizeHintForColumn(column))
        << column;
  }
  keep(window.get(), "panel_small");
}

/// Two clicks within the time of a double click, which elsewhere selects faces.
TEST_F(ClusterLabelPanelTest, boxes_of_the_list_are_clicked_as_fast_as_one_likes)
{
  start();
  choose({1});
  const auto shown = [this] {
    return find(display, {"Visible Labels", "tree", "tree_1"})->getValue().toBool();
  };
  const QRect cell = list()->visualRect(list()->model()->index(0, 0));
  const QPoint box(cell.left() + 10, cell.center().y());
  const auto send = [&](QEvent::Type type, Qt::MouseButtons buttons) {
    QMouseEvent event(type, box, list()->viewport()->mapToGlobal(box), Qt::LeftButton, buttons,
                      Qt::NoModifier);
    QCoreApplication::sendEvent(list()->viewport(), &event);
  };
  send(QEvent::MouseButtonPress, Qt::LeftButton);
  send(QEvent::MouseButtonRelease, Qt::NoButton);
  EXPECT_FALSE(shown());
  spin(200);
  send(QEvent::MouseButtonDblClick, Qt::LeftButton);
  send(QEvent::MouseButtonRelease, Qt::NoButton);
  EXPECT_TRUE(shown());
  spin(200);
  EXPECT_EQ(tool->selection().count(), 0u) << "faces of the label that is chosen";
}

/// Who aims at one would hit another.
TEST_F(ClusterLabelPanelTest, buttons_stay_where_they_are_whatever_is_told)
{
  start();
  window->resize(360, 900);
  spin(100);
  const auto places = [this] {
    std::vector<QPoint> found;
    for (auto* each : panel->findChildren<QPushButton*>()) {
      found.push_back(each->mapTo(window.get(), QPoint()));
    }
    return found;
  };
  const auto before = places();
  QLabel* status = nullptr;
  for (auto* label : panel->findChildren<QLabel*>()) {
    status = label->text().contains("3 labels") ? label : status;
  }
  ASSERT_NE(status, nullptr);
  const int height = status->height();
  status->setText("3 labels.<br>This is not stored:<br>nobody<br>listens");
  panel->layout()->activate();
  EXPECT_GT(status->height(), 2 * height);
  EXPECT_EQ(places(), before);
}

TEST_F(ClusterLabelPanelTest, areas_of_labels_are_added_up_on_a_thread)
{
  const auto message = test_meshes::terrain(400, [](double, double) { return 0.0; });
  const auto mesh = rviz_mesh_plugin::convert(message);
  rviz_mesh_plugin::LabelClusters labels;
  auto large = std::make_shared<rviz_mesh_plugin::LabelCluster>();
  large->faces.resize(mesh->faceCount());
  std::iota(large->faces.begin(), large->faces.end(), 0u);
  labels["large_1"] = large;
  rviz_mesh_plugin::LabelAreas areas;
  EXPECT_FALSE(areas.follow(mesh, labels)) << "nothing is waited for";
  EXPECT_FALSE(areas.area("large_1"));
  ASSERT_TRUE(spinUntil([&] { return areas.follow(mesh, labels); }));
  const auto found = areas.area("large_1");
  ASSERT_TRUE(found) << "all of it at once";
  double sum = 0.0;
  for (const auto face : large->faces) {
    sum += rviz_mesh_plugin::faceArea(*mesh, face);
  }
  EXPECT_DOUBLE_EQ(*found, sum);
  auto fewer = std::make_shared<rviz_mesh_plugin::LabelCluster>();
  fewer->faces = {0};
  labels["large_1"] = fewer;
  EXPECT_TRUE(areas.follow(mesh, labels));
  EXPECT_FALSE(areas.area("large_1")) << "it is of other faces";
  areas.follow(nullptr, {});
  EXPECT_FALSE(areas.area("large_1"));
}

TEST(GroupedNumber, has_separators_in_every_locale)
{
  const QLocale before;
  QLocale::setDefault(QLocale::c());
  EXPECT_EQ(rviz_mesh_plugin::groupedNumber(std::uint64_t{1234567}), "1,234,567");
  EXPECT_EQ(rviz_mesh_plugin::groupedNumber(1234567.5, 2), "1,234,567.50");
  EXPECT_EQ(rviz_mesh_plugin::measuredNumber(1234567.8), "1,234,568");
  EXPECT_EQ(rviz_mesh_plugin::measuredNumber(2.05), "2.050");
  EXPECT_EQ(rviz_mesh_plugin::measuredNumber(0.0012345), "0.001234");
  EXPECT_EQ(rviz_mesh_plugin::measuredNumber(0.0), "0.000");
  QLocale::setDefault(QLocale(QLocale::German));
  EXPECT_EQ(rviz_mesh_plugin::groupedNumber(std::uint64_t{1234567}), "1.234.567");
  QLocale::setDefault(before);
}

TEST_F(ClusterLabelPanelTest, the_released_buttons_label_and_reset)
{
  start();
  auto* name = panel->findChild<QLineEdit*>();
  EXPECT_FALSE(button("Label Cluster")->isEnabled());
  EXPECT_TRUE(button("Label Cluster")->toolTip().contains("is empty"));
  name->setText("car_1");
  refresh();
  EXPECT_TRUE(button("Label Cluster")->toolTip().contains("nothing is selected"));
  EXPECT_FALSE(button("Label Cluster")->isEnabled());
  ASSERT_TRUE(select({100, 101}));
  click("Label Cluster");
  EXPECT_TRUE(shows("1 edit not stored yet"));
  EXPECT_EQ(cell(0, 0), "car");
  EXPECT_EQ(cell(0, 4), "…");
  keep(window.get(), "panel_unstored");
  ASSERT_TRUE(stores(1, "car_1", {100, 101}));
  EXPECT_EQ(cell(0, 4), "*");
  EXPECT_TRUE(shows("4 labels, 1 label not saved in the map."));
  ASSERT_TRUE(select({102}));
  click("Label Cluster");
  answer("Add");
  ASSERT_TRUE(stores(2, "car_1", {100, 101, 102}));
  click("Reset Faces");
  EXPECT_EQ(tool->selection().count(), 0u);
  refresh();
  EXPECT_FALSE(button("Reset Faces")->isEnabled());
  rviz_mesh_plugin::LabelSituation looking;
  looking.selecting = true;
  EXPECT_EQ(whyNot(rviz_mesh_plugin::LabelAction::RESET_FACES, looking), "") << "it gives that up";
  EXPECT_FALSE(button("Label Cluster")->isEnabled());
}

TEST_F(ClusterLabelPanelTest, the_name_is_in_the_config)
{
  createPanel();
  panel->findChild<QLineEdit*>()->setText("car_7");
  rviz::Config config;
  panel->save(config);
  QString name;
  EXPECT_TRUE(config.mapGetString("ClusterName", &name));
  EXPECT_EQ(name, "car_7");
  ClusterLabelPanel other;
  other.load(config);
  EXPECT_EQ(other.findChild<QLineEdit*>()->text(), "car_7");
  refresh();
  EXPECT_TRUE(shows("No labels to edit: add a Map3D display"));
  for (const auto* button : panel->findChildren<QPushButton*>()) {
    EXPECT_FALSE(button->isEnabled()) << button->text().toStdString();
    EXPECT_TRUE(button->toolTip().contains("Not now: "));
  }
}

TEST_F(ClusterLabelPanelTest, enter_in_the_tool_asks_for_class_and_instance)
{
  start();
  ASSERT_TRUE(select({100}));
  Q_EMIT tool->labelRequested();
  auto* asked = dialog<QDialog>();
  auto* ok = asked->findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Ok);
  auto* label_class = asked->findChild<QComboBox*>();
  auto* instance = asked->findChildren<QLineEdit*>().last();
  EXPECT_EQ(label_class->count(), 2);
  EXPECT_EQ(label_class->currentText(), "tree");
  EXPECT_EQ(instance->text(), "3") << "the next one";
  keep(asked, "panel_new");
  instance->setText("2");
  EXPECT_FALSE(ok->isEnabled()) << "there is a tree_2";
  label_class->setEditText("a/b");
  EXPECT_FALSE(ok->isEnabled());
  label_class->setEditText("wall");
  EXPECT_EQ(instance->text(), "2");
  ASSERT_TRUE(ok->isEnabled());
  ok->click();
  EXPECT_EQ(tool->selection().count(), 0u) << "the next label begins with nothing";
  EXPECT_TRUE(tool->selection().canUndo());
  ASSERT_TRUE(stores(1, "wall_2", {100}));
  EXPECT_TRUE(noDialog<QDialog>());
  Q_EMIT tool->labelRequested();
  EXPECT_TRUE(shows("nothing is selected"));
}

TEST_F(ClusterLabelPanelTest, labels_and_selection_are_undone_in_one_order)
{
  start();
  const Faces first{100, 101}, second{120};
  ASSERT_TRUE(select(first));
  Q_EMIT tool->labelRequested();
  auto* asked = dialog<QDialog>();
  asked->findChild<QComboBox*>()->setEditText("rock");
  asked->findChildren<QLineEdit*>().last()->setText("5");
  asked->findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Ok)->click();
  ASSERT_TRUE(stores(1, "rock_5", first));
  EXPECT_TRUE(tool->selection().empty());
  ASSERT_TRUE(select(second));
  const auto press = [&](int key, Qt::KeyboardModifiers more = Qt::NoModifier) {
    QKeyEvent event(QEvent::KeyPress, key, Qt::ControlModifier | more);
    tool->processKeyEvent(&event, nullptr);
    refresh();
  };
  press(Qt::Key_Z);
  EXPECT_TRUE(tool->selection().empty());
  EXPECT_EQ(panel->session()->faceCount("rock_5"), 2u) << "the selection was newer";
  press(Qt::Key_Z);
  EXPECT_EQ(panel->session()->faceCount("rock_5"), 0u);
  ASSERT_TRUE(stores(2, "rock_5", {}));
  EXPECT_EQ(tool->selection().faces(), first) << "labelling is one step, with its selection";
  press(Qt::Key_Z);
  EXPECT_TRUE(tool->selection().empty());
  press(Qt::Key_Z);
  EXPECT_EQ(tool->undo(), "there is nothing to undo");
  press(Qt::Key_Y);
  EXPECT_EQ(tool->selection().faces(), first);
  press(Qt::Key_Z, Qt::ShiftModifier);
  EXPECT_EQ(panel->session()->faceCount("rock_5"), 2u);
  ASSERT_TRUE(stores(3, "rock_5", first));
  EXPECT_TRUE(tool->selection().empty());
  press(Qt::Key_Z);
  ASSERT_TRUE(select({5}));
  EXPECT_EQ(tool->redo(), "there is nothing to redo") << "something else was done since";
  EXPECT_EQ(panel->session()->faceCount("rock_5"), 0u);
}

TEST_F(ClusterLabelPanelTest, its_own_keys_undo_where_no_view_has_the_focus)
{
  start();
  choose({0});
  ASSERT_TRUE(select({150}));
  click("Assign");
  EXPECT_EQ(panel->session()->faceCount("tree_1"), 1u);
  ASSERT_TRUE(stores(1, "tree_1", {150}));
  const auto activate = [&](const char* keys) {
    for (auto* shortcut : panel->findChildren<QShortcut*>()) {
      if (shortcut->key() == QKeySequence(keys)) {
        Q_EMIT shortcut->activated();
        return;
      }
    }
    ADD_FAILURE() << "no key " << keys;
  };
  activate("Ctrl+Z");
  EXPECT_EQ(panel->session()->faceCount("tree_1"), 20u);
  EXPECT_EQ(tool->selection().faces(), Faces{150}) << "which is older";
  EXPECT_TRUE(shows("undone: labelling"));
  ASSERT_TRUE(stores(2, "tree_1", rows(10, 0, 1)));
  activate("Ctrl+Shift+Z");
  EXPECT_EQ(panel->session()->faceCount("tree_1"), 1u);
  ASSERT_TRUE(stores(3, "tree_1", {150}));
  tool.reset();
  activate("Ctrl+Z");
  EXPECT_EQ(panel->session()->faceCount("tree_1"), 20u) << "also without the tool";
}

TEST_F(ClusterLabelPanelTest, buttons_edit_what_is_chosen)
{
  start();
  EXPECT_FALSE(button("Assign")->isEnabled());
  ASSERT_TRUE(select({0, 100}));
  choose({0, 1});
  EXPECT_FALSE(button("Assign")->isEnabled()) << "two are chosen";
  choose({0});
  click("Assign");
  ASSERT_TRUE(stores(1, "tree_1", {0, 100}));
  ASSERT_TRUE(select({100, 101}));
  click("Add");
  ASSERT_TRUE(stores(2, "tree_1", {0, 100, 101}));
  click("Take Away");
  ASSERT_TRUE(stores(3, "tree_1", {0}));
  choose({0, 2});
  click("Select Faces");
  Faces both = {0};
  for (const std::uint32_t face : rows(10, 2, 3)) {
    both.push_back(face);
  }
  EXPECT_EQ(tool->selection().faces(), both);
  click("Merge…");
  auto* merge = dialog<QInputDialog>();
  merge->setTextValue("wall_1");
  merge->accept();
  ASSERT_TRUE(stores(4, "wall_1", both));
  ASSERT_TRUE(stores(5, "tree_1", {}));
  EXPECT_EQ(list()->model()->rowCount(), 2);
  choose({1});
  click("Rename…");
  auto* rename = dialog<QDialog>();
  rename->findChild<QComboBox*>()->setEditText("house");
  EXPECT_EQ(rename->findChildren<QLineEdit*>().last()->text(), "1") << "the instance stays";
  rename->accept();
  ASSERT_TRUE(stores(6, "house_1", both));
  ASSERT_TRUE(stores(7, "wall_1", {}));
  choose({0, 1});
  click("Delete…");
  answer("Cancel");
  EXPECT_EQ(panel->session()->unstored(), 0u);
  click("Delete…");
  answer("Delete");
  ASSERT_TRUE(stores(8, "house_1", {}));
  ASSERT_TRUE(stores(9, "tree_2", {}));
  EXPECT_EQ(list()->model()->rowCount(), 0);
}

TEST_F(ClusterLabelPanelTest, colors_are_set_for_labels_and_classes)
{
  start();
  choose({0});
  click("Color…");
  auto* colors = dialog<QColorDialog>();
  const osmesa_harness::Rgb tree = test_labels::colorOf("tree");
  EXPECT_EQ(colors->currentColor(), QColor(tree.red, tree.green, tree.blue)) << "that it has";
  colors->setCurrentColor(QColor(10, 20, 30));
  colors->accept();
  ASSERT_TRUE(spinUntil([&] { return server->colorsSet().size() == 1; }));
  EXPECT_EQ(server->colorsSet()[0].label, "tree_1");
  EXPECT_EQ(server->colorsSet()[0].color.b, 30 / 255.0f);
  ASSERT_TRUE(noDialog<QColorDialog>());
  click("Class Color…");
  dialog<QColorDialog>()->accept();
  ASSERT_TRUE(spinUntil([&] { return server->colorsSet().size() == 3; }));
  EXPECT_EQ(server->colorsSet()[2].label, "tree_2");
}

TEST_F(ClusterLabelPanelTest, a_label_gets_the_color_of_its_class_back)
{
  start();
  server->colors.publish(colorsOf({{"tree_1", {10, 20, 30}}}));
  const auto color = [&] {
    return list()->model()->index(0, 0).data(Qt::DecorationRole).value<QColor>();
  };
  ASSERT_TRUE(spinUntil([&] { return color() == QColor(10, 20, 30); }));
  choose({0});
  click("Color…");
  auto* colors = dialog<QColorDialog>();
  EXPECT_EQ(colors->currentColor(), QColor(10, 20, 30)) << "the own one";
  keep(colors, "panel_color");
  for (auto* button : colors->findChildren<QPushButton*>()) {
    if (button->text() == "Color of Class") {
      button->click();
    }
  }
  ASSERT_TRUE(noDialog<QColorDialog>());
  ASSERT_TRUE(spinUntil([&] { return server->colorsSet().size() == 1; })) << text();
  EXPECT_EQ(server->colorsSet()[0].label, "tree_1");
  EXPECT_EQ(server->colorsSet()[0].color.a, 0.0f);
  server->colors.publish(colorsOf({}));
  const osmesa_harness::Rgb tree = test_labels::colorOf("tree");
  EXPECT_TRUE(spinUntil([&] { return color() == QColor(tree.red, tree.green, tree.blue); }));
  EXPECT_EQ(server->colorsSet().size(), 1u);
}

TEST_F(ClusterLabelPanelTest, the_list_is_painted_only_where_something_has_changed)
{
  start();
  PaintCount count;
  list()->viewport()->installEventFilter(&count);
  const auto painted = [&] {
    count.paints = 0;
    for (int i = 0; i < 3; ++i) {
      refresh();
      spinFrames(1);
    }
    return count.paints > 0;
  };
  ASSERT_TRUE(spinUntil([&] { return !painted(); }));
  server->colors.publish(colorsOf({{"tree_1", {10, 20, 30}}}));
  EXPECT_TRUE(spinUntil(painted)) << "a color";
  ASSERT_TRUE(spinUntil([&] { return !painted(); }));
  find(display, {"Visible Labels", "tree"})->setValue(false);
  EXPECT_TRUE(spinUntil(painted)) << "a class is hidden";
  ASSERT_TRUE(spinUntil([&] { return !painted(); }));
  server->labels.publish(LabelServer::cluster("tree_1", {1}));
  EXPECT_TRUE(spinUntil(painted)) << "other faces";
  EXPECT_EQ(cell(0, 2), "1");
}

TEST_F(ClusterLabelPanelTest, labels_are_exported_and_imported)
{
  start();
  QTemporaryDir folder;
  const QString path = folder.filePath("labels.csv");
  click("Export…");
  auto* written = dialog<QFileDialog>();
  written->selectFile(path);
  static_cast<QDialog*>(written)->accept();
  EXPECT_TRUE(shows("3 labels exported to " + path.toStdString()));
  keep(window.get(), "panel_exported");
  EXPECT_EQ(readLabelFile(path.toStdString(), 200).labels.at("tree_2").faces, rows(10, 1, 2));
  ASSERT_TRUE(noDialog<QFileDialog>());
  const auto import = [&](const char* content) {
    SCOPED_TRACE(content);
    QFile changed(path);
    ASSERT_TRUE(changed.open(QIODevice::WriteOnly));
    changed.write(content);
    changed.close();
    ASSERT_TRUE(spinUntil([&] {
      button("Import…")->click();  // is refused while a file is written
      return open<QFileDialog>() != nullptr;
    }));
    auto* file = open<QFileDialog>();
    file->selectFile(path);
    static_cast<QDialog*>(file)->accept();
    ASSERT_TRUE(noDialog<QFileDialog>());
  };
  import("label,first_face\ncar_1,7\n");
  ASSERT_TRUE(stores(1, "car_1", {7}));
  EXPECT_TRUE(shows("1 label imported from " + path.toStdString()));
  import("label,first_face\ncar_1,8\n");
  EXPECT_TRUE(dialog<QMessageBox>()->text().contains("replace car_1"));
  answer("Import");
  ASSERT_TRUE(stores(2, "car_1", {8}));
  import("label,first_face\ncar_1,200\n");
  EXPECT_TRUE(shows("labels.csv: line 2: '200' is no face"));
}
