// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/loaded_cloud.h>

#include <apps/io/coordinate_offset.h>
#include <apps/io/e57_format.h>
#include <apps/io/e57_writer.h>
#include <apps/io/file_bytes.h>
#include <apps/io/kitti_format.h>
#include <apps/io/las_format.h>
#include <apps/io/pcd_format.h>
#include <apps/io/ply_format.h>
#include <apps/io/ptx_format.h>
#include <apps/io/text_formats.h>
#include <apps/io/threedtk_format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <iomanip>
#include <sstream>

namespace pcl_ssfr {
namespace io {

namespace {

using Field = pcl::PCLPointField;
using VectorFields = std::array<const Field*, 3>;

constexpr const char* kE57 = ".e57";
constexpr double kLargestStep = 0.1; // of coordinates [m]: matches are as far apart

/// How files of an extension are read: whole, or block by block.
struct Reader {
  const char* extension;
  RawCloud (*whole)(const std::string& path, std::string_view bytes);
  RawCloud (*blocks)(const std::string& path, const ByteSource& source, FieldChoice fields);

  RawCloud
  read(const std::string& path, const ByteSource& source, FieldChoice fields) const
  {
    if (source.size() == 0)
      throw IoError(path + ": is empty");
    if (blocks)
      return blocks(path, source, fields);
    return whole(path, source.first(source.size()));
  }
};

/// The reader for the extension of \p path, null when there is none.
const Reader*
readerFor(const std::string& path)
{
  static constexpr Reader kReaders[] = {{".pcd", nullptr, readPcd},
                                        {".ply", nullptr, readPly},
                                        {".csv", nullptr, readTextTable},
                                        {".xyz", nullptr, readTextTable},
                                        {".txt", nullptr, readTextTable},
                                        {".asc", nullptr, readTextTable},
                                        {".pts", nullptr, readTextTable},
                                        {".ptx", nullptr, readPtx},
                                        {".3d", readThreedtk, nullptr},
                                        {".bin", readKitti, nullptr},
                                        {".las", nullptr, readLas},
                                        {".laz", nullptr, readLas},
                                        {kE57, nullptr, readE57}};
  const std::string extension = extensionOf(path);
  for (const Reader& reader : kReaders)
    if (extension == reader.extension)
      return &reader;
  return nullptr;
}

const Reader&
requireReader(const std::string& path)
{
  const Reader* reader = readerFor(path);
  if (!reader)
    throw IoError(path + ": unknown format, the extension must be one of " + readableFormats());
  return *reader;
}

RawCloud
readScan(const std::string& path, FieldChoice fields)
{
  const Reader& reader = requireReader(path);
  return reader.read(path, FileBytes(fileOfScan(path)), fields);
}

Eigen::Vector3d
loadVector(const std::uint8_t* point, const VectorFields& fields)
{
  return {loadValue(point + fields[0]->offset, fields[0]->datatype),
          loadValue(point + fields[1]->offset, fields[1]->datatype),
          loadValue(point + fields[2]->offset, fields[2]->datatype)};
}

void
storeVector(std::uint8_t* point, const VectorFields& fields, const Eigen::Vector3d& value)
{
  for (std::size_t k = 0; k < 3; ++k)
    storeValue(point + fields[k]->offset, fields[k]->datatype, value[static_cast<Eigen::Index>(k)]);
}

const std::uint8_t*
pointAt(const pcl::PCLPointCloud2& table, std::size_t i)
{
  return table.data.data() + i * table.point_step;
}

/// The coordinates of a table. \throw IoError when it has none
VectorFields
requireCoordinates(const std::string& path, const pcl::PCLPointCloud2& table)
{
  const auto xyz = findVector(table, "x", "y", "z");
  if (!xyz)
    throw IoError(path + ": has no coordinates x, y, z");
  return *xyz;
}

/// What the tools know of a scan besides its points.
LoadedCloud
describe(const std::string& path, RawCloud raw)
{
  const VectorFields xyz = requireCoordinates(path, raw.table);
  LoadedCloud cloud;
  cloud.path = path;
  cloud.viewpoint = raw.viewpoint;
  cloud.T_file_scan = raw.T_file_scan;
  const Field* intensity = findField(raw.table, "intensity");
  cloud.has_normals = findVector(raw.table, "normal_x", "normal_y", "normal_z").has_value();
  cloud.has_intensity = intensity && intensity->count == 1;
  const std::size_t count = pointCount(raw.table);
  const auto point = [&](std::size_t i) { return loadVector(pointAt(raw.table, i), xyz); };
  cloud.offset = chooseOffset(count, point);
  if (const double step = floatStep(count, point, cloud.offset); step > kLargestStep) {
    std::ostringstream text;
    text << path << ": x, y, z are no finer than floats of 4 bytes, which have steps of " << step << " m at "
         << std::fixed << std::setprecision(0) << cloud.offset.cwiseAbs().maxCoeff()
         << " m: the shape is lost; keep them in 8 bytes, or take an offset off before";
    throw IoError(text.str());
  }
  cloud.table = std::move(raw.table);
  return cloud;
}

/// Add the points that the tools work on.
LoadedCloud
withPoints(LoadedCloud cloud)
{
  const VectorFields xyz = requireCoordinates(cloud.path, cloud.table);
  const auto normal = findVector(cloud.table, "normal_x", "normal_y", "normal_z");
  const Field* intensity = cloud.has_intensity ? findField(cloud.table, "intensity") : nullptr;
  const std::size_t count = pointCount(cloud.table);
  cloud.points = pcl::make_shared<pcl::PointCloud<pcl::PointXYZINormal>>();
  cloud.points->resize(count);
  cloud.points->is_dense = true;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* from = pointAt(cloud.table, i);
    pcl::PointXYZINormal& to = (*cloud.points)[i];
    const Eigen::Vector3d position = loadVector(from, xyz) - cloud.offset;
    to.getVector3fMap() = position.cast<float>();
    cloud.points->is_dense = cloud.points->is_dense && to.getVector3fMap().allFinite();
    if (normal)
      to.getNormalVector3fMap() = loadVector(from, *normal).cast<float>();
    if (intensity)
      to.intensity = static_cast<float>(loadValue(from + intensity->offset, intensity->datatype));
  }
  if (cloud.viewpoint)
    cloud.points->sensor_origin_.head<3>() = (*cloud.viewpoint - cloud.offset).cast<float>();
  return cloud;
}

/// A copy of \p table whose x, y, z have type \p datatype.
pcl::PCLPointCloud2
withCoordinateType(const pcl::PCLPointCloud2& table, std::uint8_t datatype)
{
  pcl::PCLPointCloud2 result;
  for (const Field& field : table.fields) {
    const bool is_coordinate = field.name == "x" || field.name == "y" || field.name == "z";
    addField(result, field.name, is_coordinate ? datatype : field.datatype, field.count);
  }
  const std::size_t count = pointCount(table);
  resizeTable(result, count);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint8_t* to = result.data.data() + i * result.point_step;
    for (std::size_t f = 0; f < table.fields.size(); ++f) {
      const Field& source = table.fields[f];
      const Field& target = result.fields[f];
      const std::uint8_t* from = pointAt(table, i) + source.offset;
      if (source.datatype == target.datatype)
        std::memcpy(to + target.offset, from, valueSize(source.datatype) * source.count);
      else
        storeValue(to + target.offset, target.datatype, loadValue(from, source.datatype));
    }
  }
  return result;
}

pcl::PCLPointCloud2
moveTable(const pcl::PCLPointCloud2& source, const Eigen::Isometry3d& T)
{
  const auto xyz = findVector(source, "x", "y", "z");
  const std::size_t count = pointCount(source);
  bool as_double = (*xyz)[0]->datatype == Field::FLOAT64;
  for (std::size_t i = 0; i < count && !as_double; ++i) {
    const Eigen::Vector3d moved = T * loadVector(pointAt(source, i), *xyz);
    as_double = moved.allFinite() && moved.cwiseAbs().maxCoeff() > kLargeCoordinate;
  }
  pcl::PCLPointCloud2 result = withCoordinateType(source, as_double ? Field::FLOAT64 : Field::FLOAT32);
  const auto moved_xyz = findVector(result, "x", "y", "z");
  const auto normal = findVector(result, "normal_x", "normal_y", "normal_z");
  for (std::size_t i = 0; i < count; ++i) {
    std::uint8_t* point = result.data.data() + i * result.point_step;
    storeVector(point, *moved_xyz, T * loadVector(pointAt(source, i), *xyz));
    if (normal)
      storeVector(point, *normal, T.linear() * loadVector(point, *normal));
  }
  return result;
}

ScanPoints
toScanPoints(const std::string& path, RawCloud raw)
{
  LoadedCloud cloud = describe(path, std::move(raw));
  const VectorFields xyz = requireCoordinates(path, cloud.table);
  const auto normal = findVector(cloud.table, "normal_x", "normal_y", "normal_z");
  ScanPoints points;
  points.size = pointCount(cloud.table);
  points.has_normals = cloud.has_normals;
  points.offset = cloud.offset;
  points.viewpoint = cloud.viewpoint;
  // In place: a point of the table takes as many bytes as its floats, or more.
  const std::size_t step = points.stride() * sizeof(float);
  for (std::size_t i = 0; i < points.size; ++i) {
    const std::uint8_t* from = pointAt(cloud.table, i);
    std::array<float, 6> floats{};
    Eigen::Map<Eigen::Vector3f>(floats.data()) = (loadVector(from, xyz) - cloud.offset).cast<float>();
    if (normal)
      Eigen::Map<Eigen::Vector3f>(floats.data() + 3) = loadVector(from, *normal).cast<float>();
    std::memcpy(cloud.table.data.data() + i * step, floats.data(), step);
  }
  points.bytes = std::move(cloud.table.data);
  points.bytes.resize(points.size * step);
  return points;
}

} // namespace

