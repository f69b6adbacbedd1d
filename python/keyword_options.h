// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/options.h>

#include <pybind11/pybind11.h>

namespace pcl_ssfr {
namespace python {

/** \brief Options from keywords by the names of the library; angles in degrees, as on the outside of all programs.
 *
 * The names are those of keywordsOf(), and "numbers": a dict of the tuned numbers of the default profile by their names
 * (numberNames()).
 * \param[in] keywords needs the interpreter
 * \param[in] base what is not named; replaced by that of the profile where another one is named
 * \throw std::invalid_argument that names the keyword and its value; of the library where the value is out of range
 */
Options
optionsFrom(const pybind11::dict& keywords, const Options& base);

/** \brief Options of a preparation from keywords, as optionsFrom().
 * \throw std::invalid_argument also for a keyword that only a search reads
 */
Options
preparationOptionsFrom(const pybind11::dict& keywords);

/// Whether all tuned numbers are the same.
bool
haveSameNumbers(const Options& a, const Options& b);

/// The options as keywords, but "numbers".
pybind11::dict
keywordsOf(const Options& options);

/// All entries of "numbers" with their defaults, in the order of their definition.
pybind11::dict
defaultNumbers();

} // namespace python
} // namespace pcl_ssfr
