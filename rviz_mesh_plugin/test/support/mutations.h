#pragma once

#include <cstdlib>

/// How many damaged messages a test sends: so many, or as many as MESH_TOOLS_MUTATIONS says.
inline int mutations(int otherwise)
{
  const char* const given = std::getenv("MESH_TOOLS_MUTATIONS");
  return given ? std::atoi(given) : otherwise;
}
