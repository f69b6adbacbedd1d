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

namespace pcl_ssfr {
namespace io {

namespace {

using Field = pcl::PCLPointField;
using VectorFields = std::array<const Field*, 3>;

constexpr const char* kE57 = ".e57";

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

using Reader = RawCloud (*)(const std::string& path, std::string_view bytes);

/// The reader for the extension of \p path, null when there is none.
Reader
readerFor(const std::string& path)
{
  struct Entry {
    const char* extension;
    Reader reader;
  };
  static constexpr Entry kReaders[] = {{".pcd", readPcd},
                                       {".ply", readPly},
                                       {".csv", readTextTable},
                                       {".xyz", readTextTable},
                                       {".txt", readTextTable},
                                       {".asc", readTextTable},
                                       {".pts", readTextTable},
                                       {".ptx", readPtx},
                                       {".3d", readThreedtk},
                                       {".bin", readKitti},
                                       {".las", readLas},
                                       {".laz", readLas},
                                       {kE57, readE57}};
  const std::string extension = extensionOf(path);
  for (const Entry& entry : kReaders)
    if (extension == entry.extension)
      return entry.reader;
  return nullptr;
}

Reader
requireReader(const std::string& path)
{
  const Reader reader = readerFor(path);
  if (!reader)
    throw IoError(path + ": unknown format, the extension must be one of " + readableFormats());
  return reader;
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

/// Turn the whole content of a file into what the tools work on.
LoadedCloud
finish(const std::string& path, RawCloud raw)
{
  LoadedCloud cloud;
  cloud.path = path;
  cloud.viewpoint = raw.viewpoint;
  cloud.T_file_scan = raw.T_file_scan;
  cloud.table = std::move(raw.table);
  const auto xyz = findVector(cloud.table, "x", "y", "z");
  if (!xyz)
    throw IoError(path + ": has no coordinates x, y, z");
  const auto normal = findVector(cloud.table, "normal_x", "normal_y", "normal_z");
  const Field* intensity = findField(cloud.table, "intensity");
  cloud.has_normals = normal.has_value();
  cloud.has_intensity = intensity && intensity->count == 1;
  const std::size_t count = pointCount(cloud.table);
  cloud.offset = chooseOffset(count, [&](std::size_t i) { return loadVector(pointAt(cloud.table, i), *xyz); });

  cloud.points = pcl::make_shared<pcl::PointCloud<pcl::PointXYZINormal>>();
  cloud.points->resize(count);
  cloud.points->is_dense = true;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* from = pointAt(cloud.table, i);
    pcl::PointXYZINormal& to = (*cloud.points)[i];
    const Eigen::Vector3d position = loadVector(from, *xyz) - cloud.offset;
    to.getVector3fMap() = position.cast<float>();
    cloud.points->is_dense = cloud.points->is_dense && to.getVector3fMap().allFinite();
    if (normal)
      to.getNormalVector3fMap() = loadVector(from, *normal).cast<float>();
    if (cloud.has_intensity)
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

} // namespace

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
  const Reader reader = requireReader(path);
  if (bytes.empty())
    throw IoError(path + ": is empty");
  return finish(path, reader(path, bytes));
}

LoadedCloud
loadCloud(const std::string& path)
{
  requireReader(path);
  if (extensionOf(path) == kE57) {
    const FileBytes source(fileOfScan(path));
    if (source.size() == 0)
      throw IoError(path + ": is empty");
    return finish(path, readE57(path, source));
  }
  const std::string bytes = readFile(path);
  return parseCloud(path, bytes);
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
saveMovedCloud(const std::string& path, const LoadedCloud& cloud, const Eigen::Isometry3d& T_target_source)
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
  const Eigen::Isometry3d sensor =
      T_target_source * Eigen::Translation3d(cloud.viewpoint.value_or(Eigen::Vector3d::Zero()));
  writePcd(path, moved, sensor);
}

} // namespace io
} // namespace pcl_ssfr
