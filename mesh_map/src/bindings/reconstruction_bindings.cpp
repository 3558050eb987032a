// A signed distance field of measured points, for Python (private).

#include "bindings/spatial_bindings.h"
#include "reconstruction/signed_distance_field.h"
#include "reconstruction/surface_extraction.h"

namespace mesh_map {
namespace {

/// A field with what was extracted of it. One thread at a time.
struct BoundField
{
  explicit BoundField(const FieldOptions& options) : field(options) {}

  SignedDistanceField field;
  SurfaceExtraction extraction;
};

py::tuple integrate(BoundField& self, Array points, Array origins, const py::object& colors,
                    const py::object& intensities, unsigned threads, const CancelFlag* cancel)
{
  MeasuredPoints measured;
  measured.points = view<float>(points, "points", {ANY, 3});
  measured.origins = view<float>(origins, "origins", {ANY, 3});
  const py::ssize_t count = points.shape(0);
  requireValue(origins.shape(0) == 1 || origins.shape(0) == count,
               "origins are one, or one for each point");
  measured.colors = viewOrNone<std::uint8_t>(colors, "colors", {count, 3});
  measured.intensities = viewOrNone<float>(intensities, "intensities", {count});
  const IntegrationCounts counts =
      resultOf({threads, cancel}, static_cast<std::size_t>(count),
               [&](const BvhOptions& run) { return self.field.integrate(measured, run); });
  return py::make_tuple(counts.used, counts.not_finite, counts.too_near, counts.too_far,
                        counts.outside);
}

py::tuple extract(BoundField& self, float least_weight, unsigned threads, const CancelFlag* cancel)
{
  FieldSurface surface =
      resultOf({threads, cancel}, self.field.blocks().blocks.size() * BLOCK_VOXELS,
               [&](const BvhOptions& run) {
                 return self.extraction.extract(self.field, least_weight, run);
               });
  return py::make_tuple(toRows(std::move(surface.vertices), 3), toRows(std::move(surface.faces), 3),
                        toRows(std::move(surface.normals), 3), toRows(std::move(surface.colors), 3),
                        toArray(std::move(surface.intensities)),
                        toArray(std::move(surface.observations)));
}

py::tuple stateOf(const BoundField& self)
{
  auto state = unlocked([&] { return self.field.state(); });
  return toArrays(state.keys, state.distances, state.weights, state.observations, state.colors,
                  state.intensities, state.cell_keys, state.cell_numbers);
}

void restore(BoundField& self, Array keys, Array distances, Array weights, Array observations,
             Array colors, Array intensities, Array cell_keys, Array cell_numbers)
{
  FieldState<ArrayView> state;
  state.keys = view<std::uint64_t>(keys, "keys", {ANY});
  state.distances = view<std::int16_t>(distances, "distances", {ANY});
  state.weights = view<std::uint16_t>(weights, "weights", {ANY});
  state.observations = view<std::uint16_t>(observations, "observations", {ANY});
  state.colors = view<std::uint8_t>(colors, "colors", {ANY});
  state.intensities = view<float>(intensities, "intensities", {ANY});
  state.cell_keys = view<std::uint64_t>(cell_keys, "cell_keys", {ANY});
  state.cell_numbers = view<float>(cell_numbers, "cell_numbers", {ANY});
  unlocked([&] {
    self.field.restore(state);
    self.extraction = SurfaceExtraction();
  });
}

}  // namespace

void bindReconstruction(py::module_& module)
{
  static py::exception<FieldMemoryError> memory_error(module, "_FieldMemoryError",
                                                      PyExc_MemoryError);
  py::register_local_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) {
        std::rethrow_exception(pointer);
      }
    } catch (const FieldMemoryError& error) {
      PyErr_SetObject(memory_error.ptr(), py::int_(error.needed).ptr());
    }
  });
  py::class_<BoundField>(module, "_SignedDistanceField", py::module_local())
      .def(py::init([](double voxel_size, double truncation, double min_range, double max_range,
                       bool carve, bool colors, bool intensities, std::size_t memory_limit) {
        FieldOptions options;
        options.voxel_size = voxel_size;
        options.truncation = truncation;
        options.min_range = min_range;
        options.max_range = max_range;
        options.carve = carve;
        options.colors = colors;
        options.intensities = intensities;
        options.memory_limit = memory_limit;
        return std::make_unique<BoundField>(options);
      }))
      .def("_integrate", &integrate)
      .def("_extract", &extract)
      .def("_state", &stateOf)
      .def("_restore", &restore)
      .def_property_readonly("_memory", [](const BoundField& self) { return self.field.memory(); })
      .def_property_readonly(
          "_blocks", [](const BoundField& self) { return self.field.blocks().index.size(); });
}

}  // namespace mesh_map
