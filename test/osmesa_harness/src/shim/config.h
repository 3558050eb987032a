#pragma once

namespace osmesa_glx {

/// Id of the one frame buffer configuration there is.
constexpr int CONFIG_ID = 0x101;

}  // namespace osmesa_glx