std::string
extensionOf(const std::string& scan)
{
  const std::string path = fileOfScan(scan);
  const std::size_t dot = path.find_last_of("./");
  if (dot == std::string::npos || path[dot] == '/')
    return {};
  std::string extension = path.substr(dot);
  std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  return extension;
}

const char*
readableFormats()
{
  return ".pcd .ply .csv .xyz .txt .asc .pts .ptx .3d .bin .las .e57";
}

bool
isReadableFormat(const std::string& path)
{
  return readerFor(path) != nullptr;
}

LoadedCloud
parseCloud(const std::string& path, std::string_view bytes)
{
  return withPoints(describe(path, requireReader(path).read(path, MemoryBytes(bytes), FieldChoice::kAll)));
}

LoadedCloud
loadTable(const std::string& path)
{
  return describe(path, readScan(path, FieldChoice::kAll));
}

LoadedCloud
loadCloud(const std::string& path)
{
  return withPoints(loadTable(path));
}

ScanPoints
loadScanPoints(const std::string& path)
{
  return toScanPoints(path, readScan(path, FieldChoice::kGeometry));
}

ScanPoints
parseScanPoints(const std::string& path, std::string_view bytes)
{
  return toScanPoints(path, requireReader(path).read(path, MemoryBytes(bytes), FieldChoice::kGeometry));
}

