// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// One reader under libFuzzer: any bytes load or give one line that says what is wrong with them. See scripts/fuzz.

#include <any_bytes.h>

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <stdexcept>

namespace {

/// Processor time that a short input may take, with the sanitizers: a stopped process is no finding, as it is with
/// libFuzzer's own limit, which is by the clock [s].
constexpr std::clock_t kLongest = 10;

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace pcl_ssfr::testing;
  const std::string name = "fuzz." PCL_SSFR_FUZZ_READER;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::clock_t start = std::clock();
  readAnyBytes(name, bytes);
  if (name == "fuzz.e57")
    readAnyBytes(name + "#1", repairE57(bytes));
  if (std::clock() - start > kLongest * CLOCKS_PER_SEC)
    throw std::logic_error(name + ": took too long");
  return 0;
}
