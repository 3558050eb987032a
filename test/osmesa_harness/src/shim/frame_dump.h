#pragma once

#include <X11/Xlib.h>

#include "drawables.h"

namespace osmesa_glx {

/// Where OSMESA_GLX_DUMP is set: writes the frame to <OSMESA_GLX_DUMP>-<id in hex>.ppm, at most
/// twice a second for each drawable. The file is there whole or not at all. Frames of 1 x 1 are
/// left out.
void dumpFrame(XID drawable, const Frame& frame);

}  // namespace osmesa_glx
