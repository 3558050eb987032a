// A GLX context: an OSMesa context and the frame it is bound to.
#pragma once

#include <GL/osmesa.h>
#include <X11/Xlib.h>

#include <memory>

#include "drawables.h"

namespace osmesa_glx {

struct Context
{
  OSMesaContext osmesa = nullptr;
  Display* display = nullptr;
  XID drawable = None;
  std::shared_ptr<Frame> frame;
  /// Current in some thread.
  bool current = false;
  /// Destroyed while current elsewhere: goes when that thread lets go of it.
  bool doomed = false;
};

/// The context of this thread, nullptr where there is none.
Context* currentContext();

/// Makes the context draw into the drawable in the size that it has now.
bool bindContext(Context* context, Display* display, XID drawable);

/// Binds the current context anew where its drawable has been resized since.
void followResize();

}  // namespace osmesa_glx
