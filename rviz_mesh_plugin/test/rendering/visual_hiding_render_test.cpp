// Faces of a mesh that is drawn are hidden at once, before there is a layout without them.
#include <array>
#include <atomic>
#include <functional>

#include "level_of_detail/mesh_layout.h"
#include "visual_fixture.h"

using namespace rviz_mesh_plugin;

namespace {

constexpr std::uint32_t CELLS = 256;

}  // namespace

class VisualHiding : public VisualFixture
{
 protected:
  static HiddenFacesConstPtr hide(const MeshData& mesh,
                                  const std::function<bool(std::uint32_t)>& is)
  {
    FaceBits bits(mesh.faceCount());
    for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
      if (is(face)) {
        bits.add(FaceBits::Faces{face});
      }
    }
    return std::make_shared<const HiddenFaces>(bits);
  }

  static MeshLayoutConstPtr layOutNow(const MeshDataConstPtr& mesh,
                                      const HiddenFacesConstPtr& hidden = nullptr)
  {
    const std::atomic<bool> canceled{false};
    return layOut(mesh, Split::NONE, nullptr, canceled, hidden);
  }

  /// Of the picture of [-1, 1]², in the left and in the right half.
  std::array<int, 2> pixels(double pixels_per_meter = 100.0)
  {
    const Image image = picture(pixels_per_meter);
    std::array<int, 2> found{};
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const Rgb at = image.at(x, y);
        const bool is_mesh = std::abs(at.red - BACKGROUND.red) > 20;
        found[x < image.width() / 2 ? 0 : 1] += is_mesh ? 1 : 0;
      }
    }
    return found;
  }

  /// But for one or two at the edges.
  void expectPixels(int left, int right, const char* what = "")
  {
    const std::array<int, 2> found = pixels();
    EXPECT_NEAR(found[0], left, left == 0 ? 0 : 10) << what;
    EXPECT_NEAR(found[1], right, right == 0 ? 0 : 10) << what;
  }

  const MeshDataConstPtr mesh = test_layouts::grid(CELLS, test_layouts::flat);
  /// Columns in the right half: two faces each.
  const HiddenFacesConstPtr right =
      hide(*mesh, [](std::uint32_t face) { return face / 2 % CELLS >= CELLS / 2; });
};

TEST_F(VisualHiding, they_go_and_come_back_without_another_layout)
{
  style.level_of_detail = false;
  visual->setStyle(style);
  const auto layout = layOutNow(mesh);
  ASSERT_GT(layout->parts.size(), 8u);
  visual->setLayout(layout);
  uploadAll();
  const LayoutOutlineConstPtr drawn = visual->layout();
  expectPixels(20000, 20000);
  const std::size_t bytes = visual->gpuBytes(), uploads = visual->geometryUploads();
  EXPECT_FALSE(visual->hides(right));
  visual->hide(right);
  uploadAll();
  EXPECT_TRUE(visual->hides(right));
  expectPixels(20000, 0);
  EXPECT_EQ(visual->facesDrawn(), mesh->faceCount() / 2) << "in full";
  const HiddenFacesConstPtr all = hide(*mesh, [](std::uint32_t) { return true; });
  visual->hide(all);
  uploadAll();
  expectPixels(0, 0);
  EXPECT_EQ(visual->gpuBytes(), bytes) << "nothing is left of what was hidden before";
  visual->hide(right);
  uploadAll();
  expectPixels(20000, 0, "some are shown again");
  visual->hide(nullptr);
  uploadAll();
  expectPixels(20000, 20000);
  visual->hide(right);
  visual->hide(nullptr);  // what is still looked for is not wanted any more
  uploadAll();
  expectPixels(20000, 20000);
  EXPECT_EQ(visual->gpuBytes(), bytes);
  EXPECT_EQ(visual->layout(), drawn);
  EXPECT_EQ(visual->geometryUploads(), uploads);
}

TEST_F(VisualHiding, nothing_of_them_is_seen_from_afar)
{
  style.level_of_detail = true;
  style.detail_pixels = 8.0f;
  visual->setStyle(style);
  visual->setLayout(layOutNow(mesh));
  uploadAll();
  const std::array<int, 2> before = pixels(40.0);
  const std::size_t few = visual->facesDrawn();
  ASSERT_LT(few, mesh->faceCount()) << "it is drawn in less detail";
  visual->hide(right);
  uploadAll();
  EXPECT_EQ(pixels(40.0), (std::array<int, 2>{before[0], 0}));
}

TEST_F(VisualHiding, the_layout_without_them_takes_over)
{
  visual->setLayout(layOutNow(mesh));
  uploadAll();
  visual->hide(right);
  uploadAll();
  const auto without = layOutNow(mesh, right);
  visual->setLayout(without);
  uploadAll();
  EXPECT_EQ(visual->layout()->hidden, right);
  EXPECT_TRUE(visual->hides(right));
  expectPixels(20000, 0);
  // What is hidden besides goes at once, too.
  const HiddenFacesConstPtr all = hide(*mesh, [](std::uint32_t) { return true; });
  visual->hide(all);
  uploadAll();
  expectPixels(0, 0);
  // With nothing left to draw, there is nothing to wait for either.
  visual->setLayout(layOutNow(mesh, all));
  uploadAll();
  visual->hide(right);
  EXPECT_TRUE(visual->upload()) << "until there is another layout";
}

TEST_F(VisualHiding, a_layout_that_is_older_than_what_is_hidden_is_drawn_without_it)
{
  visual->setLayout(layOutNow(mesh));
  uploadAll();
  visual->hide(right);
  visual->setLayout(layOutNow(mesh));  // asked for before
  uploadAll();
  expectPixels(20000, 0);
}

TEST_F(VisualHiding, another_mesh_has_none)
{
  visual->setLayout(layOutNow(mesh));
  uploadAll();
  visual->hide(right);
  uploadAll();
  visual->setLayout(layOutNow(test_layouts::grid(CELLS, test_layouts::flat)));
  uploadAll();
  expectPixels(20000, 20000);
}

TEST_F(VisualHiding, it_may_end_while_they_are_looked_for)
{
  for (int i = 0; i < 20; ++i) {
    visual->setLayout(layOutNow(mesh));
    uploadAll();
    visual->hide(i % 2 == 0 ? right : hide(*mesh, [i](std::uint32_t face) {
      return face % 20 == std::uint32_t(i);
    }));
    makeVisual();
  }
}
