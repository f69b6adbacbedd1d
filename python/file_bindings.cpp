// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "bindings.h"

#include <apps/io/e57_format.h>
#include <apps/io/loaded_cloud.h>
#include <apps/io/transform_file.h>

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace python {

namespace py = pybind11;

namespace {

/// An array of shape (N, 3) of what \p row gives for each point.
template <typename Value, typename Row>
py::array_t<Value>
arrayOf(const io::LoadedCloud& cloud, const Row& row)
{
  const std::size_t size = cloud.points->size();
  py::array_t<Value> array({size, std::size_t{3}});
  Value* to = array.mutable_data();
  {
    const py::gil_scoped_release without_interpreter;
    for (std::size_t i = 0; i < size; ++i)
      Eigen::Map<Eigen::Matrix<Value, 3, 1>>(to + 3 * i) = row(i);
  }
  return array;
}

/// The points in file coordinates: float32, or float64 where they are large. What register_scans() makes of them is
/// what the programs work on.
py::object
pointsOf(const io::LoadedCloud& cloud)
{
  if (cloud.offset.isZero(0))
    return arrayOf<float>(cloud, [&](std::size_t i) { return (*cloud.points)[i].getVector3fMap(); });
  const auto xyz = io::findVector(cloud.table, "x", "y", "z");
  return arrayOf<double>(cloud, [&](std::size_t i) {
    const std::uint8_t* at = cloud.table.data.data() + i * cloud.table.point_step;
    Eigen::Vector3d point;
    for (std::size_t k = 0; k < 3; ++k)
      point[static_cast<Eigen::Index>(k)] = io::loadValue(at + (*xyz)[k]->offset, (*xyz)[k]->datatype);
    return point;
  });
}

py::object
intensityOf(const io::LoadedCloud& cloud)
{
  if (!cloud.has_intensity)
    return py::none();
  py::array_t<float> array(static_cast<py::ssize_t>(cloud.points->size()));
  for (std::size_t i = 0; i < cloud.points->size(); ++i)
    array.mutable_at(static_cast<py::ssize_t>(i)) = (*cloud.points)[i].intensity;
  return std::move(array);
}

/// Points, viewpoint, normals, intensity, T_file_scan; None for what the file does not say.
py::tuple
readFields(const std::string& path)
{
  const io::LoadedCloud cloud = [&] {
    const py::gil_scoped_release without_interpreter;
    return io::loadCloud(path);
  }();
  py::object normals = py::none();
  if (cloud.has_normals)
    normals = arrayOf<float>(cloud, [&](std::size_t i) { return (*cloud.points)[i].getNormalVector3fMap(); });
  return py::make_tuple(pointsOf(cloud),
                        cloud.viewpoint,
                        normals,
                        intensityOf(cloud),
                        cloud.T_file_scan ? py::cast(rowMajor(cloud.T_file_scan->matrix())) : py::none());
}

std::vector<std::string>
listScans(const std::string& path)
{
  std::vector<std::string> paths;
  for (const io::E57Scan& scan : io::listE57Scans(path))
    paths.push_back(scan.path);
  return paths;
}

} // namespace

void
bindFiles(py::module_& module)
{
  module.attr("READABLE_FORMATS") = py::tuple(py::str(io::readableFormats()).attr("split")());
  module.def("read_scan_fields", &readFields, py::arg("path"), "See pcl_ssfr.read_scan_file().");
  module.def("list_e57_scans",
             &listScans,
             py::arg("path"),
             py::call_guard<py::gil_scoped_release>(),
             "See pcl_ssfr.list_e57_scans().");
  module.def(
      "read_transform",
      [](const std::string& path) { return rowMajor(io::readTransform(path).matrix()); },
      py::arg("path"),
      "See pcl_ssfr.read_transform().");
}

} // namespace python
} // namespace pcl_ssfr
