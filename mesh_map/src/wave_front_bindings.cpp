// Fronts from a point for Python (private; see mesh_map.wave_front).

#include "wave_front_bindings.h"

#include <mesh_map/wave_front.h>

#include <memory>
#include <utility>
#include <vector>

#include "array_checks.h"
#include "cancel_flag.h"

namespace mesh_map {
namespace {

using Array = const py::array&;
using Object = const py::object&;

std::vector<WaveFrontSeed> seedsOf(Array vertices, Array labels)
{
  const auto vertex_view = view<std::uint32_t>(vertices, "sources", {ANY});
  const auto label_view = view<double>(labels, "source distances", {vertices.size()});
  std::vector<WaveFrontSeed> seeds;
  for (std::size_t i = 0; i < vertex_view.size(); ++i) {
    seeds.push_back({vertex_view[i], label_view[i]});
  }
  return seeds;
}

/// A field, and what its kernels are given again each time.
class Field
{
 public:
  Field(std::shared_ptr<WaveFrontPool> pool, Array sources, Array source_labels, Object slowness)
      : vertex_count_(static_cast<py::ssize_t>(pool->mesh().vertexCount())), slowness_(slowness)
  {
    const ArrayView<float> values = slownessView();
    std::vector<WaveFrontSeed> seeds = seedsOf(sources, source_labels);
    const py::gil_scoped_release release;
    field_ = std::make_unique<WaveFrontField>(std::move(pool), std::move(seeds), values);
  }

  Field(const Field&) = delete;
  Field& operator=(const Field&) = delete;

  /// Clears buffers for later, which takes milliseconds: other threads go on meanwhile.
  ~Field()
  {
    const py::gil_scoped_release release;
    field_.reset();
  }

  bool extend(Array targets, double offset, double max_distance, const CancelFlag* cancel)
  {
    WaveFrontStop stop;
    stop.targets = view<std::uint32_t>(targets, "targets", {ANY});
    stop.offset = offset;
    stop.max_distance = max_distance;
    stop.cancel = flagOf(cancel);
    const ArrayView<float> values = slownessView();
    const py::gil_scoped_release release;
    return field_->extend(values, stop);
  }

  py::tuple update(Array sources, Array source_labels, Object slowness, Array changed,
                   const CancelFlag* cancel)
  {
    std::vector<WaveFrontSeed> seeds = seedsOf(sources, source_labels);
    const auto vertices = view<std::uint32_t>(changed, "changed", {ANY});
    const py::object before = slowness_;
    slowness_ = slowness;
    WaveFrontField::Update done;
    try {
      const ArrayView<float> values = slownessView();
      const py::gil_scoped_release release;
      done = field_->update(std::move(seeds), values, vertices, flagOf(cancel));
    } catch (...) {
      slowness_ = before;
      throw;
    }
    return py::make_tuple(done.count, done.cancelled);
  }

  double limit() const { return field_->limit(); }

  py::array potential() const
  {
    std::vector<float> values(static_cast<std::size_t>(vertex_count_));
    {
      const py::gil_scoped_release release;
      field_->writePotential(values.data());
    }
    return toArray(std::move(values));
  }

  /// The labels themselves; the field lives as long as this array does.
  static py::array labels(Object self)
  {
    const ArrayView<double> labels = py::cast<const Field&>(self).field_->labels();
    py::array_t<double> array({static_cast<py::ssize_t>(labels.size())}, labels.data(), self);
    array.attr("flags").attr("writeable") = false;
    return std::move(array);
  }

 private:
  static const std::atomic<bool>* flagOf(const CancelFlag* cancel)
  {
    return cancel == nullptr ? nullptr : &cancel->flag;
  }

  ArrayView<float> slownessView() const
  {
    if (slowness_.is_none()) {
      return {};
    }
    return view<float>(py::cast<py::array>(slowness_), "slowness", {vertex_count_});
  }

  py::ssize_t vertex_count_;
  py::object slowness_;
  std::unique_ptr<WaveFrontField> field_;
};

}  // namespace

void bindWaveFront(pybind11::module& module)
{
  using py::arg;
  py::class_<WaveFrontPool, std::shared_ptr<WaveFrontPool>>(module, "_WaveFrontPool",
                                                            py::module_local())
      .def(py::init([](std::shared_ptr<FrontMesh> mesh) {
             return std::make_shared<WaveFrontPool>(std::move(mesh));
           }),
           arg("mesh"));
  py::class_<Field>(module, "_WaveFrontField", py::module_local())
      .def(py::init<std::shared_ptr<WaveFrontPool>, Array, Array, Object>(), arg("pool"),
           arg("sources"), arg("source_labels"), arg("slowness"))
      .def("_extend", &Field::extend, arg("targets"), arg("offset"), arg("max_distance"),
           arg("cancel"))
      .def("_update", &Field::update, arg("sources"), arg("source_labels"), arg("slowness"),
           arg("changed"), arg("cancel"))
      .def("_limit", &Field::limit)
      .def("_potential", &Field::potential)
      .def("_labels", &Field::labels);
}

}  // namespace mesh_map
