// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/map_run.h>

#include "common/angles.h"
#include "multiway/project_file.h"
#include "multiway/storeys.h"
#include "profiles/prepared_data.h"

#include <pcl_ssfr/multiway/multiway_registration.h>

#include <apps/common/command_line.h>
#include <apps/common/seconds_since.h>
#include <apps/io/e57_format.h>
#include <apps/io/file_bytes.h>
#include <apps/io/loaded_cloud.h>
#include <apps/io/output_file.h>
#include <apps/map/control_points.h>
#include <apps/map/folder_lock.h>
#include <apps/map/map_files.h>
#include <apps/map/map_inputs.h>
#include <apps/map/map_page.h>
#include <apps/map/map_progress.h>
#include <apps/map/map_ranks.h>
#include <apps/map/map_truth.h>
#include <apps/map/pose_list.h>
#include <apps/methods/cloud_view.h>
#include <apps/methods/report.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <system_error>
#include <unistd.h>
#include <variant>

namespace pcl_ssfr {
namespace apps {

namespace {

UsageError
oneScanTwice(const std::string& option, const std::string& a, const std::string& b)
{
  std::string text = "--";
  text.append(option).append(": ").append(a).append(",").append(b).append(" is one scan twice");
  return UsageError(text);
}

namespace fs = std::filesystem;

constexpr int kSignalExit = 128;
constexpr Eigen::Index kOutlinePoints = 24000; // of all scans, in the report ...
constexpr Eigen::Index kLeastOutline = 300;    // ... and at least of each

MultiwayOptions
optionsOf(const MapArguments& arguments)
{
  MultiwayOptions options;
  options.threads = arguments.threads;
  options.gravity = arguments.gravity;
  options.pairs = arguments.pairs;
  return options;
}

/// At rank 0: whoever started the job ends it, mostly since another rank died.
void
onTermination(int signal)
{
  constexpr char kText[] = "ssfr_map: the job was ended; --resume goes on with what is linked\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kText, sizeof(kText) - 1);
  _exit(kSignalExit + signal);
}

class MapRun {
public:
  /// \param[in] ranks that link, may be null
  MapRun(const MapArguments& arguments, MpiRanks* ranks)
      : arguments_(arguments), ranks_(ranks), files_(findScans(arguments.inputs))
  {}

  bool
  run()
  {
    const auto start = std::chrono::steady_clock::now();
    if (files_.size() < 2)
      throw UsageError("INPUT: a map takes two scans or more, here is " + std::to_string(files_.size()));
    // Everything that may be wrong with the arguments is looked at before hours of work.
    readInputs();
    checkOwnFiles();
    makeFolder();
    const FolderLock lock(arguments_.out);
    requireNoOtherMap();
    checkOutputs(arguments_.clouds, files_);
    if (writesJson())
      io::requireWritable(arguments_.json);
    MultiwayRegistration registration(optionsOf(arguments_));
    letRanksLink(registration);
    registration.openProject(inFolder("map.sqlite"), goesOn());
    MultiwayMap map = [&] {
      MapProgress progress;
      const auto show = [&](const char* stage, std::size_t done, std::size_t total) {
        progress.show(stage, done, total);
      };
      prepare(registration, show);
      decide(registration);
      try {
        return registration.run(show);
      }
      catch (const DecisionError& problem) {
        throw UsageError("--accept, --reject: " + std::string(problem.what()));
      }
    }();
    places_.resize(map.scans.size(), Eigen::Vector3d::Zero());
    found_sensors_.resize(map.scans.size());
    describeScans(registration, map);
    if (!control_.empty())
      findVertical(registration, map);
    toFileCoordinates(map);
    MapOutput output{map, std::nullopt, {}, "ssfr_map " + arguments_.words, 0, 0};
    std::string problem = layOntoControl(map, output);
    registration.writeToProject(map);
    if (!truth_.empty())
      output.errors = compareWithTruth(map, truth_, places_);
    if (const std::string other = writeAllClouds(map); problem.empty())
      problem = other;
    output.peak_rss_mib = peakRssMib();
    output.seconds = secondsSince(start);
    write(output);
    if (!problem.empty())
      throw io::IoError(problem);
    return map.components == 1;
  }

private:
  std::string
  inFolder(const char* name) const
  {
    return (fs::path(arguments_.out) / name).string();
  }

