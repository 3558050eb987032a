// The C++ side of spatial_index.py: the native queries of mesh_map beside Embree 3, in one process,
// on the same mesh, with the same rays and as many threads.
//
//     spatial_index_embree FOLDER REPEATS
//
// FOLDER has vertices.f32, faces.u32, coherent.f32 and incoherent.f32 (6 numbers a ray) and
// points.f32. Prints lines "name value": medians in milliseconds, and what is counted.
#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_map/bvh/selection/bvh_selection.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <thread>

#include "embree_scene.h"

namespace {

using mesh_map::Bvh;

struct Data
{
  std::vector<float> vertices;
  std::vector<std::uint32_t> faces;
  mesh_map::MeshView mesh() const { return {vertices, faces}; }
};

template <class T>
std::vector<T> read(const std::string& path)
{
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  std::vector<T> values(file ? static_cast<std::size_t>(file.tellg()) / sizeof(T) : 0);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(values.data()), values.size() * sizeof(T));
  if (!file || values.empty()) {
    throw std::runtime_error(path + " cannot be read");
  }
  return values;
}

void tell(const std::string& name, double value)
{
  std::printf("%s %.9g\n", name.c_str(), value);
}

/// The medians of several actions in milliseconds, run by turns, so that none has a quieter
/// machine.
void measure(unsigned repeats,
             const std::vector<std::pair<std::string, std::function<void()>>>& actions)
{
  std::vector<std::vector<double>> times(actions.size());
  for (unsigned i = 0; i < repeats; ++i) {
    for (std::size_t k = 0; k < actions.size(); ++k) {
      const auto start = std::chrono::steady_clock::now();
      actions[k].second();
      const std::chrono::duration<double, std::milli> time =
          std::chrono::steady_clock::now() - start;
      times[k].push_back(time.count());
    }
  }
  for (std::size_t k = 0; k < actions.size(); ++k) {
    std::nth_element(times[k].begin(), times[k].begin() + repeats / 2, times[k].end());
    tell(actions[k].first, times[k][repeats / 2]);
  }
}

mesh_map::BvhOptions onThreads(unsigned threads)
{
  mesh_map::BvhOptions options;
  options.threads = threads;
  return options;
}

void measureBuild(Data& data, unsigned repeats)
{
  const auto ours = [&](unsigned threads) {
    return [&data, threads] { Bvh::build(data.mesh(), onThreads(threads)); };
  };
  const auto embree = [&](RTCBuildQuality quality, unsigned threads) {
    return [&data, quality, threads] { EmbreeScene(data.vertices, data.faces, quality, threads); };
  };
  Bvh bvh = Bvh::build(data.mesh());
  EmbreeScene scene(data.vertices, data.faces, RTC_BUILD_QUALITY_MEDIUM, 0);
  EmbreeScene moving(data.vertices, data.faces, RTC_BUILD_QUALITY_LOW, 0, RTC_SCENE_FLAG_DYNAMIC);
  const std::vector<std::uint8_t> bytes = bvh.serialize();
  measure(repeats, {{"build", ours(0)},
                    {"embree_build_low", embree(RTC_BUILD_QUALITY_LOW, 0)},
                    {"embree_build_medium", embree(RTC_BUILD_QUALITY_MEDIUM, 0)},
                    {"build_one", ours(1)},
                    {"embree_build_low_one", embree(RTC_BUILD_QUALITY_LOW, 1)},
                    {"refit", [&] { bvh.refit(data.mesh()); }},
                    {"embree_refit", [&] { moving.refit(); }},
                    {"serialize", [&] { bvh.serialize(); }},
                    {"deserialize", [&] { Bvh::deserialize(bytes, data.mesh()); }}});
  measure(1, {{"embree_build_high", embree(RTC_BUILD_QUALITY_HIGH, 0)}});
  const double faces = static_cast<double>(bvh.faceCount());
  tell("memory", static_cast<double>(bvh.memory()) / faces);
  tell("embree_memory", static_cast<double>(scene.memory()) / faces);
  tell("serialized", static_cast<double>(bytes.size()) / faces);
}

/// Rays as Bvh takes them.
struct Batch
{
  std::vector<double> origins, directions;
  explicit Batch(const Rays& rays)
  {
    for (std::size_t i = 0; i < rays.size(); i += 6) {
      origins.insert(origins.end(), &rays[i], &rays[i] + 3);
      directions.insert(directions.end(), &rays[i] + 3, &rays[i] + 6);
    }
  }
  mesh_map::RayBatch view() const { return {origins, directions, {}}; }
};

/// Says how many of Embree's answers, in single precision, differ from ours.
void compare(const std::string& name, const std::vector<std::uint32_t>& faces,
             const std::vector<double>& distances, const EmbreeHits& embree)
{
  std::size_t missed = 0, other = 0, hits = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool ours = faces[i] != mesh_map::NO_INDEX,
               theirs = embree.faces[i] != mesh_map::NO_INDEX;
    hits += ours;
    missed += ours != theirs;
    const double difference = std::abs(distances[i] - embree.distances[i]);
    other += ours && theirs && !(difference <= 1e-3 * (1.0 + distances[i]));
  }
  tell(name + "_hits", static_cast<double>(hits));
  tell(name + "_hit_by_one_only", static_cast<double>(missed));
  tell(name + "_other_distance", static_cast<double>(other));
}

