#include "ros_client/map_service_client.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <mesh_msgs/GetGeometry.h>
#include <mesh_msgs/GetLabeledClusters.h>
#include <mesh_msgs/GetMaterials.h>
#include <mesh_msgs/GetTexture.h>
#include <mesh_msgs/GetUUID.h>
#include <mesh_msgs/GetUUIDs.h>
#include <mesh_msgs/GetVertexColors.h>
#include <mesh_msgs/GetVertexCostLayers.h>
#include <mesh_msgs/GetVertexCosts.h>
#include <ros/exceptions.h>
#include <ros/names.h>
#include <boost/make_shared.hpp>

#include "base/status_lines.h"

namespace rviz_mesh_plugin {
namespace {

using Clock = std::chrono::steady_clock;
using State = ServiceReport::State;
using Names = std::vector<std::string>;

// What has no property of its own.
const char* const GEOMETRY = "get_geometry";
const char* const LAYERS = "get_vertex_cost_layers";
const char* const COSTS = "get_vertex_costs";
const char* const LABELS = "get_labeled_clusters";

std::string join(const Names& names)
{
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  return text;
}

/// The textures that the materials refer to.
std::set<std::uint32_t> texturesOf(const mesh_msgs::MeshMaterials& materials)
{
  std::set<std::uint32_t> indices;
  if (!materials.vertex_tex_coords.empty()) {
    for (const auto& material : materials.materials) {
      if (material.has_texture && material.texture_index != NONE) {
        indices.insert(material.texture_index);
      }
    }
  }
  return indices;
}

}  // namespace

/// What one service is asked, which may not be there yet: the log says how that goes. Whatever
/// waits throws Canceled.
class MapServiceClient::Question
{
 public:
  /// @param names, log, cancellation outlive this
  Question(std::string service, const ServiceNames& names, ServiceLog& log,
           const Cancellation& cancellation)
      : service_(std::move(service)), names_(names), log_(log), cancellation_(cancellation)
  {
  }

  /// Asks about a mesh, and waits. Nothing where there is no response; then the log says why.
  template <class Service>
  std::optional<typename Service::Response> get(
      const std::string& uuid, typename Service::Request request = typename Service::Request())
  {
    Names names;
    try {
      names = serviceCandidates(service_, names_);
    } catch (const ros::InvalidNameException& error) {
      name_ = "'" + service_ + "'";
      fail(std::string("is no name of a service: ") + error.what());
      return std::nullopt;
    }
    request.uuid = uuid;
    const auto bytes = ros::serialization::serializeMessage(request);
    while (!tryOnce(names, {ServiceCall::typeOf<Service>()}, bytes)) {
      pause();
    }
    return read<typename Service::Response>();
  }

  /// Tries each of the names once; says in the log how that goes, but for the end.
  /// @return whether one of them has answered, or refused
  bool tryOnce(const Names& names, const std::vector<ServiceCall::Type>& types,
               const ros::SerializedMessage& request);

  /// A second.
  void pause() const { cancellation_.wait(-1, 0, 1000); }

  const std::string& name() const { return name_; }
  const ServiceCall::Answer& answer() const { return answer_; }

  /// Nothing where there is no response; then the log says why.
  template <class Response>
  std::optional<Response> read()
  {
    if (!answer_.refusal.empty()) {
      fail("refuses: " + answer_.refusal);
      return std::nullopt;
    }
    try {
      return answer_.read<Response>();
    } catch (const std::exception& error) {
      fail(std::string("gives an answer that cannot be read: ") + error.what());
    }
    return std::nullopt;
  }

  /// Whether an answer is about the mesh that was asked for.
  /// @param given by the answer; where it names none, the one asked for
  bool belongs(const std::string& asked, std::string& given)
  {
    if (given.empty()) {
      given = asked;
    }
    // "" and "mesh" mean the only one.
    return asked.empty() || asked == "mesh" || given == asked ||
           fail("answers for the mesh '" + given + "', but '" + asked +
                "' is shown; it serves another map");
  }

