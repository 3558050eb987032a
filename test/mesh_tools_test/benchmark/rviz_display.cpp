// The C++ side of rviz_display.py: RViz's own panel and manager show one mesh in one way.
//
//     headless --master rviz_display_benchmark FOLDER SUBJECT QUIET [PICTURES]
//
// FOLDER has vertices.f32 and faces.u32; SUBJECT is mesh, marker or manual_object. A picture is
// complete when it has stayed the same for QUIET seconds. PICTURES: a folder for what was seen.
// Prints lines "name value": milliseconds, bytes and counts.
#include <malloc.h>
#include <ros/init.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <stdexcept>

#include "rviz_subjects.h"

namespace rviz_benchmark::display {
namespace {

constexpr int WIDTH = 1280;
constexpr int HEIGHT = 960;
constexpr double TIMEOUT = 120000.0;  // milliseconds
constexpr int FRAMES = 7;

void tell(const std::string& name, double value)
{
  std::printf("%s %.9g\n", name.c_str(), value);
  std::fflush(stdout);
}

/// A line of /proc/self/status in bytes.
double memory(const std::string& key)
{
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, key.size() + 1, key + ":") == 0) {
      return 1024.0 * std::stod(line.substr(key.size() + 1));
    }
  }
  return 0.0;
}

/// What is in use now: what malloc keeps for later goes back first.
double resident()
{
  malloc_trim(0);
  return memory("VmRSS");
}

double gpuBytes()
{
  const auto counts = Stage::counts();
  return static_cast<double>(counts.vertex_buffer_bytes + counts.index_buffer_bytes);
}

struct View
{
  const char* name;
  Stage::Point eye;
  Stage::Point target;
};

/// Far: the mesh is about a sixth as wide as the window. Full: it fills it. Inside: a person's eyes
/// in the middle, looking along the ground; what is behind is most of it.
std::array<View, 3> views(const World& world)
{
  const double x = 0.5 * (world.lower[0] + world.upper[0]);
  const double y = 0.5 * (world.lower[1] + world.upper[1]);
  const double z = 0.5 * (world.lower[2] + world.upper[2]);
  const double size = std::max(world.upper[0] - world.lower[0], world.upper[1] - world.lower[1]);
  double nearest = 1e30, ground = z;
  for (const auto& p : world.vertices) {
    const double distance = std::hypot(p[0] - x, p[1] - y);
    if (distance < nearest) {
      nearest = distance;
      ground = p[2];
    }
  }
  return {View{"far", {x - 4.0 * size, y, z + 3.0 * size}, {x, y, z}},
          View{"full", {x - 0.9 * size, y, z + 0.7 * size}, {x, y, z}},
          View{"inside", {x, y, ground + 1.7}, {x + 10.0, y + 1.0, ground + 1.5}}};
}

void measureFrames(const View& view, const std::string& pictures)
{
  Stage::lookAt(view.eye, view.target);
  Stage::spinFrames(4);
  Ogre::RenderTarget* window = Stage::panel()->getRenderWindow();
  std::vector<double> times;
  for (int i = 0; i < FRAMES; ++i) {
    const auto start = Clock::now();
    window->update(true);  // OSMesa finishes drawing when buffers are swapped
    times.push_back(milliseconds(Clock::now() - start));
  }
  std::nth_element(times.begin(), times.begin() + FRAMES / 2, times.end());
  tell(std::string("frame_") + view.name, times[FRAMES / 2]);
  tell(std::string("triangles_") + view.name,
       static_cast<double>(window->getStatistics().triangleCount));
  if (!pictures.empty()) {
    osmesa_harness::Image image(WIDTH, HEIGHT);
    window->writeContentsToFile(pictures + "_" + view.name + ".png");
  }
}

void tellWatch(const Watch& watch, const std::string& name)
{
  tell(name + "_first", watch.firstChanged()->end);
  tell(name + "_complete", watch.firstComplete()->end);
  tell(name + "_cpu", watch.firstComplete()->cpu);
  tell(name + "_update", watch.longestUpdate());
  tell(name + "_block", watch.longestBlock());
}

constexpr std::uint32_t TEXTURE_SIDE = 8192;
constexpr std::size_t SMALL_WORLD = 100000;  // faces: for tests, which have a smaller texture

