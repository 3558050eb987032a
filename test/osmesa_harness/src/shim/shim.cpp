#include "shim.h"

#include <cstdarg>
#include <cstring>

namespace osmesa_glx {
namespace {

void print(const char* format, va_list arguments)
{
  // One call a line, so that lines of several threads and processes stay whole.
  char line[1024];
  std::vsnprintf(line, sizeof(line), format, arguments);
  std::fprintf(stderr, "[osmesa_glx] %s\n", line);
}

}  // namespace

bool isSet(const char* variable)
{
  const char* value = std::getenv(variable);
  return value && *value && std::strcmp(value, "0") != 0;
}

void complain(const char* format, ...)
{
  va_list arguments;
  va_start(arguments, format);
  print(format, arguments);
  va_end(arguments);
}

void log(const char* format, ...)
{
  static const bool verbose = isSet("OSMESA_GLX_VERBOSE");
  if (!verbose) {
    return;
  }
  va_list arguments;
  va_start(arguments, format);
  print(format, arguments);
  va_end(arguments);
}

void* osmesaSymbol(const char* name)
{
  static void* const library = dlopen(OSMESA_LIBRARY, RTLD_NOW | RTLD_GLOBAL);
  void* symbol = library ? dlsym(library, name) : nullptr;
  if (!symbol) {
    complain("cannot draw: no %s in %s: %s", name, OSMESA_LIBRARY, dlerror());
    std::_Exit(EXIT_FAILURE);
  }
  return symbol;
}

void* nextSymbol(const char* name)
{
  void* symbol = dlsym(RTLD_NEXT, name);
  if (!symbol) {
    complain("cannot pass on to the X server: no %s: %s", name, dlerror());
    std::_Exit(EXIT_FAILURE);
  }
  return symbol;
}

}  // namespace osmesa_glx
