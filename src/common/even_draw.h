// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <cstddef>
#include <vector>

namespace pcl_ssfr {

/// Of \p drawn ones that are drawn evenly from \p all things in their order, the place of number \p k, from 0: the
/// middle of the k-th of as many equal parts. 0 <= k < drawn <= all.
constexpr std::size_t
evenlyDrawn(std::size_t k, std::size_t drawn, std::size_t all)
{
  return (2 * k + 1) * all / (2 * drawn);
}

/// At most \p most of \p all, evenly drawn in their order.
template <typename T>
std::vector<T>
drawEvenly(std::vector<T> all, std::size_t most)
{
  if (all.size() <= most)
    return all;
  std::vector<T> drawn;
  for (std::size_t k = 0; k < most; ++k)
    drawn.push_back(all[evenlyDrawn(k, most, all.size())]);
  return drawn;
}

} // namespace pcl_ssfr
