// Windows and pbuffers: their sizes and the pixels that OSMesa draws into.
#pragma once

#include <X11/Xlib.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace osmesa_glx {

/// A frame, one 0xAARRGGBB word a pixel, rows from the top down. Shared between the window and
/// every context bound to it, because OSMesa keeps writing to it until the context is bound
/// elsewhere.
struct Frame
{
  Frame(int frame_width, int frame_height)
      : width(frame_width),
        height(frame_height),
        pixels(static_cast<std::size_t>(frame_width) * static_cast<std::size_t>(frame_height))
  {
  }

  int width;
  int height;
  std::vector<std::uint32_t> pixels;
};

/// A drawable as this library knows it.
struct DrawableState
{
  int width = 1;
  int height = 1;
  XID parent = None;
  bool pbuffer = false;
  std::shared_ptr<Frame> frame;
};

/// Remembers a window that this process created, so that its size is known without the server.
void addWindow(XID id, int width, int height, XID parent);

/// A pbuffer exists here alone. Returns its new id.
XID addPbuffer(int width, int height);

/// A window of the fake display. Returns its new id.
XID addFakeWindow(int width, int height, XID parent);

void resizeDrawable(XID id, int width, int height);
void removeDrawable(XID id);

/// Copies what is known of @a id; false where it is not one of ours.
bool findDrawable(XID id, DrawableState* found);

/// The present size; asks the X server about windows that others created. False for an unknown one.
bool drawableSize(Display* display, XID id, int* width, int* height);

/// The frame of the drawable in its present size (at least 1 x 1), kept while the size stays.
std::shared_ptr<Frame> frameOf(Display* display, XID id);

}  // namespace osmesa_glx
