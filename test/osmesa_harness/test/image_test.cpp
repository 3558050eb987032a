#include <osmesa_harness/image.h>
#include <osmesa_harness/image_compare.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include <QFile>
#include <QString>
#include <QTemporaryDir>

using osmesa_harness::difference;
using osmesa_harness::differenceImage;
using osmesa_harness::Image;
using osmesa_harness::imageMatchesFile;
using osmesa_harness::imagesMatch;
using osmesa_harness::Rgb;
using osmesa_harness::sameOnAllBackEnds;

namespace {

const Rgb WHITE{255, 255, 255};
const Rgb RED{255, 0, 0};

// Every pixel another color.
Image gradient(int width, int height)
{
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.set(x, y, Rgb{static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 77});
    }
  }
  return image;
}

class Pictures : public testing::Test
{
 protected:
  void SetUp() override
  {
    ASSERT_TRUE(folder_.isValid());
    setenv("OSMESA_HARNESS_OUT", path("out").c_str(), 1);
    unsetenv("OSMESA_HARNESS_REFERENCE");
  }

  std::string path(const std::string& name) const
  {
    return (folder_.path() + "/" + QString::fromStdString(name)).toStdString();
  }

  bool exists(const std::string& name) const
  {
    return QFile::exists(QString::fromStdString(path(name)));
  }

 private:
  QTemporaryDir folder_;
};

TEST(Image, holds_what_was_set)
{
  Image image(3, 2, RED);
  EXPECT_EQ(image.count(RED), 6u);
  image.set(2, 1, WHITE);
  EXPECT_EQ(image.at(2, 1), WHITE);
  EXPECT_EQ(image.at(1, 1), RED);
  EXPECT_EQ(image.count(RED), 5u);
  EXPECT_EQ(image.count(Rgb{250, 3, 0}, 5), 5u);
  EXPECT_EQ(image.count(Rgb{250, 3, 0}, 4), 0u);
  EXPECT_EQ(image.data()[3 * 5 + 1], 255);
}

TEST(Image, refuses_pixels_outside)
{
  const Image image(3, 2);
  for (const auto& at :
       {std::make_pair(3, 0), std::make_pair(0, 2), std::make_pair(-1, 0), std::make_pair(0, -1)}) {
    EXPECT_THROW(image.at(at.first, at.second), std::out_of_range);
  }
  EXPECT_THROW(Image(-1, 2), std::invalid_argument);
  EXPECT_THROW(Image().center(), std::out_of_range);
}

TEST_F(Pictures, survive_a_file_bit_for_bit)
{
  // An odd width: QImage pads its rows to four bytes.
  const Image image = gradient(5, 3);
  image.save(path("below/picture.png"));
  EXPECT_EQ(Image::load(path("below/picture.png")), image);
}

