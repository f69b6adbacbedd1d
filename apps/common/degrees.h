// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/angles.h"

namespace pcl_ssfr {

constexpr double kDegreesPerRadian = 180 / kPi; ///< one radian [deg]: people read degrees, the library knows radians

} // namespace pcl_ssfr
