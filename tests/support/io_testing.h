// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <any_bytes.h>

#include <apps/io/loaded_cloud.h>

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <random>
#include <string>

namespace pcl_ssfr {
namespace testing {

/// A folder that lives as long as the object.
class TemporaryFolder {
public:
  TemporaryFolder()
  {
    std::string pattern = (std::filesystem::temp_directory_path() / "pcl_ssfr_XXXXXX").string();
    if (!mkdtemp(pattern.data()))
      throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~TemporaryFolder()
  {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder&
  operator=(const TemporaryFolder&) = delete;

  std::string
  file(const std::string& name) const
  {
    return (std::filesystem::path(path_) / name).string();
  }

private:
  std::string path_;
};

/// What IoError says about a file with this content; a failure when it is accepted.
inline std::string
errorOf(const std::string& name, const std::string& bytes)
{
  try {
    io::parseCloud(name, bytes);
  }
  catch (const io::IoError& error) {
    return error.what();
  }
  ADD_FAILURE() << name << " was accepted";
  return {};
}

/// The bytes of a value as this machine stores it.
template <typename T>
std::string
bytesOf(T value)
{
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

/// Leaves bytes as they are.
inline std::string
asTheyAre(const std::string& bytes)
{
  return bytes;
}

/** \brief Change, drop, double and cut bytes of a good file \p rounds times: each result must load or throw an IoError
 * of one line that names the file. Numbers that hostile headers hold are among the replacements. The same every time.
 * \param[in] finish makes the changed bytes a file, as by a checksum
 */
inline void
fuzz(const std::string& name,
     const std::string& good,
     int rounds,
     unsigned seed = 1,
     const std::function<std::string(const std::string&)>& finish = asTheyAre)
{
  static const std::string kNasty[] = {"-1",
                                       "4000000000",
                                       "99999999999999999999",
                                       "nan",
                                       "1e999",
                                       "x",
                                       "",
                                       " ",
                                       "\n",
                                       "\r",
                                       std::string(1, '\0'),
                                       "0",
                                       "\xff\xff\xff\xff",
                                       "\xff\xff\xff\x7f",
                                       "2147483648"};
  std::mt19937 random(seed); // operator() is specified bit by bit, distributions are not
  const auto below = [&random](std::size_t n) { return n == 0 ? 0 : random() % n; };
  int accepted = 0;
  for (int round = 0; round < rounds; ++round) {
    std::string bytes = good;
    // Half of the changes hit the first bytes, where the headers are.
    for (std::size_t change = 1 + below(3); change > 0; --change) {
      const std::size_t range = below(2) == 0 ? std::min<std::size_t>(bytes.size(), 400) : bytes.size();
      const std::size_t at = below(range);
      switch (below(5)) {
      case 0:
        if (!bytes.empty())
          bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes.erase(at, 1 + below(8));
        break;
      case 2:
        bytes.insert(at, kNasty[below(std::size(kNasty))]);
        break;
      case 3: {
        const std::string& nasty = kNasty[below(std::size(kNasty))];
        bytes.replace(at, std::min(bytes.size() - at, nasty.size()), nasty);
        break;
      }
      default:
        bytes.resize(at);
      }
    }
    bytes = finish(bytes);
    std::string message;
    ASSERT_NO_THROW(message = readAnyBytes(name, bytes)) << "round " << round;
    accepted += message.empty() ? 1 : 0;
  }
  // A loop that only sees errors of the first line would show nothing.
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, rounds);
}

} // namespace testing
} // namespace pcl_ssfr
