#include "osmesa_harness/back_end.h"

#include <dlfcn.h>

#include <cstdlib>

#include <QGuiApplication>

namespace osmesa_harness {
namespace {

// Looked up by name: which library answers is what is asked, and no library is linked for it.
template <class Function>
Function find(const char* name)
{
  return reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, name));
}

constexpr unsigned int GL_RENDERER_NAME = 0x1F01;
constexpr unsigned int GL_VERSION_NAME = 0x1F02;

std::string text(unsigned int name)
{
  const auto get_string = find<const unsigned char* (*)(unsigned int)>("glGetString");
  const unsigned char* found = get_string ? get_string(name) : nullptr;
  return found ? reinterpret_cast<const char*>(found) : "none";
}

}  // namespace

BackEnd currentBackEnd()
{
  BackEnd back_end;
  const auto current = find<void* (*)()>("OSMesaGetCurrentContext");
  back_end.osmesa = current && current();
  back_end.version = text(GL_VERSION_NAME);
  back_end.renderer = text(GL_RENDERER_NAME);
  back_end.platform = QGuiApplication::platformName().toStdString();
  return back_end;
}

std::string backEndComplaint(const BackEnd& back_end)
{
  const char* variable = std::getenv("OSMESA_HARNESS_EXPECT_OSMESA");
  const std::string expected = variable ? variable : "";
  if (back_end.renderer == "none") {
    return "no OpenGL context is current: nothing has been drawn";
  }
  if (expected == "1" && !back_end.osmesa) {
    return "OSMesa was asked for, but " + back_end.renderer +
           " draws; is libosmesa_glx.so preloaded?";
  }
  if (expected == "0" && back_end.osmesa) {
    return "OSMesa draws, though it should not; is libosmesa_glx.so preloaded or linked?";
  }
  return "";
}

}  // namespace osmesa_harness
