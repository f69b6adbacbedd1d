// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/e57_pages.h>
#include <apps/io/e57_structure.h>

#include <cstdint>
#include <vector>

namespace pcl_ssfr {
namespace io {

constexpr std::size_t kE57SectionHeaderBytes = 32;
constexpr std::uint8_t kE57RecordSection = 1; ///< its first byte
enum E57Packet : std::uint8_t { kE57IndexPacket = 0, kE57DataPacket = 1, kE57IgnoredPacket = 2 };
constexpr std::size_t kE57PacketHeaderBytes = 4;
constexpr std::size_t kE57DataHeaderBytes = 6; ///< then two bytes a stream

/// Numbers of equal width one after the other, least significant bit first, which arrive piece by piece.
class E57BitStream {
public:
  explicit E57BitStream(unsigned width) : width_(width) {}
  void
  append(std::string_view bytes);
  /// Whole numbers that are there.
  std::uint64_t
  available() const
  {
    return (8 * bytes_.size() - at_) / width_;
  }
  /// Take the next number; there must be one.
  std::uint64_t
  next();

private:
  unsigned width_; ///< 1 to 64 [bits]
  std::string bytes_;
  std::size_t at_ = 0; ///< first bit that was not taken
};

/** \brief Goes through the records of a scan from packet to packet.
 *
 * The index of the section is not used: packets follow each other, and each is at least four bytes long, so that any
 * file comes to an end. Memory: a block of records, and what some streams are ahead of others.
 */
class E57RecordReader {
public:
  /** \brief Read and check the header of the section.
   * \param[in] wanted fields to decode, by their place in \p structure; what is not wanted is skipped
   * \throw IoError when the section is not whole or too short for its records
   */
  E57RecordReader(E57PageReader& pages, const E57Structure& structure, std::vector<std::size_t> wanted);

  /** \brief Decode the next records.
   * \param[out] columns the values of each wanted field
   * \return how many; 0 after the last \throw IoError when the section ends before
   */
  std::size_t
  next(std::vector<std::vector<double>>& columns);

private:
  void
  readPacket();
  void
  readDataPacket();
  IoError
  wrong(const std::string& message) const;

  E57PageReader& pages_;
  const E57Structure& structure_;
  std::vector<std::size_t> wanted_;
  std::vector<E57BitStream> streams_; ///< one for each wanted field; unused where a value takes no bits
  std::uint64_t at_ = 0;              ///< of the next packet, logical
  std::uint64_t end_ = 0;             ///< of the section, logical
  std::uint64_t left_ = 0;            ///< records
  std::string packet_;
};

} // namespace io
} // namespace pcl_ssfr
