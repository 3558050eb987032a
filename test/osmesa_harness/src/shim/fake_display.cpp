#include "fake_display.h"

#include <atomic>

#include "drawables.h"
#include "shim.h"

namespace osmesa_glx {

// Far from the ids of Qt's offscreen windows (1, 2, 3, ...): OGRE takes a window whose parent has
// the id of the root for a top-level one, and then does not resize it with its panel.
const XID FAKE_ROOT = 0x24fffff0;
const XID FAKE_COLORMAP = 0x24fffff1;

namespace {

std::atomic<Display*> the_display{nullptr};

Display* makeDisplay()
{
  // Programs see the public head of the structure alone (through macros as DefaultScreen); what
  // lies behind it belongs to Xlib, is larger than the head, and must read as zero.
  struct alignas(16) Storage
  {
    char bytes[1 << 16];
  };
  static Storage storage{};
  static Screen screen{};
  static Depth depth{};
  static char name[] = ":osmesa";

  depth.depth = FAKE_DEPTH;
  depth.nvisuals = 1;
  depth.visuals = fakeVisual();

  auto* display = reinterpret_cast<Display*>(&storage);
  screen.display = display;
  screen.root = FAKE_ROOT;
  screen.width = FAKE_WIDTH;
  screen.height = FAKE_HEIGHT;
  screen.mwidth = 508;
  screen.mheight = 318;
  screen.ndepths = 1;
  screen.depths = &depth;
  screen.root_depth = FAKE_DEPTH;
  screen.root_visual = fakeVisual();
  screen.white_pixel = 0xffffff;
  screen.cmap = FAKE_COLORMAP;

  auto* head = reinterpret_cast<_XPrivDisplay>(display);
  head->fd = -1;
  head->display_name = name;
  head->nscreens = 1;
  head->screens = &screen;

  addWindow(FAKE_ROOT, FAKE_WIDTH, FAKE_HEIGHT, None);
  log("no X server: a fake display of %dx%d", FAKE_WIDTH, FAKE_HEIGHT);
  the_display = display;
  return display;
}

}  // namespace

Display* fakeDisplay()
{
  static Display* const display = makeDisplay();
  return display;
}

bool isFake(const Display* display)
{
  return display && display == the_display.load();
}

Visual* fakeVisual()
{
  static Visual visual = [] {
    Visual true_color{};
    true_color.visualid = 0x21;
    true_color.c_class = TrueColor;
    true_color.red_mask = 0xff0000;
    true_color.green_mask = 0x00ff00;
    true_color.blue_mask = 0x0000ff;
    true_color.bits_per_rgb = 8;
    true_color.map_entries = 256;
    return true_color;
  }();
  return &visual;
}

}  // namespace osmesa_glx
