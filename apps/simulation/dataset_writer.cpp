// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/dataset_writer.h>

#include <apps/common/degrees.h>
#include <apps/io/io_error.h>

#include <csignal>
#include <fcntl.h>
#include <pthread.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iomanip>
#include <locale>
#include <mutex>
#include <optional>
#include <sstream>
#include <thread>

namespace pcl_ssfr::simulation {

namespace {

namespace fs = std::filesystem;

using io::IoError;

constexpr const char* kScans = "scans";
constexpr const char* kPairs = "pairs.csv";
constexpr const char* kPoses = "poses.txt";
constexpr const char* kDescription = "dataset.json";
constexpr int kDigits = 17; // read back to the same bits

std::string
systemMessage(int error)
{
  return std::strerror(error);
}

// ---------------------------------------------------------------------------------------------------------------------
// Files

/// A new file whose every byte has reached the disk once finish() returns.
class OutputFile {
public:
  /// \param[in] path where it is written \param[in] name what messages call it
  OutputFile(const fs::path& path, std::string name) : file_(std::fopen(path.c_str(), "wb")), name_(std::move(name))
  {
    if (!file_)
      throw IoError(name_ + ": cannot be created: " + systemMessage(errno));
  }
  ~OutputFile()
  {
    if (file_)
      std::fclose(file_);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile&
  operator=(const OutputFile&) = delete;

  void
  write(std::string_view bytes)
  {
    check(std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size());
    size_ += bytes.size();
  }
  std::size_t
  finish()
  {
    check(std::fflush(file_) == 0 && fsync(fileno(file_)) == 0);
    std::FILE* file = file_;
    file_ = nullptr;
    check(std::fclose(file) == 0);
    return size_;
  }

private:
  void
  check(bool good) const
  {
    if (!good)
      throw IoError(name_ + ": cannot be written: " + systemMessage(errno));
  }

  std::FILE* file_;
  std::string name_;
  std::size_t size_ = 0;
};

/// Flush the entries of a folder; what a file system cannot do here is not an error.
void
flushFolder(const fs::path& folder)
{
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (descriptor < 0)
    return;
  fsync(descriptor);
  close(descriptor);
}

// ---------------------------------------------------------------------------------------------------------------------
// Folders

/// The name of what an existing folder holds besides a dataset as it is written here; nothing when it is one.
std::optional<std::string>
foreignEntry(const fs::path& folder)
{
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool regular = entry.symlink_status().type() == fs::file_type::regular;
    if (regular && (name == kPairs || name == kPoses || name == kDescription))
      continue;
    if (name != kScans || entry.symlink_status().type() != fs::file_type::directory)
      return name;
    for (const auto& scan : fs::directory_iterator(entry.path()))
      if (scan.path().extension() != ".pcd" || scan.symlink_status().type() != fs::file_type::regular)
        return (fs::path(kScans) / scan.path().filename()).string();
  }
  return fs::exists(folder / kDescription) ? std::nullopt : std::optional<std::string>("no dataset.json");
}

/// Throws unless \p folder is free, empty, or a dataset that may be replaced.
void
checkTarget(const fs::path& folder, bool overwrite)
{
  const auto status = fs::status(folder);
  if (!fs::exists(status))
    return;
  if (!fs::is_directory(status))
    throw IoError(folder.string() + ": is not a folder");
  if (fs::is_empty(folder))
    return;
  if (!overwrite)
    throw IoError(folder.string() + ": exists and is not empty; --overwrite replaces a dataset");
  if (const auto foreign = foreignEntry(folder))
    throw IoError(folder.string() +
                  ": is not replaced, it holds more or other things than a dataset: " + io::inQuotes(*foreign));
}

/// Makes a folder and those above it, and can take back those that it made.
class NewFolders {
public:
  void
  make(const fs::path& folder)
  {
    std::vector<fs::path> missing;
    for (fs::path path = folder; !path.empty() && !fs::exists(path); path = path.parent_path())
      missing.push_back(path);
    for (auto path = missing.rbegin(); path != missing.rend(); ++path)
      if (fs::create_directory(*path))
        made_.push_back(*path);
  }
  /// Remove what was made, as far as it is empty.
  void
  undo()
  {
    std::error_code ignored;
    for (auto path = made_.rbegin(); path != made_.rend(); ++path)
      fs::remove(*path, ignored);
    made_.clear();
  }

private:
  std::vector<fs::path> made_;
};

/// A folder "PATH.SUFFIX-n" that did not exist.
fs::path
makeSibling(const fs::path& path, const std::string& suffix)
{
  constexpr int kAttempts = 100;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    fs::path sibling = path;
    sibling += "." + suffix + "-" + std::to_string(getpid()) + (attempt ? "-" + std::to_string(attempt) : "");
    if (fs::create_directory(sibling))
      return sibling;
  }
  throw IoError(path.string() + ": no free name for a temporary folder next to it");
}

// ---------------------------------------------------------------------------------------------------------------------

/** \brief Runs a clean-up when the process is asked to stop, then lets it stop.
 *
 * The signals are blocked in the thread that makes the object and in all that it starts; a thread waits for them.
 * Signals that are ignored already (nohup, background jobs) stay ignored.
 */
class StopWatcher {
public:
  template <typename CleanUp>
  explicit StopWatcher(CleanUp clean_up)
  {
    sigemptyset(&signals_);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
      struct sigaction action = {};
      if (sigaction(number, nullptr, &action) == 0 && action.sa_handler == SIG_DFL)
        sigaddset(&signals_, number);
    }
    // Writing past a limit on the size of files shall be an error like a full disk.
    old_size_handler_ = signal(SIGXFSZ, SIG_IGN);
    // The signal that ends the thread is among them even when nothing else is waited for.
    sigaddset(&signals_, SIGUSR2);
    pthread_sigmask(SIG_BLOCK, &signals_, &old_mask_);
    thread_ = std::thread([this, clean_up] {
      int number = 0;
      while (sigwait(&signals_, &number) != 0 || (number == SIGUSR2 && !stop_)) {
      }
      if (stop_)
        return;
      clean_up();
      sigset_t one;
      sigemptyset(&one);
      sigaddset(&one, number);
      pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
      raise(number);
    });
  }
  ~StopWatcher()
  {
    stop_ = true;
    pthread_kill(thread_.native_handle(), SIGUSR2);
    thread_.join();
    pthread_sigmask(SIG_SETMASK, &old_mask_, nullptr);
    signal(SIGXFSZ, old_size_handler_);
  }
  StopWatcher(const StopWatcher&) = delete;
  StopWatcher&
  operator=(const StopWatcher&) = delete;

private:
  sigset_t signals_{};
  sigset_t old_mask_{};
  void (*old_size_handler_)(int) = SIG_DFL;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

std::ostringstream
makeStream()
{
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream << std::setprecision(kDigits);
  return stream;
}

std::string
formatPairs(const std::vector<std::string>& names, const std::vector<DatasetPair>& pairs)
{
  auto text = makeStream();
  text << "source,target";
  for (int i = 0; i < 16; ++i)
    text << ",T" << i / 4 << i % 4;
  text << ",overlap,rotation_deg,translation_m\n";
  for (const DatasetPair& pair : pairs) {
    text << names.at(pair.source) << ',' << names.at(pair.target);
    for (Eigen::Index i = 0; i < 16; ++i)
      text << ',' << pair.T_target_source.matrix()(i / 4, i % 4);
    const double angle = Eigen::AngleAxisd(pair.T_target_source.linear()).angle();
    text << std::setprecision(6) << ',' << pair.overlap << ',' << angle * kDegreesPerRadian << ','
         << pair.T_target_source.translation().norm() << std::setprecision(kDigits) << '\n';
  }
  return text.str();
}

std::string
formatPoses(const std::vector<std::string>& names, const std::vector<Eigen::Isometry3d>& poses)
{
  auto text = makeStream();
  text << "# scan tx ty tz qx qy qz qw (world from scan, metres)\n";
  for (std::size_t i = 0; i < names.size(); ++i) {
    Eigen::Quaterniond q(poses[i].linear());
    q.normalize();
    if (q.w() < 0)
      q.coeffs() *= -1;
    text << names[i];
    for (Eigen::Index k = 0; k < 3; ++k)
      text << ' ' << poses[i].translation()[k];
    for (Eigen::Index k = 0; k < 4; ++k)
      text << ' ' << q.coeffs()[k];
    text << '\n';
  }
  return text.str();
}

} // namespace