void measureRays(const Bvh& bvh, const EmbreeScene& scene, const EmbreeScene& robust,
                 const Rays& rays, const std::string& name, unsigned repeats)
{
  const Batch batch(rays);
  EmbreeHits embree(rays.size() / 6);
  std::vector<std::uint8_t> occluded(rays.size() / 6);
  mesh_map::RayHits ours;
  const auto cast = [&](unsigned threads) {
    return [&, threads] { ours = castRays(bvh, batch.view(), {}, onThreads(threads)); };
  };
  const auto other = [&](const EmbreeScene& which, unsigned width, unsigned threads) {
    return [&, width, threads] { which.cast(rays, width, threads, embree); };
  };
  measure(repeats, {{name, cast(0)},
                    {"embree_" + name + "_1", other(scene, 1, 0)},
                    {"embree_" + name + "_8", other(scene, 8, 0)},
                    {"embree_" + name + "_robust", other(robust, 1, 0)},
                    {name + "_one", cast(1)},
                    {"embree_" + name + "_1_one", other(scene, 1, 1)},
                    {name + "_any", [&] { raysHitAny(bvh, batch.view()); }},
                    {"embree_" + name + "_any", [&] { scene.occluded(rays, 0, occluded); }}});
  robust.cast(rays, 1, 0, embree);
  compare(name, ours.faces, ours.distances, embree);
}

/// Each ray on its own, from one thread: microseconds come out as milliseconds of 1000 rays.
void measurePick(const Bvh& bvh, const EmbreeScene& scene, const Rays& rays, unsigned repeats)
{
  constexpr std::size_t COUNT = 1000;
  const Batch batch(rays);
  const std::size_t step = rays.size() / 6 / COUNT;
  measure(repeats, {{"pick",
                     [&] {
                       for (std::size_t i = 0; i < COUNT; ++i) {
                         castRay(bvh, batch.view()[i * step]);
                       }
                     }},
                    {"embree_pick", [&] {
                       std::uint32_t face;
                       float distance;
                       for (std::size_t i = 0; i < COUNT; ++i) {
                         scene.cast(&rays[6 * i * step], face, distance);
                       }
                     }}});
}

void measurePoints(const Bvh& bvh, const EmbreeScene& scene, const std::vector<float>& points,
                   unsigned repeats)
{
  const std::vector<double> wide(points.begin(), points.end());
  EmbreeHits embree(points.size() / 3);
  mesh_map::SurfaceHits ours;
  measure(repeats, {{"closest", [&] { ours = closestPoints(bvh, wide); }},
                    {"embree_closest", [&] { scene.closest(points, 0, embree); }}});
  compare("closest", ours.faces, ours.distances, embree);
  for (const float radius : {1.0f, 5.0f}) {
    const std::string name = "sphere_" + std::to_string(static_cast<int>(radius));
    const mesh_map::SphereRegion sphere({points[0], points[1], points[2]}, radius);
    std::vector<std::uint32_t> faces, others;
    measure(20 * repeats,
            {{name, [&] { faces = selectFaces(bvh, sphere); }},
             {"embree_" + name, [&] { others = scene.sphere(points.data(), radius); }}});
    tell(name + "_faces", static_cast<double>(faces.size()));
    tell("embree_" + name + "_faces", static_cast<double>(others.size()));
  }
}

void run(const std::string& folder, unsigned repeats)
{
  Data data{read<float>(folder + "/vertices.f32"), read<std::uint32_t>(folder + "/faces.u32")};
  measureBuild(data, repeats);
  const Bvh bvh = Bvh::build(data.mesh());
  const EmbreeScene scene(data.vertices, data.faces, RTC_BUILD_QUALITY_MEDIUM, 0);
  const EmbreeScene robust(data.vertices, data.faces, RTC_BUILD_QUALITY_MEDIUM, 0,
                           RTC_SCENE_FLAG_ROBUST);
  for (const std::string name : {"coherent", "incoherent"}) {
    const Rays rays = read<float>(folder + "/" + name + ".f32");
    measureRays(bvh, scene, robust, rays, name, repeats);
    if (name == "coherent") {
      measurePick(bvh, scene, rays, repeats);
    }
  }
  measurePoints(bvh, scene, read<float>(folder + "/points.f32"), repeats);
  tell("threads", mesh_map::resolveThreads(0));
}

}  // namespace

int main(int argc, char** argv)
{
  if (argc != 3 || std::atoi(argv[2]) < 1) {
    std::cerr << "usage: spatial_index_embree FOLDER REPEATS\n";
    return 2;
  }
  try {
    run(argv[1], static_cast<unsigned>(std::atoi(argv[2])));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "spatial_index_embree: " << error.what() << "\n";
    return 1;
  }
}
