// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/result.h>

#include <Eigen/Geometry>

namespace pcl_ssfr {
namespace apps {

/// A pose between clouds that an offset was taken off from a pose between files, and back.
class FileFrames {
public:
  /// \param[in] source,target the origins of the clouds, in file coordinates [m]
  FileFrames(const Eigen::Vector3d& source, const Eigen::Vector3d& target) : source_(source), target_(target) {}

  /// The pose between the clouds.
  Eigen::Isometry3d
  toClouds(const Eigen::Isometry3d& T_files) const
  {
    return Eigen::Translation3d(-target_) * T_files * Eigen::Translation3d(source_);
  }

  /// The pose between the files.
  Eigen::Isometry3d
  toFiles(const Eigen::Isometry3d& T_clouds) const
  {
    return Eigen::Translation3d(target_) * T_clouds * Eigen::Translation3d(-source_);
  }

  /// All poses and places of a result, and its information matrix, which is about the origin of the target.
  Result
  toFiles(Result result) const
  {
    result.T_target_source = toFiles(result.T_target_source);
    for (Candidate& candidate : result.candidates)
      candidate.T_target_source = toFiles(candidate.T_target_source);
    // A motion (w, v) about the file's origin is (w, v + w x offset) about the offset.
    Eigen::Matrix<double, 6, 6> shift = Eigen::Matrix<double, 6, 6>::Identity();
    shift.bottomLeftCorner<3, 3>() << 0, target_.z(), -target_.y(), -target_.z(), 0, target_.x(), target_.y(),
        -target_.x(), 0;
    result.information = shift.transpose() * result.information * shift;
    if (result.source_viewpoint_used)
      result.source_viewpoint += source_;
    if (result.target_viewpoint_used)
      result.target_viewpoint += target_;
    return result;
  }

private:
  Eigen::Vector3d source_;
  Eigen::Vector3d target_;
};

} // namespace apps
} // namespace pcl_ssfr
