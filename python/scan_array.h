// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/scan_view.h>

#include <Eigen/Geometry>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace python {

/// The memory of an array of shape (N, 3), float32 or float64, of any strides.
struct ArrayRows {
  const char* data = nullptr;
  std::size_t size = 0;         ///< N
  std::ptrdiff_t row_bytes = 0; ///< from one row to the next
  std::ptrdiff_t column_bytes = 0;
  bool is_double = false;

  /// Row i, in [0, size).
  Eigen::Vector3d
  row(std::size_t i) const;
  /// Whether a ScanView can read it where it is.
  bool
  isReadable() const;
  /// Floats from one row to the next; only when it isReadable().
  std::size_t
  stride() const;
};

/** \brief A scan that a caller in Python holds: read in place where its memory allows it, else copied as floats.
 *
 * Arrays of float32 whose rows are three floats in sequence are read in place: also slices and the first columns of a
 * wider array. Large coordinates (map frames) are copied with an offset taken off in double, as the programs do.
 */
class ScanArray {
public:
  /** \brief Keep the array; needs the interpreter.
   * \param[in] name of the argument, for messages
   * \param[in] points an array of shape (N, 3), N > 0, float32 or float64 [m]
   * \param[in] viewpoint three finite numbers [m], or None: the origin
   * \param[in] normals of the shape of \p points, or None
   * \throw std::invalid_argument that names the argument and what is wrong with it
   */
  ScanArray(std::string name,
            const pybind11::object& points,
            const pybind11::object& viewpoint,
            const pybind11::object& normals);

  /** \brief Look for the offset, and copy what cannot be read in place; does not need the interpreter.
   * \throw std::invalid_argument when no point is finite
   */
  void
  prepare();

  /// After prepare(); borrowed from this object. Points are relative to offset().
  ScanView
  view() const;
  /// What was copied is not needed any more, nor is view().
  void
  letCopiesGo();
  /// What prepare() took off the coordinates [m]; zero unless they are large.
  const Eigen::Vector3d&
  offset() const
  {
    return offset_;
  }

private:
  std::string name_;
  pybind11::object points_owner_; ///< keep the memory alive
  pybind11::object normals_owner_;
  ArrayRows points_;
  std::optional<ArrayRows> normals_;
  std::optional<Eigen::Vector3d> viewpoint_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
  std::vector<float> copied_points_; ///< empty when they are read in place
  std::vector<float> copied_normals_;
};

/// Three finite numbers, or nothing for None. \throw std::invalid_argument that names the argument
std::optional<Eigen::Vector3d>
vectorOrNone(const std::string& name, const pybind11::object& value);

/// A rigid motion from an array of shape (4, 4). \throw std::invalid_argument that names the argument
Eigen::Isometry3d
poseFrom(const std::string& name, const pybind11::object& value);

} // namespace python
} // namespace pcl_ssfr