const char*
writableFormats()
{
  return ".pcd, .ply or .e57";
}

bool
isWritableFormat(const std::string& path)
{
  const std::string extension = extensionOf(path);
  return fileOfScan(path) == path && (extension == ".pcd" || extension == ".ply" || extension == kE57);
}

void
saveMovedCloud(const std::string& path,
               const LoadedCloud& cloud,
               const Eigen::Isometry3d& T_target_source,
               std::string_view pcd_comment)
{
  if (!isWritableFormat(path))
    throw IoError(path + ": unknown format, the extension must be " + writableFormats());
  if (extensionOf(path) == kE57) {
    E57Writer writer(path);
    const std::string file = fileOfScan(cloud.path);
    const std::string name = std::filesystem::path(file).stem().string() + cloud.path.substr(file.size());
    writer.addScan(name, cloud, T_target_source);
    return writer.finish();
  }
  const pcl::PCLPointCloud2 moved = moveTable(cloud.table, T_target_source);
  if (extensionOf(path) == ".ply")
    return writePly(path, moved);
  Eigen::Isometry3d sensor = T_target_source * Eigen::Translation3d(cloud.viewpoint.value_or(Eigen::Vector3d::Zero()));
  if (!cloud.viewpoint && !cloud.offset.isZero(0))
    sensor.translation().setZero(); // the origin of a map, where no sensor was: nothing is known
  writePcd(path, moved, sensor, pcd_comment);
}

} // namespace io
} // namespace pcl_ssfr
