// What GLX says of itself: one frame buffer configuration, BGRA of 8 bits, 24 bits of depth, 8 of
// stencil, no multisampling.
#include <GL/glx.h>
#include <GL/glxext.h>
#include <X11/Xutil.h>

#include <cstdlib>

#include "config.h"
#include "drawables.h"
#include "fake_display.h"
#include "shim.h"

namespace osmesa_glx {
namespace {

constexpr int LARGEST_SIDE = 8192;

struct Config
{
  int id;
};
Config the_config{CONFIG_ID};

// Both are freed by the caller with XFree, which is free().
XVisualInfo* makeVisualInfo(Display* display)
{
  const int screen = DefaultScreen(display);
  auto* info = static_cast<XVisualInfo*>(std::calloc(1, sizeof(XVisualInfo)));
  info->visual = DefaultVisual(display, screen);
  info->visualid = info->visual->visualid;
  info->screen = screen;
  info->depth = DefaultDepth(display, screen);
  info->c_class = TrueColor;
  info->red_mask = 0xff0000;
  info->green_mask = 0x00ff00;
  info->blue_mask = 0x0000ff;
  info->colormap_size = 256;
  info->bits_per_rgb = 8;
  return info;
}

GLXFBConfig* makeConfigList(int* count)
{
  auto* list = static_cast<GLXFBConfig*>(std::calloc(1, sizeof(GLXFBConfig)));
  list[0] = reinterpret_cast<GLXFBConfig>(&the_config);
  *count = 1;
  return list;
}

int attribute(Display* display, int name)
{
  switch (name) {
    case GLX_FBCONFIG_ID:
      return CONFIG_ID;
    case GLX_VISUAL_ID:
      return static_cast<int>(DefaultVisual(display, DefaultScreen(display))->visualid);
    case GLX_RED_SIZE:
    case GLX_GREEN_SIZE:
    case GLX_BLUE_SIZE:
    case GLX_ALPHA_SIZE:
    case GLX_STENCIL_SIZE:
      return 8;
    case GLX_DEPTH_SIZE:
      return 24;
    case GLX_BUFFER_SIZE:
      return 32;
    case GLX_DOUBLEBUFFER:
    case GLX_RGBA:
    case GLX_USE_GL:
    case GLX_X_RENDERABLE:
      return 1;
    case GLX_RENDER_TYPE:
      return GLX_RGBA_BIT;
    case GLX_DRAWABLE_TYPE:
      return GLX_WINDOW_BIT | GLX_PIXMAP_BIT | GLX_PBUFFER_BIT;
    case GLX_CONFIG_CAVEAT:
    case GLX_TRANSPARENT_TYPE:
      return GLX_NONE;
    case GLX_X_VISUAL_TYPE:
      return GLX_TRUE_COLOR;
    case GLX_MAX_PBUFFER_WIDTH:
    case GLX_MAX_PBUFFER_HEIGHT:
      return LARGEST_SIDE;
    case GLX_MAX_PBUFFER_PIXELS:
      return LARGEST_SIDE * LARGEST_SIDE;
    default:
      return 0;
  }
}

// Stereo, multisampling and other people's configurations are what a caller cannot have.
bool impossible(const int* wanted)
{
  return (wanted[0] == GLX_STEREO && wanted[1] == True) ||
         (wanted[0] == GLX_SAMPLES && wanted[1] > 0) ||
         (wanted[0] == GLX_SAMPLE_BUFFERS && wanted[1] > 0) ||
         (wanted[0] == GLX_FBCONFIG_ID && wanted[1] != CONFIG_ID);
}

constexpr const char* EXTENSIONS =
    "GLX_ARB_create_context GLX_ARB_create_context_profile GLX_ARB_get_proc_address "
    "GLX_EXT_swap_control GLX_SGIX_fbconfig GLX_SGIX_pbuffer";

}  // namespace
}  // namespace osmesa_glx

using osmesa_glx::the_config;

SHIM_API Bool glXQueryExtension(Display*, int* error_base, int* event_base)
{
  if (error_base) {
    *error_base = 0;
  }
  if (event_base) {
    *event_base = 0;
  }
  return True;
}

SHIM_API Bool glXQueryVersion(Display*, int* major, int* minor)
{
  if (major) {
    *major = 1;
  }
  if (minor) {
    *minor = 4;
  }
  return True;
}

SHIM_API const char* glXQueryExtensionsString(Display*, int)
{
  return osmesa_glx::EXTENSIONS;
}

SHIM_API const char* glXGetClientString(Display*, int name)
{
  switch (name) {
    case GLX_VENDOR:
      return "osmesa_glx";
    case GLX_VERSION:
      return "1.4";
    default:
      return osmesa_glx::EXTENSIONS;
  }
}

SHIM_API const char* glXQueryServerString(Display* display, int, int name)
{
  return glXGetClientString(display, name);
}

SHIM_API GLXFBConfig* glXGetFBConfigs(Display*, int, int* count)
{
  return osmesa_glx::makeConfigList(count);
}

SHIM_API GLXFBConfig* glXChooseFBConfig(Display*, int, const int* wanted, int* count)
{
  for (; wanted && *wanted; wanted += 2) {
    if (osmesa_glx::impossible(wanted)) {
      *count = 0;
      return nullptr;
    }
  }
  return osmesa_glx::makeConfigList(count);
}

SHIM_API int glXGetFBConfigAttrib(Display* display, GLXFBConfig, int name, int* value)
{
  *value = osmesa_glx::attribute(display, name);
  return Success;
}

SHIM_API int glXGetConfig(Display* display, XVisualInfo*, int name, int* value)
{
  *value = osmesa_glx::attribute(display, name);
  return Success;
}

SHIM_API XVisualInfo* glXGetVisualFromFBConfig(Display* display, GLXFBConfig)
{
  return osmesa_glx::makeVisualInfo(display);
}

SHIM_API XVisualInfo* glXChooseVisual(Display* display, int, int*)
{
  return osmesa_glx::makeVisualInfo(display);
}

SHIM_API GLXFBConfig glXGetFBConfigFromVisualSGIX(Display*, XVisualInfo*)
{
  return reinterpret_cast<GLXFBConfig>(&the_config);
}

SHIM_API int glXQueryContext(Display*, GLXContext, int name, int* value)
{
  *value = name == GLX_FBCONFIG_ID ? osmesa_glx::CONFIG_ID
                                   : (name == GLX_RENDER_TYPE ? GLX_RGBA_TYPE : 0);
  return Success;
}
