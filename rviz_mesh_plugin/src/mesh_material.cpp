#include "rviz_mesh_plugin/mesh_material.h"

#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>
#include <OgreTextureUnitState.h>

#include "rviz_mesh_plugin/mesh_part_object.h"
#include "rviz_mesh_plugin/ogre_compatibility.h"
#include "rviz_mesh_plugin/two_sided_lighting.h"
#include "rviz_mesh_plugin/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

/// Lines are pulled this far in front of the faces they lie in (units of the depth buffer; slope of
/// the face).
constexpr float WIREFRAME_DEPTH_BIAS = 1.0f;
constexpr float WIREFRAME_SLOPE_BIAS = 1.0f;

/// Draws in one color without light.
void setUnlitColor(Ogre::Pass* pass, const Ogre::ColourValue& color)
{
  // Without lighting OGRE takes the color of the vertices: light is on, but all the light is the
  // surface's own.
  pass->setLightingEnabled(true);
  pass->setAmbient(Ogre::ColourValue::Black);
  pass->setDiffuse(Ogre::ColourValue(0.0f, 0.0f, 0.0f, color.a));
  pass->setSpecular(Ogre::ColourValue::Black);
  pass->setSelfIllumination(color);
}

/// Translucent passes blend with what is behind them and leave the depth buffer alone.
void setBlending(Ogre::Pass* pass, bool translucent)
{
  pass->setSceneBlending(translucent ? Ogre::SBT_TRANSPARENT_ALPHA : Ogre::SBT_REPLACE);
  pass->setDepthWriteEnabled(!translucent);
}

Ogre::CullingMode cullingMode(MeshStyle::Culling culling)
{
  switch (culling) {
    case MeshStyle::Culling::BACK:
      return Ogre::CULL_CLOCKWISE;
    case MeshStyle::Culling::FRONT:
      return Ogre::CULL_ANTICLOCKWISE;
    default:
      return Ogre::CULL_NONE;
  }
}

void addTexture(Ogre::Pass* pass, const FaceLook& look)
{
  if (look.from == FaceLook::Color::TEXTURE) {
    Ogre::TextureUnitState* unit = pass->createTextureUnitState(look.texture->getName());
    unit->setTextureFiltering(Ogre::TFO_TRILINEAR);
  }
}

SurfaceColor surfaceColor(const MeshStyle& style, const FaceLook& look)
{
  SurfaceColor surface;
  surface.color = look.color;
  surface.alpha = style.alpha;
  surface.custom_parameter = MeshPartObject::COLOR_PARAMETER;
  surface.textured = look.from == FaceLook::Color::TEXTURE;
  surface.flat_shading = style.flat_shading;
  if (look.from == FaceLook::Color::VERTICES) {
    surface.from = SurfaceColor::From::VERTICES;
  } else if (look.from == FaceLook::Color::PARTS) {
    surface.from = SurfaceColor::From::RENDERABLES;
  }
  return surface;
}

void addProgramFaces(Ogre::Technique* technique, const MeshStyle& style, const FaceLook& look)
{
  Ogre::Pass* pass = technique->createPass();
  setTwoSidedLighting(pass, surfaceColor(style, look));
  pass->setCullingMode(cullingMode(style.culling));
  // Without programs, this would make the light flat, too.
  pass->setShadingMode(look.one_color_per_face ? Ogre::SO_FLAT : Ogre::SO_GOURAUD);
  setBlending(pass, look.translucent);
  addTexture(pass, look);
}

/// One side of the faces.
void addFixedFunctionSide(Ogre::Technique* technique, bool front, const MeshStyle& style,
                          const FaceLook& look)
{
  Ogre::Pass* pass = technique->createPass();
  pass->setCullingMode(front ? Ogre::CULL_CLOCKWISE : Ogre::CULL_ANTICLOCKWISE);
  const bool flat = style.flat_shading || look.one_color_per_face;
  pass->setShadingMode(flat ? Ogre::SO_FLAT : Ogre::SO_GOURAUD);
  setBlending(pass, look.translucent);
  addTexture(pass, look);
  if (look.from == FaceLook::Color::VERTICES) {
    pass->setLightingEnabled(front);
    pass->setVertexColourTracking(Ogre::TVC_DIFFUSE);
    return;
  }
  const bool own_alpha = look.from == FaceLook::Color::ONE;
  Ogre::ColourValue color =
      look.from == FaceLook::Color::TEXTURE ? Ogre::ColourValue::White : look.color;
  color.a = own_alpha ? look.color.a : style.alpha;
  setUnlitColor(pass, front ? color * AMBIENT_SHARE : color);
  Ogre::ColourValue diffuse =
      front ? color * (1.0f - AMBIENT_SHARE) : Ogre::ColourValue(0.0f, 0.0f, 0.0f);
  diffuse.a = color.a;
  pass->setDiffuse(diffuse);
}

void addFixedFunctionFaces(Ogre::Technique* technique, const MeshStyle& style, const FaceLook& look)
{
  if (style.culling != MeshStyle::Culling::BACK) {
    addFixedFunctionSide(technique, false, style, look);
  }
  if (style.culling != MeshStyle::Culling::FRONT) {
    addFixedFunctionSide(technique, true, style, look);
  }
}

void addWireframe(Ogre::Technique* technique, const MeshStyle& style)
{
  const Ogre::ColourValue& color = style.wireframe_color;
  Ogre::Pass* pass = technique->createPass();
  setUnlitColor(pass, color);
  setBlending(pass, color.a < 1.0f);
  pass->setPolygonMode(Ogre::PM_WIREFRAME);
  pass->setCullingMode(cullingMode(style.culling));
  pass->setDepthBias(WIREFRAME_DEPTH_BIAS, WIREFRAME_SLOPE_BIAS);
}

}  // namespace

MeshMaterial::MeshMaterial()
    : material_(Ogre::MaterialManager::getSingleton().create(
          uniqueName("Material"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME))
{
  material_->setReceiveShadows(false);
}

MeshMaterial::~MeshMaterial()
{
  removeResource(Ogre::MaterialManager::getSingleton(), material_);
}

void MeshMaterial::apply(const MeshStyle& style, const FaceLook& look)
{
  material_->removeAllTechniques();
  for (const bool programs : {true, false}) {
    Ogre::Technique* technique = material_->createTechnique();
    if (look.from != FaceLook::Color::HIDDEN) {
      programs ? addProgramFaces(technique, style, look)
               : addFixedFunctionFaces(technique, style, look);
    }
    if (style.show_wireframe) {
      addWireframe(technique, style);
    }
    if (technique->getNumPasses() == 0) {
      technique->createPass();  // OGRE refuses a technique without any
    }
  }
}

void MeshMaterial::applyUnlit(const Ogre::ColourValue& color)
{
  material_->removeAllTechniques();
  Ogre::Pass* pass = material_->createTechnique()->createPass();
  setUnlitColor(pass, color);
  setBlending(pass, color.a < 1.0f);
}

}  // namespace rviz_mesh_plugin
