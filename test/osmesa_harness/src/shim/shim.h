// What the files of libosmesa_glx.so share: visibility, logging, and the functions behind the
// overrides.
#pragma once

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>

/// Everything else of this library is hidden, so that it overrides exactly what it means to.
#define SHIM_API extern "C" __attribute__((visibility("default")))

namespace osmesa_glx {

/// True where the environment variable is set to anything but "" and "0".
bool isSet(const char* variable);

/// One line on stderr, whatever OSMESA_GLX_VERBOSE says.
void complain(const char* format, ...) __attribute__((format(printf, 1, 2)));

/// One line on stderr where OSMESA_GLX_VERBOSE is set.
void log(const char* format, ...) __attribute__((format(printf, 1, 2)));

/// The function of that name in libOSMesa itself, whatever overrides it in this process.
/// Ends the process with a message where there is none: nothing could be drawn at all.
void* osmesaSymbol(const char* name);

/// The function of that name in the library that this one hides (libX11, libXrandr).
void* nextSymbol(const char* name);

}  // namespace osmesa_glx

/// The function `name` of libOSMesa, looked up once.
#define OSMESA(name)                                                        \
  ([] {                                                                     \
    static const auto function =                                            \
        reinterpret_cast<decltype(&name)>(osmesa_glx::osmesaSymbol(#name)); \
    return function;                                                        \
  }())

/// The hidden function `name`, looked up once.
#define NEXT(name)                                                                                 \
  ([] {                                                                                            \
    static const auto function = reinterpret_cast<decltype(&name)>(osmesa_glx::nextSymbol(#name)); \
    return function;                                                                               \
  }())
