#include <cmath>
#include <string>
#include <thread>

#include <geometry_msgs/PointStamped.h>
#include <QDir>
#include <QFile>
#include <QFileDialog>
#include <QLabel>
#include <QMessageBox>
#include <QPushButton>
#include <QTableWidget>
#include <QTemporaryDir>

#include "measurement/measurement_files.h"
#include "support/kept_picture.h"
#include "surface_tool_fixture.h"
#include "tools/measuring/measurement_pane.h"
#include "tools/mesh_measure_tool.h"

using rviz_mesh_plugin::Measurement;
using rviz_mesh_plugin::MeasurementKind;
using rviz_mesh_plugin::MeshMeasureTool;

/// Seen from above: 100 pixels a meter.
class MeshMeasureTest : public ToolFixture
{
 protected:
  void SetUp() override
  {
    ToolFixture::SetUp();
    QObject::connect(manager(), &rviz::VisualizationManager::statusUpdate, &guard_,
                     [this](const QString& text) { said = text.toStdString(); });
    tool = std::make_unique<MeshMeasureTool>();
    tool->initialize(manager());
    tool->activate();
  }
  void TearDown() override
  {
    tool.reset();
    ToolFixture::TearDown();
  }

  /// Flat for x < 0, and 45 degrees up from there.
  static mesh_msgs::MeshGeometryStamped fold(std::uint32_t cells = 20)
  {
    return test_meshes::terrain(cells, [](double x, double) { return std::max(0.0, x); });
  }
  static double xOf(int pixel) { return (pixel + 0.5 - 320) / 100.0; }
  static double yOf(int pixel) { return (240 - pixel - 0.5) / 100.0; }

  Display* showGray(const mesh_msgs::MeshGeometryStamped& message)
  {
    auto* display = createMeshDisplay();
    DisplayFixture::set(display, {"Display Type", "Faces Color"}, QColor(120, 130, 160));
    EXPECT_TRUE(show(display, message));
    EXPECT_TRUE(spinUntil([&] { return display->shownMeshes().size() == 1; }));
    waitUntilPrepared();
    viewFromAbove();
    spinFrames();
    return display;
  }

  void choose(const char* kind)
  {
    tool->getPropertyContainer()->subProp("Measure")->setValue(QString(kind));
  }
  void click(int x, int y)
  {
    for (const auto type : {QEvent::MouseButtonPress, QEvent::MouseButtonRelease}) {
      auto event = mouse(x, y, type, Qt::LeftButton);
      tool->processMouseEvent(event);
    }
  }
  void key(int key)
  {
    QKeyEvent event(QEvent::KeyPress, key, Qt::NoModifier);
    tool->processKeyEvent(&event, panel());
  }
  bool says(const std::string& text) const { return said.find(text) != std::string::npos; }
  const std::vector<Measurement>& all() const { return tool->measurements().all(); }
  testing::AssertionResult measured(std::size_t count)
  {
    const bool done = spinUntil([&] {
      return all().size() == count && std::none_of(all().begin(), all().end(), [](const auto& one) {
               return one.state == Measurement::WAITING;
             });
    });
    return done ? testing::AssertionSuccess() : testing::AssertionFailure() << said;
  }
  QTableWidget* table() const { return tool->pane()->findChild<QTableWidget*>(); }
  QString cell(int row, int column) const { return table()->item(row, column)->text(); }
  QPushButton* button(const QString& text) const
  {
    for (auto* one : tool->pane()->findChildren<QPushButton*>()) {
      if (one->text() == text) {
        return one;
      }
    }
    throw std::runtime_error(text.toStdString());
  }
  bool reports(const QString& text) const
  {
    for (const auto* label : tool->pane()->findChildren<QLabel*>()) {
      if (label->text().contains(text)) {
        return true;
      }
    }
    return false;
  }
  /// Answers the dialog of files as its user does.
  void exportTo(const QString& name, const QString& path)
  {
    button(name)->click();
    auto* dialog = tool->pane()->findChild<QFileDialog*>();
    ASSERT_TRUE(dialog);
    EXPECT_EQ(dialog->acceptMode(), QFileDialog::AcceptSave);
    EXPECT_FALSE(dialog->testOption(QFileDialog::DontConfirmOverwrite)) << "it asks";
    Q_EMIT dialog->fileSelected(path);
    delete dialog;
  }
  static std::string textOf(const QString& path)
  {
    QFile file(path);
    return file.open(QIODevice::ReadOnly) ? file.readAll().toStdString() : "none";
  }
  void keep(const char* name)
  {
    spinFrames();
    grab().save(osmesa_harness::resultsFolder() + "/" + name);
  }