fs::path
resolvedFolder(const std::string& name, std::error_code& error)
{
  const fs::path absolute = fs::absolute(name, error);
  const fs::path path = error ? fs::path() : fs::weakly_canonical(absolute / "", error);
  return path.has_filename() ? path : path.parent_path();
}

struct DatasetWriter::Impl {
  Impl(const std::string& folder, bool overwrite_) : overwrite(overwrite_)
  {
    if (folder.empty())
      throw IoError("'': is not the name of a folder");
    shown = folder;
    try {
      std::error_code error;
      target = resolvedFolder(folder, error);
      if (error)
        throw IoError(shown.string() + ": cannot be made: " + error.message());
      checkTarget(target, overwrite);
      above.make(target.parent_path());
      partial = makeSibling(target, "partial");
      fs::create_directory(partial / kScans);
      watcher.emplace([this] {
        mutex.lock(); // for good: nothing is written any more
        remove();
      });
    }
    catch (const fs::filesystem_error& error) {
      remove();
      throw IoError(shown.string() + ": cannot be made: " + error.code().message());
    }
    catch (...) {
      remove();
      throw;
    }
  }
  ~Impl()
  {
    const std::lock_guard<std::mutex> lock(mutex);
    remove();
  }

  void
  remove()
  {
    std::error_code ignored;
    if (!partial.empty())
      fs::remove_all(partial, ignored);
    partial.clear();
    above.undo();
  }