  /// There is a file of --json besides those in the folder.
  bool
  writesJson() const
  {
    return !arguments_.json.empty() && arguments_.json != kStandardOutput;
  }

  std::vector<std::string>
  scanNames() const
  {
    std::vector<std::string> names;
    names.reserve(files_.size());
    for (const MapInputFile& file : files_)
      names.push_back(file.name);
    return names;
  }

  /// A decision is one on the map that is there.
  bool
  goesOn() const
  {
    return arguments_.resume || !arguments_.accepted.empty() || !arguments_.rejected.empty() ||
           !arguments_.pins.empty() || !arguments_.poses.empty() || !arguments_.control.empty() || arguments_.gravity;
  }

  int
  scanNamed(const char* option, const std::string& name) const
  {
    int found = -1;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      if (files_[i].name == name || files_[i].path == name)
        return static_cast<int>(i);
      // The path has the number of a scan in an E57 file, the name may have its name.
      std::vector<std::string> names = namesOfScan(files_[i].name);
      const std::vector<std::string> more = namesOfScan(files_[i].path);
      names.insert(names.end(), more.begin(), more.end());
      if (std::find(names.begin(), names.end(), name) == names.end())
        continue;
      if (found >= 0)
        throw UsageError(std::string("--") + option + ": " + io::inQuotes(name) + " may be " +
                         files_[static_cast<std::size_t>(found)].name + " or " + files_[i].name);
      found = static_cast<int>(i);
    }
    if (found < 0)
      throw UsageError(std::string("--") + option + ": " + io::inQuotes(name) + " is none of the scans");
    return found;
  }

  void
  readInputs()
  {
    truth_ = readPosesOfScans(arguments_.truth);
    poses_ = readPosesOfScans(arguments_.poses);
    if (!arguments_.control.empty())
      control_ = readControl(arguments_.control);
    for (const ControlPoint& point : control_)
      scanNamed("control", point.scan);
    for (const std::string& name : arguments_.pins)
      scanNamed("pin", name);
    for (const auto& [a, b] : arguments_.accepted)
      if (scanNamed("accept", a) == scanNamed("accept", b))
        throw oneScanTwice("accept", a, b);
    for (const auto& [a, b] : arguments_.rejected)
      if (scanNamed("reject", a) == scanNamed("reject", b))
        throw oneScanTwice("reject", a, b);
  }

  /// Empty without a file.
  std::vector<std::optional<Eigen::Isometry3d>>
  readPosesOfScans(const std::string& file) const
  {
    if (file.empty())
      return {};
    const std::map<std::string, Eigen::Isometry3d> named = readPoses(file);
    std::vector<std::optional<Eigen::Isometry3d>> poses = posesOfScans(named, scanNames(), file);
    const auto known = static_cast<std::size_t>(
        std::count_if(poses.begin(), poses.end(), [](const auto& pose) { return pose.has_value(); }));
    if (known == 0)
      throw io::IoError(file + ": names none of the scans");
    // As of a larger map, or misspelt. Not counted of E57 files, where each pose has several names.
    if (known < named.size() && !io::isE57(file))
      std::cerr << "ssfr_map: " << file << ": " << named.size() - known << " of " << named.size()
                << " poses are of no scan here\n";
    return poses;
  }

  /// What is written takes the place of nothing that is read, nor of what is no earlier map, nor of each other.
  void
  checkOwnFiles() const
  {
    std::error_code error;
    const bool is_map = fs::exists(inFolder("map.sqlite"), error);
    std::map<std::string, std::string> taken; // why a file is not written to, by its identity
    for (const std::string& input : {arguments_.truth, arguments_.poses, arguments_.control})
      if (!input.empty())
        taken[io::fileIdentity(input)] = " would be replaced, but is read; take a copy of it in another place";
    for (const MapInputFile& file : files_)
      taken[io::fileIdentity(io::fileOfScan(file.path))] = " would replace the scan " + file.path;
    const auto take = [&taken](const std::string& option, const std::string& path) {
      const std::string identity = io::fileIdentity(path);
      const std::string used = option.empty() ? " is a file of the map" : " is also that of " + option;
      const auto [found, is_free] = taken.emplace(identity, used);
      if (!is_free && !identity.empty())
        throw UsageError((option.empty() ? "" : option + ": ") + path + found->second);
    };
    for (const char* name : {"poses.csv", "links.csv", "map.json", "report.html", "poses.tum"}) {
      if (!is_map && fs::exists(inFolder(name), error))
        throw io::IoError(inFolder(name) + ": is there already, and " + arguments_.out +
                          " holds no map of this program; take another folder");
      take("", inFolder(name));
    }
    take("", inFolder("map.sqlite"));
    for (const auto& [option, path] : outputFiles(arguments_.clouds, files_)) {
      take(option, path);
      if (option != std::string("--pcd")) // those are marked, and not read again
        requireNotAmongScans(option, path);
    }
    if (writesJson())
      take("--json", arguments_.json);
  }

