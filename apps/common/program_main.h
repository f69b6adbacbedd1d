// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/common/usage_error.h>

#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace pcl_ssfr {
namespace apps {

/// Memory that is freed stays with the process: a registration asks for as much again at once, and the system clears
/// each page that it gives anew, which takes a sixth of the time of a pair. Either bound alone is slower than none.
inline void
keepFreedMemory()
{
#ifdef __GLIBC__
  constexpr int kLargestOfHeap = 32 << 20; // [bytes] the most that the GNU C library takes from the heap
  constexpr int kKept = 256 << 20;         // [bytes] of free heap
  if (mallopt(M_MMAP_THRESHOLD, kLargestOfHeap) != 0)
    mallopt(M_TRIM_THRESHOLD, kKept);
#endif
}

constexpr int kUsageExit = 2; ///< the command line is wrong
constexpr int kFilesExit = 3; ///< a file cannot be read or written, or memory ran out

/** \brief The main() of a program: \p run(arguments) gives the exit code; an exception becomes one line on standard
 * error, begun with \p name, and the code of its kind.
 */
template <typename Run>
int
runProgram(const std::string& name, int argc, char** argv, const Run& run)
{
  keepFreedMemory();
  try {
    return run(std::vector<std::string>(argv + 1, argv + argc));
  }
  catch (const UsageError& error) {
    std::cerr << name << ": " << error.what() << "; see " << name << " --help\n";
    return kUsageExit;
  }
  catch (const std::bad_alloc&) {
    std::cerr << name << ": out of memory\n";
  }
  catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << '\n';
  }
  return kFilesExit;
}

} // namespace apps
} // namespace pcl_ssfr
