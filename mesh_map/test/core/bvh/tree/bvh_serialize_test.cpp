#include <mesh_map/bvh/tree/bvh.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "bvh/tree/bvh_bytes.h"
#include "bvh_checks.h"

using mesh_map::Bvh;
using Bytes = std::vector<std::uint8_t>;

namespace {

constexpr std::size_t HEADER = 40;

void writeNumber(Bytes& bytes, std::size_t at, std::uint64_t value, std::size_t size)
{
  for (std::size_t i = 0; i < size; ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
}

void repairChecksum(Bytes& bytes)
{
  if (bytes.size() >= 8) {
    const std::size_t end = bytes.size() - 8;
    writeNumber(bytes, end, mesh_map::checksum(bytes.data(), end), 8);
  }
}

/// What deserialize() says, or what is wrong with what it makes.
std::string answer(const Bytes& bytes, const TestMesh& mesh)
{
  try {
    return whatIsWrong(Bvh::deserialize(bytes, mesh.view()), mesh);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

std::string refused(const std::string& why)
{
  return "not the bytes of a spatial index of this mesh: " + why + "; build the index anew";
}

}  // namespace

TEST(BvhSerialize, MakesTheSameTreeAgain)
{
  std::vector<TestMesh> meshes = testMeshes();
  meshes.push_back(terrain(150));
  meshes.push_back(terrain(150, 10.0f, 5e5f));
  for (const TestMesh& mesh : meshes) {
    SCOPED_TRACE(mesh.name);
    Bvh bvh = Bvh::build(mesh.view());
    const Bytes bytes = bvh.serialize();
    const Bvh again = Bvh::deserialize(bytes, mesh.view());
    EXPECT_TRUE(sameTree(bvh, again));
    EXPECT_EQ(again.serialize(), bytes);
    EXPECT_EQ(again.memory(), bvh.memory());

    TestMesh moved = mesh;
    for (float& value : moved.positions) {
      value = 1.5f * value + 1.0f;
    }
    bvh.refit(moved.view());
    EXPECT_TRUE(sameTree(bvh, Bvh::deserialize(bvh.serialize(), moved.view())));
  }
}

TEST(BvhSerialize, HasTheFormThatItIsSaidToHave)
{
  const TestMesh mesh{"one", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}};
  const Bytes bytes = Bvh::build(mesh.view()).serialize();
  const Bytes begin = {'m', 'e', 's', 'h', '_', 'b', 'v', 'h', 1, 0, 0, 0, 1, 0, 0, 0,
                       1,   0,   0,   0,   0,   0,   0,   0,   0, 0, 0, 0, 0, 0, 0, 0};
  ASSERT_EQ(bytes.size(), HEADER + 16 + 4 + 8);
  EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 32), begin);
  const Bytes node = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(Bytes(bytes.begin() + HEADER, bytes.end() - 8), node);
}

TEST(BvhSerialize, RefusesBytesOfAnotherMesh)
{
  const TestMesh mesh = terrain(20);
  const Bytes bytes = Bvh::build(mesh.view()).serialize();
  EXPECT_EQ(answer(bytes, mesh), "");
  EXPECT_EQ(answer(bytes, terrain(21)), refused("800 faces where 882 belong"));
  const std::string elsewhere = refused("it is one of a mesh whose faces are elsewhere");
  TestMesh other = mesh;
  other.positions[700] = std::nextafter(other.positions[700], 100.0f);
  EXPECT_EQ(answer(bytes, other), elsewhere);
  other = mesh;
  std::swap(other.faces[0], other.faces[1]);
  EXPECT_EQ(answer(bytes, other), elsewhere);
  other = mesh;
  std::swap_ranges(other.faces.begin(), other.faces.begin() + 3, other.faces.begin() + 30);
  EXPECT_EQ(answer(bytes, other), elsewhere);

  // What is no mesh is refused as by build().
  other.faces[100] = 441;
  EXPECT_EQ(answer(bytes, other).find("face 33 refers to vertex 441"), 0u);
  EXPECT_EQ(answer(bytes, {"", {}, {}}),
            "a mesh without faces has no spatial index: give it at least one face");

  // Other numbers of vertices are no matter where the faces are as they were.
  other = mesh;
  other.positions.insert(other.positions.end(), {1, 2, 3});
  EXPECT_EQ(answer(bytes, other), "");
}

