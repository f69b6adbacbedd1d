// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/link_settings.h"

#include "common/config_numbers.h"
#include "multiway/scan_pair.h"

#include <pcl_ssfr/version.h>

#include <cstddef>
#include <cstdio>
#include <string_view>
#include <utility>
#include <vector>

namespace pcl_ssfr {

namespace {

/// Numbers that read back to the same bits.
class NumberText {
public:
  explicit NumberText(std::string text) : text_(std::move(text)) {}

  void
  add(double value)
  {
    char number[32];
    std::snprintf(number, sizeof(number), " %.17g", value);
    text_ += number;
  }
  template <typename Matrix>
  void
  addAll(const Matrix& m)
  {
    for (Eigen::Index i = 0; i < m.size(); ++i)
      add(m.data()[i]);
  }
  void
  addName(std::string_view name)
  {
    text_.append(1, ' ').append(name);
  }
  const std::string&
  text() const
  {
    return text_;
  }

private:
  std::string text_;
};

} // namespace

std::string
settingsOf(const MultiwayOptions& options)
{
  NumberText settings(PCL_SSFR_VERSION);
  Options r = pairOptions(options);
  settings.add(static_cast<double>(r.profile));
  settings.add(static_cast<double>(r.viewpoint_mode));
  for (const double value :
       {r.normal_radius, r.density_radius, r.leaf, r.bin_width, r.overlap_radius, r.min_confidence})
    settings.add(value);
  settings.add(r.refine ? 1 : 0);
  settings.add(r.max_refinement_steps);
  settings.add(r.max_candidates);
  PatchProfileConfig standard;
  const std::vector<ConfigNumber> given = numbersOf(r.patch_profile), usual = numbersOf(standard);
  for (std::size_t i = 0; i < given.size(); ++i)
    if (given[i].value() != usual[i].value()) {
      settings.addName(given[i].name);
      settings.add(given[i].value());
    }
  settings.add(options.link.hypotheses);
  settings.add(options.link.least_probability);
  if (r.gravity) {
    settings.addAll(r.gravity->up_source);
    settings.addAll(r.gravity->up_target);
    settings.add(r.gravity->tolerance);
  }
  return settings.text();
}

std::string
withGuess(const std::string& settings, const std::optional<PairGuess>& guess)
{
  if (!guess)
    return settings;
  NumberText text(settings);
  text.addAll(guess->T_target_source.matrix());
  text.add(guess->tolerance.rotation);
  text.add(guess->tolerance.translation);
  return text.text();
}

} // namespace pcl_ssfr
