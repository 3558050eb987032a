#pragma once

#include <string>

#include <gtest/gtest.h>
#include <osmesa_harness/render_fixture.h>
#include <rviz/display.h>
#include <rviz/properties/status_list.h>
#include <rviz/properties/status_property.h>

/// Reads the status tree of displays.
class StatusFixture : public osmesa_harness::RenderFixture
{
 protected:
  static constexpr int TIMEOUT = 60000;  // milliseconds; only reached when something is broken

  /// "Ok: text" of one line; empty where there is none.
  static std::string status(rviz::Display* display, const std::string& name)
  {
    std::string found;
    forEachLine(display, [&](rviz::StatusProperty& line) {
      if (line.getNameStd() == name) {
        found = textOf(line);
      }
    });
    return found;
  }

  /// Waits until a line starts with "Ok", "Warn" or "Error" and contains a text.
  static testing::AssertionResult waitForStatus(rviz::Display* display, const std::string& name,
                                                const std::string& level, const std::string& text)
  {
    const auto matches = [&] {
      const std::string line = status(display, name);
      return line.rfind(level + ":", 0) == 0 && line.find(text) != std::string::npos;
    };
    if (spinUntil(matches, TIMEOUT)) {
      return testing::AssertionSuccess();
    }
    testing::AssertionResult failure = testing::AssertionFailure();
    failure << "waited for '" << level << ": …" << text << "' of " << name << "; there are";
    forEachLine(display, [&](rviz::StatusProperty& line) {
      failure << "\n" << line.getNameStd() << ": " << textOf(line);
    });
    return failure;
  }

 private:
  static std::string textOf(rviz::StatusProperty& line)
  {
    return (rviz::StatusProperty::statusWord(line.getLevel()) + ": " + line.getValue().toString())
        .toStdString();
  }

  template <class Read>
  static void forEachLine(rviz::Display* display, const Read& read)
  {
    for (int i = 0; i < display->numChildren(); ++i) {
      auto* list = dynamic_cast<rviz::StatusList*>(display->childAt(i));
      for (int j = 0; list && j < list->numChildren(); ++j) {
        if (auto* line = dynamic_cast<rviz::StatusProperty*>(list->childAt(j))) {
          read(*line);
        }
      }
    }
  }
};
