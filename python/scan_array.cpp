// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "scan_array.h"

#include <apps/io/coordinate_offset.h>
#include <apps/io/transform_file.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace pcl_ssfr {
namespace python {

namespace py = pybind11;

namespace {

/// What numpy makes of \p value: an array as it is, NaN in place of what is masked, anything else converted.
py::array
asArray(const std::string& name, const py::object& value)
{
  try {
    const py::module_ numpy = py::module_::import("numpy");
    if (py::isinstance(value, numpy.attr("ma").attr("MaskedArray")))
      return value.attr("filled")(std::numeric_limits<double>::quiet_NaN());
    return numpy.attr("asarray")(value);
  }
  catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError))
      throw;
    throw std::invalid_argument(name + ": is no array");
  }
}

std::string
describe(const py::array& array)
{
  return "of dtype " + py::str(array.dtype()).cast<std::string>() + " and shape " +
         py::str(array.attr("shape")).cast<std::string>();
}

ArrayRows
rowsOf(const std::string& name, const py::array& array)
{
  const bool is_double = py::isinstance<py::array_t<double>>(array);
  if (!is_double && !py::isinstance<py::array_t<float>>(array))
    throw std::invalid_argument(name + ": an array " + describe(array) + ", must be of float32 or float64");
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw std::invalid_argument(name + ": an array " + describe(array) + ", must be of shape (N, 3)");
  if (array.shape(0) == 0)
    throw std::invalid_argument(name + ": has no points");
  ArrayRows rows;
  rows.data = static_cast<const char*>(array.data());
  rows.size = static_cast<std::size_t>(array.shape(0));
  rows.row_bytes = array.strides(0);
  rows.column_bytes = array.strides(1);
  rows.is_double = is_double;
  return rows;
}

template <typename Value>
Value
load(const char* at)
{
  Value value;
  std::memcpy(&value, at, sizeof(value)); // numpy's memory need not be aligned
  return value;
}

std::vector<float>
copyOf(const ArrayRows& rows, const Eigen::Vector3d& offset)
{
  std::vector<float> copy(3 * rows.size);
  for (std::size_t i = 0; i < rows.size; ++i)
    Eigen::Map<Eigen::Vector3f>(copy.data() + 3 * i) = (rows.row(i) - offset).cast<float>();
  return copy;
}

/// The argument that goes with the points \p name: "source_viewpoint" with "source", "viewpoint" with "points".
std::string
companion(const std::string& name, const char* what)
{
  return name == "points" ? what : name + "_" + what;
}

/// Numbers of doubles in an array of the shape of \p matrix.
template <typename Matrix>
bool
readMatrix(const py::object& value, Matrix& matrix)
{
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
  if (!array) {
    PyErr_Clear();
    return false;
  }
  const bool is_vector = Matrix::ColsAtCompileTime == 1;
  if (array.ndim() != (is_vector ? 1 : 2) || array.shape(0) != matrix.rows() ||
      (!is_vector && array.shape(1) != matrix.cols()))
    return false;
  using RowMajor = Eigen::Matrix<double,
                                 Matrix::RowsAtCompileTime,
                                 Matrix::ColsAtCompileTime,
                                 is_vector ? Eigen::ColMajor : Eigen::RowMajor>;
  matrix = Eigen::Map<const RowMajor>(array.data());
  return true;
}

} // namespace

Eigen::Vector3d
ArrayRows::row(std::size_t i) const
{
  const char* at = data + static_cast<std::ptrdiff_t>(i) * row_bytes;
  if (is_double)
    return {load<double>(at), load<double>(at + column_bytes), load<double>(at + 2 * column_bytes)};
  return {load<float>(at), load<float>(at + column_bytes), load<float>(at + 2 * column_bytes)};
}

bool
ArrayRows::isReadable() const
{
  constexpr std::ptrdiff_t kFloat = sizeof(float);
  return !is_double && column_bytes == kFloat && row_bytes >= 3 * kFloat && row_bytes % kFloat == 0 &&
         reinterpret_cast<std::uintptr_t>(data) % alignof(float) == 0;
}

std::size_t
ArrayRows::stride() const
{
  return static_cast<std::size_t>(row_bytes) / sizeof(float);
}

ScanArray::ScanArray(std::string name, const py::object& points, const py::object& viewpoint, const py::object& normals)
    : name_(std::move(name)), points_owner_(asArray(name_, points)),
      points_(rowsOf(name_, py::reinterpret_borrow<py::array>(points_owner_))),
      viewpoint_(vectorOrNone(companion(name_, "viewpoint"), viewpoint))
{
  if (normals.is_none())
    return;
  const std::string argument = companion(name_, "normals");
  normals_owner_ = asArray(argument, normals);
  normals_ = rowsOf(argument, py::reinterpret_borrow<py::array>(normals_owner_));
  if (normals_->size != points_.size)
    throw std::invalid_argument(argument + ": has " + std::to_string(normals_->size) + " rows for " +
                                std::to_string(points_.size) + " points");
}

void
ScanArray::prepare()
{
  std::size_t finite = 0;
  while (finite < points_.size && !points_.row(finite).allFinite())
    ++finite;
  if (finite == points_.size)
    throw std::invalid_argument(name_ + ": none of its " + std::to_string(points_.size) + " points is finite");
  offset_ = io::chooseOffset(points_.size, [this](std::size_t i) { return points_.row(i); });
  // Points and normals of a view have one stride.
  const bool in_place = points_.isReadable() && offset_.isZero(0) &&
                        (!normals_ || (normals_->isReadable() && normals_->stride() == points_.stride()));
  if (in_place)
    return;
  copied_points_ = copyOf(points_, offset_);
  if (normals_)
    copied_normals_ = copyOf(*normals_, Eigen::Vector3d::Zero());
}

ScanView
ScanArray::view() const
{
  const auto floatsOf = [](const ArrayRows& rows, const std::vector<float>& copy) {
    return copy.empty() ? reinterpret_cast<const float*>(rows.data) : copy.data();
  };
  ScanView view;
  view.size = points_.size;
  view.stride = copied_points_.empty() ? points_.stride() : 3;
  view.xyz = floatsOf(points_, copied_points_);
  view.normals = normals_ ? floatsOf(*normals_, copied_normals_) : nullptr;
  view.viewpoint = viewpoint_.value_or(Eigen::Vector3d::Zero()) - offset_;
  return view;
}

void
ScanArray::letCopiesGo()
{
  copied_points_ = std::vector<float>();
  copied_normals_ = std::vector<float>();
}

std::optional<Eigen::Vector3d>
vectorOrNone(const std::string& name, const py::object& value)
{
  if (value.is_none())
    return std::nullopt;
  Eigen::Vector3d vector;
  if (!readMatrix(value, vector) || !vector.allFinite())
    throw std::invalid_argument(name + " = " + py::str(value).cast<std::string>() + ", must be three finite numbers");
  return vector;
}

Eigen::Isometry3d
poseFrom(const std::string& name, const py::object& value)
{
  Eigen::Matrix4d matrix;
  if (!readMatrix(value, matrix))
    throw std::invalid_argument(name + ": must be an array of numbers of shape (4, 4)");
  try {
    return io::toRigidMotion(matrix);
  }
  catch (const std::invalid_argument& error) {
    throw std::invalid_argument(name + " " + error.what());
  }
}

} // namespace python
} // namespace pcl_ssfr
