#include <cmath>
#include <iterator>
#include <numeric>
#include <random>
#include <set>

#include "base/face_bits.h"
#include "base/grouped_number.h"
#include "selection/face_neighbors.h"
#include "selection/selection_visual.h"
#include "selection_tool_fixture.h"
#include "support/label_display_fixture.h"

using namespace rviz_mesh_plugin;

namespace {

using Point = std::array<double, 2>;
using Polygon = std::vector<Point>;

double side(const Point& a, const Point& b, const Point& p)
{
  return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

bool contains(const Polygon& polygon, const Point& p)
{
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a[1] > p[1]) != (b[1] > p[1]) &&
        p[0] < (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) + a[0]) {
      inside = !inside;
    }
  }
  return inside;
}

/// Whether two polygons have a point in common.
bool meet(const Polygon& one, const Polygon& other)
{
  for (std::size_t i = 0; i < one.size(); ++i) {
    for (std::size_t j = 0; j < other.size(); ++j) {
      const Point &a = one[i], &b = one[(i + 1) % one.size()];
      const Point &c = other[j], &d = other[(j + 1) % other.size()];
      if (side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0) {
        return true;
      }
    }
  }
  return contains(one, other[0]) || contains(other, one[0]);
}

}  // namespace

class SelectionToolTest : public SelectionToolFixture
{
 protected:
  /// Those whose picture meets the polygon (all of the mesh is in front of the camera).
  Faces inPicture(const std::vector<Pixel>& corners)
  {
    const ShownMesh mesh = shown();
    const auto clip = meshToClip(*camera(), mesh);
    Polygon polygon;
    for (const Pixel& corner : corners) {
      polygon.push_back({(corner.x + 0.5) / 320.0 - 1.0, 1.0 - (corner.y + 0.5) / 240.0});
    }
    Faces faces;
    for (std::uint32_t face = 0; face < mesh.mesh->faceCount(); ++face) {
      const auto p = cornersOf(*mesh.mesh, face);
      Polygon triangle;
      for (unsigned c = 0; c < 9; c += 3) {
        const auto row = [&](unsigned r) {
          return clip[4 * r] * p[c] + clip[4 * r + 1] * p[c + 1] + clip[4 * r + 2] * p[c + 2] +
                 clip[4 * r + 3];
        };
        EXPECT_GT(row(3), 0.0);
        triangle.push_back({row(0) / row(3), row(1) / row(3)});
      }
      if (meet(polygon, triangle)) {
        faces.push_back(face);
      }
    }
    return faces;
  }

  Faces inBox(const Pixel& a, const Pixel& b) { return inPicture({a, {b.x, a.y}, b, {a.x, b.y}}); }

  static Faces without(const Faces& all, const Faces& less)
  {
    Faces left;
    std::set_difference(all.begin(), all.end(), less.begin(), less.end(), std::back_inserter(left));
    return left;
  }
};

TEST_F(SelectionToolTest, box_and_lasso_take_what_touches_them)
{
  showTerrain();
  for (int view = 0; view < 3; ++view) {
    takeView(view);
    const Faces box = inBox({250, 180}, {390, 300}), hole = inBox({290, 220}, {340, 260});
    const Faces lasso = inPicture(LASSO);
    ASSERT_GT(box.size(), 20u);
    ASSERT_LT(box.size(), 800u);
    ASSERT_FALSE(hole.empty());
    key(Qt::Key_1);
    drag({{250, 180}, {300, 200}, {390, 300}});
    EXPECT_EQ(selected(), box) << view;
    EXPECT_FALSE(tool->busy());
    double area = 0.0;
    for (const auto face : box) {
      area += faceArea(*shown().mesh, face);
    }
    EXPECT_TRUE(says(std::to_string(box.size()) + " faces are selected, " +
                     rviz_mesh_plugin::measuredNumber(area).toStdString() + " m²"))
        << said.toStdString();
    drag({{340, 220}, {290, 260}}, Qt::RightButton);
    EXPECT_EQ(selected(), without(box, hole)) << view;
    key(Qt::Key_Delete);
    EXPECT_TRUE(selected().empty());
    key(Qt::Key_2);
    drag(LASSO);
    EXPECT_TRUE(tool->busy());
    ASSERT_TRUE(settle());
    EXPECT_EQ(selected(), lasso) << view;
    key(Qt::Key_Delete);
  }
  EXPECT_TRUE(says("No faces are selected")) << said.toStdString();
}

