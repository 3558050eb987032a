// Regions and the selection of faces for Python (private; see mesh_map.spatial_selection).

#include <stdexcept>
#include <string>
#include <utility>

#include "bindings/spatial_bindings.h"

namespace mesh_map {

namespace {

std::shared_ptr<Region> sphere(Object center, double radius)
{
  return std::make_shared<SphereRegion>(vector3(center, "center"), radius);
}

std::shared_ptr<Region> convex(Array planes)
{
  const auto numbers = view<double>(planes, "planes", {ANY, 4});
  std::vector<Plane> list;
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    list.push_back({numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]});
  }
  return std::make_shared<ConvexRegion>(list);
}

std::shared_ptr<Region> box(Object center, Array axes, Object half_size)
{
  const auto numbers = view<double>(axes, "axes", {3, 3});
  std::array<std::array<double, 3>, 3> rows;
  for (std::size_t i = 0; i < 9; ++i) {
    rows[i / 3][i % 3] = numbers[i];
  }
  return std::make_shared<ConvexRegion>(
      ConvexRegion::box(vector3(center, "center"), rows, vector3(half_size, "half_size")));
}

std::shared_ptr<Region> lasso(Array polygon, Array view_projection)
{
  const auto points = view<double>(polygon, "polygon", {ANY, 2});
  const auto numbers = view<double>(view_projection, "view_projection", {4, 4});
  std::vector<LassoRegion::Point> corners;
  for (std::size_t i = 0; i < points.size(); i += 2) {
    corners.push_back({points[i], points[i + 1]});
  }
  std::array<double, 16> matrix;
  std::copy(numbers.begin(), numbers.end(), matrix.begin());
  return std::make_shared<LassoRegion>(std::move(corners), matrix);
}

/// The kind of region that a function needs; ValueError for another.
template <class T>
const T& kind(const Region& region, const char* name)
{
  const T* const found = dynamic_cast<const T*>(&region);
  requireValue(found != nullptr, std::string("this needs a ") + name);
  return *found;
}

py::array select(const Bvh& bvh, const Region& region, bool inside, Object mask)
{
  const auto mask_view = maskView(bvh.faceCount(), mask);
  return toArray(unlocked([&] { return selectFaces(bvh, region, modeOf(inside), mask_view); }));
}

template <class T>
std::vector<T> copied(ArrayView<T> values)
{
  return {values.begin(), values.end()};
}

/// Values of a hit for each ray, from an array that Python gives.
template <class T>
std::vector<T> answer(const py::tuple& hits, std::size_t which, std::size_t count)
{
  const auto array = py::cast<py::array>(hits[which]);
  const auto size = static_cast<py::ssize_t>(count);
  return copied(which == 2 ? view<T>(array, "barycentric", {size, 3})
                           : view<T>(array, "hits", {size}));
}

/// Rays are cast by a function in Python, which takes origins, directions and maximum distances,
/// and gives faces, distances and barycentric coordinates.
RayCast rayCast(const py::function& cast)
{
  return [&cast](const RayBatch& rays) {
    const py::gil_scoped_acquire acquire;
    const auto hits = py::cast<py::tuple>(
        cast(toRows(copied(rays.origins), 3), toRows(copied(rays.directions), 3),
             rays.max_distances.empty() ? py::object(py::none())
                                        : py::object(toArray(copied(rays.max_distances)))));
    RayHits result;
    result.faces = answer<std::uint32_t>(hits, 0, rays.size());
    result.distances = answer<double>(hits, 1, rays.size());
    result.barycentric = answer<double>(hits, 2, rays.size());
    return result;
  };
}

py::array seen(const Bvh& bvh, const Region& region, Array faces, Object eye,
               const py::function& cast)
{
  const auto candidates = indexView(faces, bvh.faceCount(), "faces");
  const std::array<double, 3> from = vector3(eye, "eye");
  const RayCast cast_rays = rayCast(cast);
  return toArray(unlocked([&] { return seenFaces(bvh, region, candidates, from, cast_rays); }));
}

py::array inPicture(const Bvh& bvh, const Region& region, Array origins, Array directions,
                    Object mask, const py::function& cast)
{
  const RayBatch pixels = rayBatch(origins, directions, toArray(std::vector<double>()));
  const auto mask_view = maskView(bvh.faceCount(), mask);
  const RayCast cast_rays = rayCast(cast);
  return toArray(
      unlocked([&] { return facesInPicture(bvh, region, pixels, mask_view, cast_rays); }));
}

py::tuple toTuple(PixelRays&& rays)
{
  return py::make_tuple(toRows(std::move(rays.origins), 3), toRows(std::move(rays.directions), 3));
}

py::tuple pixelsOfFrustum(const Region& region, Object eye, std::size_t columns, std::size_t rows)
{
  const auto& frustum = kind<ConvexRegion>(region, "frustum");
  const std::array<double, 3> from = vector3(eye, "eye");
  return toTuple(unlocked([&] { return frustumPixels(frustum, from, columns, rows); }));
}

py::tuple pixelsOfLasso(const Region& region, std::size_t columns, std::size_t rows)
{
  const auto& lasso = kind<LassoRegion>(region, "lasso");
  return toTuple(unlocked([&] { return lassoPixels(lasso, columns, rows); }));
}

}  // namespace

void bindRegions(py::module_& module, BvhClass& bvh)
{
  using py::arg;

  py::class_<Region, std::shared_ptr<Region>>(module, "_Region", py::module_local());
  module.def("_sphere", &sphere, arg("center"), arg("radius"));
  module.def("_convex", &convex, arg("planes"));
  module.def("_box", &box, arg("center"), arg("axes"), arg("half_size"));
  module.def("_lasso", &lasso, arg("polygon"), arg("view_projection"));
  module.def("_frustum_pixels", &pixelsOfFrustum, arg("region"), arg("eye"), arg("columns"),
             arg("rows"));
  module.def("_lasso_pixels", &pixelsOfLasso, arg("region"), arg("columns"), arg("rows"));
  bvh.def("_select", &select, arg("region"), arg("inside"), arg("mask"))
      .def("_seen", &seen, arg("region"), arg("faces"), arg("eye"), arg("cast"))
      .def("_in_picture", &inPicture, arg("region"), arg("origins"), arg("directions"), arg("mask"),
           arg("cast"));
}

}  // namespace mesh_map
