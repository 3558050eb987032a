// What is in a map file, as Map3D and its own hdf5_map_server bring it to the screen.
#include <array>
#include <cstddef>
#include <functional>
#include <memory>

#include <QColor>

#include "coloring/cost_coloring.h"
#include "conversion/mesh_conversion.h"
#include "displays/cluster_label_display.h"
#include "labels/label_colors.h"
#include "support/map3d_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::isNear;
using osmesa_harness::Rgb;
using rviz_mesh_plugin::conversions;
using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::Rgba8;

namespace {

const Rgb NOTHING{48, 48, 48};
const Rgb GREEN{0, 255, 0};
const Rgb RED{255, 0, 0};
const Rgb MATERIAL{90, 30, 150};

Rgb toRgb(const Rgba8& color)
{
  return {color.red, color.green, color.blue};
}

Rgb redGreen(float cost, float greatest)
{
  return toRgb(scaleColor(rviz_mesh_plugin::ColorScale::RED_GREEN, cost / greatest));
}

Rgb classColor(const std::string& label_class)
{
  return toRgb(rviz_mesh_plugin::LabelColors().classColor(label_class));
}

}  // namespace

/// The map of write_test_map.py: four squares of 100 x 100 pixels, side by side.
class Map3DLayers : public Map3DFixture
{
 protected:
  using Squares = std::array<Rgb, 4>;

  void writeTestMap(const std::string& name, int squares = 4) const
  {
    const std::string command =
        "/usr/bin/python3 '" WRITE_TEST_MAP "' '" + path(name) + "' " + std::to_string(squares);
    ASSERT_EQ(std::system(command.c_str()), 0);
  }

  /// A display of a map, without lines over its faces and without the legend.
  Display* createPlainMap(const std::string& file)
  {
    Display* display = createMap(file);
    set(display, "Show Wireframe", false);
    set(display, "Show Normals", false);
    return display;
  }

  static void set(const Display* display, const char* name, const QVariant& value)
  {
    display->meshDisplay()->subProp(name)->setValue(value);
  }

  static void setChild(const Display* display, const char* name, const QVariant& value)
  {
    display->meshDisplay()->subProp("Display Type")->subProp(name)->setValue(value);
  }

  static void showOnly(const Display* display, bool mesh, bool labels)
  {
    display->meshDisplay()->setEnabled(mesh);
    display->labelDisplay()->setEnabled(labels);
  }

  static Image picture()
  {
    viewFromAbove(2.0, 0.5, 100.0);
    return grab();
  }

  /// Whether each pixel of a part of a picture has a color.
  static testing::AssertionResult isFilled(const Image& image, int left, int top, int width,
                                           int height, const Rgb& color)
  {
    for (int y = top; y < top + height; ++y) {
      for (int x = left; x < left + width; ++x) {
        if (!isNear(image.at(x, y), color, 1)) {
          return testing::AssertionFailure()
                 << "(" << x << ", " << y << ") is " << image.at(x, y) << " instead of " << color;
        }
      }
    }
    return testing::AssertionSuccess();
  }

  static testing::AssertionResult waitFor(
      const std::function<testing::AssertionResult(const Image&)>& check)
  {
    testing::AssertionResult result = testing::AssertionFailure();
    spinUntil(
        [&] {
          const testing::AssertionResult now = check(picture());
          const bool done = now;
          result = now;
          return done;
        },
        TIMEOUT);
    return result;
  }

  /// Waits until all pixels of the squares have these colors.
  static testing::AssertionResult shows(const Squares& colors)
  {
    return waitFor([&](const Image& image) {
      testing::AssertionResult result = testing::AssertionSuccess();
      for (int i = 0; i < 4 && result; ++i) {
        result = isFilled(image, 120 + 100 * i, 190, 100, 100, colors[i]);
      }
      return result;
    });
  }
};