TEST_F(SelectionToolTest, visible_only_takes_what_is_seen)
{
  showTerrain();
  lookAt({3.5, -2.5, 1.0}, {0.3, -0.2, 0.4});
  spinFrames();
  choose("Selection", "Visible Only");
  const Pixel a{220, 170}, b{430, 310};
  const Faces through = inBox(a, b);
  drag({a, b});
  EXPECT_TRUE(says("Looking which faces are seen")) << said.toStdString();
  ASSERT_TRUE(settle());
  const Faces seen = selected();
  EXPECT_LT(seen.size(), through.size() - 20);
  EXPECT_TRUE(without(seen, through).empty());
  for (int y = a.y; y <= b.y; y += 3) {
    for (int x = a.x; x <= b.x; x += 3) {
      const Pick pick = picker.pick(mouse(x, y));
      EXPECT_TRUE(!pick.hit || tool->selection().contains(pick.hit->face) ||
                  pick.hit->barycentric[0] < 0.25 || pick.hit->barycentric[1] < 0.25 ||
                  pick.hit->barycentric[2] < 0.25)
          << "the middle of a face is seen at " << x << " " << y;
    }
  }
  key(Qt::Key_T, Qt::ControlModifier);
  key(Qt::Key_B, Qt::ControlModifier);
  drag({a, b});
  EXPECT_FALSE(tool->busy());
  key(Qt::Key_Delete);
  drag({a, b});
  const Faces front = selected();
  const auto eye = eyeInMesh(*camera(), shown());
  Faces expected;
  for (const auto face : through) {
    const auto p = cornersOf(*shown().mesh, face);
    const Vector corner{p[0], p[1], p[2]};
    const Vector normal = cross({p[3] - corner[0], p[4] - corner[1], p[5] - corner[2]},
                                {p[6] - corner[0], p[7] - corner[1], p[8] - corner[2]});
    if (dot(normal, minus(eye, corner)) > 0.0) {
      expected.push_back(face);
    }
  }
  EXPECT_EQ(front, expected);
  EXPECT_LT(front.size(), through.size());
}

TEST_F(SelectionToolTest, flood_does_not_go_through_what_is_hidden)
{
  // A wall across a floor: what is behind it is seen again, but not beside what is before it.
  const auto height = [](double x, double) { return x > -0.1 && x < 0.1 ? 0.15 : 0.0; };
  showPrepared(test_meshes::terrain(40, height));
  lookAt({3.0, 0.2, 1.0}, {0.0, 0.0, 0.0});
  spinFrames();
  const auto mesh = shown().mesh;
  const auto neighbors = [&] { return SurfaceIndex::instance().findNeighbors(mesh).neighbors; };
  ASSERT_TRUE(spinUntil([&] { return neighbors() != nullptr; }));
  const Pixel before{320, 290};
  const auto hit = picker.pick(mouse(before.x, before.y)).hit;
  ASSERT_TRUE(hit && hit->point[0] > 0.3) << "before the wall";
  choose("Flood Angle", 180.0f);
  choose("Mode", "Box");
  choose("Selection", "Visible Only");
  drag({{0, 0}, {DEFAULT_WIDTH - 1, DEFAULT_HEIGHT - 1}});
  ASSERT_TRUE(settle());
  const Faces seen = selected();
  key(Qt::Key_Delete);

  // From one face that is seen to the next.
  const std::set<std::uint32_t> all_seen(seen.begin(), seen.end());
  std::set<std::uint32_t> reached{hit->face};
  for (bool grown = true; grown;) {
    grown = false;
    const FaceBits so_far(mesh->faceCount(), Faces(reached.begin(), reached.end()));
    for (const auto face : neighbors()->grow(so_far)) {
      grown |= all_seen.count(face) > 0 && reached.insert(face).second;
    }
  }
  const Faces expected(reached.begin(), reached.end());
  ASSERT_LT(expected.size(), seen.size() - 100) << "behind the wall something is seen";
  key(Qt::Key_3);
  click(before);
  EXPECT_TRUE(tool->busy()) << "not on the GUI thread";
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected(), expected);
  click(before, Qt::RightButton);
  ASSERT_TRUE(settle());
  EXPECT_TRUE(selected().empty()) << "deselecting takes the same";
  choose("Selection", "Through");
  click(before);
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected().size(), mesh->faceCount()) << "all of it is connected";
  key(Qt::Key_Delete);

  // What is not in the picture is not seen either.
  lookAt({1.6, 0.2, 0.5}, {0.9, 0.1, 0.0});
  spinFrames();
  choose("Selection", "Visible Only");
  click({320, 240});
  ASSERT_TRUE(settle());
  const Faces near = selected();
  EXPECT_GT(near.size(), 20u);
  const Faces in_picture = inPicture(
      {{-1, -1}, {DEFAULT_WIDTH, -1}, {DEFAULT_WIDTH, DEFAULT_HEIGHT}, {-1, DEFAULT_HEIGHT}});
  EXPECT_LT(in_picture.size(), mesh->faceCount() * 3 / 4);
  EXPECT_TRUE(without(near, in_picture).empty());
}