  /// @param reason why it is waited for
  void search(const std::string& reason) { wait(State::SEARCHING, service_, reason); }

  /// All went well. @param remark more about the answer, to be told
  void end(const std::string& remark = std::string())
  {
    log_.note(service_, [&](ServiceLog::Entry& entry) {
      entry.name = name_;
      entry.remark = shortened(remark);
      entry.busy = false;
      ++entry.answered;
    });
  }

  /// @return false
  bool fail(const std::string& reason)
  {
    log_.fail(service_, name_, reason);
    return false;
  }

  /// What became of an answer. @return @a accepted
  bool judge(bool accepted, const std::string& remark = std::string())
  {
    if (!accepted) {
      return fail("answers with what cannot be shown, as the line on it says");
    }
    end(remark);
    return true;
  }

 private:
  void wait(State state, const std::string& name, const std::string& reason)
  {
    log_.note(service_, [&](ServiceLog::Entry& entry) {
      entry.name = name;
      entry.state = state;
      entry.busy = true;
      entry.reason = shortened(reason);
    });
  }

  const std::string service_;
  const ServiceNames& names_;
  ServiceLog& log_;
  const Cancellation& cancellation_;
  std::string name_;  ///< of the service that answered or refused
  ServiceCall::Answer answer_;
};

bool MapServiceClient::Question::tryOnce(const Names& names,
                                         const std::vector<ServiceCall::Type>& types,
                                         const ros::SerializedMessage& request)
{
  std::string lost, objector, objection;
  bool refused = false;
  const auto refuse = [&](const std::string& name, const std::string& reason) {
    if (!refused) {
      refused = true;
      name_ = name;
      answer_ = ServiceCall::Answer();
      answer_.refusal = reason;
    }
  };
  for (const std::string& name : names) {
    const auto progress = [&](std::size_t bytes, std::size_t of) {
      log_.note(service_, [&](ServiceLog::Entry& entry) {
        entry.bytes = bytes;
        entry.of = of;
        if (of == 0) {
          entry.name = name;
          entry.state = State::WAITING;
          entry.busy = true;
          entry.since = Clock::now();
        }
      });
    };
    try {
      auto answer = ServiceCall(cancellation_).call(name, types, request, progress);
      if (answer && answer->refusal.empty()) {
        name_ = name;
        answer_ = std::move(*answer);
        return true;
      }
      if (answer) {
        refuse(name, answer->refusal);
      }
    } catch (const Canceled&) {
      throw;
    } catch (const ConnectionLost& error) {
      lost = name + " does not answer: " + error.what();
    } catch (const WrongService& error) {
      objector = name;
      objection = error.what();
    } catch (const std::exception& error) {  // out of memory, or of files
      refuse(name, std::string("its answer cannot be read: ") + error.what());
    }
  }
  if (!refused && !objection.empty()) {
    wait(State::FAILED, objector, objection);
  } else if (!refused) {
    search(!lost.empty()   ? lost
           : names.empty() ? "the topic of the geometry has no valid name, beside which it would be"
                           : "there is no " + join(names));
  }
  return refused;
}

/// All that is asked between two calls of cancel(). Its threads share it, and may outlive
/// everything else: it owns what it uses.
struct MapServiceClient::Work
{
  const std::shared_ptr<AttributeQueue> queue;
  const std::shared_ptr<MeshLoader> loader;
  const ServiceNames names;
  ServiceLog log;
  std::mutex mutex;  ///< of those below
  std::map<std::string, std::vector<std::string>> layers;
  std::map<std::string, std::set<std::uint32_t>> missing_textures;
};

/// Something that is asked about a mesh, and handed over. What does that returns whether it was all
/// there is: if not, a service refuses, or has nothing (yet), and may be asked again.
class MapServiceClient::Errand
{
 public:
  /// @param again it was asked before
  Errand(Work& work, const Cancellation& cancellation, std::string uuid, std::string item,
         bool again)
      : work_(work),
        cancellation_(cancellation),
        uuid_(std::move(uuid)),
        item_(std::move(item)),
        again_(again)
  {
  }