  std::unique_ptr<MeshMeasureTool> tool;
  std::string said;

 private:
  QObject guard_;
};

TEST_F(MeshMeasureTest, distances_are_kept_one_beside_the_other)
{
  EXPECT_EQ(tool->getShortcutKey(), 'd');
  EXPECT_TRUE(says("Click at two points")) << said;
  showGray(fold());
  click(247, 301);
  EXPECT_TRUE(says("second point")) << said;
  click(372, 157);
  click(372, 300);
  click(400, 150);
  ASSERT_TRUE(measured(2));
  const Measurement& first = all()[0];
  const double x = xOf(372), x0 = xOf(247), y = yOf(157) - yOf(301);
  EXPECT_NEAR(first.straight(), std::hypot(x - x0, y, x), 1e-5);
  EXPECT_NEAR(first.plan(), std::hypot(x - x0, y), 1e-5);
  EXPECT_NEAR(first.rise(), x, 1e-5);
  EXPECT_NEAR(first.slope(), std::atan2(x, std::hypot(x - x0, y)), 1e-5);
  EXPECT_NEAR(first.result.path.length, std::hypot(std::sqrt(2.0) * x - x0, y), 1e-4);
  EXPECT_NE(tool->measurements().measuredBy(), std::this_thread::get_id());
  EXPECT_NE(tool->measurements().measuredBy(), std::thread::id());
  EXPECT_TRUE(says("Distance 2: ")) << said;
  ASSERT_EQ(table()->rowCount(), 2);
  EXPECT_EQ(cell(0, 2).toStdString(), first.value());
  EXPECT_EQ(cell(0, 3).toStdString(), first.details());
  EXPECT_EQ(first.frame, "map");
  EXPECT_EQ(first.uuid, "mesh");
  keep("mesh_measure_distances.png");
  tool->deactivate();
  EXPECT_EQ(all().size(), 2u) << "they stay with another tool";
}

TEST_F(MeshMeasureTest, nothing_is_measured_on_the_gui_thread)
{
  showGray(fold(100));
  choose("Area");
  for (const auto& [x, y] : {std::pair{250, 200}, {400, 200}, {400, 300}}) {
    click(x, y);
  }
  key(Qt::Key_Return);
  ASSERT_EQ(all().size(), 1u);
  EXPECT_EQ(all()[0].state, Measurement::WAITING) << "it is another thread's";
  choose("Profile");
  click(250, 240);
  click(400, 240);
  EXPECT_EQ(all()[1].state, Measurement::WAITING);
  ASSERT_TRUE(measured(2));
  EXPECT_NE(tool->measurements().measuredBy(), std::this_thread::get_id());
}

