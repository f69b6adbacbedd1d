// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// One reader under libFuzzer: any bytes load or give one line that says what is wrong with them, in memory that the
// bytes justify. See scripts/fuzz.

#include <any_bytes.h>

#include <sanitizer/allocator_interface.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <stdexcept>

namespace {

/// Memory that a reader may take for each byte of a file, what the test makes of the points included. A point takes 48
/// bytes as PCL has them, besides its fields: a PLY file of bytes spends 3 on it. What formats pack more tightly than
/// that: an E57 record may take a byte, and 3 bytes of a compressed PCD file may stand for 264.
constexpr std::size_t
mostPerByte(std::string_view reader)
{
  return reader == "pcd" ? 1000 : reader == "e57" ? 250 : 64;
}
constexpr std::size_t kOwnMemory = 1U << 20; ///< of any file, blocks that are read at a time included [bytes]

std::atomic<std::ptrdiff_t> live{0}; ///< bytes allocated since the input was given
std::atomic<std::ptrdiff_t> peak{0};

void
onAllocation(const volatile void* /*at*/, std::size_t size)
{
  const std::ptrdiff_t now = live += static_cast<std::ptrdiff_t>(size);
  if (now > peak)
    peak = now;
}

void
onFree(const volatile void* at)
{
  if (at != nullptr)
    live -= static_cast<std::ptrdiff_t>(__sanitizer_get_allocated_size(at));
}

const int hooks = __sanitizer_install_malloc_and_free_hooks(onAllocation, onFree);

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
  live = peak = 0;
  readAnyBytes(name, bytes);
  if (name == "fuzz.e57")
    readAnyBytes(name + "#1", repairE57(bytes));
  if (std::clock() - start > kLongest * CLOCKS_PER_SEC)
    throw std::logic_error(name + ": took too long");
  const std::size_t most = kOwnMemory + mostPerByte(PCL_SSFR_FUZZ_READER) * size;
  if (hooks == 0 || static_cast<std::size_t>(peak) > most)
    throw std::logic_error(name + ": took " + std::to_string(peak) + " bytes of memory");
  return 0;
}
