// The Xlib calls that RViz, OGRE and Qt's offscreen platform make: answered here on the fake
// display, passed on to Xlib on a real one.
#include <X11/Xlib.h>
#include <X11/Xutil.h>

#include <cstring>

#include "drawables.h"
#include "fake_display.h"
#include "shim.h"

using osmesa_glx::DrawableState;
using osmesa_glx::isFake;

SHIM_API Display* XOpenDisplay(const char* name)
{
  static const bool no_x = osmesa_glx::isSet("OSMESA_GLX_NO_X");
  const bool asks_for_fake = name && std::strcmp(name, ":osmesa") == 0;
  Display* display = no_x || asks_for_fake ? nullptr : NEXT(XOpenDisplay)(name);
  return display ? display : osmesa_glx::fakeDisplay();
}

SHIM_API int XCloseDisplay(Display* display)
{
  return isFake(display) ? 0 : NEXT(XCloseDisplay)(display);
}

SHIM_API int XFlush(Display* display)
{
  return isFake(display) ? 1 : NEXT(XFlush)(display);
}

SHIM_API int XSync(Display* display, Bool discard)
{
  return isFake(display) ? 1 : NEXT(XSync)(display, discard);
}

SHIM_API Bool XQueryExtension(Display* display, const char* name, int* major_opcode,
                              int* first_event, int* first_error)
{
  if (!isFake(display)) {
    return NEXT(XQueryExtension)(display, name, major_opcode, first_event, first_error);
  }
  *major_opcode = *first_event = *first_error = 0;
  return False;
}

SHIM_API int XGetErrorText(Display* display, int code, char* buffer, int length)
{
  if (!isFake(display)) {
    return NEXT(XGetErrorText)(display, code, buffer, length);
  }
  std::snprintf(buffer, static_cast<std::size_t>(length), "error %d of the fake display", code);
  return 0;
}

SHIM_API Atom XInternAtom(Display* display, const char* name, Bool only_if_exists)
{
  return isFake(display) ? None : NEXT(XInternAtom)(display, name, only_if_exists);
}

SHIM_API Colormap XCreateColormap(Display* display, Window window, Visual* visual, int allocate)
{
  return isFake(display) ? osmesa_glx::FAKE_COLORMAP
                         : NEXT(XCreateColormap)(display, window, visual, allocate);
}

SHIM_API int XFreeColormap(Display* display, Colormap colormap)
{
  return isFake(display) ? 1 : NEXT(XFreeColormap)(display, colormap);
}

SHIM_API int XMapWindow(Display* display, Window window)
{
  return isFake(display) ? 1 : NEXT(XMapWindow)(display, window);
}

SHIM_API int XUnmapWindow(Display* display, Window window)
{
  return isFake(display) ? 1 : NEXT(XUnmapWindow)(display, window);
}

SHIM_API int XMoveWindow(Display* display, Window window, int x, int y)
{
  return isFake(display) ? 1 : NEXT(XMoveWindow)(display, window, x, y);
}

SHIM_API void XSetWMProperties(Display* display, Window window, XTextProperty* name,
                               XTextProperty* icon_name, char** argv, int argc, XSizeHints* size,
                               XWMHints* hints, XClassHint* class_hint)
{
  if (!isFake(display)) {
    NEXT(XSetWMProperties)(display, window, name, icon_name, argv, argc, size, hints, class_hint);
  }
}

SHIM_API Status XSetWMProtocols(Display* display, Window window, Atom* protocols, int count)
{
  return isFake(display) ? 1 : NEXT(XSetWMProtocols)(display, window, protocols, count);
}

SHIM_API Status XSendEvent(Display* display, Window window, Bool propagate, long mask,
                           XEvent* event)
{
  return isFake(display) ? 1 : NEXT(XSendEvent)(display, window, propagate, mask, event);
}

SHIM_API Window XCreateSimpleWindow(Display* display, Window parent, int x, int y,
                                    unsigned int width, unsigned int height, unsigned int border,
                                    unsigned long border_color, unsigned long background)
{
  if (!isFake(display)) {
    return NEXT(XCreateSimpleWindow)(display, parent, x, y, width, height, border, border_color,
                                     background);
  }
  return osmesa_glx::addFakeWindow(static_cast<int>(width), static_cast<int>(height), parent);
}

SHIM_API Window XCreateWindow(Display* display, Window parent, int x, int y, unsigned int width,
                              unsigned int height, unsigned int border, int depth,
                              unsigned int window_class, Visual* visual, unsigned long mask,
                              XSetWindowAttributes* attributes)
{
  if (isFake(display)) {
    return osmesa_glx::addFakeWindow(static_cast<int>(width), static_cast<int>(height), parent);
  }
  const Window window = NEXT(XCreateWindow)(display, parent, x, y, width, height, border, depth,
                                            window_class, visual, mask, attributes);
  osmesa_glx::addWindow(window, static_cast<int>(width), static_cast<int>(height), parent);
  return window;
}

SHIM_API int XResizeWindow(Display* display, Window window, unsigned int width, unsigned int height)
{
  osmesa_glx::resizeDrawable(window, static_cast<int>(width), static_cast<int>(height));
  return isFake(display) ? 1 : NEXT(XResizeWindow)(display, window, width, height);
}

SHIM_API int XDestroyWindow(Display* display, Window window)
{
  osmesa_glx::removeDrawable(window);
  return isFake(display) ? 1 : NEXT(XDestroyWindow)(display, window);
}

SHIM_API Status XGetWindowAttributes(Display* display, Window window, XWindowAttributes* attributes)
{
  if (!isFake(display)) {
    return NEXT(XGetWindowAttributes)(display, window, attributes);
  }
  // Windows of Qt's offscreen platform are not known here; they are accepted as parents, 1 x 1.
  DrawableState drawable;
  osmesa_glx::findDrawable(window, &drawable);
  *attributes = XWindowAttributes();
  attributes->width = drawable.width;
  attributes->height = drawable.height;
  attributes->depth = osmesa_glx::FAKE_DEPTH;
  attributes->visual = osmesa_glx::fakeVisual();
  attributes->colormap = osmesa_glx::FAKE_COLORMAP;
  attributes->root = osmesa_glx::FAKE_ROOT;
  attributes->c_class = InputOutput;
  attributes->map_state = IsViewable;
  attributes->screen = DefaultScreenOfDisplay(display);
  return 1;
}

SHIM_API Status XQueryTree(Display* display, Window window, Window* root, Window* parent,
                           Window** children, unsigned int* child_count)
{
  if (!isFake(display)) {
    return NEXT(XQueryTree)(display, window, root, parent, children, child_count);
  }
  DrawableState drawable;
  drawable.parent = osmesa_glx::FAKE_ROOT;
  osmesa_glx::findDrawable(window, &drawable);
  *root = osmesa_glx::FAKE_ROOT;
  *parent = drawable.parent;
  *children = nullptr;
  *child_count = 0;
  return 1;
}

// Declared here rather than included: one function is not worth the development files of libXrandr.
struct _XRRScreenConfiguration;
SHIM_API _XRRScreenConfiguration* XRRGetScreenInfo(Display* display, Window window);
SHIM_API _XRRScreenConfiguration* XRRGetScreenInfo(Display* display, Window window)
{
  return isFake(display) ? nullptr : NEXT(XRRGetScreenInfo)(display, window);
}
