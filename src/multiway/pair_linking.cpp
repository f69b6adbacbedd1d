// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/multiway/pair_linking.h>

#include "multiway/scan_pair.h"

#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace pcl_ssfr {

namespace {

constexpr std::uint32_t kTasks = 0x31545353; // "SST1": what the bytes hold, in which format
constexpr std::uint32_t kLinks = 0x314c5353; // "SSL1"

/// Values one after another, as they are in memory.
class ByteWriter {
public:
  template <typename T>
  void
  add(const T& value)
  {
    static_assert(std::is_arithmetic_v<T>, "only numbers have the same bytes everywhere");
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  template <typename Matrix>
  void
  addMatrix(const Matrix& m)
  {
    bytes_.append(reinterpret_cast<const char*>(m.data()), sizeof(double) * static_cast<std::size_t>(m.size()));
  }
  void
  addText(const std::string& text)
  {
    add(static_cast<std::uint64_t>(text.size()));
    bytes_ += text;
  }
  std::string
  take()
  {
    return std::move(bytes_);
  }

private:
  std::string bytes_;
};

class ByteReader {
public:
  explicit ByteReader(const std::string& bytes) : bytes_(bytes) {}

  template <typename T>
  T
  get()
  {
    T value{};
    std::memcpy(&value, next(sizeof(value)), sizeof(value));
    return value;
  }
  template <typename Matrix>
  void
  getMatrix(Matrix& m)
  {
    const std::size_t size = sizeof(double) * static_cast<std::size_t>(m.size());
    std::memcpy(m.data(), next(size), size);
  }
  std::string
  getText()
  {
    const auto size = get<std::uint64_t>();
    return {next(size), static_cast<std::size_t>(size)};
  }
  /// Read so many items by \p read. \throw std::runtime_error also when something is left behind them
  template <typename Read>
  void
  forEach(std::uint32_t format, const Read& read)
  {
    if (get<std::uint32_t>() != format)
      fail();
    for (auto count = get<std::uint64_t>(); count > 0; --count)
      read();
    if (at_ != bytes_.size())
      fail();
  }
  [[noreturn]] static void
  fail()
  {
    throw std::runtime_error("a message between processes is damaged, or of another version");
  }

private:
  const char*
  next(std::uint64_t size)
  {
    if (size > bytes_.size() - at_)
      fail();
    const char* begin = bytes_.data() + at_;
    at_ += static_cast<std::size_t>(size);
    return begin;
  }

