#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "mesh_zoo.h"
#include "support/layout_checks.h"

using namespace rviz_mesh_plugin;
using layout_checks::canSimplify;
using layout_checks::Position;
using Segment = std::array<Position, 2>;
using Triangle = std::array<Position, 3>;

namespace {

struct Border
{
  std::vector<Segment> open;   ///< edges of one face alone
  std::vector<Segment> outer;  ///< and those with more faces on one side than on the other
};

Border borderOf(const std::vector<Triangle>& faces)
{
  std::map<Segment, std::array<int, 2>> sides;
  for (const auto& face : faces) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Position& a = face[i];
      const Position& b = face[(i + 1) % 3];
      ++sides[a < b ? Segment{a, b} : Segment{b, a}][a < b ? 0 : 1];
    }
  }
  Border border;
  for (const auto& [edge, counts] : sides) {
    if (counts[0] + counts[1] == 1) {
      border.open.push_back(edge);
    }
    if (counts[0] != counts[1]) {
      border.outer.push_back(edge);
    }
  }
  return border;
}

float distance(const Position& point, const Segment& segment)
{
  Position along, to;
  float square = 0.0f;
  float place = 0.0f;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    along[axis] = segment[1][axis] - segment[0][axis];
    to[axis] = point[axis] - segment[0][axis];
    square += along[axis] * along[axis];
    place += along[axis] * to[axis];
  }
  place = square > 0.0f ? std::min(std::max(place / square, 0.0f), 1.0f) : 0.0f;
  return std::hypot(to[0] - place * along[0], to[1] - place * along[1], to[2] - place * along[2]);
}

/// Of the ends of @a from, to the nearest of @a to: the greatest one.
float greatestDistance(const std::vector<Segment>& from, const std::vector<Segment>& to)
{
  float greatest = 0.0f;
  for (const auto& segment : from) {
    for (const auto& end : segment) {
      float least = std::numeric_limits<float>::max();
      for (const auto& other : to) {
        least = std::min(least, distance(end, other));
      }
      greatest = std::max(greatest, least);
    }
  }
  return greatest;
}

double length(const std::vector<Segment>& segments)
{
  double sum = 0.0;
  for (const auto& [a, b] : segments) {
    sum += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  }
  return sum;
}

/// Seen from above; faces that lie on their backs count negative.
double areaFromAbove(const std::vector<Triangle>& faces)
{
  double area = 0.0;
  for (const auto& face : faces) {
    area += 0.5 * ((face[1][0] - face[0][0]) * (face[2][1] - face[0][1]) -
                   (face[2][0] - face[0][0]) * (face[1][1] - face[0][1]));
  }
  return area;
}

mesh_zoo::MeshPtr rectangle(std::uint32_t columns, std::uint32_t rows)
{
  auto mesh = mesh_zoo::terrain(columns, rows);
  for (std::uint32_t i = 0; i < mesh->vertices.size(); ++i) {
    mesh->vertices[i].position = {0.1f * (i % (columns + 1)), 0.1f * (i / (columns + 1)), 1.0f};
  }
  return mesh_zoo::finish(mesh);
}

/// With a star of wavy arms cut out in the middle.
mesh_zoo::MeshPtr withHole(const mesh_zoo::MeshPtr& mesh, float x, float y, float radius)
{
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < mesh->indices.size(); i += 3) {
    const auto& a = mesh->vertices[mesh->indices[i]].position;
    const float angle = std::atan2(a[1] - y, a[0] - x);
    const float edge = 1.0f + 0.35f * std::sin(5.0f * angle) + 0.1f * std::sin(17.0f * angle);
    if (std::hypot(a[0] - x, a[1] - y) > radius * edge) {
      kept.insert(kept.end(), &mesh->indices[i], &mesh->indices[i] + 3);
    }
  }
  mesh->indices = kept;
  return mesh;
}

