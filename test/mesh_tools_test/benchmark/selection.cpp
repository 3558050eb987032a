// The C++ side of selection.py: the real tool in RViz's own panel, from a mouse event to the
// updated index buffer, beside a scan of all faces by OpenCL.
//
//     headless --master selection_benchmark FOLDER REPEATS
//
// FOLDER has vertices.f32 and faces.u32; REPEATS are the places in each mode. Prints lines
// "name value": milliseconds and counts.
#include <ros/init.h>
#include <rviz/properties/property.h>
#include <rviz/tool_manager.h>
#include <rviz/viewport_mouse_event.h>
#include "displays/display_tree.h"
#include "displays/textured_mesh_display.h"
#include "picking/surface_index.h"
#include "picking/surface_picker.h"
#include "picking/view_geometry.h"
#include "rendering/mesh_visual.h"
#include "selection/selection_visual.h"
#include "tools/cluster_label_tool.h"

#include <OgreRenderWindow.h>
#include <QKeyEvent>
#include <QMouseEvent>

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <random>

#include "linear_scan.h"
#include "rviz_subjects.h"

namespace rviz_benchmark::selection {
namespace {

using rviz_mesh_plugin::ClusterLabelTool;

constexpr int WIDTH = 1280;
constexpr int HEIGHT = 960;
constexpr int STROKE_EVENTS = 300;
constexpr float RADIUS = 1.0f;  // meters

void tell(const std::string& name, double value)
{
  std::printf("%s %.9g\n", name.c_str(), value);
  std::fflush(stdout);
}

double quantile(std::vector<double> values, double part)
{
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

rviz::ViewportMouseEvent mouse(const QPoint& at, QEvent::Type type, Qt::MouseButton button,
                               Qt::KeyboardModifiers modifiers)
{
  const Qt::MouseButtons buttons = type == QEvent::MouseButtonRelease ? Qt::NoButton : button;
  QMouseEvent event(type, QPointF(at), type == QEvent::MouseMove ? Qt::NoButton : button, buttons,
                    modifiers);
  return {Stage::panel(), Stage::panel()->getViewport(), &event, at.x(), at.y()};
}

/// The tool and its mouse.
class Hand
{
 public:
  explicit Hand(ClusterLabelTool& tool) : tool_(tool) {}

  /// Milliseconds until the highlight is as the event wants it.
  double send(const QPoint& at, QEvent::Type type, Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    auto event = mouse(at, type, Qt::LeftButton, modifiers);
    const auto start = Clock::now();
    tool_.processMouseEvent(event);
    while (tool_.busy()) {
      QApplication::processEvents();
    }
    return milliseconds(Clock::now() - start);
  }

  std::size_t count() const { return tool_.selection().count(); }

  void clear()
  {
    tool_.clearSelection();
    Stage::spinFrames(1);
  }

 private:
  ClusterLabelTool& tool_;
};

struct Times
{
  std::vector<double> milliseconds;
  std::size_t faces = 0;

  void tell(const std::string& name) const
  {
    selection::tell(name, quantile(milliseconds, 0.5));
    selection::tell(name + "_tail", quantile(milliseconds, 0.95));
    selection::tell(name + "_faces",
                    static_cast<double>(faces) / static_cast<double>(milliseconds.size()));
  }
};

mesh_map::Ray rayAt(const QPoint& at)
{
  return rviz_mesh_plugin::cursorRay(mouse(at, QEvent::MouseMove, Qt::NoButton, Qt::NoModifier));
}

/// The sides of the frustum of a rectangle.
LinearScan::Planes planesOf(const QRect& rect)
{
  const std::array<QPoint, 4> corners{rect.topLeft(), rect.bottomLeft(), rect.bottomRight(),
                                      rect.topRight()};
  LinearScan::Planes planes;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto a = rayAt(corners[i]);
    const auto b = rayAt(corners[(i + 1) % 4]);
    const auto inside = rayAt(rect.center());
    std::array<double, 3> normal{a.direction[1] * b.direction[2] - a.direction[2] * b.direction[1],
                                 a.direction[2] * b.direction[0] - a.direction[0] * b.direction[2],
                                 a.direction[0] * b.direction[1] - a.direction[1] * b.direction[0]};
    double side = 0.0, offset = 0.0;
    for (int k = 0; k < 3; ++k) {
      side += normal[k] * inside.direction[k];
    }
    for (int k = 0; k < 3; ++k) {
      normal[k] = side < 0.0 ? -normal[k] : normal[k];
      offset -= normal[k] * a.origin[k];
      planes[i][k] = static_cast<float>(normal[k]);
    }
    planes[i][3] = static_cast<float>(offset);
  }
  return planes;
}

template <class Ask>
void ask(Times& times, const Ask& question)
{
  const auto start = Clock::now();
  times.faces += question();
  times.milliseconds.push_back(milliseconds(Clock::now() - start));
}

void measureTable(Hand& hand, LinearScan* scan, int repeats)
{
  Times single, radius, box, scan_single, scan_radius, scan_box;
  std::mt19937 random(1);
  const auto anywhere = [&random]() {
    return QPoint(std::uniform_int_distribution<int>(WIDTH / 4, 3 * WIDTH / 4)(random),
                  std::uniform_int_distribution<int>(HEIGHT / 3, 3 * HEIGHT / 4)(random));
  };
  for (int i = 0; i < repeats; ++i) {
    const QPoint at = anywhere();
    const mesh_map::Ray ray = rayAt(at);
    hand.send(at, QEvent::MouseButtonPress);
    single.milliseconds.push_back(hand.send(at, QEvent::MouseButtonRelease));
    single.faces += hand.count();
    hand.clear();
    radius.milliseconds.push_back(hand.send(at, QEvent::MouseButtonPress, Qt::ControlModifier));
    radius.faces += hand.count();
    hand.send(at, QEvent::MouseButtonRelease, Qt::ControlModifier);
    hand.clear();
    const QRect rect(at, at + QPoint(WIDTH / 8, HEIGHT / 8));
    hand.send(rect.topLeft(), QEvent::MouseButtonPress);
    hand.send(rect.center(), QEvent::MouseMove);
    hand.send(rect.bottomRight(), QEvent::MouseMove);
    box.milliseconds.push_back(hand.send(rect.bottomRight(), QEvent::MouseButtonRelease));
    box.faces += hand.count();
    hand.clear();
    if (scan != nullptr) {
      ask(scan_single, [&] { return scan->single(ray.origin, ray.direction); });
      ask(scan_radius, [&] { return scan->radius(ray.origin, ray.direction, RADIUS); });
      ask(scan_box, [&] { return scan->box(planesOf(rect)); });
    }
  }
  single.tell("single");
  radius.tell("radius");
  box.tell("box");
  if (scan != nullptr) {
    scan_single.tell("scan_single");
    scan_radius.tell("scan_radius");
    scan_box.tell("scan_box");
  }
}

/// A stroke over the window, as fast as it goes.
void measureStroke(Hand& hand)
{
  std::vector<double> times;
  hand.send({WIDTH / 4, HEIGHT / 2}, QEvent::MouseButtonPress, Qt::ControlModifier);
  for (int i = 1; i <= STROKE_EVENTS; ++i) {
    const QPoint at(WIDTH / 4 + i * WIDTH / 2 / STROKE_EVENTS,
                    HEIGHT / 2 + static_cast<int>(HEIGHT / 8 * std::sin(0.1 * i)));
    times.push_back(hand.send(at, QEvent::MouseMove, Qt::ControlModifier));
  }
  hand.send({3 * WIDTH / 4, HEIGHT / 2}, QEvent::MouseButtonRelease, Qt::ControlModifier);
  double sum = 0.0;
  for (const double time : times) {
    sum += time;
  }
  tell("stroke_rate", 1000.0 * STROKE_EVENTS / sum);
  tell("stroke_longest", quantile(times, 1.0));
  tell("stroke_faces", static_cast<double>(hand.count()));
  hand.clear();
}

/// CPU milliseconds of a frame: the median of several.
double frameTime()
{
  Stage::spinFrames(3);
  std::vector<double> times;
  for (int i = 0; i < 7; ++i) {
    const double start = processMilliseconds();
    Stage::panel()->getRenderWindow()->update(true);
    times.push_back(processMilliseconds() - start);
  }
  return quantile(times, 0.5);
}

/// Whether the mesh is drawn without the faces that are hidden, and in full.
bool isLaidOut()
{
  bool done = true;
  rviz_mesh_plugin::visitDisplays<rviz_mesh_plugin::TexturedMeshDisplay>(
      Stage::manager()->getRootDisplayGroup(), rviz_mesh_plugin::DisplayChoice::ALL,
      [&](const rviz_mesh_plugin::TexturedMeshDisplay& display) {
        const auto* visual = display.visual();
        done = done && visual && visual->shownLayout() == visual->layout() &&
               visual->layout()->hidden == rviz_mesh_plugin::hiddenFaces(*display.mesh()) &&
               visual->progress() >= 1.0f;
      });
  return done;
}

/// Whether nothing is drawn any more of what is hidden.
bool isHidden()
{
  bool done = true;
  rviz_mesh_plugin::visitDisplays<rviz_mesh_plugin::TexturedMeshDisplay>(
      Stage::manager()->getRootDisplayGroup(), rviz_mesh_plugin::DisplayChoice::ALL,
      [&](const rviz_mesh_plugin::TexturedMeshDisplay& display) {
        const auto hidden = rviz_mesh_plugin::hiddenFaces(*display.mesh());
        done = done && hidden && display.visual() && display.visual()->hides(hidden);
      });
  return done;
}

/// What edits of many faces take of the GUI thread, and what their highlight takes of a frame.
void measureGui(ClusterLabelTool& tool)
{
  GuiThread gui;
  double hidden_after = 0.0;
  const auto start = Clock::now();
  const auto done = [&] {
    if (hidden_after == 0.0 && isHidden()) {
      hidden_after = milliseconds(Clock::now() - start);
    }
    return !tool.busy() && tool.visual()->isCurrent() && isLaidOut();
  };
  const auto edit = [&](const std::string& name, const std::function<void()>& action) {
    if (!gui.watch(action, done)) {
      throw std::runtime_error(name + " was not done in a minute");
    }
    tell("gui_" + name, gui.longest());
    tell("gui_" + name + "_all", gui.all());
  };
  const auto key = [&tool](int code, Qt::KeyboardModifiers modifiers) {
    QKeyEvent event(QEvent::KeyPress, code, modifiers);
    tool.processKeyEvent(&event, Stage::panel());
  };
  const auto send = [&tool](const QPoint& at, QEvent::Type type, Qt::KeyboardModifiers modifiers) {
    auto event = mouse(at, type, Qt::LeftButton, modifiers);
    tool.processMouseEvent(event);
  };
  const auto drag = [&](const QPoint& from, const QPoint& to, int moves,
                        Qt::KeyboardModifiers modifiers) {
    send(from, QEvent::MouseButtonPress, modifiers);
    for (int i = 1; i <= moves; ++i) {
      send(from + (to - from) * i / moves, QEvent::MouseMove, modifiers);
    }
    send(to, QEvent::MouseButtonRelease, modifiers);
  };
  const double plain_before = frameTime();
  edit("box", [&] { drag({2, 2}, {WIDTH - 3, HEIGHT - 3}, 3, Qt::NoModifier); });
  tell("gui_box_faces", static_cast<double>(tool.selection().count()));
  edit("undo", [&] { key(Qt::Key_Z, Qt::ControlModifier); });
  edit("redo", [&] { key(Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier); });
  edit("grow", [&] { key(Qt::Key_Plus, Qt::NoModifier); });
  edit("all", [&] { key(Qt::Key_A, Qt::ControlModifier); });
  tell("frame_all_selected", frameTime());
  edit("invert", [&] { key(Qt::Key_I, Qt::ControlModifier); });
  tell("frame_plain", 0.5 * (plain_before + frameTime()));  // nothing is selected, as before
  tool.getPropertyContainer()->subProp("Brush Radius")->setValue(5.0f);
  edit("brush", [&] {
    drag({WIDTH / 2 - 100, HEIGHT / 2}, {WIDTH / 2 + 100, HEIGHT / 2}, 10, Qt::ControlModifier);
  });
  tell("gui_brush_faces", static_cast<double>(tool.selection().count()));
  const double before = milliseconds(Clock::now() - start);
  edit("hide", [&] { key(Qt::Key_H, Qt::NoModifier); });
  tell("hide_until_gone", hidden_after - before);
  tell("hide_until_drawn", milliseconds(Clock::now() - start) - before);
  edit("show_all", [&] { key(Qt::Key_H, Qt::ControlModifier); });
  edit("undo_hide", [&] {
    key(Qt::Key_Z, Qt::ControlModifier);
    key(Qt::Key_Z, Qt::ControlModifier);
  });
  tool.clearSelection();
}

void measure(const World& world, int repeats)
{
  Stage::SetUpTestSuite();
  Stage::manager()->setFixedFrame("map");
  Stage::resizePanel(WIDTH, HEIGHT);
  const double x = 0.5 * (world.lower[0] + world.upper[0]);
  const double y = 0.5 * (world.lower[1] + world.upper[1]);
  const double size = std::max(world.upper[0] - world.lower[0], world.upper[1] - world.lower[1]);
  Stage::lookAt({x - 0.5 * size, y, world.upper[2] + 0.4 * size}, {x, y, world.lower[2]});
  const std::unique_ptr<Subject> subject = makeSubject("mesh");
  subject->create();
  const auto must = [](bool done, const char* what) {
    if (!done) {
      throw std::runtime_error(what);
    }
  };
  must(Stage::spinUntil([&] { return subject->ready(); }), "the display did not subscribe");
  subject->prepare(world);
  subject->show();
  auto* tool = dynamic_cast<ClusterLabelTool*>(
      Stage::manager()->getToolManager()->addTool("rviz_mesh_plugin/ClusterLabel"));
  must(tool != nullptr, "there is no tool rviz_mesh_plugin/ClusterLabel");
  tool->getPropertyContainer()->subProp("Brush Radius")->setValue(RADIUS);
  Stage::manager()->getToolManager()->setCurrentTool(tool);
  const rviz_mesh_plugin::SurfacePicker picker(Stage::manager());
  const auto start = Clock::now();
  const auto prepared = [&picker] {
    const auto shown = picker.meshes();
    return !shown.empty() &&
           rviz_mesh_plugin::SurfaceIndex::instance().find(shown.front().mesh).queries != nullptr;
  };
  while (!prepared()) {
    must(milliseconds(Clock::now() - start) < 300000.0, "the mesh was not prepared in 5 minutes");
    Stage::spinFrames(1);
  }
  for (int i = 0; i < 6; ++i) {
    Stage::spinFrames(5);  // what has to be uploaded once, is
  }
  std::unique_ptr<LinearScan> scan;
  try {
    scan = std::make_unique<LinearScan>(world);
  } catch (const std::exception& error) {
    std::cerr << "without the scan: " << error.what() << "\n";
  }
  Hand hand(*tool);
  hand.send({WIDTH / 2, HEIGHT / 2}, QEvent::MouseButtonPress);
  hand.send({WIDTH / 2, HEIGHT / 2}, QEvent::MouseButtonRelease);
  must(hand.count() == 1, "a click in the middle of the window selects nothing");
  for (int i = 0; i < 12; ++i) {
    Stage::spinFrames(5);
  }
  hand.clear();
  measureTable(hand, scan.get(), repeats);
  measureStroke(hand);
  const auto shown = picker.meshes().front().mesh;
  while (!rviz_mesh_plugin::SurfaceIndex::instance().findNeighbors(shown).neighbors) {
    Stage::spinFrames(1);
  }
  measureGui(*tool);
}

}  // namespace

int run(int argc, char** argv)
{
  ros::init(argc, argv, "selection_benchmark", ros::init_options::AnonymousName);
  const int repeats = argc == 3 ? std::atoi(argv[2]) : 0;
  if (repeats < 1) {
    std::cerr << "usage: selection_benchmark FOLDER REPEATS\n";
    return 2;
  }
  return rviz_benchmark::run("selection_benchmark", argc, argv,
                             [argv, repeats] { measure(readWorld(argv[1]), repeats); });
}

}  // namespace rviz_benchmark::selection
