#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "query_fixture.h"
#include "spatial/opencl_session.h"

using query_test::Log;
using query_test::Questions;
using query_test::TemporaryFolder;
using query_test::waves;
using rviz_mesh_plugin::SpatialQueries;
using rviz_mesh_plugin::SpatialQueriesOptions;

namespace {

class OpenClStartTest : public query_test::DeviceTest
{
 protected:
  /// Starts a device, and says whether its program came from the cache. Others must have ended.
  bool startsFromCache(const std::string& folder)
  {
    auto options = this->options();
    options.cache_folder = folder;
    const SpatialQueries queries(bvh_, options);
    EXPECT_TRUE(queries.waitForDevice());
    const auto before = mesh_map::queryCount(mesh_map::BackEnd::OPENCL, mesh_map::Query::RAY);
    const Questions questions(300);
    EXPECT_TRUE(queries.castRays(questions.rays()) == mesh_map::castRays(*bvh_, questions.rays()));
    EXPECT_EQ(mesh_map::queryCount(mesh_map::BackEnd::OPENCL, mesh_map::Query::RAY) - before, 300u);
    const std::string text = log_.infos().back();
    const bool cached = text.find("program from the cache") != std::string::npos;
    EXPECT_NE(cached, text.find("program compiled") != std::string::npos) << text;
    return cached;
  }

  const query_test::BvhPtr bvh_ = waves(10);
};

}  // namespace

TEST_F(OpenClStartTest, compiles_once)
{
  EXPECT_FALSE(startsFromCache(cache_.path()));
  EXPECT_EQ(cache_.files().size(), 1u);
  EXPECT_TRUE(startsFromCache(cache_.path()));
  EXPECT_TRUE(startsFromCache(cache_.path()));
  EXPECT_EQ(log_.infos().size(), 3u) << "one line a start";
  EXPECT_TRUE(log_.warnings().empty());
}

TEST_F(OpenClStartTest, replaces_a_damaged_file)
{
  ASSERT_FALSE(startsFromCache(cache_.path()));
  const std::string file = cache_.files().at(0);
  std::ofstream(file, std::ios::binary | std::ios::in).seekp(200).put('\x55');
  EXPECT_FALSE(startsFromCache(cache_.path()));
  EXPECT_TRUE(startsFromCache(cache_.path()));
  EXPECT_EQ(cache_.files(), std::vector<std::string>{file});
}

TEST_F(OpenClStartTest, replaces_a_binary_that_the_driver_does_not_take)
{
  ASSERT_FALSE(startsFromCache(cache_.path()));
  const rviz_mesh_plugin::ProgramCache cache(cache_.path());
  const auto devices = rviz_mesh_plugin::listDevices();
  const std::string file = cache_.files().at(0);
  bool replaced = false;
  for (const cl::Device& device : devices) {
    const auto program = rviz_mesh_plugin::buildProgram(device, "", "", cache);
    replaced = replaced || cache.store(program.key, {'n', 'o', 'n', 'e'});
    EXPECT_FALSE(rviz_mesh_plugin::buildProgram(device, "", "", cache).from_cache);
  }
  EXPECT_TRUE(replaced);
}

TEST_F(OpenClStartTest, does_without_a_cache)
{
  EXPECT_FALSE(startsFromCache(""));
  EXPECT_FALSE(startsFromCache("/proc/no/such/folder"));
  EXPECT_FALSE(startsFromCache("/proc/no/such/folder"));
  EXPECT_TRUE(log_.warnings().empty());
}

TEST_F(OpenClStartTest, is_shared_by_all_meshes_of_the_process)
{
  const SpatialQueries first(bvh_, options()), second(waves(12), options());
  EXPECT_TRUE(first.waitForDevice());
  EXPECT_TRUE(second.waitForDevice());
  ASSERT_EQ(log_.infos().size(), 1u);
  const auto info = rviz_mesh_plugin::describe(rviz_mesh_plugin::listDevices().at(0));
  EXPECT_NE(log_.infos()[0].find(info.driver), std::string::npos) << log_.infos()[0];
}

TEST_F(OpenClStartTest, frees_everything_with_its_last_user)
{
  auto session = rviz_mesh_plugin::OpenClSession::shared("", cache_.path(), nullptr);
  ASSERT_TRUE(session->wait());
  const std::weak_ptr<const rviz_mesh_plugin::OpenClProgram> program = session->program();
  ASSERT_FALSE(program.expired());
  session.reset();
  EXPECT_TRUE(program.expired());
}

TEST_F(OpenClStartTest, is_off_or_another_device_if_wished)
{
  const Questions questions(100);
  const auto expected = mesh_map::castRays(*bvh_, questions.rays());
  const auto count = [] {
    return mesh_map::queryCount(mesh_map::BackEnd::OPENCL, mesh_map::Query::RAY);
  };
  const auto before = count();
  ::setenv("MESH_TOOLS_OPENCL", "Off", 1);
  const SpatialQueries off(bvh_, options());
  EXPECT_FALSE(off.waitForDevice());
  EXPECT_TRUE(off.castRays(questions.rays()) == expected);
  EXPECT_TRUE(log_.warnings().empty()) << "as wished";
  EXPECT_TRUE(log_.infos().empty());

  auto wished = options();
  wished.device = "no such device";
  const SpatialQueries missing(bvh_, wished);
  EXPECT_FALSE(missing.waitForDevice());
  EXPECT_TRUE(missing.castRays(questions.rays()) == expected);
  ASSERT_EQ(log_.warnings().size(), 1u);
  EXPECT_NE(log_.warnings()[0].find("no device is 'no such device' (there is "), std::string::npos)
      << log_.warnings()[0];
  EXPECT_EQ(count(), before);

  const auto info = rviz_mesh_plugin::describe(rviz_mesh_plugin::listDevices().at(0));
  wished.device = info.platform.substr(0, 4);
  const SpatialQueries named(bvh_, wished);
  EXPECT_TRUE(named.waitForDevice()) << "the parameter overrides the variable";
  EXPECT_TRUE(named.castRays(questions.rays()) == expected);
  EXPECT_EQ(count(), before + 100);
  ::unsetenv("MESH_TOOLS_OPENCL");
}