TEST_F(Map3DLayers, are_seen_with_each_display_type)
{
  writeTestMap("a.h5");
  Display* display = createPlainMap(path("a.h5"));
  showOnly(display, true, false);
  ASSERT_TRUE(waitForFaces(display, 8));
  EXPECT_TRUE(shows({GREEN, GREEN, GREEN, GREEN}));

  set(display, "Display Type", "Vertex Color");
  EXPECT_TRUE(shows({Rgb{255, 0, 0}, Rgb{0, 0, 255}, Rgb{10, 200, 90}, Rgb{255, 255, 255}}));

  set(display, "Display Type", "Vertex Costs");
  setChild(display, "Legend", false);
  setChild(display, "Color Scale", "Red Green");
  setChild(display, "Vertex Costs Type", "height_diff");
  EXPECT_TRUE(shows({GREEN, redGreen(1, 3), redGreen(2, 3), RED}));
  setChild(display, "Vertex Costs Type", "roughness");
  // The file says that roughness is lethal above 1.5 m: there is no red of the scale's.
  const Rgb lethal{200, 0, 200};
  setChild(display, "Lethal Color", QColor(200, 0, 200));
  EXPECT_TRUE(
      waitForStatus(display->meshDisplay(), "Costs", "Ok", "8 lethal (lethal above 1.5 m)"));
  EXPECT_TRUE(shows({lethal, lethal, redGreen(1, 3), GREEN}));
  setChild(display, "Mark Lethal", false);
  EXPECT_TRUE(shows({RED, redGreen(2, 3), redGreen(1, 3), GREEN}));
  setChild(display, "Vertex Costs Type", "steepness");
  EXPECT_TRUE(shows({GREEN, RED, GREEN, RED}));

  set(display, "Display Type", "Textures");
  const auto textured = [](const Rgb& untextured) {
    return [untextured](const Image& image) {
      // The first picture upright, but for where its halves meet: it repeats.
      auto result = isFilled(image, 120, 192, 100, 46, {200, 100, 0});
      if (result) {
        result = isFilled(image, 120, 242, 100, 46, {0, 100, 200});
      }
      if (result) {
        result = isFilled(image, 220, 190, 100, 100, {60, 70, 80});
      }
      return result ? isFilled(image, 320, 190, 200, 100, untextured) : result;
    };
  };
  EXPECT_TRUE(waitFor(textured(MATERIAL)));
  setChild(display, "Show textured faces only", true);
  EXPECT_TRUE(waitFor(textured(NOTHING)));

  set(display, "Display Type", "Hide Faces");
  EXPECT_TRUE(shows({NOTHING, NOTHING, NOTHING, NOTHING}));
  set(display, "Display Type", "Fixed Color");
  setChild(display, "Faces Color", QColor(1, 2, 250));
  EXPECT_TRUE(shows({Rgb{1, 2, 250}, Rgb{1, 2, 250}, Rgb{1, 2, 250}, Rgb{1, 2, 250}}));
}

TEST_F(Map3DLayers, have_labels_that_are_edited_and_kept)
{
  writeTestMap("a.h5");
  Display* display = createPlainMap(path("a.h5"));
  showOnly(display, false, true);
  const Rgb tree = classColor("tree");
  const Rgb wall{10, 20, 30};
  EXPECT_TRUE(shows({tree, NOTHING, wall, NOTHING}));
  // Over the mesh, too.
  showOnly(display, true, true);
  EXPECT_TRUE(shows({tree, GREEN, wall, GREEN}));
  showOnly(display, false, true);

  // What tools do.
  std::string refusal;
  const auto edit = [&](const std::function<std::string()>& request) {
    return spinUntil([&] { return (refusal = request()).empty(); }, TIMEOUT);
  };
  ASSERT_TRUE(edit([&] {
    return display->labelDisplay()->storeFaces("tree_1", rviz_mesh_plugin::labelFaces({2, 3}),
                                               true);
  })) << refusal;
  EXPECT_TRUE(shows({NOTHING, tree, wall, NOTHING}));
  ASSERT_TRUE(edit([&] {
    return display->labelDisplay()->storeFaces("car_1", rviz_mesh_plugin::labelFaces({6, 7}), true);
  })) << refusal;
  EXPECT_TRUE(shows({NOTHING, tree, wall, classColor("car")}));
  const Rgba8 violet{200, 0, 100, 255};
  ASSERT_TRUE(edit([&] { return display->labelDisplay()->setLabelColor("tree_1", &violet); }))
      << refusal;
  EXPECT_TRUE(shows({NOTHING, toRgb(violet), wall, classColor("car")}));
  ASSERT_TRUE(edit([&] { return display->labelDisplay()->setLabelColor("wall_1", nullptr); }))
      << refusal;
  const Squares edited{NOTHING, toRgb(violet), classColor("wall"), classColor("car")};
  EXPECT_TRUE(shows(edited));

  choose(display, "");
  EXPECT_TRUE(shows({NOTHING, NOTHING, NOTHING, NOTHING}));
  EXPECT_TRUE(spinUntil([] { return children().empty(); }, TIMEOUT));
  choose(display, path("a.h5"));
  EXPECT_TRUE(shows(edited)) << "after the map has been loaded again";
  remove(display);
  EXPECT_TRUE(spinUntil([] { return children().empty(); }, TIMEOUT));
  display = createPlainMap(path("a.h5"));
  showOnly(display, false, true);
  EXPECT_TRUE(shows(edited)) << "in another display";

  // A label that is deleted is in the file no more, not even without faces.
  ASSERT_TRUE(edit([&] {
    return display->labelDisplay()->storeFaces("car_1", rviz_mesh_plugin::labelFaces({}), true);
  })) << refusal;
  EXPECT_TRUE(shows({NOTHING, toRgb(violet), classColor("wall"), NOTHING}));
  remove(display);
  EXPECT_TRUE(spinUntil([] { return children().empty(); }, TIMEOUT));
  const std::string look =
      "/usr/bin/python3 -c 'import sys; from mesh_msgs_hdf5.map_file import MapFile; "
      "names = MapFile(sys.argv[1]).label_names(); print(names); "
      "sys.exit(names != [\"tree_1\", \"wall_1\"])' '" +
      path("a.h5") + "'";
  EXPECT_EQ(std::system(look.c_str()), 0);
}