  /// A cloud in a folder of scans would be a scan of the next run.
  void
  requireNotAmongScans(const std::string& option, const std::string& path) const
  {
    const fs::path parent = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : ".";
    const auto& inputs = arguments_.inputs;
    const auto input = std::find_if(inputs.begin(), inputs.end(), [&](const std::string& folder) {
      std::error_code error;
      return fs::is_directory(folder, error) && fs::equivalent(parent, folder, error);
    });
    if (input != inputs.end())
      throw UsageError(option + ": " + path + " would be read as a scan by the next run, as all clouds in " + *input +
                       " are; take another folder");
  }

  void
  makeFolder() const
  {
    std::error_code error;
    fs::create_directories(arguments_.out, error);
    if (!fs::is_directory(arguments_.out))
      throw io::IoError(arguments_.out + ": the folder cannot be created" + (error ? ": " + error.message() : ""));
  }

  /// Without --resume or a decision the links of an earlier map are not touched.
  void
  requireNoOtherMap() const
  {
    std::error_code error;
    if (!goesOn() && fs::exists(inFolder("map.sqlite"), error) && ProjectFile::holdsLinks(inFolder("map.sqlite")))
      throw io::IoError(inFolder("map.sqlite") +
                        ": holds a map already; --resume goes on with it, or take another folder");
  }

  void
  letRanksLink(MultiwayRegistration& registration) const
  {
    if (!ranks_)
      return;
    std::vector<std::string> paths;
    paths.reserve(files_.size());
    for (const MapInputFile& file : files_)
      paths.push_back(file.path);
    registration.setLinker([ranks = ranks_, paths](const std::vector<PairTask>& tasks, const OnLink& on_link) {
      dealPairs(*ranks, tasks, paths, on_link);
    });
  }

  void
  prepare(MultiwayRegistration& registration, const MultiwayRegistration::Progress& progress)
  {
    offsets_.assign(files_.size(), Eigen::Vector3d::Zero());
    registration.addScans(
        scanNames(),
        [&](std::size_t i) {
          const auto points = std::make_shared<io::ScanPoints>(io::loadScanPoints(files_[i].path));
          offsets_[i] = points->offset;
          return ScanSource{viewOf(*points), points};
        },
        progress);
  }

  void
  decide(MultiwayRegistration& registration) const
  {
    for (std::size_t i = 0; i < poses_.size(); ++i)
      if (poses_[i]) {
        PosePrior prior;
        prior.T_map_scan = *poses_[i] * Eigen::Translation3d(offsets_[i]);
        prior.rotation = arguments_.pose_rotation_deg * kDegree;
        prior.translation = arguments_.pose_translation_m;
        registration.setPosePrior(static_cast<int>(i), prior);
      }
    for (const std::string& name : arguments_.pins)
      registration.pin(scanNamed("pin", name));
    for (const auto& [a, b] : arguments_.accepted)
      registration.accept(scanNamed("accept", a), scanNamed("accept", b));
    for (const auto& [a, b] : arguments_.rejected)
      registration.reject(scanNamed("reject", a), scanNamed("reject", b));
  }

