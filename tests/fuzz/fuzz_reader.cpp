// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// One reader under libFuzzer: any bytes load or give one line that says what is wrong with them. See scripts/fuzz.

#include <any_bytes.h>

#include <cstddef>
#include <cstdint>

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace pcl_ssfr::testing;
  const std::string name = "fuzz." PCL_SSFR_FUZZ_READER;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  readAnyBytes(name, bytes);
  if (name == "fuzz.e57")
    readAnyBytes(name + "#1", repairE57(bytes));
  return 0;
}