TEST_F(MeshMeasureTest, an_area_on_a_slope)
{
  showGray(fold());
  choose("Area");
  click(340, 200);
  click(400, 200);
  EXPECT_TRUE(says("2 corners")) << said;
  key(Qt::Key_Return);
  EXPECT_TRUE(says("three corners at least")) << said;
  click(400, 290);
  click(300, 160);
  key(Qt::Key_Backspace);
  EXPECT_TRUE(says("3 corners")) << said;
  click(340, 290);
  click(341, 201);  // the first corner
  ASSERT_TRUE(measured(1));
  const auto& area = all()[0].result.area;
  EXPECT_NEAR(area.plan, 0.6 * 0.9, 1e-5);
  EXPECT_NEAR(area.surface, std::sqrt(2.0) * 0.6 * 0.9, 1e-5);
  EXPECT_EQ(area.uncovered, 0.0);
  EXPECT_EQ(all()[0].value(), "0.764 m²");
  EXPECT_EQ(all()[0].details(), "0.540 m² in plan, 3.497 m around");
  // Closed by a double click.
  for (const auto& [x, y] : {std::pair{240, 200}, {300, 200}, {300, 300}, {300, 300}}) {
    click(x, y);
  }
  ASSERT_TRUE(measured(2));
  EXPECT_NEAR(all()[1].result.area.surface, 0.3, 1e-5);
  keep("mesh_measure_areas.png");
  // One that crosses itself is told.
  for (const auto& [x, y] : {std::pair{250, 250}, {380, 320}, {380, 250}, {250, 320}}) {
    click(x, y);
  }
  key(Qt::Key_Enter);
  ASSERT_TRUE(measured(3));
  EXPECT_EQ(all()[2].state, Measurement::FAILED);
  EXPECT_TRUE(says("crosses itself")) << said;
}

TEST_F(MeshMeasureTest, a_profile_and_its_files)
{
  showGray(test_meshes::terrain(20, [](double x, double) { return x < -0.01 ? 0.0 : 0.3; }));
  choose("Profile");
  click(250, 240);
  click(390, 240);
  ASSERT_TRUE(measured(1));
  const auto& profile = all()[0].result.profile;
  EXPECT_TRUE(profile.connected);
  EXPECT_NEAR(profile.heights().ascent, 0.3, 1e-6);
  EXPECT_NEAR(profile.heights().surface, 1.3 + std::hypot(0.1, 0.3), 1e-5);
  table()->selectRow(0);
  tool->pane()->resize(330, 480);
  tool->pane()->grab().save(QString::fromStdString(osmesa_harness::resultsFolder()) +
                            "/mesh_measure_pane.png");
  QTemporaryDir folder;
  const QString path = folder.filePath("profile.csv");
  exportTo("Export Profile…", path);
  ASSERT_TRUE(spinUntil([&] { return reports("The profile was written"); }));
  EXPECT_EQ(textOf(path), rviz_mesh_plugin::profileToCsv(all()[0]));
  EXPECT_EQ(textOf(path).rfind("piece,distance_m,z_m,x_m,y_m,frame,map_uuid\n1,0.000000,", 0), 0u);
  choose("Distance");
  click(250, 200);
  click(390, 200);
  ASSERT_TRUE(measured(2));
  exportTo("Export…", path);
  ASSERT_TRUE(spinUntil([&] { return reports("2 measurements were written"); }))
      << "the dialog has asked whether to replace it";
  EXPECT_EQ(textOf(path), rviz_mesh_plugin::measurementsToCsv(all()));
  exportTo("Export…", folder.filePath("none/file.csv"));
  ASSERT_TRUE(spinUntil([&] { return reports("none/file.csv cannot be written: "); }));
  keep("mesh_measure_profile.png");
}

TEST_F(MeshMeasureTest, one_or_all_are_deleted)
{
  showGray(fold());
  const auto nodes = counts().nodes;
  for (int y = 180; y < 300; y += 40) {
    click(250, y);
    click(390, y);
  }
  ASSERT_TRUE(measured(3));
  table()->selectRow(1);
  button("Delete")->click();
  ASSERT_EQ(all().size(), 2u);
  EXPECT_EQ(all()[1].number, 3u) << "numbers stay";
  EXPECT_EQ(table()->rowCount(), 2);
  button("Delete All…")->click();
  auto* box = tool->pane()->findChild<QMessageBox*>();
  ASSERT_TRUE(box);
  EXPECT_EQ(all().size(), 2u) << "it asks";
  box->accept();
  EXPECT_TRUE(all().empty());
  EXPECT_FALSE(button("Delete All…")->isEnabled());
  spinFrames();
  EXPECT_EQ(counts().nodes, nodes) << "the marks are gone";
}