  bool mesh()
  {
    Question question = ask(GEOMETRY);
    auto response =
        uuid_.empty() ? findMesh(question) : question.get<mesh_msgs::GetGeometry>(uuid_);
    if (!response || !question.belongs(uuid_, response->mesh_geometry_stamped.uuid) ||
        !work_.loader) {
      return false;
    }
    const auto mesh = boost::make_shared<mesh_msgs::MeshGeometryStamped>(
        std::move(response->mesh_geometry_stamped));
    work_.loader->receive(mesh, {&cancellation_.flag(), question.name()});
    question.end();
    return true;
  }

  bool colors()
  {
    Question question = ask(work_.names.colors);
    auto response = question.get<mesh_msgs::GetVertexColors>(uuid_);
    if (!response) {
      return false;
    }
    auto& colors = response->mesh_vertex_colors_stamped;
    // Servers answer so, with or without the uuid, for a mesh that has none.
    if (colors.mesh_vertex_colors.vertex_colors.empty()) {
      question.end("the mesh has no vertex colors");
      return false;
    }
    return question.belongs(uuid_, colors.uuid) && handOver(question, colors);
  }

  /// And textures; later only those of them that were refused.
  bool materials()
  {
    std::set<std::uint32_t> textures;
    {
      const std::lock_guard<std::mutex> lock(work_.mutex);
      const auto missing = work_.missing_textures.find(uuid_);
      if (missing != work_.missing_textures.end()) {
        textures = missing->second;
      }
    }
    if (!textures.empty()) {
      return this->textures(textures, true);
    }
    Question question = ask(work_.names.materials);
    auto response = question.get<mesh_msgs::GetMaterials>(uuid_);
    if (!response) {
      return false;
    }
    auto& materials = response->mesh_materials_stamped;
    if (materials.mesh_materials.materials.empty()) {
      question.end("the mesh has no materials");
      return false;
    }
    if (!question.belongs(uuid_, materials.uuid) || !handOver(question, materials)) {
      return false;
    }
    textures = texturesOf(materials.mesh_materials);
    response.reset();  // it may be large
    return work_.names.texture.empty() || this->textures(textures, false);
  }

  /// Never all: further layers may be computed.
  bool layerNames()
  {
    Question question = ask(LAYERS);
    if (auto response = question.get<mesh_msgs::GetVertexCostLayers>(uuid_)) {
      question.end(std::to_string(response->layers.size()) + " cost layers");
      const std::lock_guard<std::mutex> lock(work_.mutex);
      work_.layers[uuid_] = std::move(response->layers);
    }
    return false;
  }

  bool layer()
  {
    Question question = ask(COSTS, "layers");
    mesh_msgs::GetVertexCosts::Request request;
    request.layer = item_;
    auto response = question.get<mesh_msgs::GetVertexCosts>(uuid_, request);
    if (!response || !question.belongs(uuid_, response->mesh_vertex_costs_stamped.uuid)) {
      return false;
    }
    auto& costs = response->mesh_vertex_costs_stamped;
    costs.type = costs.type.empty() ? item_ : costs.type;
    return handOver(question, costs);
  }

  bool labels()
  {
    Question question = ask(LABELS);
    const auto response = question.get<mesh_msgs::GetLabeledClusters>(uuid_);
    return response &&
           question.judge(work_.queue->receiveLabels(uuid_, response->clusters, true,
                                                     {&cancellation_.flag(), question.name()}),
                          std::to_string(response->clusters.size()) + " labels");
  }

 private:
  Question ask(const std::string& service, const std::string& items = std::string())
  {
    work_.log.want(service, items, again_);
    return Question(service, work_.names, work_.log, cancellation_);
  }

  template <class Message>
  bool handOver(Question& question, const Message& message)
  {
    return question.judge(work_.queue->receive(message, {&cancellation_.flag(), question.name()}));
  }

