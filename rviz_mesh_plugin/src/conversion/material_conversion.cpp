#include "conversion/material_conversion.h"

#include <algorithm>
#include <utility>

#include "base/erase_if.h"
#include "base/texture_halving.h"
#include "conversion/attribute_conversion.h"

namespace rviz_mesh_plugin {
namespace {

/// Labels of clusters are not used: they may be of any kind.
void refuseInvalid(const mesh_msgs::MeshMaterialsStamped& message)
{
  auto findings = check(message);
  eraseIf(findings, [](const Finding& finding) { return finding.rule == "label_unusable"; });
  refuse(findings);
}

/// Faces numbered without large gaps: a table of all.
void assignDensely(const mesh_msgs::MeshMaterials& given, std::uint32_t last_face, Materials& made)
{
  std::vector<std::uint32_t> table(std::size_t(last_face) + 1, NONE);
  for (std::size_t i = 0; i < given.clusters.size(); ++i) {
    for (const std::uint32_t face : given.clusters[i].face_indices) {
      table[face] = given.cluster_materials[i];
    }
  }
  for (std::size_t face = 0; face < table.size(); ++face) {
    if (table[face] != NONE) {
      made.faces.push_back(static_cast<std::uint32_t>(face));
      made.face_materials.push_back(table[face]);
    }
  }
}

/// A few faces of any number, whose table could be too large.
void assignSparsely(const mesh_msgs::MeshMaterials& given, std::size_t count, Materials& made)
{
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // face, cluster
  pairs.reserve(count);
  for (std::size_t i = 0; i < given.clusters.size(); ++i) {
    for (const std::uint32_t face : given.clusters[i].face_indices) {
      pairs.emplace_back(face, static_cast<std::uint32_t>(i));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (i + 1 == pairs.size() || pairs[i + 1].first != pairs[i].first) {
      made.faces.push_back(pairs[i].first);
      made.face_materials.push_back(given.cluster_materials[pairs[i].second]);
    }
  }
}

void assignMaterials(const mesh_msgs::MeshMaterials& given, Materials& made)
{
  std::size_t count = 0;
  std::uint32_t last_face = 0;
  for (const auto& cluster : given.clusters) {
    count += cluster.face_indices.size();
    for (const std::uint32_t face : cluster.face_indices) {
      last_face = std::max(last_face, face);
    }
  }
  if (last_face / 8 <= count) {
    assignDensely(given, last_face, made);
  } else {
    assignSparsely(given, count, made);
  }
}

void halve(TextureImage& image)
{
  std::vector<Rgba8> pixels;
  appendHalved(image.pixels.data(), image.height, image.width, image.height, pixels);
  image.pixels = std::move(pixels);
  image.width = halfOf(image.width);
  image.height = halfOf(image.height);
}

}  // namespace

MaterialsConstPtr convert(const mesh_msgs::MeshMaterialsStamped& message)
{
  refuseInvalid(message);
  const mesh_msgs::MeshMaterials& given = message.mesh_materials;
  auto materials = std::make_shared<Materials>();
  materials->uuid = message.uuid;
  for (const auto& material : given.materials) {
    materials->materials.push_back(
        {toRgba8(material.color), material.has_texture ? material.texture_index : NONE});
  }
  assignMaterials(given, *materials);
  materials->texture_coordinates.reserve(given.vertex_tex_coords.size());
  for (const auto& pair : given.vertex_tex_coords) {
    materials->texture_coordinates.push_back({pair.u, 1.0f - pair.v});
  }
  return materials;
}

TextureImageConstPtr convert(const mesh_msgs::MeshTexture& message)
{
  refuse(check(message));
  const sensor_msgs::Image& image = message.image;
  const PixelEncoding& encoding = *findEncoding(image.encoding);
  // Of two bytes the high one.
  const std::size_t high = encoding.depth == 2 && !image.is_bigendian ? 1 : 0;
  const auto place = [&](int channel) { return channel * encoding.depth + high; };
  const std::size_t red = place(encoding.red), green = place(encoding.green),
                    blue = place(encoding.blue);
  const bool has_alpha = encoding.alpha >= 0;
  const std::size_t alpha_place = has_alpha ? place(encoding.alpha) : 0;
  auto texture = std::make_shared<TextureImage>();
  texture->uuid = message.uuid;
  texture->index = message.texture_index;
  texture->width = image.width;
  texture->height = image.height;
  texture->pixels.reserve(std::size_t(image.width) * image.height);  // not more than the data
  for (std::size_t y = 0; y < image.height; ++y) {
    const std::uint8_t* pixel = image.data.data() + y * image.step;
    for (std::size_t x = 0; x < image.width; ++x, pixel += encoding.bytes()) {
      const std::uint8_t alpha = has_alpha ? pixel[alpha_place] : 255;
      texture->pixels.push_back({pixel[red], pixel[green], pixel[blue], alpha});
      texture->translucent = texture->translucent || alpha < 255;
    }
  }
  while (std::max(texture->width, texture->height) > GREATEST_TEXTURE_SIDE) {
    halve(*texture);
  }
  return texture;
}

}  // namespace rviz_mesh_plugin