  /// What the report and the comparison need of the scans.
  void
  describeScans(const MultiwayRegistration& registration, const MultiwayMap& map)
  {
    outlines_.resize(map.scans.size());
    const Eigen::Index most = std::max(
        kLeastOutline, kOutlinePoints / std::max<Eigen::Index>(1, static_cast<Eigen::Index>(map.scans.size())));
    for (std::size_t i = 0; i < map.scans.size(); ++i) {
      if (!map.scans[i].usable)
        continue;
      const auto& scan = std::get<PatchScan>(registration.preparedScan(static_cast<int>(i)).data().scan);
      places_[i] = scan.origin + scan.viewpoint + offsets_[i];
      if (scan.viewpoint_found)
        found_sensors_[i] = places_[i];
      ScanOutline& outline = outlines_[i];
      outline.place = places_[i];
      for (const MainNormal& main : scan.main_normals) {
        outline.normals.push_back(main.direction);
        outline.weights.push_back(main.support);
      }
      const Eigen::Index n = scan.surface.points.cols();
      const Eigen::Index count = std::min(n, most);
      outline.points.resize(3, count);
      for (Eigen::Index k = 0; k < count; ++k)
        outline.points.col(k) = scan.surface.points.col(k * n / count).cast<double>() + scan.origin + offsets_[i];
    }
  }

  /// The vertical of the largest component: of either sign where no axis of its scans says more.
  void
  findVertical(const MultiwayRegistration& registration, const MultiwayMap& map)
  {
    std::vector<StoreyScan> scans;
    Eigen::Vector3d axes = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < map.scans.size(); ++i) {
      const Eigen::Isometry3d& T = map.scans[i].T_map_scan;
      if (!map.scans[i].usable || map.scans[i].component != 0)
        continue;
      scans.push_back(storeyScan(registration.preparedScan(static_cast<int>(i)), T));
      axes += T.linear() * arguments_.gravity.value_or(Eigen::Vector3d::UnitZ()).normalized();
    }
    const AliasConfig config;
    const std::optional<Eigen::Vector3d> up = findUp(scans, arguments_.gravity, config);
    if (!up)
      return;
    const double along = axes.dot(*up) / static_cast<double>(scans.size());
    vertical_ = {along < 0 ? Eigen::Vector3d(-*up) : *up, std::abs(along) > config.level_normal};
  }

  /// Poses so far map points without the offsets that were taken off large coordinates.
  void
  toFileCoordinates(MultiwayMap& map) const
  {
    std::map<int, Eigen::Isometry3d> frames; // of the components: the scan that holds a frame keeps the identity
    for (std::size_t i = 0; i < map.scans.size(); ++i)
      if (map.scans[i].T_map_scan.matrix().isIdentity(0))
        frames.emplace(map.scans[i].component, Eigen::Isometry3d(Eigen::Translation3d(offsets_[i])));
    for (std::size_t i = 0; i < map.scans.size(); ++i) {
      if (offsets_[i].isZero(0) && frames.count(map.scans[i].component) == 0)
        continue;
      const auto found = frames.find(map.scans[i].component);
      const Eigen::Isometry3d frame = found == frames.end() ? Eigen::Isometry3d::Identity() : found->second;
      const Eigen::Translation3d offset(-offsets_[i]);
      for (Eigen::Isometry3d* pose : {&map.scans[i].T_map_scan, &map.graph_poses[i], &map.chain_poses[i]})
        *pose = frame * *pose * offset;
    }
    for (MapLink& link : map.links)
      link.T_target_source = Eigen::Translation3d(offsets_[static_cast<std::size_t>(link.target)]) *
                             link.T_target_source *
                             Eigen::Translation3d(-offsets_[static_cast<std::size_t>(link.source)]);
  }

  /// The largest component is laid onto its control. \return why it was not; the map keeps its frame then
  std::string
  layOntoControl(MultiwayMap& map, MapOutput& output) const
  {
    if (control_.empty())
      return "";
    ControlledPlaces places;
    for (const ControlPoint& point : control_) {
      const auto i = static_cast<std::size_t>(scanNamed("control", point.scan));
      if (map.scans[i].component != 0)
        continue;
      places.labels.push_back(point.label());
      places.map.push_back(map.scans[i].T_map_scan * point.in_scan.value_or(places_[i]));
      places.site.push_back(point.site);
      places.sigma.push_back(map.scans[i].sigma_translation);
    }
    ControlFit fit;
    try {
      fit = fitControl(places.map, places.site);
    }
    catch (const std::invalid_argument& problem) {
      return arguments_.control + ": " + std::to_string(places.labels.size()) + " of " +
             std::to_string(control_.size()) + " places are of the largest component: " + problem.what() +
             "; the map was written in its own frame";
    }
    Eigen::Matrix<double, 6, 6> rotation = Eigen::Matrix<double, 6, 6>::Zero();
    rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() = fit.T_site_map.linear();
    for (std::size_t i = 0; i < map.scans.size(); ++i)
      if (map.scans[i].component == 0) {
        for (Eigen::Isometry3d* pose : {&map.scans[i].T_map_scan, &map.graph_poses[i], &map.chain_poses[i]})
          *pose = fit.T_site_map * *pose;
        map.scans[i].covariance = rotation * map.scans[i].covariance * rotation.transpose();
      }
    for (std::size_t k = 0; k < places.labels.size(); ++k)
      output.control.push_back({places.labels[k], fit.residuals[k]});
    for (std::string& doubt : doubtsOfControl(places, fit, vertical_, MultiwayOptions().gravity_tolerance))
      map.notes.push_back(std::move(doubt));
    return "";
  }