TEST_F(MeshMeasureTest, costs_leave_them_and_another_mesh_makes_them_stale)
{
  auto* display = showGray(fold());
  click(250, 240);
  click(390, 240);
  ASSERT_TRUE(measured(1));
  spinFrames();
  const auto nodes = counts().nodes;
  costs.publish(test_meshes::costs("slope", std::vector<float>(21 * 21, 0.5f)));
  ASSERT_TRUE(spinUntil([&] { return display->costTypes().size() == 1; }));
  spinFrames();
  EXPECT_FALSE(all()[0].stale);
  EXPECT_EQ(counts().nodes, nodes);
  auto other = test_meshes::square();
  other.uuid = "other";
  ASSERT_TRUE(show(display, other));
  ASSERT_TRUE(spinUntil([&] { return all()[0].stale; }));
  EXPECT_TRUE(cell(0, 3).startsWith("the mesh is gone; ")) << cell(0, 3).toStdString();
  EXPECT_TRUE(rviz_mesh_plugin::measurementsToCsv(all()).find("mesh gone") != std::string::npos);
  EXPECT_LT(counts().nodes, nodes) << "nothing is drawn of it";
  // Another one of that name and size, and then the same again.
  ASSERT_TRUE(show(display, test_meshes::terrain(20, [](double x, double) { return 0.5 * x; })));
  spinFrames();
  EXPECT_TRUE(all()[0].stale);
  ASSERT_TRUE(show(display, fold()));
  ASSERT_TRUE(spinUntil([&] { return !all()[0].stale; }));
  // With another height between the points, and nowhere else.
  auto hump = fold();
  hump.mesh_geometry.vertices[10 * 21 + 11].z += 0.02;
  ASSERT_TRUE(show(display, hump));
  ASSERT_TRUE(spinUntil([&] { return all()[0].stale; }));
  ASSERT_TRUE(show(display, fold()));
  ASSERT_TRUE(spinUntil([&] { return !all()[0].stale; }));
  EXPECT_EQ(all()[0].state, Measurement::DONE);
  delete display;
  ASSERT_TRUE(spinUntil([&] { return all()[0].stale; }));
}

TEST_F(MeshMeasureTest, points_of_two_meshes_and_a_mesh_that_goes)
{
  auto* first = showGray(test_meshes::square());
  first->setName("first");
  auto* second = createMeshDisplay();
  second->setName("second");
  const std::string other_topic = geometry_topic + "/other";
  const auto publisher = node.advertise<mesh_msgs::MeshGeometryStamped>(other_topic, 1, true);
  DisplayFixture::set(second, {"Geometry Topic"}, other_topic.c_str());
  auto message = test_meshes::square();
  message.header.frame_id = "aside";
  message.uuid = "second";
  putFrame("aside", {{2.1, 0, 0}, {1, 0, 0, 0}});
  publisher.publish(message);
  ASSERT_TRUE(spinUntil([&] { return second->shownMeshes().size() == 1; }));
  waitUntilPrepared();
  click(320, 240);
  click(500, 240);
  EXPECT_TRUE(says("this one is on that of 'second', the others on that of 'first'")) << said;
  EXPECT_TRUE(all().empty());
  delete first;
  EXPECT_TRUE(spinUntil([&] { return says("is gone"); })) << said;
  click(320, 240);
  EXPECT_TRUE(says("Nothing can be measured here: no surface")) << said;
  click(480, 200);
  click(550, 240);
  ASSERT_TRUE(measured(1));
  EXPECT_EQ(all()[0].frame, "aside");
  EXPECT_NEAR(all()[0].points[0].position[0], xOf(480) - 2.1, 1e-5) << "in the mesh's own frame";
  // Destroyed in the middle of measuring.
  click(480, 200);
  click(550, 250);
  tool.reset();
  spinFrames();
}
