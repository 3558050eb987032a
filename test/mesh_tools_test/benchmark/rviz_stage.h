// What benchmark/rviz_display.cpp watches RViz with: its frames, its update() and its event loop.
#pragma once

#include <OgreFrameListener.h>
#include <OgreRenderWindow.h>
#include <OgreRoot.h>
#include <osmesa_harness/render_fixture.h>
#include <ros/master.h>
#include <ros/node_handle.h>
#include <rviz/display.h>
#include <rviz/ogre_helpers/render_system.h>
#include <rviz/render_panel.h>
#include <rviz/visualization_manager.h>

#include <QApplication>
#include <QThread>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <functional>
#include <iostream>
#include <string_view>
#include <vector>

namespace rviz_benchmark {

using Clock = std::chrono::steady_clock;

inline double milliseconds(Clock::duration duration)
{
  return std::chrono::duration<double, std::milli>(duration).count();
}

/// CPU time of all threads of this process, in milliseconds.
inline double processMilliseconds()
{
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// CPU time of the thread that asks, in milliseconds.
inline double threadMilliseconds()
{
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// The panel and manager of the render fixture, without a test around them.
class Stage : public osmesa_harness::RenderFixture
{
 public:
  using RenderFixture::close;
  using RenderFixture::counts;
  using RenderFixture::createDisplay;
  using RenderFixture::lookAt;
  using RenderFixture::manager;
  using RenderFixture::panel;
  using RenderFixture::Point;
  using RenderFixture::resizePanel;
  using RenderFixture::sceneManager;
  using RenderFixture::SetUpTestSuite;
  using RenderFixture::spin;
  using RenderFixture::spinFrames;
  using RenderFixture::spinUntil;
  void TestBody() override {}
};

/// A display of nothing that calls a function in each update().
class Probe : public rviz::Display
{
 public:
  explicit Probe(std::function<void()> function) : function_(std::move(function)) {}
  void update(float, float) override { function_(); }

 private:
  std::function<void()> function_;
};

/// Watches what RViz does from a moment on.
class Watch : public Ogre::FrameListener
{
 public:
  struct Frame
  {
    double end = 0.0;  ///< milliseconds since start()
    double cpu = 0.0;  ///< of all threads until then, without drawing
    std::uint64_t hash = 0;
  };

  /// @param between adds the display to be watched; probes lie before and behind it
  explicit Watch(const std::function<void()>& between)
      : before_(new Probe([this] { update_start_ = Clock::now(); })), after_(new Probe([this] {
          update_ = std::max(update_, milliseconds(Clock::now() - update_start_));
        }))
  {
    Stage::manager()->addDisplay(before_, true);
    between();
    Stage::manager()->addDisplay(after_, true);
    Ogre::Root::getSingleton().addFrameListener(this);
  }

  ~Watch() override { Ogre::Root::getSingleton().removeFrameListener(this); }

  /// Forgets what was seen and does something; the picture of now is that to differ from.
  void start(const std::function<void()>& action)
  {
    frames_.assign(1, Frame{0.0, 0.0, hashOfWindow()});
    update_ = block_ = drawing_ = drawing_cpu_ = 0.0;
    start_ = Clock::now();
    start_cpu_ = processMilliseconds();
    action();
    block_ = milliseconds(Clock::now() - start_);
  }

  /// Lets RViz work until its picture has stayed the same for this long.
  /// @return whether the picture has changed since start()
  bool settle(double quiet_milliseconds, double timeout_milliseconds)
  {
    double now = 0.0;
    while ((now = milliseconds(Clock::now() - start_)) < timeout_milliseconds) {
      const double drawn_before = drawing_;
      const auto began = Clock::now();
      QApplication::processEvents();
      block_ = std::max(block_, milliseconds(Clock::now() - began) - (drawing_ - drawn_before));
      QThread::msleep(1);
      if (firstChanged() && now - firstComplete()->end > quiet_milliseconds) {
        return true;
      }
    }
    return firstChanged() != nullptr;
  }

  /// The first frame that differs from the picture at start(); null if none does.
  const Frame* firstChanged() const
  {
    const auto found = std::find_if(frames_.begin(), frames_.end(), [this](const Frame& frame) {
      return frame.hash != frames_.front().hash;
    });
    return found == frames_.end() ? nullptr : &*found;
  }

  /// The first frame from which on nothing has changed any more.
  const Frame* firstComplete() const
  {
    std::size_t i = frames_.size() - 1;
    while (i > 0 && frames_[i - 1].hash == frames_[i].hash) {
      --i;
    }
    return &frames_[i];
  }

  /// The longest time, in milliseconds, that the watched display's update() took; that events kept
  /// the GUI thread busy, without drawing.
  double longestUpdate() const { return update_; }
  double longestBlock() const { return block_; }

 private:
  bool frameStarted(const Ogre::FrameEvent&) override
  {
    draw_start_ = Clock::now();
    draw_start_cpu_ = processMilliseconds();
    return true;
  }

  bool frameEnded(const Ogre::FrameEvent&) override
  {
    const std::uint64_t hash = hashOfWindow();
    const double cpu = processMilliseconds();
    drawing_ += milliseconds(Clock::now() - draw_start_);
    drawing_cpu_ += cpu - draw_start_cpu_;
    frames_.push_back({milliseconds(Clock::now() - start_), cpu - start_cpu_ - drawing_cpu_, hash});
    return true;
  }

  std::uint64_t hashOfWindow()
  {
    Ogre::RenderTarget* window = Stage::panel()->getRenderWindow();
    const std::size_t width = window->getWidth(), height = window->getHeight();
    pixels_.resize(width * height * 3);
    const Ogre::PixelBox box(width, height, 1, Ogre::PF_BYTE_RGB, pixels_.data());
#if OGRE_VERSION >= ((1 << 16) | (12 << 8))
    window->copyContentsToMemory(Ogre::Box(0, 0, width, height), box, Ogre::RenderTarget::FB_AUTO);
#else
    window->copyContentsToMemory(box, Ogre::RenderTarget::FB_AUTO);
#endif
    return std::hash<std::string_view>()({pixels_.data(), pixels_.size()});
  }

  Probe* before_;  // RViz's
  Probe* after_;
  std::vector<Frame> frames_;
  std::vector<char> pixels_;
  Clock::time_point start_;
  Clock::time_point update_start_;
  Clock::time_point draw_start_;
  double start_cpu_ = 0.0;
  double draw_start_cpu_ = 0.0;
  double update_ = 0.0;
  double block_ = 0.0;
  double drawing_ = 0.0;
  double drawing_cpu_ = 0.0;
};

/// CPU time of the GUI thread without drawing, from a moment on: how much in all, and at a time.
class GuiThread : public Ogre::FrameListener
{
 public:
  GuiThread() { Ogre::Root::getSingleton().addFrameListener(this); }
  ~GuiThread() override { Ogre::Root::getSingleton().removeFrameListener(this); }

  /// Does something, and then what comes of it until that is done.
  /// @return whether it was, before the timeout
  bool watch(const std::function<void()>& action, const std::function<bool()>& done,
             double timeout_milliseconds = 60000.0)
  {
    all_ = longest_ = 0.0;
    piece(action);
    const auto start = Clock::now();
    int quiet = 0;  // frames: what is done is also seen
    while (quiet < 3 && milliseconds(Clock::now() - start) < timeout_milliseconds) {
      const int frames = frames_;
      piece([] { QApplication::processEvents(); });
      QThread::msleep(1);
      quiet = done() ? quiet + (frames_ > frames ? 1 : 0) : 0;
    }
    return done();
  }

  double all() const { return all_; }
  double longest() const { return longest_; }

 private:
  void piece(const std::function<void()>& work)
  {
    drawing_ = 0.0;
    const double start = threadMilliseconds();
    work();
    const double taken = threadMilliseconds() - start - drawing_;
    all_ += taken;
    longest_ = std::max(longest_, taken);
  }

  bool frameStarted(const Ogre::FrameEvent&) override
  {
    draw_start_ = threadMilliseconds();
    return true;
  }
  bool frameEnded(const Ogre::FrameEvent&) override
  {
    drawing_ += threadMilliseconds() - draw_start_;
    ++frames_;
    return true;
  }

  double all_ = 0.0;
  double longest_ = 0.0;
  double drawing_ = 0.0;
  double draw_start_ = 0.0;
  int frames_ = 0;
};

/// Does it with RViz's Qt application and a ROS node that has been named; the exit code of main().
inline int run(const char* program, int argc, char** argv, const std::function<void()>& work)
{
  if (!ros::master::check()) {
    std::cerr << "no ROS master: start it with `rosrun osmesa_harness headless --master`\n";
    return 1;
  }
  try {
    QApplication application(argc, argv);
    application.setQuitOnLastWindowClosed(false);
    rviz::RenderSystem::disableAntiAliasing();
    ros::NodeHandle keeps_ros_running;
    work();
    std::_Exit(0);  // whatever the ends of RViz and OGRE take is not measured
  } catch (const std::exception& error) {
    std::cerr << program << ": " << error.what() << "\n";
    return 1;
  }
}

}  // namespace rviz_benchmark