/// What large messages take of the GUI thread, beside what the same time takes without any.
/// @param quiet milliseconds in which all that comes of them is done
void measureGui(const World& world, MeshSubject& subject, double quiet)
{
  GuiThread gui;
  const auto work = [&](const std::string& name, double wait, const std::function<void()>& action) {
    const auto watch = [&](const std::function<void()>& act) {
      const auto start = Clock::now();
      gui.watch(act, [&] { return milliseconds(Clock::now() - start) > wait; });
    };
    watch([] {});
    const double idle = gui.all();
    watch(action);
    tell("gui_" + name, gui.longest());
    tell("gui_" + name + "_all", std::max(0.0, gui.all() - idle));
  };
  const auto large = MeshSubject::makeUpdate(world, 1, 1000000);
  work("sparse", quiet, [&] { subject.update(large); });
  const auto small = MeshSubject::makeUpdate(world, 1, 100000);
  int left = 200;
  QTimer timer;
  QObject::connect(&timer, &QTimer::timeout, [&] {
    if (left-- > 0) {
      subject.update(small);
    }
  });
  work("stream", quiet + 2000.0, [&] { timer.start(10); });
  timer.stop();
  subject.prepareMaterials(world);
  Stage::spin(static_cast<int>(2.0 * quiet));
  const double before = resident();
  const bool small_world = world.faces.size() < SMALL_WORLD;
  subject.prepareTexture(small_world ? TEXTURE_SIDE / 16 : TEXTURE_SIDE);
  work("texture", (small_world ? 2.0 : 10.0) * quiet, [&] { subject.showTexture(); });
  tell("memory_texture", resident() - before);
}

void measure(const World& world, Subject& subject, double quiet, const std::string& pictures)
{
  Stage::SetUpTestSuite();
  Stage::manager()->setFixedFrame("map");
  Stage::resizePanel(WIDTH, HEIGHT);
  const auto all_views = views(world);
  Stage::lookAt(all_views[1].eye, all_views[1].target);
  Watch watch([&subject] { subject.create(); });
  if (!Stage::spinUntil([&subject] { return subject.ready(); })) {
    throw std::runtime_error("the display did not subscribe within 10 s");
  }
  Stage::spinFrames(10);
  const double gpu_before = gpuBytes();
  const double memory_before = resident();
  subject.prepare(world);
  Stage::spinFrames(2);
  watch.start([&subject] { subject.show(); });
  if (!watch.settle(quiet, TIMEOUT)) {
    throw std::runtime_error("nothing appeared within 2 minutes");
  }
  tellWatch(watch, "show");
  tell("memory", resident() - memory_before);
  tell("memory_peak", memory("VmHWM") - memory_before);
  for (const View& view : all_views) {
    measureFrames(view, pictures);
  }

  Stage::lookAt(all_views[1].eye, all_views[1].target);
  subject.prepareLayers(world);
  subject.switchTo(0);
  Stage::spin(static_cast<int>(quiet));
  // The second switch and not the first: that has to make room for colors.
  watch.start([&subject] { subject.switchTo(1); });
  if (!watch.settle(quiet, TIMEOUT)) {
    throw std::runtime_error("the layer did not change within 2 minutes");
  }
  tellWatch(watch, "switch");
  tell("gpu", gpuBytes() - gpu_before);
  tell("memory_layers", resident() - memory_before);
  if (!pictures.empty()) {
    Stage::panel()->getRenderWindow()->writeContentsToFile(pictures + "_layer.png");
  }
  if (auto* mesh = dynamic_cast<MeshSubject*>(&subject)) {
    measureGui(world, *mesh, quiet);
  }
}

}  // namespace

int run(int argc, char** argv)
{
  ros::init(argc, argv, "rviz_display_benchmark", ros::init_options::AnonymousName);
  const std::string name = argc > 2 ? argv[2] : "";
  if (argc < 4 || (name != "mesh" && name != "marker" && name != "manual_object")) {
    std::cerr
        << "usage: rviz_display_benchmark FOLDER mesh|marker|manual_object QUIET [PICTURES]\n";
    return 2;
  }
  return rviz_benchmark::run("rviz_display_benchmark", argc, argv, [&] {
    const World world = readWorld(argv[1]);
    const std::unique_ptr<Subject> subject = makeSubject(name);
    measure(world, *subject, 1000.0 * std::stod(argv[3]),
            argc > 4 ? std::string(argv[4]) + "/" + name : "");
  });
}

}  // namespace rviz_benchmark::display
