#include "rendering/two_sided_lighting.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <OgreGpuProgramParams.h>
#include <OgreHighLevelGpuProgram.h>
#include <OgreHighLevelGpuProgramManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>

#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

const char* const VERTEX_PROGRAM = "rviz_mesh_plugin/two_sided_lighting.vert";
const char* const FRAGMENT_PROGRAM = "rviz_mesh_plugin/two_sided_lighting.frag";
const char* const TEXTURED_PROGRAM = "rviz_mesh_plugin/two_sided_lighting_textured.frag";
// The same where a mesh is cut: to discard fragments costs graphics cards their early test of
// depth.
const char* const CUT_FRAGMENT_PROGRAM = "rviz_mesh_plugin/two_sided_lighting_section.frag";
const char* const CUT_TEXTURED_PROGRAM =
    "rviz_mesh_plugin/two_sided_lighting_textured_section.frag";
const char* const CUT_UNLIT_PROGRAM = "rviz_mesh_plugin/unlit_section.frag";
// Of what lies on all of a mesh once more, in one color: what is handed from vertices to fragments
// counts there, for each of many small faces.
const char* const OVERLAY_VERTEX_PROGRAM = "rviz_mesh_plugin/overlay.vert";
const char* const OVERLAY_PROGRAM = "rviz_mesh_plugin/overlay.frag";
const char* const CUT_OVERLAY_PROGRAM = "rviz_mesh_plugin/overlay_section.frag";

// Colors travel in gl_FrontColor: of all varyings only that one obeys flat shading, by which each
// face has the color of its last vertex.
const char* const VERTEX_SOURCE = R"glsl(#version 120
invariant gl_Position;
uniform mat4 world_view_projection;
uniform mat4 world_view;
uniform mat4 normal_matrix;
uniform mat4 projection;
varying vec3 view_position;
varying vec3 view_normal;
varying vec3 to_eye;
varying vec2 texture_position;
varying vec3 surface_point;

void main()
{
  surface_point = gl_Vertex.xyz;
  gl_Position = world_view_projection * gl_Vertex;
  view_position = (world_view * gl_Vertex).xyz;
  view_normal = (normal_matrix * vec4(gl_Normal, 0.0)).xyz;
  to_eye = projection[3][3] == 0.0 ? -view_position : vec3(0.0, 0.0, 1.0);
  texture_position = gl_MultiTexCoord0.xy;
  gl_FrontColor = gl_Color;
  gl_BackColor = gl_Color;
}
)glsl";

const char* const OVERLAY_VERTEX_SOURCE = R"glsl(#version 120
invariant gl_Position;
uniform mat4 world_view_projection;
uniform mat4 world_view;
uniform mat4 normal_matrix;
varying vec3 view_position;
varying vec3 view_normal;
varying vec3 surface_point;

void main()
{
  surface_point = gl_Vertex.xyz;
  gl_Position = world_view_projection * gl_Vertex;
  view_position = (world_view * gl_Vertex).xyz;
  view_normal = (normal_matrix * vec4(gl_Normal, 0.0)).xyz;
}
)glsl";

const char* const WHOLE = R"glsl(#version 120
varying vec3 surface_point;
void cut() {}
)glsl";

const char* const CUT = R"glsl(#version 120
uniform vec4 section_lower;
uniform vec4 section_upper;
varying vec3 surface_point;
void cut()
{
  if (any(lessThan(surface_point, section_lower.xyz)) ||
      any(greaterThan(surface_point, section_upper.xyz))) {
    discard;
  }
}
)glsl";

const char* const UNLIT = R"glsl(
uniform vec4 surface_color;
void main()
{
  cut();
  gl_FragColor = surface_color;
}
)glsl";

const char* const FRAGMENT_START = R"glsl(
uniform vec4 surface_color;
uniform float use_vertex_colors;
uniform float alpha;
vec4 surfaceColor()
{
  vec4 color = mix(surface_color, gl_Color, use_vertex_colors);
  return vec4(color.rgb, color.a * alpha);
}
)glsl";

const char* const TEXTURED_START = R"glsl(
uniform sampler2D surface_texture;
uniform float alpha;
varying vec2 texture_position;
vec4 surfaceColor()
{
  vec4 color = texture2D(surface_texture, texture_position);
  return vec4(color.rgb, color.a * alpha);
}
)glsl";

