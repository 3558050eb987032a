// A layout drawn without hidden faces, before the mesh is laid out without them.
#include <algorithm>
#include <atomic>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "level_of_detail/part_masks.h"
#include "mesh_zoo.h"
#include "support/layout_checks.h"
#include "threads/cancellation.h"

using namespace rviz_mesh_plugin;

namespace {

const std::atomic<bool> NOT_CANCELED{false};
using Face = std::array<std::uint32_t, 3>;

HiddenFacesConstPtr hiddenOf(const MeshData& mesh, const std::function<bool(std::uint32_t)>& is)
{
  FaceBits bits(mesh.faceCount());
  for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
    if (is(face)) {
      bits.add(FaceBits::Faces{face});
    }
  }
  return std::make_shared<const HiddenFaces>(bits);
}

/// What is drawn in full, by vertices of the mesh.
std::vector<Face> drawn(const MeshLayout& layout, const PartMasks& masks)
{
  std::map<std::size_t, const PartMask*> masked;
  for (const PartMask& mask : masks.masks) {
    EXPECT_TRUE(masked.emplace(mask.part, &mask).second) << "a part twice";
  }
  std::vector<Face> faces;
  for (std::size_t i = 0; i < layout.parts.size(); ++i) {
    const IndexRange& full = layout.parts[i].levels.front();
    const std::vector<std::uint32_t> all(layout.indices.begin() + full.start,
                                         layout.indices.begin() + full.start + full.count);
    const std::vector<std::uint32_t>& indices = masked.count(i) ? masked.at(i)->indices : all;
    for (std::size_t k = 0; k + 2 < indices.size(); k += 3) {
      faces.push_back(layout_checks::rotatedToLeast<std::uint32_t>(
          {layout.sources[indices[k]], layout.sources[indices[k + 1]],
           layout.sources[indices[k + 2]]}));
    }
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

std::vector<Face> seen(const MeshData& mesh, const std::vector<const HiddenFaces*>& hidden)
{
  std::vector<Face> faces;
  for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
    const auto contains = [&](const HiddenFaces* one) { return one && one->contains(face); };
    if (std::none_of(hidden.begin(), hidden.end(), contains)) {
      faces.push_back(layout_checks::rotatedToLeast<std::uint32_t>(
          {mesh.indices[3 * face], mesh.indices[3 * face + 1], mesh.indices[3 * face + 2]}));
    }
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

}  // namespace

TEST(PartMasks, exactly_what_is_not_hidden_is_drawn)
{
  for (const auto& [name, mesh] : mesh_zoo::all()) {
    SCOPED_TRACE(name);
    const std::uint32_t count = mesh->faceCount();
    for (const auto& is : std::vector<std::function<bool(std::uint32_t)>>{
             [](std::uint32_t face) { return face % 3 == 1; },
             [count](std::uint32_t face) { return face > count / 2; },
             [](std::uint32_t face) { return face == 0; },
             [](std::uint32_t) { return true; },
         }) {
      const HiddenFacesConstPtr hidden = hiddenOf(*mesh, is);
      const auto layout = layOut(mesh, Split::NONE, nullptr, NOT_CANCELED);
      EXPECT_EQ(drawn(*layout, maskParts(*layout, hidden, NOT_CANCELED)),
                seen(*mesh, {hidden.get()}));
      const HiddenFacesConstPtr before =
          hiddenOf(*mesh, [](std::uint32_t face) { return face % 7 == 1; });
      const auto without = layOut(mesh, Split::NONE, nullptr, NOT_CANCELED, before);
      EXPECT_EQ(drawn(*without, maskParts(*without, hidden, NOT_CANCELED)),
                seen(*mesh, {hidden.get(), before.get()}))
          << "on a layout that has not all faces";
    }
  }
}

TEST(PartMasks, no_simplified_face_that_is_drawn_reaches_into_a_part_that_is_masked)
{
  const auto mesh = mesh_zoo::terrain(300, 300);
  const auto layout = layOut(mesh, Split::NONE, nullptr, NOT_CANCELED);
  ASSERT_GT(layout->parts.size(), 12u);
  std::vector<std::size_t> part_of(layout->vertices.size(), layout->parts.size());
  for (std::size_t i = layout->parts.size(); i-- > 0;) {
    const IndexRange& full = layout->parts[i].levels.front();
    for (std::size_t k = full.start; k < full.end(); ++k) {
      part_of[layout->indices[k]] = i;
    }
  }
  for (const std::size_t middle : {std::size_t{0}, layout->parts.size() / 2}) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < middle; ++i) {
      begin += layout->parts[i].levels.front().count / 3;
    }
    const std::uint32_t one = (*layout->faces)[begin];
    const PartMasks masks = maskParts(
        *layout, hiddenOf(*mesh, [&](std::uint32_t face) { return face == one; }), NOT_CANCELED);
    ASSERT_EQ(masks.masks.size(), 1u);
    EXPECT_EQ(masks.masks.front().part, middle);
    const std::set<std::size_t> in_full(masks.in_full.begin(), masks.in_full.end());
    EXPECT_EQ(in_full.count(middle), 0u) << "it is masked";
    EXPECT_LT(in_full.size(), layout->parts.size() - 1) << "the others are drawn as ever";
    for (std::size_t i = 0; i < layout->parts.size(); ++i) {
      if (i == middle || in_full.count(i) != 0) {
        continue;
      }
      for (std::size_t level = 1; level < layout->parts[i].levels.size(); ++level) {
        const IndexRange& range = layout->parts[i].levels[level];
        for (std::size_t k = range.start; k < range.end(); ++k) {
          ASSERT_NE(part_of[layout->indices[k]], middle) << "part " << i << ", level " << level;
        }
      }
    }
    EXPECT_TRUE(!layout_checks::canSimplify() || !in_full.empty());
  }
}

TEST(PartMasks, there_are_none_where_none_can_be_made)
{
  const auto mesh = mesh_zoo::terrain(20, 20);
  const HiddenFacesConstPtr all = hiddenOf(*mesh, [](std::uint32_t) { return true; });
  const auto masks = [&](const MeshLayoutConstPtr& layout, const HiddenFacesConstPtr& hidden) {
    return maskParts(*layout, hidden, NOT_CANCELED).masks.size();
  };
  const auto layout = layOut(mesh, Split::NONE, nullptr, NOT_CANCELED);
  EXPECT_EQ(masks(layout, all), layout->parts.size());
  EXPECT_EQ(masks(layout, nullptr), 0u);
  EXPECT_EQ(masks(layout, hiddenOf(*mesh_zoo::terrain(3, 3), [](std::uint32_t) { return true; })),
            0u)
      << "of another mesh";
  EXPECT_EQ(masks(layOut(mesh, Split::BY_FACE, nullptr, NOT_CANCELED), all), 0u);
  const std::atomic<bool> canceled{true};
  EXPECT_THROW(maskParts(*layout, all, canceled), Canceled);
}
