#include "rviz_mesh_plugin/mesh_material.h"

#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>

#include "rviz_mesh_plugin/ogre_compatibility.h"
#include "rviz_mesh_plugin/two_sided_lighting.h"
#include "rviz_mesh_plugin/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

/// Lines are pulled this far in front of the faces they lie in (units of the depth buffer; slope of
/// the face).
constexpr float WIREFRAME_DEPTH_BIAS = 1.0f;
constexpr float WIREFRAME_SLOPE_BIAS = 1.0f;

struct FaceLook
{
  bool vertex_colors;
  bool translucent;
  Ogre::ColourValue color;
};

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

void addProgramFaces(Ogre::Technique* technique, const FaceLook& look)
{
  Ogre::Pass* pass = technique->createPass();
  setTwoSidedLighting(pass, look.vertex_colors, look.color);
  setBlending(pass, look.translucent);
}

void addFixedFunctionFaces(Ogre::Technique* technique, const FaceLook& look)
{
  Ogre::Pass* back = technique->createPass();
  back->setCullingMode(Ogre::CULL_ANTICLOCKWISE);
  Ogre::Pass* front = technique->createPass();
  front->setCullingMode(Ogre::CULL_CLOCKWISE);
  setBlending(back, look.translucent);
  setBlending(front, look.translucent);
  if (look.vertex_colors) {
    back->setLightingEnabled(false);
    front->setLightingEnabled(true);
    front->setVertexColourTracking(Ogre::TVC_DIFFUSE);
    return;
  }
  setUnlitColor(back, look.color);
  setUnlitColor(front, look.color * AMBIENT_SHARE);
  Ogre::ColourValue diffuse = look.color * (1.0f - AMBIENT_SHARE);
  diffuse.a = look.color.a;
  front->setDiffuse(diffuse);
}

void addWireframe(Ogre::Technique* technique, const Ogre::ColourValue& color)
{
  Ogre::Pass* pass = technique->createPass();
  setUnlitColor(pass, color);
  setBlending(pass, color.a < 1.0f);
  pass->setPolygonMode(Ogre::PM_WIREFRAME);
  pass->setCullingMode(Ogre::CULL_NONE);
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

void MeshMaterial::apply(const MeshStyle& style, bool has_vertex_colors, bool blend_vertex_colors)
{
  FaceLook look;
  look.vertex_colors = style.faces == MeshStyle::Faces::VERTEX_COLORS && has_vertex_colors;
  look.color = style.faces_color;
  look.translucent = look.vertex_colors ? blend_vertex_colors : look.color.a < 1.0f;
  material_->removeAllTechniques();
  for (const bool programs : {true, false}) {
    Ogre::Technique* technique = material_->createTechnique();
    if (style.faces != MeshStyle::Faces::HIDDEN) {
      programs ? addProgramFaces(technique, look) : addFixedFunctionFaces(technique, look);
    }
    if (style.show_wireframe) {
      addWireframe(technique, style.wireframe_color);
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
