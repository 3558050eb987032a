// main() of a benchmark in RViz: BENCHMARK is the namespace of one.
namespace rviz_benchmark::BENCHMARK {

int run(int argc, char** argv);

}  // namespace rviz_benchmark::BENCHMARK

int main(int argc, char** argv)
{
  return rviz_benchmark::BENCHMARK::run(argc, argv);
}
