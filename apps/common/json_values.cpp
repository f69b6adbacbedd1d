// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/json_values.h>

#include <cmath>

namespace pcl_ssfr {
namespace apps {

nlohmann::ordered_json
numberOrNull(double value)
{
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json
vectorJson(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
}

nlohmann::ordered_json
matrixJson(const Eigen::Isometry3d& T)
{
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (Eigen::Index row = 0; row < 4; ++row) {
    nlohmann::ordered_json values = nlohmann::ordered_json::array();
    for (Eigen::Index column = 0; column < 4; ++column)
      values.push_back(numberOrNull(T.matrix()(row, column)));
    rows.push_back(values);
  }
  return rows;
}

} // namespace apps
} // namespace pcl_ssfr
