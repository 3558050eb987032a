#include "drawables.h"

#include <algorithm>
#include <map>
#include <mutex>

#include "fake_display.h"
#include "shim.h"

namespace osmesa_glx {
namespace {

// Ids of our own. Qt's offscreen platform numbers its windows 1, 2, 3, ..., and an X server gives
// each client ids below 0x20000000: neither range may be met.
constexpr XID FIRST_FAKE_WINDOW = 0x25000000;
constexpr XID FIRST_PBUFFER = 0x3f000000;

// Function statics: windows are created from static constructors of the program, too.
std::mutex& mutex()
{
  static std::mutex the_mutex;
  return the_mutex;
}

std::map<XID, DrawableState>& ours()
{
  static std::map<XID, DrawableState> the_drawables;
  return the_drawables;
}

// Frames of windows that others created (Qt's own), whose size only the X server knows.
std::map<XID, std::shared_ptr<Frame>>& foreignFrames()
{
  static std::map<XID, std::shared_ptr<Frame>> the_frames;
  return the_frames;
}

XID add(XID id, int width, int height, XID parent, bool pbuffer)
{
  DrawableState drawable;
  drawable.width = width;
  drawable.height = height;
  drawable.parent = parent;
  drawable.pbuffer = pbuffer;
  ours()[id] = drawable;
  return id;
}

}  // namespace

void addWindow(XID id, int width, int height, XID parent)
{
  const std::lock_guard<std::mutex> lock(mutex());
  add(id, width, height, parent, false);
}

XID addPbuffer(int width, int height)
{
  static XID next = FIRST_PBUFFER;
  const std::lock_guard<std::mutex> lock(mutex());
  return add(next++, width, height, None, true);
}

XID addFakeWindow(int width, int height, XID parent)
{
  static XID next = FIRST_FAKE_WINDOW;
  const std::lock_guard<std::mutex> lock(mutex());
  return add(next++, width, height, parent, false);
}

void resizeDrawable(XID id, int width, int height)
{
  const std::lock_guard<std::mutex> lock(mutex());
  const auto found = ours().find(id);
  if (found != ours().end()) {
    found->second.width = width;
    found->second.height = height;
  }
}

void removeDrawable(XID id)
{
  const std::lock_guard<std::mutex> lock(mutex());
  ours().erase(id);
  foreignFrames().erase(id);
}

bool findDrawable(XID id, DrawableState* found)
{
  const std::lock_guard<std::mutex> lock(mutex());
  const auto drawable = ours().find(id);
  if (drawable == ours().end()) {
    return false;
  }
  *found = drawable->second;
  return true;
}

bool drawableSize(Display* display, XID id, int* width, int* height)
{
  DrawableState drawable;
  if (findDrawable(id, &drawable)) {
    *width = drawable.width;
    *height = drawable.height;
    return true;
  }
  if (!display || isFake(display)) {
    return false;
  }
  Window root = None;
  int x = 0;
  int y = 0;
  unsigned int server_width = 0;
  unsigned int server_height = 0;
  unsigned int border = 0;
  unsigned int depth = 0;
  if (!XGetGeometry(display, id, &root, &x, &y, &server_width, &server_height, &border, &depth)) {
    return false;
  }
  *width = static_cast<int>(server_width);
  *height = static_cast<int>(server_height);
  return true;
}

std::shared_ptr<Frame> frameOf(Display* display, XID id)
{
  int width = 1;
  int height = 1;
  if (!drawableSize(display, id, &width, &height)) {
    log("drawable 0x%lx is unknown, taken as 1x1", id);
  }
  width = std::max(width, 1);
  height = std::max(height, 1);

  const std::lock_guard<std::mutex> lock(mutex());
  const auto known = ours().find(id);
  auto& frame = known == ours().end() ? foreignFrames()[id] : known->second.frame;
  if (!frame || frame->width != width || frame->height != height) {
    frame = std::make_shared<Frame>(width, height);
  }
  return frame;
}

}  // namespace osmesa_glx
