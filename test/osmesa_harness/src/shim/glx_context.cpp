// Contexts of GLX, made of OSMesa's.
#include "context.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/glx.h>
#include <GL/glxext.h>

#include <mutex>
#include <set>
#include <vector>

#include "shim.h"

namespace osmesa_glx {
namespace {

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