  /// Waits for a mesh of whatever name, which it is asked for by then. Nothing: refused, as the log
  /// says.
  std::optional<mesh_msgs::GetGeometry::Response> findMesh(Question& question)
  {
    const auto listed = serviceCandidates("get_uuids", work_.names);
    const auto single = serviceCandidates("get_uuid", work_.names);
    Names names;
    for (std::size_t i = 0; i < listed.size(); ++i) {  // of each namespace both
      names.push_back(listed[i]);
      if (i < single.size()) {
        names.push_back(single[i]);
      }
    }
    const std::vector<ServiceCall::Type> types = {ServiceCall::typeOf<mesh_msgs::GetUUIDs>(),
                                                  ServiceCall::typeOf<mesh_msgs::GetUUID>()};
    const auto request = ros::serialization::serializeMessage(mesh_msgs::GetUUIDs::Request());
    while (true) {
      if (question.tryOnce(names, types, request) && question.answer().refusal.empty()) {
        const auto uuid = question.answer().type == 0 ? firstOf(question) : singleOf(question);
        if (!uuid) {
          return std::nullopt;
        }
        if (!uuid->empty()) {
          uuid_ = *uuid;
          return question.get<mesh_msgs::GetGeometry>(uuid_);
        }
        question.search(question.name() + " names no mesh yet");
      } else if (question.tryOnce(
                     serviceCandidates(GEOMETRY, work_.names),
                     {ServiceCall::typeOf<mesh_msgs::GetGeometry>()},
                     ros::serialization::serializeMessage(mesh_msgs::GetGeometry::Request()))) {
        return question.read<mesh_msgs::GetGeometry::Response>();
      }
      question.pause();
    }
  }

  static std::optional<std::string> firstOf(Question& question)
  {
    const auto all = question.read<mesh_msgs::GetUUIDs::Response>();
    return !all ? std::nullopt
                : std::make_optional(all->uuids.empty() ? std::string() : all->uuids.front());
  }

  static std::optional<std::string> singleOf(Question& question)
  {
    const auto one = question.read<mesh_msgs::GetUUID::Response>();
    return one ? std::make_optional(one->uuid) : std::nullopt;
  }

  bool textures(const std::set<std::uint32_t>& indices, bool again)
  {
    for (std::size_t i = 0; i < indices.size(); ++i) {
      work_.log.want(work_.names.texture, "textures", again);
    }
    std::set<std::uint32_t> missing;
    for (const std::uint32_t index : indices) {
      if (!texture(index)) {
        missing.insert(index);
      }
    }
    const std::lock_guard<std::mutex> lock(work_.mutex);
    if (missing.empty()) {
      work_.missing_textures.erase(uuid_);
      return true;
    }
    work_.missing_textures[uuid_] = std::move(missing);
    return false;
  }

  bool texture(std::uint32_t index)
  {
    Question question(work_.names.texture, work_.names, work_.log, cancellation_);
    mesh_msgs::GetTexture::Request request;
    request.texture_index = index;
    auto response = question.get<mesh_msgs::GetTexture>(uuid_, request);
    if (!response || !question.belongs(uuid_, response->texture.uuid)) {
      return false;
    }
    if (response->texture.texture_index != index) {
      return question.fail("answers with texture " +
                           std::to_string(response->texture.texture_index) + " instead of " +
                           std::to_string(index));
    }
    return handOver(question, response->texture);
  }

  Work& work_;
  const Cancellation& cancellation_;
  std::string uuid_;
  const std::string item_;
  const bool again_;
};

/// When something that is asked may be asked again.
struct MapServiceClient::Turn
{
  std::chrono::milliseconds pause{0};  ///< after it
  std::mutex mutex;
  std::optional<Clock::time_point> due;  ///< nothing: it is being asked, or all has come

  void end(bool complete)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    if (!complete) {
      due = Clock::now() + pause;
    }
  }

  bool isDue()
  {
    const std::lock_guard<std::mutex> lock(mutex);
    return due && Clock::now() >= *due;
  }
};

