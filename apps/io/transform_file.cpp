// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/transform_file.h>

#include <apps/io/file_bytes.h>
#include <apps/io/text_scanner.h>

#include <Eigen/SVD>

#include <iomanip>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr double kRigidTolerance = 1e-3; ///< of the entries of R^T R: three digits must have been written
constexpr double kExact = 1e-14;         ///< nearer than this to a rotation nothing is gained by a projection

} // namespace

Eigen::Isometry3d
toRigidMotion(const Eigen::Matrix4d& matrix)
{
  if (!matrix.allFinite())
    throw std::invalid_argument("is not finite");
  const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
  if (!(linear.transpose() * linear).isIdentity(kRigidTolerance) || linear.determinant() < 0 ||
      !matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kRigidTolerance))
    throw std::invalid_argument("is not a rigid motion (a rotation, a translation, last row 0 0 0 1)");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = linear;
  if (!(linear.transpose() * linear).isIdentity(kExact)) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
    T.linear() = svd.matrixU() * svd.matrixV().transpose();
  }
  T.translation() = matrix.topRightCorner<3, 1>();
  return T;
}

Eigen::Isometry3d
readTransform(const std::string& path)
{
  const std::string content = readFile(path);
  TextScanner scanner(content, path);
  std::vector<double> values;
  while (scanner.nextData()) {
    scanner.appendNumbers(values);
    if (values.size() > 16)
      throw scanner.error("more than the 16 numbers of a 4x4 transform");
  }
  if (values.size() != 16)
    throw IoError(path + ": a 4x4 transform needs 16 numbers, found " + std::to_string(values.size()));
  try {
    return toRigidMotion(Eigen::Matrix<double, 4, 4, Eigen::RowMajor>(values.data()));
  }
  catch (const std::invalid_argument& error) {
    throw IoError(path + ": the transform " + error.what());
  }
}

std::string
formatTransform(const Eigen::Isometry3d& T, int digits)
{
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(digits);
  for (Eigen::Index row = 0; row < 4; ++row)
    text << T.matrix()(row, 0) << ' ' << T.matrix()(row, 1) << ' ' << T.matrix()(row, 2) << ' ' << T.matrix()(row, 3)
         << '\n';
  return text.str();
}

} // namespace io
} // namespace pcl_ssfr