TEST_F(SelectionToolTest, of_a_label_only_what_is_seen_is_taken)
{
  LabelServer server("/sight");
  auto* labels =
      createDisplayAs<rviz_mesh_plugin::ClusterLabelDisplay>("rviz_mesh_plugin/ClusterLabel");
  set(labels, {"Geometry Topic"}, geometry_topic.c_str());
  set(labels, {"Labels Topic"}, "/sight/new_cluster_label");
  showTerrain();
  lookAt({3.5, -2.5, 1.0}, {0.3, -0.2, 0.4});
  spinFrames();
  const auto mesh = shown().mesh;
  Faces all(mesh->faceCount());
  std::iota(all.begin(), all.end(), 0);
  server.labels.publish(LabelServer::cluster("ground_1", all));
  ASSERT_TRUE(spinUntil([&] { return labels->labels().size() == 1u; }));
  const Pixel at{320, 240};
  ASSERT_TRUE(picker.pick(mouse(at.x, at.y)).hit);
  const auto byBoxAndLabel = [&] {
    key(Qt::Key_1);
    drag({{0, 0}, {DEFAULT_WIDTH - 1, DEFAULT_HEIGHT - 1}});
    EXPECT_TRUE(settle());
    const Faces box = selected();
    key(Qt::Key_Delete);
    key(Qt::Key_4);
    click(at);
    EXPECT_TRUE(settle());
    const Faces label = selected();
    EXPECT_EQ(label, box);
    click(at, Qt::RightButton);
    EXPECT_TRUE(settle());
    EXPECT_TRUE(selected().empty());
    return label;
  };
  EXPECT_EQ(byBoxAndLabel(), all);
  choose("Back Faces", false);
  const Faces front = byBoxAndLabel();
  EXPECT_LT(front.size(), all.size());
  choose("Selection", "Visible Only");
  const Faces seen = byBoxAndLabel();
  EXPECT_LT(seen.size(), front.size());
  EXPECT_GT(seen.size(), 100u);
}

TEST_F(SelectionToolTest, click_flood_and_brush)
{
  showTerrain();
  const auto mesh = shown().mesh;
  for (int view = 0; view < 3; ++view) {
    takeView(view);
    const auto hit = picker.pick(mouse(318, 236)).hit;
    ASSERT_TRUE(hit);
    click({318, 236});
    EXPECT_EQ(selected(), Faces{hit->face});
    EXPECT_EQ(tool->mesh(), mesh);
    drag({{300, 235}, {302, 236}, {318, 236}}, Qt::RightButton);
    EXPECT_TRUE(selected().empty()) << "hardly a drag: one face, where it ends";

    choose("Brush Radius", 0.3f);
    press({318, 236}, Qt::LeftButton, Qt::ControlModifier);
    const Faces ball = touching(*mesh, mesh_map::SphereRegion(hit->point, 0.3f));
    EXPECT_EQ(selected(), ball);
    EXPECT_GT(ball.size(), 10u);
    release({318, 236}, Qt::ControlModifier);
    const auto other = picker.pick(mouse(330, 240)).hit;
    ASSERT_TRUE(other);
    choose("Brush Radius", 0.15f);
    drag({{330, 240}}, Qt::RightButton, Qt::ControlModifier);
    EXPECT_EQ(selected(),
              without(ball, touching(*mesh, mesh_map::SphereRegion(other->point, 0.15f))));
    key(Qt::Key_Delete);

    const auto neighbors = [&] { return SurfaceIndex::instance().findNeighbors(mesh).neighbors; };
    ASSERT_TRUE(spinUntil([&] { return neighbors() != nullptr; }));
    choose("Flood Angle", 12.0f);
    key(Qt::Key_3);
    click({318, 236});
    ASSERT_TRUE(settle());
    const Faces region = neighbors()->flood(*mesh, hit->face, 12.0 * M_PI / 180.0);
    EXPECT_EQ(selected(), region);
    EXPECT_GT(region.size(), 1u);
    EXPECT_LT(region.size(), mesh->faceCount());
    key(Qt::Key_Plus);
    const FaceBits bits(mesh->faceCount(), region);
    EXPECT_EQ(selected().size(), region.size() + neighbors()->grow(bits).size());
    key(Qt::Key_Z, Qt::ControlModifier);
    EXPECT_EQ(selected(), region);
    click({318, 236}, Qt::RightButton);
    ASSERT_TRUE(settle());
    EXPECT_TRUE(selected().empty());
    key(Qt::Key_1);
  }
}