MapServiceClient::MapServiceClient(std::shared_ptr<AttributeQueue> queue,
                                   std::shared_ptr<MeshLoader> loader, Milliseconds first_pause,
                                   Milliseconds greatest_pause)
    : queue_(std::move(queue)),
      loader_(std::move(loader)),
      first_pause_(first_pause),
      greatest_pause_(greatest_pause)
{
}

void MapServiceClient::setNames(const ServiceNames& names)
{
  const auto tied = [](const ServiceNames& n) {
    return std::tie(n.colors, n.materials, n.texture, n.geometry_topic, n.service_namespace);
  };
  if (tied(names) != tied(names_)) {
    cancel();
    names_ = names;
  }
}

void MapServiceClient::cancel()
{
  lanes_.clear();
  turns_.clear();
  work_.reset();
  failure_.clear();
}

void MapServiceClient::request(const std::string& lane, bool (Errand::*errand)(),
                               const std::string& uuid, const std::string& item)
{
  try {
    if (!work_) {
      work_.reset(new Work{queue_, loader_, names_, {}, {}, {}, {}});
    }
    std::shared_ptr<Turn>& last = turns_[lane + "\n" + uuid + "\n" + item];
    if (last && !last->isDue()) {
      return;
    }
    const bool again = last != nullptr;
    const auto turn = std::make_shared<Turn>();
    turn->pause = again ? std::min(2 * last->pause, greatest_pause_) : first_pause_;
    WorkThread& thread = lanes_.try_emplace(lane, "map " + lane, NAME_PATIENCE).first->second;
    thread.add([=, work = work_](const Cancellation& cancellation) {
      bool complete = false;
      try {
        complete = (Errand(*work, cancellation, uuid, item, again).*errand)();
      } catch (const Canceled&) {
        return;
      } catch (const std::exception& error) {
        work->log.want("services", {}, false);
        work->log.fail("services", "the services", std::string("cannot be asked: ") + error.what());
      }
      turn->end(complete);
    });
    last = turn;
  } catch (const std::exception& error) {  // no more threads or files
    failure_ = std::string("the services cannot be asked: ") + error.what();
  }
}

void MapServiceClient::requestMesh(const std::string& uuid)
{
  request("mesh", &Errand::mesh, uuid);
}

void MapServiceClient::requestColors(const std::string& uuid)
{
  if (!names_.colors.empty()) {
    request("colors", &Errand::colors, uuid);
  }
}

void MapServiceClient::requestMaterials(const std::string& uuid)
{
  if (!names_.materials.empty()) {
    request("materials", &Errand::materials, uuid);
  }
}

void MapServiceClient::requestCosts(const std::string& uuid)
{
  request("layer names", &Errand::layerNames, uuid);
}

void MapServiceClient::requestLayer(const std::string& uuid, const std::string& type)
{
  request("layers", &Errand::layer, uuid, type);
}

void MapServiceClient::requestLabels(const std::string& uuid)
{
  request("labels", &Errand::labels, uuid);
}

bool MapServiceClient::missesTextures(const std::string& uuid) const
{
  if (!work_) {
    return false;
  }
  const std::lock_guard<std::mutex> lock(work_->mutex);
  return work_->missing_textures.count(uuid) != 0;
}

std::vector<std::string> MapServiceClient::layers(const std::string& uuid) const
{
  if (!work_) {
    return {};
  }
  const std::lock_guard<std::mutex> lock(work_->mutex);
  const auto found = work_->layers.find(uuid);
  return found == work_->layers.end() ? std::vector<std::string>() : found->second;
}

ServiceReport MapServiceClient::report() const
{
  ServiceReport report = work_ ? work_->log.report() : ServiceReport();
  if (!failure_.empty()) {
    report.worst = State::FAILED;
    report.text = failure_ + (report.text.empty() ? "" : "; ") + report.text;
  }
  return report;
}

}  // namespace rviz_mesh_plugin
