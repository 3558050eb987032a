#include "ros_client/checked_callback.h"

#include <iterator>

#include "base/erase_if.h"

namespace rviz_mesh_plugin {

std::shared_ptr<TopicReaders> TopicReaders::instance()
{
  static const auto readers = std::make_shared<TopicReaders>();
  return readers;
}

void TopicReaders::add(const std::string& topic, const std::shared_ptr<const Refuse>& refuse)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  for (auto item = by_topic_.begin(); item != by_topic_.end();) {
    auto& readers = item->second;
    eraseIf(readers, [](const auto& reader) { return reader.expired(); });
    item = readers.empty() ? by_topic_.erase(item) : std::next(item);
  }
  by_topic_[topic].push_back(refuse);
}

void TopicReaders::refuse(const std::string& topic, const std::string& reason)
{
  std::vector<std::shared_ptr<const Refuse>> told;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto readers = by_topic_.find(topic);
    if (readers != by_topic_.end()) {
      for (const auto& reader : readers->second) {
        told.push_back(reader.lock());
      }
    }
  }
  for (const auto& reader : told) {
    if (reader) {
      (*reader)(reason);
    }
  }
}

}  // namespace rviz_mesh_plugin
