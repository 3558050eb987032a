// A Display that no X server stands behind, for programs under QT_QPA_PLATFORM=offscreen.
#pragma once

#include <X11/Xlib.h>

namespace osmesa_glx {

/// The one fake display of the process, made by the first call: one screen of 1920 x 1200, 24 bits.
Display* fakeDisplay();

bool isFake(const Display* display);

/// Its root window, its visual and its color map.
extern const XID FAKE_ROOT;
extern const XID FAKE_COLORMAP;
Visual* fakeVisual();

constexpr int FAKE_WIDTH = 1920;
constexpr int FAKE_HEIGHT = 1200;
constexpr int FAKE_DEPTH = 24;

}  // namespace osmesa_glx