  void
  writeFile(const fs::path& name, std::string_view content)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    OutputFile file(partial / name, (shown / name).string());
    file.write(content);
    bytes += file.finish();
  }

  void
  commit()
  {
    checkTarget(target, overwrite); // it may have been made meanwhile
    for (const fs::path& folder : {partial / kScans, partial})
      flushFolder(folder);
    fs::path old;
    if (fs::exists(target) && !fs::is_empty(target)) {
      old = makeSibling(target, "replaced");
      fs::rename(target, old);
    }
    try {
      fs::rename(partial, target);
    }
    catch (const fs::filesystem_error&) {
      std::error_code ignored;
      if (!old.empty())
        fs::rename(old, target, ignored);
      throw;
    }
    flushFolder(target.parent_path());
    partial.clear();
    above = {};
    std::error_code ignored;
    if (!old.empty())
      fs::remove_all(old, ignored);
  }

  fs::path shown;   ///< as the user calls it
  fs::path target;  ///< absolute
  fs::path partial; ///< empty when there is none (any more)
  bool overwrite;
  NewFolders above;
  std::size_t bytes = 0;
  std::mutex mutex; ///< held by whoever writes or cleans up
  std::optional<StopWatcher> watcher;
};

DatasetWriter::DatasetWriter(const std::string& folder, bool overwrite)
    : impl_(std::make_unique<Impl>(folder, overwrite))
{}

DatasetWriter::~DatasetWriter()
{
  impl_->watcher.reset();
}

void
DatasetWriter::writeScan(const std::string& name,
                         const std::vector<Eigen::Vector3f>& points,
                         const std::vector<float>& intensity)
{
  if (points.size() != intensity.size())
    throw IoError(name + ": " + std::to_string(intensity.size()) + " intensities for " + std::to_string(points.size()) +
                  " points");
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  OutputFile file(impl_->partial / kScans / name, (impl_->shown / kScans / name).string());
  const std::string count = std::to_string(points.size());
  file.write("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\n"
             "TYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " +
             count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n");
  constexpr std::size_t kBlock = 1 << 16; // points
  std::vector<std::array<float, 4>> block;
  block.reserve(std::min(kBlock, points.size()));
  for (std::size_t begin = 0; begin < points.size(); begin += kBlock) {
    block.clear();
    for (std::size_t i = begin; i < std::min(begin + kBlock, points.size()); ++i)
      block.push_back({points[i].x(), points[i].y(), points[i].z(), intensity[i]});
    file.write({reinterpret_cast<const char*>(block.data()), block.size() * sizeof(block[0])});
  }
  impl_->bytes += file.finish();
}

void
DatasetWriter::writeTruth(const std::vector<std::string>& names,
                          const std::vector<Eigen::Isometry3d>& T_world_scan,
                          const std::vector<DatasetPair>& pairs)
{
  if (names.size() != T_world_scan.size())
    throw IoError(std::string(kPoses) + ": " + std::to_string(T_world_scan.size()) + " poses for " +
                  std::to_string(names.size()) + " scans");
  impl_->writeFile(kPoses, formatPoses(names, T_world_scan));
  impl_->writeFile(kPairs, formatPairs(names, pairs));
}

void
DatasetWriter::writeDescription(std::string_view json)
{
  impl_->writeFile(kDescription, json);
}

std::size_t
DatasetWriter::bytesWritten() const
{
  return impl_->bytes;
}

void
DatasetWriter::commit()
{
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  try {
    impl_->commit();
  }
  catch (const fs::filesystem_error& error) {
    throw IoError(impl_->shown.string() + ": cannot be put in place: " + error.code().message());
  }
}

} // namespace pcl_ssfr::simulation
