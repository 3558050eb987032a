#include "base/status_lines.h"

#include <algorithm>
#include <exception>

#include <rviz/display.h>

namespace rviz_mesh_plugin {

std::string shortened(std::string text, std::size_t most, char control)
{
  if (text.size() > most) {
    text = text.substr(0, most - 3) + "...";
  }
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, control);
  return text;
}

StatusLine noMapOpen()
{
  return StatusLine::warn("no map is open; the line 'Map' of the display above tells why");
}

void StatusLines::report(const std::string& name, const OptionalStatus& status)
{
  const auto shown = lines_.find(name);
  if (!status) {
    if (shown != lines_.end()) {
      lines_.erase(shown);
      display_->deleteStatusStd(name);
    }
    return;
  }
  if (shown != lines_.end() && shown->second.level == status->level &&
      shown->second.text == status->text) {
    return;
  }
  lines_[name] = *status;
  display_->setStatusStd(static_cast<rviz::StatusProperty::Level>(status->level), name,
                         status->text);
}

bool StatusLines::attempt(const std::function<void()>& work)
{
  try {
    work();
    return true;
  } catch (const std::exception& error) {  // Ogre::Exception, ros::Exception, std::bad_alloc
    report("Display", StatusLine::error("the display cannot do what it should: ", error.what()));
    return false;
  }
}

void StatusLines::repeat(const std::function<void()>& work)
{
  const bool done = attempt(work);
  if (done && repeat_failed_) {
    report("Display", std::nullopt);
  }
  repeat_failed_ = !done;
}

}  // namespace rviz_mesh_plugin
