#include "rviz_mesh_plugin/mesh_inbox.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "rviz_mesh_plugin/mesh_conversion.h"

namespace rviz_mesh_plugin {
namespace {

/// Puts @a item behind the others, in place of the one that it supersedes.
template <class Pointer, class IsSame>
void replaceOrAppend(std::vector<Pointer>& items, Pointer item, const IsSame& is_same)
{
  items.erase(std::remove_if(items.begin(), items.end(), is_same), items.end());
  items.push_back(std::move(item));
}

}  // namespace

template <class Message, class Store>
void MeshInbox::receive(const Message& message, Reception InboxContent::*reception,
                        const Store& store)
{
  std::string refusal;
  decltype(convert(message)) converted;
  try {
    converted = convert(message);
  } catch (const RejectedMessage& rejected) {
    refusal = rejected.what();
  } catch (const std::exception& error) {  // out of memory
    refusal = std::string("the message could not be converted: ") + error.what();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  Reception& log = content_.*reception;
  log.refusal = refusal;
  if (converted) {
    ++log.accepted;
    store(std::move(converted));
  } else {
    ++log.refused;
  }
}

void MeshInbox::receive(const mesh_msgs::MeshGeometryStamped& message)
{
  receive(message, &InboxContent::geometry_reception,
          [this](MeshDataConstPtr mesh) { content_.geometry = std::move(mesh); });
}

void MeshInbox::receive(const mesh_msgs::MeshVertexCostsStamped& message)
{
  receive(message, &InboxContent::costs_reception, [this](const CostLayerConstPtr& layer) {
    replaceOrAppend(content_.costs, layer, [&](const CostLayerConstPtr& other) {
      return other->uuid == layer->uuid && other->type == layer->type;
    });
  });
}

void MeshInbox::receive(const mesh_msgs::MeshVertexColorsStamped& message)
{
  receive(message, &InboxContent::colors_reception, [this](const ColorLayerConstPtr& layer) {
    replaceOrAppend(content_.colors, layer,
                    [&](const ColorLayerConstPtr& other) { return other->uuid == layer->uuid; });
  });
}

InboxContent MeshInbox::take()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  InboxContent taken = std::move(content_);
  content_ = InboxContent();
  content_.geometry_reception = taken.geometry_reception;
  content_.costs_reception = taken.costs_reception;
  content_.colors_reception = taken.colors_reception;
  return taken;
}

void MeshInbox::clearGeometry()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  content_.geometry.reset();
  content_.geometry_reception = Reception();
}

void MeshInbox::clearCosts()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  content_.costs.clear();
  content_.costs_reception = Reception();
}

void MeshInbox::clearColors()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  content_.colors.clear();
  content_.colors_reception = Reception();
}

}  // namespace rviz_mesh_plugin