TEST_F(Map3DLayers, have_one_mesh_that_is_converted_once)
{
  const auto shown = [](const Display* display, std::size_t faces) {
    return spinUntil(
        [&] {
          const auto labelled = display->labelDisplay()->mesh();
          return labelled && labelled->faceCount() == faces &&
                 labelled == display->meshDisplay()->mesh();
        },
        TIMEOUT);
  };
  writeTestMap("a.h5");
  writeTestMap("b.h5", 5);
  const std::size_t before = conversions;
  Display* display = createPlainMap(path("a.h5"));
  ASSERT_TRUE(shown(display, 8));
  EXPECT_EQ(conversions - before, 1u);
  showOnly(display, false, false);
  spinFrames(2);
  showOnly(display, true, true);
  display->labelDisplay()->reset();
  EXPECT_TRUE(shown(display, 8));
  display->meshDisplay()->reset();
  EXPECT_TRUE(shown(display, 8));
  EXPECT_EQ(conversions - before, 1u) << "the other one has had it all the time";
  choose(display, path("b.h5"));
  ASSERT_TRUE(shown(display, 10));
  EXPECT_EQ(conversions - before, 2u) << "of another map";
  const std::weak_ptr<const MeshData> mesh = display->meshDisplay()->mesh();
  remove(display->labelDisplay());
  spinFrames(2);
  EXPECT_EQ(display->meshDisplay()->mesh(), mesh.lock());
  remove(display);
  EXPECT_TRUE(spinUntil([&] { return mesh.expired(); }, TIMEOUT)) << "something keeps it alive";
}

TEST_F(Map3DLayers, leave_nothing_when_the_map_is_loaded_again_and_again)
{
  writeTestMap("short.h5");
  writeTestMap("long.h5", 5);
  const auto put = [&](const char* name) {
    // A file of its own each time, in one step.
    const std::string command = "cp '" + path(name) + "' '" + path("new.h5") + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    ASSERT_EQ(std::rename(path("new.h5").c_str(), path("a.h5").c_str()), 0);
  };
  put("short.h5");
  Display* display = createPlainMap(path("a.h5"));
  set(display, "Display Type", "Textures");
  const Rgb tree = classColor("tree");
  const Squares seen{tree, {60, 70, 80}, {10, 20, 30}, MATERIAL};
  ASSERT_TRUE(shows(seen));
  const pid_t server = serverOf(display);
  osmesa_harness::SceneCounts before;
  for (int i = 0; i < 20; ++i) {
    if (i == 2) {
      spinFrames(5);
      before = counts();  // what is made once for all is there
    }
    put(i % 2 == 0 ? "long.h5" : "short.h5");
    ASSERT_TRUE(waitForFaces(display, i % 2 == 0 ? 10 : 8));
    ASSERT_TRUE(shows(seen)) << status(display->labelDisplay(), "Labels");
    ASSERT_EQ(serverOf(display), server) << i;
    ASSERT_EQ(display->session().server()->ending(), "") << i;
  }
  EXPECT_TRUE(spinUntil([&] { return counts() == before; }, TIMEOUT))
      << counts() << "\ninstead of\n"
      << before;
  EXPECT_EQ(serverOf(display), server);
}
