#include "rviz_mesh_plugin/two_sided_lighting.h"

#include <string>

#include <OgreGpuProgramParams.h>
#include <OgreHighLevelGpuProgram.h>
#include <OgreHighLevelGpuProgramManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>

#include "rviz_mesh_plugin/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

const char* const VERTEX_PROGRAM = "rviz_mesh_plugin/two_sided_lighting.vert";
const char* const FRAGMENT_PROGRAM = "rviz_mesh_plugin/two_sided_lighting.frag";

const char* const VERTEX_SOURCE = R"glsl(#version 120
uniform mat4 world_view_projection;
uniform mat4 world_view;
uniform mat4 normal_matrix;
uniform mat4 projection;
varying vec3 view_position;
varying vec3 view_normal;
varying vec3 to_eye;
varying vec4 vertex_color;

void main()
{
  gl_Position = world_view_projection * gl_Vertex;
  view_position = (world_view * gl_Vertex).xyz;
  view_normal = (normal_matrix * vec4(gl_Normal, 0.0)).xyz;
  to_eye = projection[3][3] == 0.0 ? -view_position : vec3(0.0, 0.0, 1.0);
  vertex_color = gl_Color;
}
)glsl";

// The side that is seen is told by the plane of the facet and not by gl_FrontFacing: that one is
// reversed in textures (OGRE mirrors them) and wrong where faces are wound against their normals.
const char* const FRAGMENT_SOURCE = R"glsl(#version 120
uniform vec4 surface_color;
uniform float use_vertex_colors;
uniform float ambient_share;
uniform vec4 light_direction;
uniform vec4 light_color;
varying vec3 view_position;
varying vec3 view_normal;
varying vec3 to_eye;
varying vec4 vertex_color;

vec3 unitOr(vec3 v, vec3 otherwise)
{
  float square = dot(v, v);
  return square > 0.0 ? v * inversesqrt(square) : otherwise;
}

void main()
{
  vec3 facet = unitOr(cross(dFdx(view_position), dFdy(view_position)), vec3(0.0, 0.0, 1.0));
  facet = dot(facet, to_eye) < 0.0 ? -facet : facet;
  vec3 normal = unitOr(view_normal, facet);
  normal = dot(normal, facet) < 0.0 ? -normal : normal;
  float share = max(dot(normal, -light_direction.xyz), 0.0);
  vec4 color = mix(surface_color, vertex_color, use_vertex_colors);
  gl_FragColor = vec4(color.rgb * mix(vec3(ambient_share), vec3(1.0), share * light_color.rgb), color.a);
}
)glsl";

void ensureProgram(const char* name, Ogre::GpuProgramType type, const char* source)
{
  auto& manager = Ogre::HighLevelGpuProgramManager::getSingleton();
  const std::string group = Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME;
  if (!manager.resourceExists(name)) {
    manager.createProgram(name, group, "glsl", type)->setSource(source);
  }
}

}  // namespace

void setTwoSidedLighting(Ogre::Pass* pass, bool vertex_colors, const Ogre::ColourValue& color)
{
  ensureProgram(VERTEX_PROGRAM, Ogre::GPT_VERTEX_PROGRAM, VERTEX_SOURCE);
  ensureProgram(FRAGMENT_PROGRAM, Ogre::GPT_FRAGMENT_PROGRAM, FRAGMENT_SOURCE);
  pass->setCullingMode(Ogre::CULL_NONE);
  pass->setLightingEnabled(true);
  pass->setVertexProgram(VERTEX_PROGRAM);
  pass->setFragmentProgram(FRAGMENT_PROGRAM);
  using Parameters = Ogre::GpuProgramParameters;
  if (pass->getVertexProgram()->isSupported()) {
    const auto parameters = pass->getVertexProgramParameters();
    parameters->setIgnoreMissingParams(true);
    parameters->setNamedAutoConstant("world_view_projection", Parameters::ACT_WORLDVIEWPROJ_MATRIX);
    parameters->setNamedAutoConstant("world_view", Parameters::ACT_WORLDVIEW_MATRIX);
    parameters->setNamedAutoConstant("normal_matrix",
                                     Parameters::ACT_INVERSE_TRANSPOSE_WORLDVIEW_MATRIX);
    parameters->setNamedAutoConstant("projection", Parameters::ACT_PROJECTION_MATRIX);
  }
  if (pass->getFragmentProgram()->isSupported()) {
    const auto parameters = pass->getFragmentProgramParameters();
    parameters->setIgnoreMissingParams(true);
    parameters->setNamedConstant("surface_color", color);
    parameters->setNamedConstant("use_vertex_colors", vertex_colors ? 1.0f : 0.0f);
    parameters->setNamedConstant("ambient_share", AMBIENT_SHARE);
    parameters->setNamedAutoConstant("light_direction", Parameters::ACT_LIGHT_DIRECTION_VIEW_SPACE,
                                     0);
    parameters->setNamedAutoConstant("light_color", Parameters::ACT_LIGHT_DIFFUSE_COLOUR, 0);
  }
}

}  // namespace rviz_mesh_plugin