  /// The clouds that are wanted. \return why they were not written; tables and report are all the same
  std::string
  writeAllClouds(const MultiwayMap& map) const
  {
    if (!arguments_.clouds.any())
      return "";
    try {
      MapProgress progress;
      const auto show = [&](std::size_t done, std::size_t total) { progress.show("write", done, total); };
      writeClouds(arguments_.clouds, files_, map, places_, found_sensors_, show);
    }
    catch (const io::IoError& problem) {
      return problem.what();
    }
    return "";
  }

  /// Which scans are not among the clouds that were asked for.
  std::string
  leftOutText(const MultiwayMap& map) const
  {
    std::string names;
    for (const MapScan& scan : map.scans)
      if (arguments_.clouds.any() && !isWritten(scan))
        names += (names.empty() ? "" : ", ") + scan.name;
    return names.empty() ? "" : "not in the clouds, as they have no place in the largest component: " + names + "\n";
  }

  void
  write(const MapOutput& output) const
  {
    io::writeFile(inFolder("poses.csv"), posesCsv(output.map));
    io::writeFile(inFolder("links.csv"), linksCsv(output.map));
    const std::string json =
        mapJson(output).dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
    io::writeFile(inFolder("map.json"), json);
    io::writeFile(inFolder("report.html"), mapPage(output, outlines_));
    if (arguments_.tum)
      io::writeFile(inFolder("poses.tum"), posesTum(output.map));
    else if (std::error_code error; fs::remove(inFolder("poses.tum"), error))
      std::cerr << "ssfr_map: poses.tum of the earlier map is removed (--tum writes it)\n";
    if (writesJson())
      io::writeFile(arguments_.json, json);
    if (arguments_.json != kStandardOutput)
      std::cout << mapText(output) << "written to " << arguments_.out << "\n" << leftOutText(output.map);
    else
      std::cout << json;
    std::cout.flush();
    if (!std::cout)
      throw io::IoError("standard output: cannot be written");
  }

  const MapArguments& arguments_;
  MpiRanks* ranks_;
  std::vector<MapInputFile> files_;
  std::vector<std::optional<Eigen::Isometry3d>> truth_, poses_; ///< of each scan; empty: no file
  std::vector<ControlPoint> control_;
  std::vector<Eigen::Vector3d> offsets_;                      ///< of each scan's coordinates [m]
  std::vector<Eigen::Vector3d> places_;                       ///< of the sensors, in file coordinates [m]
  std::vector<std::optional<Eigen::Vector3d>> found_sensors_; ///< of those, what was found in the points
  std::vector<ScanOutline> outlines_;
  std::optional<MapVertical> vertical_; ///< of the largest component
};

} // namespace

bool
runMap(const MapArguments& arguments)
{
  if (!MpiRanks::areLaunched())
    return MapRun(arguments, nullptr).run();
  MpiRanks ranks;
  if (ranks.rank() == 0) {
    std::signal(SIGTERM, onTermination);
    return MapRun(arguments, &ranks).run();
  }
  MultiwayOptions options = optionsOf(arguments);
  options.threads = std::max(1U, arguments.threads); // its neighbours are processes
  linkDealtPairs(ranks, options, [](const std::string& path) {
    const auto points = std::make_shared<io::ScanPoints>(io::loadScanPoints(path));
    return ScanSource{viewOf(*points), points};
  });
  return true;
}

} // namespace apps
} // namespace pcl_ssfr
