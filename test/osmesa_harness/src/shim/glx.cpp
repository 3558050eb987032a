// GLX on OSMesa: what it says of itself, contexts, windows and pbuffers, and what happens when a
// frame is done.
#include "glx.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/glx.h>
#include <GL/glxext.h>
#include <X11/Xutil.h>

#include <cstdlib>
#include <mutex>
#include <set>
#include <vector>

#include "fake_display.h"
#include "frame_dump.h"
#include "shim.h"

namespace osmesa_glx {
namespace {

// One frame buffer configuration: BGRA of 8 bits, 24 bits of depth, 8 of stencil, no multisampling.

constexpr int CONFIG_ID = 0x101;
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

// Contexts, made of OSMesa's.

thread_local Context* the_current = nullptr;

std::mutex& mutex()
{
  static std::mutex the_mutex;
  return the_mutex;
}

// Programs destroy a context twice or after the fact; only living ones are touched.
std::set<Context*>& living()
{
  static std::set<Context*> the_contexts;
  return the_contexts;
}

GLXContext create(GLXContext share, int profile, int major, int minor)
{
  std::vector<int> attributes{OSMESA_FORMAT,       OSMESA_BGRA, OSMESA_DEPTH_BITS, 24,
                              OSMESA_STENCIL_BITS, 8,           OSMESA_ACCUM_BITS, 0,
                              OSMESA_PROFILE,      profile};
  if (profile == OSMESA_CORE_PROFILE) {
    attributes.insert(attributes.end(),
                      {OSMESA_CONTEXT_MAJOR_VERSION, major, OSMESA_CONTEXT_MINOR_VERSION, minor});
  }
  attributes.push_back(0);
  auto* shared_with = reinterpret_cast<Context*>(share);
  OSMesaContext osmesa = OSMESA(OSMesaCreateContextAttribs)(
      attributes.data(), shared_with ? shared_with->osmesa : nullptr);
  if (!osmesa) {
    complain("OSMesa made no context (profile 0x%x, version %d.%d)", profile, major, minor);
    return nullptr;
  }
  auto* context = new Context;
  context->osmesa = osmesa;
  {
    const std::lock_guard<std::mutex> lock(mutex());
    living().insert(context);
  }
  log("context %p, shares with %p, profile 0x%x", static_cast<void*>(context),
      static_cast<void*>(shared_with), profile);
  return reinterpret_cast<GLXContext>(context);
}

void destroy(Context* context)
{
  OSMESA(OSMesaDestroyContext)(context->osmesa);
  delete context;
}

void release()
{
  Context* context = the_current;
  if (!context) {
    return;
  }
  // Textures drawn here must be whole before a context that shares them reads them.
  OSMESA(glFlush)();
  OSMESA(OSMesaMakeCurrent)(nullptr, nullptr, 0, 0, 0);
  the_current = nullptr;
  bool doomed = false;
  {
    const std::lock_guard<std::mutex> lock(mutex());
    context->current = false;
    doomed = context->doomed;
  }
  context->frame.reset();
  if (doomed) {
    destroy(context);
  }
}

bool makeCurrent(Context* context, Display* display, XID drawable)
{
  if (the_current != context) {
    release();
    const std::lock_guard<std::mutex> lock(mutex());
    if (!living().count(context) || context->current) {
      return false;
    }
    context->current = true;
    the_current = context;
  }
  return bindContext(context, display, drawable);
}

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

Context* currentContext()
{
  return the_current;
}

bool bindContext(Context* context, Display* display, XID drawable)
{
  const bool first_time = context->display == nullptr;
  auto frame = frameOf(display, drawable);
  if (!OSMESA(OSMesaMakeCurrent)(context->osmesa, frame->pixels.data(), GL_UNSIGNED_BYTE,
                                 frame->width, frame->height)) {
    complain("OSMesa cannot draw into drawable 0x%lx of %dx%d", drawable, frame->width,
             frame->height);
    return false;
  }
  OSMESA(OSMesaPixelStore)(OSMESA_Y_UP, 0);
  // The frame before is let go only now: OSMesa wrote to it until here.
  context->frame = std::move(frame);
  context->display = display;
  context->drawable = drawable;
  if (first_time) {
    log("context %p draws into 0x%lx, %dx%d: %s on %s", static_cast<void*>(context), drawable,
        context->frame->width, context->frame->height,
        reinterpret_cast<const char*>(OSMESA(glGetString)(GL_VERSION)),
        reinterpret_cast<const char*>(OSMESA(glGetString)(GL_RENDERER)));
  }
  return true;
}

void followResize()
{
  Context* context = the_current;
  int width = 0;
  int height = 0;
  if (!context || !context->frame ||
      !drawableSize(context->display, context->drawable, &width, &height) || width < 1 ||
      height < 1 || (width == context->frame->width && height == context->frame->height)) {
    return;
  }
  log("0x%lx resized: %dx%d to %dx%d", context->drawable, context->frame->width,
      context->frame->height, width, height);
  bindContext(context, context->display, context->drawable);
}

}  // namespace osmesa_glx

using osmesa_glx::Context;
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

SHIM_API GLXContext glXCreateContextAttribsARB(Display*, GLXFBConfig, GLXContext share, Bool,
                                               const int* attributes)
{
  int major = 1;
  int minor = 0;
  int profiles = GLX_CONTEXT_CORE_PROFILE_BIT_ARB;
  for (; attributes && *attributes; attributes += 2) {
    switch (attributes[0]) {
      case GLX_CONTEXT_MAJOR_VERSION_ARB:
        major = attributes[1];
        break;
      case GLX_CONTEXT_MINOR_VERSION_ARB:
        minor = attributes[1];
        break;
      case GLX_CONTEXT_PROFILE_MASK_ARB:
        profiles = attributes[1];
        break;
      default:
        break;
    }
  }
  constexpr int KNOWN =
      GLX_CONTEXT_CORE_PROFILE_BIT_ARB | GLX_CONTEXT_COMPATIBILITY_PROFILE_BIT_ARB;
  if (profiles & ~KNOWN) {
    return nullptr;  // OpenGL ES is not offered
  }
  // A profile means something from version 3.2 on; OSMesa's core profile starts at 3.3.
  const bool core = (profiles & GLX_CONTEXT_CORE_PROFILE_BIT_ARB) && major >= 3;
  if (core && major == 3 && minor < 3) {
    minor = 3;
  }
  return osmesa_glx::create(share, core ? OSMESA_CORE_PROFILE : OSMESA_COMPAT_PROFILE, major,
                            minor);
}

SHIM_API GLXContext glXCreateContext(Display*, XVisualInfo*, GLXContext share, Bool)
{
  return osmesa_glx::create(share, OSMESA_COMPAT_PROFILE, 1, 0);
}

SHIM_API GLXContext glXCreateNewContext(Display*, GLXFBConfig, int, GLXContext share, Bool)
{
  return osmesa_glx::create(share, OSMESA_COMPAT_PROFILE, 1, 0);
}

SHIM_API void glXDestroyContext(Display*, GLXContext glx_context)
{
  auto* context = reinterpret_cast<Context*>(glx_context);
  if (context && context == osmesa_glx::currentContext()) {
    osmesa_glx::release();
  }
  {
    const std::lock_guard<std::mutex> lock(osmesa_glx::mutex());
    if (!osmesa_glx::living().erase(context)) {
      return;
    }
    if (context->current) {
      context->doomed = true;
      return;
    }
  }
  osmesa_glx::destroy(context);
}

SHIM_API Bool glXMakeCurrent(Display* display, GLXDrawable drawable, GLXContext glx_context)
{
  if (!glx_context || !drawable) {
    osmesa_glx::release();
    return True;
  }
  return osmesa_glx::makeCurrent(reinterpret_cast<Context*>(glx_context), display, drawable);
}

SHIM_API Bool glXMakeContextCurrent(Display* display, GLXDrawable draw, GLXDrawable,
                                    GLXContext context)
{
  return glXMakeCurrent(display, draw, context);
}

SHIM_API GLXContext glXGetCurrentContext(void)
{
  return reinterpret_cast<GLXContext>(osmesa_glx::currentContext());
}

SHIM_API GLXDrawable glXGetCurrentDrawable(void)
{
  const Context* context = osmesa_glx::currentContext();
  return context ? context->drawable : None;
}

SHIM_API GLXDrawable glXGetCurrentReadDrawable(void)
{
  return glXGetCurrentDrawable();
}

SHIM_API Display* glXGetCurrentDisplay(void)
{
  const Context* context = osmesa_glx::currentContext();
  return context ? context->display : nullptr;
}

SHIM_API Bool glXIsDirect(Display*, GLXContext)
{
  return True;
}

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
  Context* context = osmesa_glx::currentContext();
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
