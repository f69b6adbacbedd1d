// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/patch_config.h>

#include <string_view>
#include <vector>

namespace pcl_ssfr {

/// Values that a number may have.
enum class NumberBound {
  Finite,
  NotNegative,
  Positive,
  AtLeastOne,
  AtLeastThree, ///< what a plane takes
  Level,        ///< of the octree of a scan, [0, kMortonBits - 1)
  Share,        ///< [0, 1]
  OpenShare,    ///< (0, 1)
  Chord,        ///< of the unit sphere, (0, 1]
  RightAngle    ///< (0, pi/2]
};

/// What a number is multiplied by for a scene, see METHOD, "Scale".
enum class NumberScaling {
  None,
  Scene,  ///< a length [m]
  Matches ///< a distance of matches [m]: noisy scans match from farther away
};

/// A number of a PatchProfileConfig: its name, "group.field", and where it is.
struct ConfigNumber {
  ConfigNumber(const char* its_name,
               double& its_value,
               NumberBound its_bound,
               NumberScaling its_scaling = NumberScaling::None)
      : name(its_name), bound(its_bound), scaling(its_scaling), real(&its_value)
  {}
  ConfigNumber(const char* its_name, int& its_value, NumberBound its_bound)
      : name(its_name), bound(its_bound), count(&its_value)
  {}

  double
  value() const
  {
    return real ? *real : *count;
  }

  std::string_view name; ///< of static storage
  NumberBound bound;
  NumberScaling scaling = NumberScaling::None;
  double* real = nullptr; ///< one of them
  int* count = nullptr;
};

/// All numbers of \p config, in the order of their definition; they point into it.
std::vector<ConfigNumber>
numbersOf(PatchProfileConfig& config);

/** \brief The numbers for a pair of scenes of scale \p scale > 0: every length multiplied by it, distances of matches
 * by \p noise >= 1 besides. Those of the preparation are, too; a scan is prepared with scaled() of patch_config.h.
 */
PatchProfileConfig
scaledForPair(const PatchProfileConfig& config, double scale, double noise);

/// Whether all numbers of the preparation are the same.
bool
isSamePreparation(const PatchProfileConfig& a, const PatchProfileConfig& b);

} // namespace pcl_ssfr
