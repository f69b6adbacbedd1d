// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>

namespace pcl_ssfr {
namespace python {

/// Add what registers pairs to the module: results, prepared scans, register_scans(), prepare_scan().
void
bindPairs(pybind11::module_& module);

/// Add the readers of files.
void
bindFiles(pybind11::module_& module);

/// Add what places many scans in one frame. Only where the component "multiway" is built.
void
bindMaps(pybind11::module_& module);

/// The enumerator of the Python class \p name that has the value \p value.
inline pybind11::object
enumerator(const char* name, const char* value)
{
  return pybind11::module_::import("pcl_ssfr._enums").attr(name)(value);
}

/// A matrix as an array in the order of C.
template <typename Derived>
auto
rowMajor(const Eigen::MatrixBase<Derived>& matrix)
{
  return Eigen::Matrix<double, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime, Eigen::RowMajor>(matrix);
}

} // namespace python
} // namespace pcl_ssfr
