// GLX windows and pbuffers, and what happens when a frame is done.
#include <GL/osmesa.h>
// (osmesa.h before glx.h: both include gl.h)
#include <GL/glx.h>
#include <GL/glxext.h>
#include <X11/Xutil.h>

#include "config.h"
#include "context.h"
#include "fake_display.h"
#include "frame_dump.h"
#include "shim.h"

namespace osmesa_glx {
namespace {

// Shows the frame in the window of a real X server.
void present(Display* display, XID window, Frame* frame)
{
  const int screen = DefaultScreen(display);
  XImage* image = XCreateImage(display, DefaultVisual(display, screen),
                               static_cast<unsigned int>(DefaultDepth(display, screen)), ZPixmap, 0,
                               reinterpret_cast<char*>(frame->pixels.data()),
                               static_cast<unsigned int>(frame->width),
                               static_cast<unsigned int>(frame->height), 32, 0);
  if (!image) {
    complain("cannot show a frame of %dx%d", frame->width, frame->height);
    return;
  }
  GC context = XCreateGC(display, window, 0, nullptr);
  XPutImage(display, window, context, image, 0, 0, 0, 0, static_cast<unsigned int>(frame->width),
            static_cast<unsigned int>(frame->height));
  XFreeGC(display, context);
  XFlush(display);
  image->data = nullptr;  // the frame's own
  XDestroyImage(image);
}

}  // namespace
}  // namespace osmesa_glx

SHIM_API GLXPbuffer glXCreatePbuffer(Display*, GLXFBConfig, const int* attributes)
{
  int width = 1;
  int height = 1;
  for (; attributes && *attributes; attributes += 2) {
    if (attributes[0] == GLX_PBUFFER_WIDTH) {
      width = attributes[1];
    } else if (attributes[0] == GLX_PBUFFER_HEIGHT) {
      height = attributes[1];
    }
  }
  return osmesa_glx::addPbuffer(width, height);
}

SHIM_API void glXDestroyPbuffer(Display*, GLXPbuffer pbuffer)
{
  osmesa_glx::removeDrawable(pbuffer);
}

SHIM_API GLXWindow glXCreateWindow(Display*, GLXFBConfig, Window window, const int*)
{
  return window;
}

SHIM_API void glXDestroyWindow(Display*, GLXWindow) {}

SHIM_API void glXQueryDrawable(Display* display, GLXDrawable drawable, int name,
                               unsigned int* value)
{
  int width = 0;
  int height = 0;
  osmesa_glx::drawableSize(display, drawable, &width, &height);
  switch (name) {
    case GLX_WIDTH:
      *value = static_cast<unsigned int>(width);
      break;
    case GLX_HEIGHT:
      *value = static_cast<unsigned int>(height);
      break;
    case GLX_FBCONFIG_ID:
      *value = osmesa_glx::CONFIG_ID;
      break;
    default:
      *value = 0;
      break;
  }
}

SHIM_API void glXSwapBuffers(Display* display, GLXDrawable drawable)
{
  osmesa_glx::Context* context = osmesa_glx::currentContext();
  if (!context || !context->frame || context->drawable != drawable) {
    return;
  }
  OSMESA(glFinish)();  // copies what was drawn into the frame
  osmesa_glx::DrawableState known;
  const bool pbuffer = osmesa_glx::findDrawable(drawable, &known) && known.pbuffer;
  if (!pbuffer && !osmesa_glx::isFake(display)) {
    osmesa_glx::present(display, drawable, context->frame.get());
  }
  osmesa_glx::dumpFrame(drawable, *context->frame);
  osmesa_glx::followResize();
}

SHIM_API void glXWaitGL(void)
{
  OSMESA(glFinish)();
}
SHIM_API void glXWaitX(void) {}

// Nothing waits for a screen to be refreshed.
SHIM_API int glXSwapIntervalMESA(unsigned int)
{
  return 0;
}
SHIM_API int glXSwapIntervalSGI(int)
{
  return 0;
}
SHIM_API void glXSwapIntervalEXT(Display*, GLXDrawable, int) {}
