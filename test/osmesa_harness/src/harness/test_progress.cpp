#include "osmesa_harness/test_progress.h"

#include <cstdlib>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace osmesa_harness {
namespace {

/// As the value of an attribute. Control characters, which XML does not have, become spaces.
std::string quoted(const std::string& text)
{
  std::string result = "\"";
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\n':
        result += "&#10;";
        break;
      default:
        result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return result + '"';
}

std::string nameOf(const testing::TestInfo& test)
{
  return " classname=" + quoted(test.test_suite_name()) + " name=" + quoted(test.name());
}

class Progress : public testing::EmptyTestEventListener
{
 public:
  explicit Progress(const char* path) : file_(path) {}

 private:
  void OnTestStart(const testing::TestInfo& test) override
  {
    file_ << "<begun" + nameOf(test) + "/>\n" << std::flush;
  }

  void OnTestEnd(const testing::TestInfo& test) override
  {
    const testing::TestResult& result = *test.result();
    std::string parts = result.Skipped() ? "<skipped/>" : "";
    for (int i = 0; i < result.total_part_count(); ++i) {
      const testing::TestPartResult& part = result.GetTestPartResult(i);
      if (part.failed()) {
        parts += "<failure message=" + quoted(part.message()) + "/>";
      }
    }
    const double seconds = static_cast<double>(result.elapsed_time()) / 1000.0;
    file_ << "<testcase" + nameOf(test) + " time=\"" + std::to_string(seconds) + "\">" + parts +
                 "</testcase>\n"
          << std::flush;
  }

  std::ofstream file_;
};

}  // namespace

void tellProgress()
{
  const char* path = std::getenv("OSMESA_HARNESS_PROGRESS");
  if (path && *path) {
    testing::UnitTest::GetInstance()->listeners().Append(new Progress(path));
  }
}

}  // namespace osmesa_harness
