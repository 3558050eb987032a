#pragma once

#include <string>

namespace osmesa_harness {

/// Who draws in this process, asked of the current OpenGL context.
struct BackEnd
{
  /// An OSMesa context is current in this thread.
  bool osmesa = false;
  /// OpenGL's version and renderer, "none" where no context is current.
  std::string version = "none";
  std::string renderer = "none";
  /// Qt's platform: "offscreen" or "xcb".
  std::string platform;
};

/// Call it once a window has been drawn.
BackEnd currentBackEnd();

/// Nothing where everything is as OSMESA_HARNESS_EXPECT_OSMESA asks: 1 means OSMesa draws, 0 that
/// it does not. Otherwise the sentence to fail with.
std::string backEndComplaint(const BackEnd& back_end);

}  // namespace osmesa_harness