// The side that is seen is told by the plane of the facet and not by gl_FrontFacing: that one is
// reversed in textures (OGRE mirrors them) and wrong where faces are wound against their normals.
const char* const LIGHT = R"glsl(
uniform float ambient_share;
uniform vec4 light_direction;
uniform vec4 light_color;
uniform mat4 view;
uniform float underside_share;
varying vec3 view_position;
varying vec3 view_normal;

vec3 unitOr(vec3 v, vec3 otherwise)
{
  float square = dot(v, v);
  return square > 0.0 ? v * inversesqrt(square) : otherwise;
}

vec3 lightSeen(vec3 to_eye, bool is_flat)
{
  vec3 facet = unitOr(cross(dFdx(view_position), dFdy(view_position)), vec3(0.0, 0.0, 1.0));
  facet = dot(facet, to_eye) < 0.0 ? -facet : facet;
  vec3 normal = is_flat ? facet : unitOr(view_normal, facet);
  normal = dot(normal, facet) < 0.0 ? -normal : normal;
  float share = max(dot(normal, -light_direction.xyz), 0.0);
  vec3 light = mix(vec3(ambient_share), vec3(1.0), share * light_color.rgb);
  vec3 up = (view * vec4(0.0, 0.0, 1.0, 0.0)).xyz;
  return light * mix(underside_share, 1.0, 0.5 + 0.5 * dot(normal, up));
}
)glsl";

const char* const OVERLAY = R"glsl(
uniform vec4 surface_color;
uniform mat4 projection;

void main()
{
  vec3 to_eye = projection[3][3] == 0.0 ? -view_position : vec3(0.0, 0.0, 1.0);
  vec3 light = lightSeen(to_eye, false);
  cut();  // after what looks at neighboring fragments
  gl_FragColor = vec4(surface_color.rgb * light, surface_color.a);
}
)glsl";

const char* const FRAGMENT_REST = R"glsl(
uniform float flat_shading;
uniform float contour_interval;
varying vec3 to_eye;

void main()
{
  vec3 light = lightSeen(to_eye, flat_shading > 0.5);
  vec4 color = surfaceColor();
  if (contour_interval > 0.0) {
    float at = surface_point.z / contour_interval;
    float pixels = abs(fract(at - 0.5) - 0.5) / max(fwidth(at), 1e-6);
    light *= mix(0.25, 1.0, clamp(pixels - 0.5, 0.0, 1.0));
  }
  cut();  // after what looks at neighboring fragments
  gl_FragColor = vec4(color.rgb * light, color.a);
}
)glsl";

void ensureProgram(const char* name, Ogre::GpuProgramType type, const std::string& source)
{
  auto& manager = Ogre::HighLevelGpuProgramManager::getSingleton();
  const std::string group = Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME;
  if (!manager.resourceExists(name)) {
    manager.createProgram(name, group, "glsl", type)->setSource(source);
  }
}

using Parameters = Ogre::GpuProgramParameters;

using Color = SurfaceLook::Color;

void setSection(Ogre::GpuProgramParameters* parameters, const Section& section)
{
  Ogre::Vector4 lower(0.0f), upper(0.0f);
  const Bounds widened = section.widened();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lower[axis] = widened.lower[axis];
    upper[axis] = widened.upper[axis];
  }
  parameters->setNamedConstant("section_lower", lower);
  parameters->setNamedConstant("section_upper", upper);
}

void ensurePrograms()
{
  using std::string;
  ensureProgram(VERTEX_PROGRAM, Ogre::GPT_VERTEX_PROGRAM, VERTEX_SOURCE);
  ensureProgram(OVERLAY_VERTEX_PROGRAM, Ogre::GPT_VERTEX_PROGRAM, OVERLAY_VERTEX_SOURCE);
  const auto ensure = [](const char* name, const string& source) {
    ensureProgram(name, Ogre::GPT_FRAGMENT_PROGRAM, source);
  };
  ensure(FRAGMENT_PROGRAM, string(WHOLE) + FRAGMENT_START + LIGHT + FRAGMENT_REST);
  ensure(TEXTURED_PROGRAM, string(WHOLE) + TEXTURED_START + LIGHT + FRAGMENT_REST);
  ensure(CUT_FRAGMENT_PROGRAM, string(CUT) + FRAGMENT_START + LIGHT + FRAGMENT_REST);
  ensure(CUT_TEXTURED_PROGRAM, string(CUT) + TEXTURED_START + LIGHT + FRAGMENT_REST);
  ensure(CUT_UNLIT_PROGRAM, string(CUT) + UNLIT);
  ensure(OVERLAY_PROGRAM, string(WHOLE) + LIGHT + OVERLAY);
  ensure(CUT_OVERLAY_PROGRAM, string(CUT) + LIGHT + OVERLAY);
}