TEST(BvhSerialize, SaysWhatIsWrong)
{
  const TestMesh mesh = terrain(20);
  const Bytes good = Bvh::build(mesh.view()).serialize();
  const auto nodes = mesh_map::readNumber<std::uint32_t>(good.data() + 16);
  const std::size_t faces = HEADER + 16 * std::size_t{nodes};
  const auto changed = [&](std::size_t at, std::uint64_t value, std::size_t size = 4) {
    Bytes bytes = good;
    writeNumber(bytes, at, value, size);
    repairChecksum(bytes);
    return answer(bytes, mesh);
  };
  EXPECT_EQ(answer({}, mesh), refused("0 bytes are too few"));
  EXPECT_EQ(changed(0, 0x6C), refused("they do not begin as such"));
  EXPECT_EQ(changed(8, 2), refused("version 2 is not 1, which is read"));
  EXPECT_EQ(changed(12, 801), refused("801 faces where 800 belong"));
  EXPECT_EQ(changed(16, nodes + 1), refused(std::to_string(good.size()) + " bytes where " +
                                            std::to_string(good.size() + 16) + " belong"));
  EXPECT_NE(changed(16, 0xFFFFFFFFu).find("belong"), std::string::npos);
  EXPECT_EQ(changed(20, 0x7FC00000), refused("a center at nan"));
  EXPECT_EQ(changed(24, 0x7F800000), refused("a center at inf"));
  EXPECT_NE(changed(28, 0x7F7FFFFF).find("a center at 3402823"), std::string::npos);
  EXPECT_EQ(changed(32, 1, 8), refused("it is one of a mesh whose faces are elsewhere"));
  EXPECT_EQ(changed(faces, 800), refused("face 800 at position 0 of 800"));
  const auto first = mesh_map::readNumber<std::uint32_t>(good.data() + faces);
  EXPECT_EQ(changed(faces + 4 * 9, first),
            refused("face " + std::to_string(first) + " a second time at position 9"));
  const auto count = mesh_map::readNumber<std::uint32_t>(good.data() + HEADER);
  EXPECT_EQ(changed(HEADER, count + 1), refused("node 0 has 801 triangles where 800 belong"));
  EXPECT_NE(changed(HEADER, 0xFFFFFFFFu).find("node 0 has"), std::string::npos);
  Bytes damaged = good;
  damaged[faces] ^= 1;
  EXPECT_EQ(answer(damaged, mesh), refused("they are damaged (the checksum differs)"));

  // A chain of nodes is sound in all but its depth.
  for (const std::size_t length : {mesh_map::BVH_DEPTH, mesh_map::BVH_DEPTH + 1}) {
    Bytes chain(good.begin(), good.begin() + HEADER);
    const TestMesh few = identical(5);
    const Bytes of_few = Bvh::build(few.view()).serialize();
    std::copy(of_few.begin(), of_few.begin() + HEADER, chain.begin());
    writeNumber(chain, 16, length, 4);
    chain.resize(HEADER + 16 * length + 4 * 5 + 8);
    for (std::size_t i = 0; i + 1 < length; ++i) {
      writeNumber(chain, HEADER + 16 * i, 5, 4);
    }
    writeNumber(chain, HEADER + 16 * (length - 1), 4, 4);
    writeNumber(chain, HEADER + 16 * (length - 1) + 12, 1, 4);
    for (std::uint32_t i = 0; i < 5; ++i) {
      writeNumber(chain, HEADER + 16 * length + 4 * i, i, 4);
    }
    repairChecksum(chain);
    EXPECT_EQ(answer(chain, few),
              length == mesh_map::BVH_DEPTH ? "" : refused("the tree is deeper than 42 nodes"));
  }
}

TEST(BvhSerialize, TakesOrRefusesWhateverBytes)
{
  std::mt19937 random(11);
  const auto below = [&random](std::size_t limit) { return random() % limit; };
  std::size_t taken = 0, refused = 0;
  for (const TestMesh& mesh : {identical(1), terrain(3), soup(200), identical(60)}) {
    const Bytes good = Bvh::build(mesh.view()).serialize();
    for (unsigned round = 0; round < 2500; ++round) {
      Bytes bytes = good;
      for (std::size_t change = below(3) + 1; change > 0; --change) {
        const std::size_t at = below(bytes.size());
        switch (below(6)) {
          case 0:
            bytes[at] ^= static_cast<std::uint8_t>(1u << below(8));
            break;
          case 1:  // small numbers in the place of numbers
            writeNumber(bytes, at / 4 * 4, below(12),
                        std::min<std::size_t>(4, bytes.size() - at / 4 * 4));
            break;
          case 2:
            bytes.resize(at + 1);
            break;
          case 3:
            bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), below(40), 7);
            break;
          case 4:
            bytes[at] = static_cast<std::uint8_t>(random());
            break;
          default: {  // exchange two numbers, as of faces or nodes
            const std::size_t i = at / 4 * 4, k = below(bytes.size()) / 4 * 4;
            for (std::size_t b = 0; b < 4 && std::max(i, k) + b < bytes.size(); ++b) {
              std::swap(bytes[i + b], bytes[k + b]);
            }
          }
        }
      }
      if (round % 5 != 0) {
        repairChecksum(bytes);
      }
      const std::string said = answer(bytes, mesh);
      ASSERT_TRUE(said.empty() || said.find("not the bytes of a spatial index") == 0) << said;
      ++(said.empty() ? taken : refused);
    }
  }
  EXPECT_GT(taken, 100u);
  EXPECT_GT(refused, 5000u);
}
