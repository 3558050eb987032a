// The few calls of OpenGL itself that OSMesa may answer otherwise than GLX does: it has one buffer
// where a window has two, and it does not notice that a window was resized.
#include <GL/osmesa.h>
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/glx.h>

#include <cstring>

#include "glx.h"
#include "shim.h"

namespace {

bool drawsIntoWindow(GLenum binding)
{
  GLint frame_buffer_object = 0;
  OSMESA(glGetIntegerv)(binding, &frame_buffer_object);
  return frame_buffer_object == 0;
}

GLenum onlyBuffer(GLenum buffer)
{
  return buffer == GL_BACK || buffer == GL_BACK_LEFT || buffer == GL_LEFT ? GL_FRONT_LEFT : buffer;
}

// This library itself, whether preloaded or linked, for names that it defines.
void* thisLibrary()
{
  static void* const handle = [] {
    Dl_info info;
    void* found = nullptr;
    if (dladdr(reinterpret_cast<void*>(&thisLibrary), &info)) {
      found = dlopen(info.dli_fname, RTLD_NOW | RTLD_NOLOAD);
    }
    return found;
  }();
  return handle;
}

bool isOurs(const char* name)
{
  return std::strncmp(name, "glX", 3) == 0 || std::strcmp(name, "glDrawBuffer") == 0 ||
         std::strcmp(name, "glReadBuffer") == 0 || std::strcmp(name, "glViewport") == 0;
}

}  // namespace

SHIM_API void glDrawBuffer(GLenum buffer)
{
  OSMESA(glDrawBuffer)
  (drawsIntoWindow(GL_DRAW_FRAMEBUFFER_BINDING) ? onlyBuffer(buffer) : buffer);
}

SHIM_API void glReadBuffer(GLenum buffer)
{
  OSMESA(glReadBuffer)
  (drawsIntoWindow(GL_READ_FRAMEBUFFER_BINDING) ? onlyBuffer(buffer) : buffer);
}

SHIM_API void glViewport(GLint x, GLint y, GLsizei width, GLsizei height)
{
  if (drawsIntoWindow(GL_DRAW_FRAMEBUFFER_BINDING)) {
    osmesa_glx::followResize();
  }
  OSMESA(glViewport)(x, y, width, height);
}

SHIM_API __GLXextFuncPtr glXGetProcAddressARB(const GLubyte* name)
{
  const char* text = reinterpret_cast<const char*>(name);
  if (isOurs(text)) {
    return reinterpret_cast<__GLXextFuncPtr>(dlsym(thisLibrary(), text));
  }
  return reinterpret_cast<__GLXextFuncPtr>(OSMESA(OSMesaGetProcAddress)(text));
}

SHIM_API __GLXextFuncPtr glXGetProcAddress(const GLubyte* name)
{
  return glXGetProcAddressARB(name);
}