  const std::string& bytes_;
  std::size_t at_ = 0;
};

PairHypothesis
readHypothesis(ByteReader& in)
{
  PairHypothesis h;
  for (double* value : {&h.probability, &h.score, &h.overlap, &h.contradiction, &h.rmse})
    *value = in.get<double>();
  in.getMatrix(h.T_target_source.matrix());
  in.getMatrix(h.information);
  return h;
}

/// FNV-1a (Fowler, Noll, Vo), eight bytes at a time; a product takes bits upwards only, so what is at the top, such as
/// signs of coordinates, is brought down each time.
std::uint64_t
hashedWith(std::uint64_t hash, std::uint64_t value)
{
  hash = (hash ^ value) * 0x100000001b3u;
  return hash ^ (hash >> 32);
}

std::uint64_t
hashedWith(std::uint64_t hash, const Eigen::Vector3f& p)
{
  std::uint32_t bits[3];
  std::memcpy(bits, p.data(), sizeof(bits));
  return hashedWith(hashedWith(hash, bits[0] | static_cast<std::uint64_t>(bits[1]) << 32), bits[2]);
}

} // namespace

PairLink
linkPair(const PairTask& task, const PreparedScan& source, const PreparedScan& target, const MultiwayOptions& options)
{
  PairLink link = linkScans(source, target, options, task.guess);
  link.source = task.source;
  link.target = task.target;
  return link;
}

std::uint64_t
hashOfPoints(const ScanView& scan)
{
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (std::size_t i = 0; i < scan.count(); ++i)
    hash = hashedWith(hash, scan.point(i));
  return hashedWith(hash, scan.count());
}

std::uint64_t
hashOfScan(const ScanView& scan)
{
  return hashOfScan(scan, hashOfPoints(scan));
}

std::uint64_t
hashOfScan(const ScanView& scan, std::uint64_t points)
{
  std::uint64_t hash = hashedWith(points, scan.viewpoint_is_known ? 1 : 0);
  for (const double coordinate : scan.viewpoint) {
    const double value = coordinate + 0.0; // one zero
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    hash = hashedWith(hash, bits);
  }
  // Given normals say which side of a patch was seen where the sensor is not known.
  for (std::size_t i = 0; scan.normals && i < scan.count(); ++i)
    hash = hashedWith(hash, scan.normal(i));
  return hash;
}

std::string
toBytes(const std::vector<PairTask>& tasks)
{
  ByteWriter out;
  out.add(kTasks);
  out.add(static_cast<std::uint64_t>(tasks.size()));
  for (const PairTask& task : tasks) {
    out.add(static_cast<std::int32_t>(task.source));
    out.add(static_cast<std::int32_t>(task.target));
    out.add(task.source_hash);
    out.add(task.target_hash);
    out.add(static_cast<std::uint8_t>(task.guess ? 1 : 0));
    if (task.guess) {
      out.addMatrix(task.guess->T_target_source.matrix());
      out.add(task.guess->tolerance.rotation);
      out.add(task.guess->tolerance.translation);
    }
  }
  return out.take();
}

std::vector<PairTask>
tasksFromBytes(const std::string& bytes)
{
  std::vector<PairTask> tasks;
  ByteReader in(bytes);
  in.forEach(kTasks, [&] {
    PairTask task;
    task.source = in.get<std::int32_t>();
    task.target = in.get<std::int32_t>();
    task.source_hash = in.get<std::uint64_t>();
    task.target_hash = in.get<std::uint64_t>();
    if (in.get<std::uint8_t>() != 0) {
      task.guess.emplace();
      in.getMatrix(task.guess->T_target_source.matrix());
      task.guess->tolerance.rotation = in.get<double>();
      task.guess->tolerance.translation = in.get<double>();
    }
    tasks.push_back(std::move(task));
  });
  return tasks;
}

std::string
toBytes(const std::vector<PairLink>& links)
{
  ByteWriter out;
  out.add(kLinks);
  out.add(static_cast<std::uint64_t>(links.size()));
  for (const PairLink& link : links) {
    for (const int value : {link.source, link.target, static_cast<int>(link.status)})
      out.add(static_cast<std::int32_t>(value));
    out.addText(link.message);
    for (const double value : {link.confidence, link.probability_of_none, link.seconds})
      out.add(value);
    out.add(static_cast<std::uint64_t>(link.hypotheses.size()));
    for (const PairHypothesis& h : link.hypotheses) {
      for (const double value : {h.probability, h.score, h.overlap, h.contradiction, h.rmse})
        out.add(value);
      out.addMatrix(h.T_target_source.matrix());
      out.addMatrix(h.information);
    }
  }
  return out.take();
}

std::vector<PairLink>
linksFromBytes(const std::string& bytes)
{
  std::vector<PairLink> links;
  ByteReader in(bytes);
  in.forEach(kLinks, [&] {
    PairLink link;
    link.source = in.get<std::int32_t>();
    link.target = in.get<std::int32_t>();
    link.status = static_cast<Status>(in.get<std::int32_t>());
    link.message = in.getText();
    for (double* value : {&link.confidence, &link.probability_of_none, &link.seconds})
      *value = in.get<double>();
    for (auto count = in.get<std::uint64_t>(); count > 0; --count)
      link.hypotheses.push_back(readHypothesis(in));
    links.push_back(std::move(link));
  });
  return links;
}

} // namespace pcl_ssfr
