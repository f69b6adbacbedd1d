// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/ptx_format.h>

#include <apps/io/text_scanner.h>

#include <Eigen/Geometry>

#include <cmath>

namespace pcl_ssfr {
namespace io {

namespace {

constexpr double kRigidTolerance = 1e-3; ///< of the entries of R^T R of a pose written with few digits
constexpr std::size_t kMinColumns = 3;
constexpr std::size_t kMaxColumns = 7; // x y z intensity r g b

struct ScanHeader {
  std::size_t points = 0;
  Eigen::Isometry3d T_world_scanner = Eigen::Isometry3d::Identity();
};

std::size_t
readCount(const TextScanner& scanner, const char* what)
{
  const auto tokens = splitTokens(scanner.line());
  const auto count = tokens.size() == 1 ? parseCount(tokens[0]) : std::nullopt;
  if (!count || *count > UINT32_MAX)
    throw scanner.error(std::string(what) + ": " + inQuotes(scanner.line()) + " is not a count");
  return static_cast<std::size_t>(*count);
}

void
nextLine(TextScanner& scanner, const char* what)
{
  if (!scanner.nextData())
    throw scanner.error(std::string("the file ends before the ") + what);
}

/// The ten lines before the points; the current line is the first of them.
ScanHeader
readScanHeader(TextScanner& scanner)
{
  ScanHeader header;
  const std::size_t columns = readCount(scanner, "number of columns");
  nextLine(scanner, "number of rows");
  const std::size_t rows = readCount(scanner, "number of rows");
  for (const char* what : {"scanner position", "scanner axis", "scanner axis", "scanner axis"}) {
    nextLine(scanner, what);
    scanner.numbers(3, what);
  }
  Eigen::Matrix4d matrix; // of row vectors: point_world = point_scanner * matrix
  for (Eigen::Index row = 0; row < 4; ++row) {
    nextLine(scanner, "transform");
    const auto values = scanner.numbers(4, "the transform");
    matrix.row(row) = Eigen::Map<const Eigen::RowVector4d>(values.data());
  }
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>().transpose();
  const bool rigid = matrix.allFinite() && (rotation.transpose() * rotation).isIdentity(kRigidTolerance) &&
                     rotation.determinant() > 0 && matrix.col(3).isApprox(Eigen::Vector4d::UnitW(), kRigidTolerance);
  if (!rigid)
    throw scanner.error("the transform is not a rigid motion");
  header.T_world_scanner.linear() = rotation;
  header.T_world_scanner.translation() = matrix.row(3).head<3>().transpose();
  // A point takes six bytes at least ("0 0 0" and the end of the line, which the last may lack).
  const std::uint64_t possible = (scanner.left() + 1) / 6;
  if (rows > 0 && columns > possible / rows)
    throw scanner.error(std::to_string(columns) + " columns of " + std::to_string(rows) +
                        " points do not fit into the " + std::to_string(scanner.left()) + " bytes that follow");
  header.points = columns * rows;
  return header;
}

} // namespace

RawCloud
readPtx(const std::string& path, const ByteSource& source, FieldChoice fields)
{
  TextScanner scanner(source, path);
  std::vector<double> values;
  std::vector<double> line;
  std::size_t columns = 0;
  std::size_t scans = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  while (scanner.nextData()) {
    const ScanHeader header = readScanHeader(scanner);
    position = header.T_world_scanner.translation();
    ++scans;
    for (std::size_t i = 0; i < header.points; ++i) {
      if (!scanner.nextData())
        throw scanner.error("the file ends after " + std::to_string(i) + " of " + std::to_string(header.points) +
                            " points");
      line.clear();
      const std::size_t got = scanner.appendNumbers(line);
      if (columns == 0)
        columns = got;
      if (got != columns || got < kMinColumns || got > kMaxColumns)
        throw scanner.error(std::to_string(got) + " values, expected x y z, intensity and colour like the first point");
      Eigen::Map<Eigen::Vector3d> point(line.data());
      if (point.isZero(0))
        continue;
      point = header.T_world_scanner * point.eval();
      values.insert(values.end(), line.begin(), fields == FieldChoice::kAll ? line.end() : line.begin() + 3);
    }
  }
  if (scans == 0)
    throw IoError(path + ": holds no scan");
  std::vector<std::string> names{"x", "y", "z"};
  if (fields != FieldChoice::kAll)
    columns = names.size();
  if (columns == 4 || columns == 7)
    names.emplace_back("intensity");
  if (columns >= 6)
    names.insert(names.end(), {"red", "green", "blue"});
  while (names.size() < columns)
    names.push_back("column_" + std::to_string(names.size() + 1));
  RawCloud cloud;
  cloud.table = tableFromColumns(names, values);
  if (scans == 1 && !position.isZero(0))
    cloud.viewpoint = position;
  return cloud;
}

} // namespace io
} // namespace pcl_ssfr