void setVertexProgram(Ogre::Pass* pass, const char* program = VERTEX_PROGRAM)
{
  pass->setVertexProgram(program);
  if (pass->getVertexProgram()->isSupported()) {
    const auto parameters = pass->getVertexProgramParameters();
    parameters->setIgnoreMissingParams(true);
    parameters->setNamedAutoConstant("world_view_projection", Parameters::ACT_WORLDVIEWPROJ_MATRIX);
    parameters->setNamedAutoConstant("world_view", Parameters::ACT_WORLDVIEW_MATRIX);
    parameters->setNamedAutoConstant("normal_matrix",
                                     Parameters::ACT_INVERSE_TRANSPOSE_WORLDVIEW_MATRIX);
    parameters->setNamedAutoConstant("projection", Parameters::ACT_PROJECTION_MATRIX);
  }
}

void setFragmentParameters(Ogre::GpuProgramParameters* parameters, const SurfaceLook& look)
{
  parameters->setIgnoreMissingParams(true);
  setSection(parameters, look.section);
  if (look.from == Color::TEXTURE) {
    parameters->setNamedConstant("surface_texture", 0);
  } else if (look.from == Color::PARTS) {
    parameters->setNamedAutoConstant("surface_color", Parameters::ACT_CUSTOM, PART_COLOR);
  } else {
    parameters->setNamedConstant("surface_color", look.color);
  }
  parameters->setNamedConstant("use_vertex_colors", look.from == Color::VERTICES ? 1.0f : 0.0f);
  parameters->setNamedConstant("alpha", look.from == Color::ONE ? 1.0f : look.alpha);
  parameters->setNamedConstant("flat_shading", look.flat_shading ? 1.0f : 0.0f);
  parameters->setNamedConstant("ambient_share", AMBIENT_SHARE);
  parameters->setNamedConstant("underside_share", UNDERSIDE_SHARE);
  parameters->setNamedConstant("contour_interval", look.contour_interval);
  parameters->setNamedAutoConstant("view", Parameters::ACT_VIEW_MATRIX);
  parameters->setNamedAutoConstant("projection", Parameters::ACT_PROJECTION_MATRIX);
  parameters->setNamedAutoConstant("light_direction", Parameters::ACT_LIGHT_DIRECTION_VIEW_SPACE,
                                   0);
  parameters->setNamedAutoConstant("light_color", Parameters::ACT_LIGHT_DIFFUSE_COLOUR, 0);
}

}  // namespace

void setTwoSidedLighting(Ogre::Pass* pass, const SurfaceLook& look)
{
  ensurePrograms();
  const bool textured = look.from == SurfaceLook::Color::TEXTURE, cut = look.section.cuts();
  pass->setCullingMode(Ogre::CULL_NONE);
  pass->setLightingEnabled(true);
  setVertexProgram(pass, look.overlay ? OVERLAY_VERTEX_PROGRAM : VERTEX_PROGRAM);
  if (look.overlay) {
    pass->setFragmentProgram(cut ? CUT_OVERLAY_PROGRAM : OVERLAY_PROGRAM);
  } else if (textured) {
    pass->setFragmentProgram(cut ? CUT_TEXTURED_PROGRAM : TEXTURED_PROGRAM);
  } else {
    pass->setFragmentProgram(cut ? CUT_FRAGMENT_PROGRAM : FRAGMENT_PROGRAM);
  }
  if (pass->getFragmentProgram()->isSupported()) {
    setFragmentParameters(pass->getFragmentProgramParameters().get(), look);
  }
}

void setUnlitSection(Ogre::Pass* pass, const Ogre::ColourValue& color, const Section& section)
{
  ensurePrograms();
  setVertexProgram(pass);
  pass->setFragmentProgram(CUT_UNLIT_PROGRAM);
  if (pass->getFragmentProgram()->isSupported()) {
    const auto parameters = pass->getFragmentProgramParameters();
    parameters->setIgnoreMissingParams(true);
    parameters->setNamedConstant("surface_color", color);
    setSection(parameters.get(), section);
  }
}

}  // namespace rviz_mesh_plugin