/// x, y, z and faces of a binary PLY file of triangles; null where there is no such file.
mesh_zoo::MeshPtr realMesh(const std::string& name)
{
  const char* folder = std::getenv("MESH_TOOLS_DATA");
  std::ifstream file(std::string(folder ? folder : SHARED_DATA) + "/" + name, std::ios::binary);
  if (!file) {
    return nullptr;
  }
  std::size_t counts[2] = {0, 0};
  std::size_t floats[2] = {0, 0};  // of a vertex; behind the indices of a face
  std::size_t element = 0;
  bool texture = false;
  for (std::string line; std::getline(file, line) && line != "end_header";) {
    std::istringstream words(line);
    std::string first, second, third;
    words >> first >> second >> third;
    if (first == "element") {
      element = second == "vertex" ? 0 : 1;
      counts[element] = std::stoul(third);
    } else if (first == "property") {
      floats[element] += second == "float" ? 1 : 0;
      texture = texture || line == "property list uchar float texcoord";
    }
  }
  auto mesh = std::make_shared<MeshData>();
  std::vector<float> values(std::max(floats[0], floats[1]));
  const auto skip = [&](std::size_t bytes) { file.seekg(bytes, std::ios::cur); };
  for (std::size_t i = 0; i < counts[0]; ++i) {
    file.read(reinterpret_cast<char*>(values.data()), 4 * floats[0]);
    mesh_zoo::addVertex(*mesh, values[0], values[1], values[2]);
  }
  for (std::size_t i = 0; i < counts[1]; ++i) {
    std::uint32_t corners[3] = {};
    skip(1);
    file.read(reinterpret_cast<char*>(corners), sizeof(corners));
    mesh->indices.insert(mesh->indices.end(), corners, corners + 3);
    skip((texture ? 4 * std::size_t(file.get()) : 0) + 4 * floats[1]);
  }
  return mesh_zoo::finish(mesh);
}

/// In cells of the level.
struct Bounds
{
  float away;   ///< of the mesh's border from that of the level
  double area;  ///< lost or won per length of the border
};

void expectBorderKept(const MeshDataConstPtr& mesh, const Bounds& bounds)
{
  const std::atomic<bool> go_on{false};
  const auto layout = layOut(mesh, Split::NONE, nullptr, go_on);
  ASSERT_EQ(layout->cell_sizes.size() > 1, canSimplify());
  const auto faces = layout_checks::positionsOf(*layout, 0);
  const auto border = borderOf(faces).open;
  ASSERT_FALSE(border.empty());
  for (std::size_t level = 1; level < layout->cell_sizes.size(); ++level) {
    const float cell = layout->cell_sizes[level];
    SCOPED_TRACE("level " + std::to_string(level) + ", cells of " + std::to_string(cell) + " m");
    const auto coarse_faces = layout_checks::positionsOf(*layout, level);
    const Border coarse = borderOf(coarse_faces);
    EXPECT_LE(greatestDistance(border, coarse.outer), bounds.away * cell);
    EXPECT_LE(greatestDistance(coarse.open, border), 0.01f * cell) << "a hole, or not the border";
    EXPECT_NEAR(areaFromAbove(coarse_faces), areaFromAbove(faces),
                bounds.area * cell * length(border));
  }
}

}  // namespace

TEST(LayoutBorder, of_a_rectangle_stays)
{
  expectBorderKept(rectangle(150, 200), {0.5f, 0.01});
  expectBorderKept(rectangle(400, 73), {0.5f, 0.01});
}

TEST(LayoutBorder, of_a_terrain_stays)
{
  expectBorderKept(mesh_zoo::terrain(150, 200), {0.8f, 0.12});
}

TEST(LayoutBorder, of_an_irregular_hole_stays)
{
  expectBorderKept(withHole(mesh_zoo::terrain(150, 200), 7.0f, 11.0f, 3.0f), {1.0f, 0.06});
  // The ends of its arms are narrower than the cells.
  expectBorderKept(withHole(rectangle(250, 250), 12.0f, 13.0f, 7.0f), {1.3f, 0.02});
}

TEST(LayoutBorder, of_a_real_mesh_stays)
{
  const auto mesh = realMesh("tray.ply");
  if (!mesh) {
    GTEST_SKIP() << "tray.ply is not there";
  }
  expectBorderKept(mesh, {0.1f, 0.01});
}