TEST_F(Pictures, that_cannot_be_read_are_named)
{
  std::ofstream(path("text.png")) << "not a picture";
  for (const std::string name : {"text.png", "missing.png"}) {
    try {
      Image::load(path(name));
      FAIL() << "no exception for " << name;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(path(name)), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(Image(2, 2).save("/proc/nothing/picture.png"), std::runtime_error);
}

TEST(Difference, is_measured)
{
  const Image a(4, 5, Rgb{10, 20, 30});
  Image b = a;
  EXPECT_EQ(difference(a, b).differing_pixels, 0u);
  EXPECT_EQ(difference(a, b).mean_squared_error, 0.0);
  EXPECT_EQ(difference(a, b).first_x, -1);
  b.set(2, 1, Rgb{10, 20, 81});
  b.set(0, 3, Rgb{10, 122, 30});
  const auto found = difference(a, b);
  EXPECT_EQ(found.differing_pixels, 2u);
  EXPECT_EQ(found.first_x, 2);
  EXPECT_EQ(found.first_y, 1);
  EXPECT_EQ(found.largest, 102);
  // 51 / 255 = 0.2 and 102 / 255 = 0.4, over 20 pixels of 3 channels.
  EXPECT_DOUBLE_EQ(found.mean_squared_error, (0.2 * 0.2 + 0.4 * 0.4) / 60.0);
  EXPECT_THROW(difference(a, Image(5, 4)), std::invalid_argument);
}

TEST(Difference, of_black_and_white_is_one)
{
  EXPECT_DOUBLE_EQ(difference(Image(3, 3), Image(3, 3, WHITE)).mean_squared_error, 1.0);
}

TEST(Difference, is_drawn)
{
  const Image a = gradient(4, 4);
  Image b = a;
  b.set(3, 2, Rgb{3, 2, 78});
  const Image drawn = differenceImage(a, b);
  EXPECT_EQ(drawn.at(3, 2), RED);
  EXPECT_EQ(drawn.count(WHITE), 15u);
  // Two columns and one row that only one of them has.
  const Image larger = differenceImage(a, gradient(6, 3));
  EXPECT_EQ(larger.width(), 6);
  EXPECT_EQ(larger.height(), 4);
  EXPECT_EQ(larger.count(WHITE), 12u);
  EXPECT_EQ(larger.count(Rgb{0, 0, 255}), 12u);
}

TEST_F(Pictures, that_match_leave_no_files)
{
  const Image a = gradient(8, 8);
  Image b = a;
  EXPECT_TRUE(imagesMatch("same", a, b));
  b.set(0, 0, Rgb{51, 0, 77});
  const double error = 0.2 * 0.2 / (3 * 64);
  EXPECT_TRUE(imagesMatch("same", a, b, error * 1.01));
  EXPECT_FALSE(exists("out"));
  EXPECT_FALSE(imagesMatch("same", a, b, error * 0.99));
}

TEST_F(Pictures, that_do_not_match_are_shown_with_their_difference)
{
  const Image expected = gradient(8, 8);
  Image actual = expected;
  actual.set(6, 4, WHITE);
  const auto result = imagesMatch("broken", actual, expected);
  EXPECT_FALSE(result);
  EXPECT_EQ(Image::load(path("out/broken_actual.png")), actual);
  EXPECT_EQ(Image::load(path("out/broken_expected.png")), expected);
  EXPECT_EQ(Image::load(path("out/broken_diff.png")), differenceImage(actual, expected));
  const std::string message = result.message();
  for (const std::string part : {"'broken'", "1 pixels", "(6, 4)", "rgb(255, 255, 255)",
                                 "rgb(6, 4, 77)", "broken_diff.png"}) {
    EXPECT_NE(message.find(part), std::string::npos) << part << " is not in: " << message;
  }
}

TEST_F(Pictures, of_other_sizes_never_match)
{
  const auto result = imagesMatch("size", Image(4, 3), Image(3, 4), 1.0);
  EXPECT_FALSE(result);
  EXPECT_NE(std::string(result.message()).find("is 4 x 3, expected 3 x 4"), std::string::npos);
  EXPECT_TRUE(exists("out/size_diff.png"));
}

TEST_F(Pictures, that_cannot_be_written_still_fail_with_both_reasons)
{
  setenv("OSMESA_HARNESS_OUT", "/proc/nothing", 1);
  const auto result = imagesMatch("broken", Image(2, 2), Image(2, 2, WHITE));
  EXPECT_FALSE(result);
  EXPECT_NE(std::string(result.message()).find("differs in 4 pixels"), std::string::npos);
  EXPECT_NE(std::string(result.message()).find("cannot be written"), std::string::npos);
}

TEST_F(Pictures, are_compared_with_files)
{
  const Image image = gradient(8, 8);
  image.save(path("golden.png"));
  EXPECT_TRUE(imageMatchesFile("golden", image, path("golden.png")));
  EXPECT_FALSE(imageMatchesFile("golden", Image(8, 8), path("golden.png")));
  const auto result = imageMatchesFile("new", image, path("none.png"));
  EXPECT_FALSE(result);
  EXPECT_NE(std::string(result.message()).find(path("none.png")), std::string::npos);
  EXPECT_EQ(Image::load(path("out/new_actual.png")), image);
}

TEST_F(Pictures, are_compared_with_those_of_another_back_end)
{
  const Image image = gradient(8, 8);
  EXPECT_TRUE(sameOnAllBackEnds("scene", image));
  EXPECT_EQ(Image::load(path("out/scene.png")), image);

  setenv("OSMESA_HARNESS_REFERENCE", path("out").c_str(), 1);
  setenv("OSMESA_HARNESS_OUT", path("second").c_str(), 1);
  EXPECT_TRUE(sameOnAllBackEnds("scene", image));
  EXPECT_TRUE(exists("second/scene.png"));
  Image other = image;
  other.set(1, 1, WHITE);
  EXPECT_FALSE(sameOnAllBackEnds("scene", other));
  EXPECT_TRUE(exists("second/scene_diff.png"));
  EXPECT_FALSE(sameOnAllBackEnds("unknown", image));
}

}  // namespace

int main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
