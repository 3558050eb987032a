// Times of roscpp for a MeshGeometryStamped, for benchmark/serialization.py.
//
//     serialization_roscpp VERTICES FACES
//
// Prints the medians in milliseconds: "serialize 31.0" and "deserialize 20.0".

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <vector>

#include <mesh_msgs/MeshGeometryStamped.h>
#include <ros/serialization.h>

namespace {

constexpr int REPEATS = 7;

double medianMilliseconds(const std::function<void()>& action)
{
  std::vector<double> times;
  for (int i = 0; i < REPEATS; ++i) {
    const auto start = std::chrono::steady_clock::now();
    action();
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    times.push_back(time.count());
  }
  std::nth_element(times.begin(), times.begin() + REPEATS / 2, times.end());
  return times[REPEATS / 2];
}

}  // namespace

int main(int argc, char** argv)
{
  if (argc != 3) {
    std::cerr << "usage: serialization_roscpp VERTICES FACES\n";
    return 2;
  }
  mesh_msgs::MeshGeometryStamped message;
  message.mesh_geometry.vertices.resize(std::strtoul(argv[1], nullptr, 10));
  message.mesh_geometry.vertex_normals.resize(message.mesh_geometry.vertices.size());
  message.mesh_geometry.faces.resize(std::strtoul(argv[2], nullptr, 10));

  // As ros::Publisher::publish does it, with a new buffer each time.
  ros::SerializedMessage wire;
  const double write =
      medianMilliseconds([&] { wire = ros::serialization::serializeMessage(message); });
  const double read = medianMilliseconds([&] {
    mesh_msgs::MeshGeometryStamped received;  // a subscriber gets a new message each time
    ros::serialization::deserializeMessage(wire, received);
  });
  std::cout << "serialize " << write << "\ndeserialize " << read << "\n";
  return 0;
}
