// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Success, accuracy and time of a method on every pair of dataset folders (pairs.csv beside the scans).

#include "cloud_views.h"
#include "pair_variants.h"
#include "scan_loader.h"

#include <pcl_ssfr/pipeline.h>

#include <apps/io/dataset_folder.h>

#include <pcl/features/normal_3d_omp.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>

#include <boost/program_options.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
namespace po = boost::program_options;
using pcl_ssfr::testing::viewOfCloud;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr double kMaxRotationError = 2;      // [deg] success ...
constexpr double kMaxTranslationError = 0.3; // ... and [m]
constexpr double kTwoPi = 6.283185307179586;
constexpr double kDegrees = 360 / kTwoPi;

using Pair = pcl_ssfr::io::ScanPair;

struct Settings {
  std::string method = "ssfr";
  bool turn = true; ///< turn each source by a random rotation about its sensor first
  unsigned seed = 1;
  unsigned threads = 2;
  std::size_t every = 1;
  double away = 0;     ///< move the origin of both scans this far from the sensor [m]
  bool merged = false; ///< lay another scan into each target first: it has no viewpoint any more
  bool verbose = false;
  bool failed = false;   ///< a line for each pair that was not solved
  bool features = false; ///< a line a candidate with its evidence, for scripts/fit_confidence
  bool why = false;      ///< a line for each pair that is not solved: where the truth was lost
  std::vector<std::size_t> only;
  pcl_ssfr::benchmarks::Spoil spoil; ///< of each source
  bool others = false;               ///< the pairs of scans that pairs.csv does not list, instead of those that it does
  bool unrelated = false;            ///< pair each source with a target of the next folder: every answer is wrong
  bool mirrored = false;             ///< mirror each source, as a left-handed file is: every answer is wrong
  fs::path target_folder;            ///< of the targets, when unrelated ...
  std::vector<Pair> target_pairs;    ///< ... and its pairs
};

/// Whether no pose is right.
bool
hasNoTruth(const Settings& settings)
{
  return settings.unrelated || settings.mirrored;
}

struct Outcome {
  pcl_ssfr::Result result;
  double seconds = 0;
  double rotation_error = 180;  // [deg]
  double translation_error = 0; // [m]
  int truth_rank = -1;          // place of the first right candidate
  bool success = false;
  std::vector<bool> right_candidates;
  std::string why; ///< where the truth was lost
};

Cloud::Ptr
moved(const Cloud& cloud, const Eigen::Isometry3d& T)
{
  auto out = pcl::make_shared<Cloud>(cloud);
  for (pcl::PointXYZ& p : *out)
    p.getVector3fMap() = (T * p.getVector3fMap().cast<double>()).cast<float>();
  return out;
}

Eigen::Isometry3d
randomRotation(std::mt19937_64& rng)
{
  const auto uniform = [&rng] { return static_cast<double>(rng() >> 11) * 0x1.0p-53; };
  const double u = uniform(), v = kTwoPi * uniform(), w = kTwoPi * uniform();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(std::sqrt(1 - u) * std::sin(v),
                                  std::sqrt(1 - u) * std::cos(v),
                                  std::sqrt(u) * std::sin(w),
                                  std::sqrt(u) * std::cos(w))
                   .toRotationMatrix();
  return T;
}

pcl::PointCloud<pcl::PointNormal>::Ptr
withNormals(const Cloud::Ptr& cloud, unsigned threads)
{
  pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::PointNormal> estimation(threads);
  estimation.setInputCloud(cloud);
  estimation.setKSearch(20);
  auto out = pcl::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  estimation.compute(*out);
  pcl::PointCloud<pcl::PointNormal>::Ptr kept = pcl::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    pcl::PointNormal p = (*out)[i];
    p.getVector3fMap() = (*cloud)[i].getVector3fMap();
    if (std::isfinite(p.normal_x))
      kept->push_back(p);
  }
  return kept;
}

pcl_ssfr::Result
runIcp(const Cloud::Ptr& source, const Cloud::Ptr& target, unsigned threads)
{
  pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
  const auto s = withNormals(source, threads);
  icp.setInputSource(s);
  icp.setInputTarget(withNormals(target, threads));
  icp.setMaximumIterations(50);
  pcl::PointCloud<pcl::PointNormal> out;
  icp.align(out);
  pcl_ssfr::Result result;
  result.T_target_source.matrix() = icp.getFinalTransformation().cast<double>();
  result.status = icp.hasConverged() ? pcl_ssfr::Status::Converged : pcl_ssfr::Status::NoCandidate;
  result.confidence = icp.hasConverged() ? 1 : 0;
  return result;
}

pcl_ssfr::Options
makeMethodOptions(const Settings& settings)
{
  using namespace pcl_ssfr;
  Options options = makeOptions(settings.method == "ssfr_paper2017" ? Profile::Paper2017 : Profile::Default);
  options.threads = settings.threads;
  return options;
}

pcl_ssfr::Result
runMethod(const Cloud::Ptr& source, const Cloud::Ptr& target, const Settings& settings)
{
  using namespace pcl_ssfr;
  if (settings.method == "icp_point_to_plane")
    return runIcp(source, target, settings.threads);
  const Options options = makeMethodOptions(settings);
  const auto [s, t] = prepareScans(viewOfCloud(*source), viewOfCloud(*target), options);
  return registerScans(s, t, options);
}

void
judge(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth, double& degrees, double& metres)
{
  const Eigen::Isometry3d error = estimate.inverse() * truth;
  const Eigen::Quaterniond q(error.linear());
  degrees = 2 * std::atan2(q.vec().norm(), std::abs(q.w())) * kDegrees;
  metres = (estimate.translation() - truth.translation()).norm();
}

/// Among the pairs of the folder that the target of pairs[i] is from, one that lays another scan into it than the
/// source of pairs[i]; none: null.
const Pair*
findOtherOfTarget(const std::vector<Pair>& pairs, std::size_t i, const Settings& settings)
{
  const std::vector<Pair>& among = settings.unrelated ? settings.target_pairs : pairs;
  for (std::size_t k = 1; k <= among.size(); ++k) {
    const Pair& other = among[(i + k) % among.size()];
    if (other.target == pairs[i].target && (settings.unrelated || other.source != pairs[i].source))
      return &other;
  }
  return nullptr;
}

Outcome
runPair(const fs::path& folder, const std::vector<Pair>& pairs, std::size_t number, const Settings& settings)
{
  const Pair& pair = pairs[number];
  Cloud::Ptr source = pcl_ssfr::benchmarks::loadScan(folder.string(), pair.source);
  const std::string target_folder = (settings.unrelated ? settings.target_folder : folder).string();
  Cloud::Ptr target = pcl_ssfr::benchmarks::loadScan(target_folder, pair.target);
  if (const Pair* other = settings.merged ? findOtherOfTarget(pairs, number, settings) : nullptr)
    *target += *moved(*pcl_ssfr::benchmarks::loadScan(target_folder, other->source), other->T_target_source);
  std::mt19937_64 rng(settings.seed * 1000003u + number);
  Eigen::Isometry3d motion = settings.turn ? randomRotation(rng) : Eigen::Isometry3d::Identity();
  Eigen::Isometry3d target_motion = Eigen::Isometry3d::Identity();
  if (settings.away > 0) {
    motion.pretranslate(randomRotation(rng).linear() * Eigen::Vector3d(settings.away, 0, 0));
    target_motion.translation() = randomRotation(rng).linear() * Eigen::Vector3d(settings.away, 0, 0);
    target = moved(*target, target_motion);
  }
  source = pcl_ssfr::benchmarks::spoiled(*source, settings.spoil, settings.seed + number);
  if (settings.mirrored)
    for (pcl::PointXYZ& point : *source)
      point.y = -point.y;
  source = moved(*source, motion);
  const Eigen::Isometry3d truth = target_motion * pair.T_target_source * motion.inverse();

  Outcome outcome;
  const auto start = std::chrono::steady_clock::now();
  outcome.result = runMethod(source, target, settings);
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  // The translation error is taken where the source's sensor lies.
  const Eigen::Isometry3d at_sensor(motion);
  judge(
      outcome.result.T_target_source * at_sensor, truth * at_sensor, outcome.rotation_error, outcome.translation_error);
  const auto right = [&settings](double degrees, double metres) {
    return !hasNoTruth(settings) && degrees < kMaxRotationError && metres < kMaxTranslationError;
  };
  outcome.success = right(outcome.rotation_error, outcome.translation_error);
  for (std::size_t k = 0; k < outcome.result.candidates.size(); ++k) {
    double degrees = 180, metres = 1e9;
    judge(outcome.result.candidates[k].T_target_source * at_sensor, truth * at_sensor, degrees, metres);
    outcome.right_candidates.push_back(right(degrees, metres));
    if (outcome.right_candidates.back() && outcome.truth_rank < 0)
      outcome.truth_rank = static_cast<int>(k);
  }
  return outcome;
}

double
median(std::vector<double> values)
{
  if (values.empty())
    return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Answers of like confidence, and how many of them were right.
struct CalibrationBin {
  std::size_t answers = 0, right = 0;
  double confidence = 0; ///< sum
};

/// Expected calibration error: the mean difference of confidence and share of right answers, over ten bins.
double
calibrationError(const std::vector<std::pair<double, bool>>& answers)
{
  std::array<CalibrationBin, 10> bins;
  for (const auto& [confidence, right] : answers) {
    CalibrationBin& bin = bins[static_cast<std::size_t>(std::clamp(10 * confidence, 0.0, 9.0))];
    ++bin.answers;
    bin.right += right;
    bin.confidence += confidence;
  }
  double sum = 0;
  for (const CalibrationBin& bin : bins)
    sum += std::abs(bin.confidence - static_cast<double>(bin.right));
  return answers.empty() ? 0 : sum / static_cast<double>(answers.size());
}

struct Totals {
  std::size_t pairs = 0, solved = 0, converged = 0, converged_right = 0;
  std::vector<std::pair<double, bool>> confidences; ///< and whether the answer was right
  std::vector<double> degrees, metres, seconds;
  std::map<std::string, double> stages;

  void
  add(const Outcome& o)
  {
    ++pairs;
    solved += o.success;
    converged += o.result.accepted();
    converged_right += o.result.accepted() && o.success;
    seconds.push_back(o.seconds);
    confidences.emplace_back(o.result.confidence, o.success);
    if (o.success) {
      degrees.push_back(o.rotation_error);
      metres.push_back(o.translation_error);
    }
    for (const pcl_ssfr::StageReport& s : o.result.stages)
      stages[s.name] += s.seconds;
  }
  void
  print(const std::string& name) const
  {
    std::printf("| %-20s | %5zu | %6zu | %5.1f %% | %9zu | %15zu | %8.3f | %6.1f | %6.3f |\n",
                name.c_str(),
                pairs,
                solved,
                100.0 * static_cast<double>(solved) / static_cast<double>(std::max<std::size_t>(1, pairs)),
                converged,
                converged - converged_right,
                median(degrees),
                100 * median(metres),
                median(seconds));
    std::fflush(stdout);
  }
};

std::vector<Pair>
readPairs(const fs::path& folder, const Settings& settings)
{
  std::vector<Pair> pairs = pcl_ssfr::io::readDatasetFolder(folder.string()).pairs;
  return settings.others ? pcl_ssfr::benchmarks::otherPairs(pairs) : pairs;
}

/// One table: every method, sources turned at random and as they are. The default profile runs on every pair.
int
compare(const std::vector<std::string>& folders, Settings settings)
{
  const std::vector<std::string> methods = {"ssfr", "ssfr_paper2017", "icp_point_to_plane"};
  const std::size_t every = settings.every;
  std::printf(
      "Solved pairs (within %g degrees and %g m) of pairs tried. Turned: each source first turned at random about "
      "its sensor (seed %u).\n\n"
      "| set | ssfr, turned | ssfr, as is | paper2017, turned | paper2017, as is | ICP, turned | ICP, as is | "
      "ssfr median error | ssfr converged wrong |\n|---|---|---|---|---|---|---|---|---|\n",
      kMaxRotationError,
      kMaxTranslationError,
      settings.seed);
  std::map<std::pair<std::string, bool>, Totals> all;
  const auto cell = [](const Totals& t) { std::printf(" %zu / %zu |", t.solved, t.pairs); };
  for (const std::string& name : folders) {
    const fs::path folder(name);
    const std::vector<Pair> pairs = readPairs(folder, settings);
    std::printf("| %s |", fs::weakly_canonical(folder).filename().c_str());
    Totals ours;
    std::size_t wrong = 0;
    for (const std::string& method : methods)
      for (const bool turn : {true, false}) {
        settings.method = method;
        settings.turn = turn;
        settings.every = method == "ssfr" ? 1 : every;
        Totals totals;
        for (std::size_t i = 0; i < pairs.size(); i += settings.every) {
          const Outcome outcome = runPair(folder, pairs, i, settings);
          totals.add(outcome);
          all[{method, turn}].add(outcome);
        }
        cell(totals);
        std::fflush(stdout);
        if (method == "ssfr") {
          wrong += totals.converged - totals.converged_right;
          if (turn)
            ours = totals;
        }
      }
    std::printf(" %.3f deg, %.1f cm | %zu |\n", median(ours.degrees), 100 * median(ours.metres), wrong);
    std::fflush(stdout);
  }
  std::printf("| all |");
  std::size_t wrong = 0;
  for (const std::string& method : methods)
    for (const bool turn : {true, false}) {
      const Totals& totals = all[{method, turn}];
      cell(totals);
      if (method == "ssfr")
        wrong += totals.converged - totals.converged_right;
    }
  const Totals& ours = all[{"ssfr", true}];
  std::printf(" %.3f deg, %.1f cm | %zu |\n", median(ours.degrees), 100 * median(ours.metres), wrong);
  return 0;
}

int
run(const std::vector<std::string>& folders, Settings settings)
{
  Totals all;
  if (!settings.verbose)
    std::printf("Method %s, source %s, %u threads\n\n"
                "| set                  | pairs | solved |   rate  | converged | converged wrong | med. deg | med.cm | "
                "med. s |\n"
                "|----------------------|-------|--------|---------|-----------|-----------------|----------|--------|-"
                "-------|\n",
                settings.method.c_str(),
                settings.turn ? "turned at random" : "as it is",
                settings.threads);
  for (std::size_t f = 0; f < folders.size(); ++f) {
    const fs::path folder(folders[f]);
    std::vector<Pair> pairs = readPairs(folder, settings);
    if (settings.unrelated) {
      settings.target_folder = folders[(f + 1) % folders.size()];
      settings.target_pairs = pcl_ssfr::io::readDatasetFolder(settings.target_folder.string()).pairs;
      for (std::size_t i = 0; i < pairs.size(); ++i)
        pairs[i].target = settings.target_pairs[i % settings.target_pairs.size()].target;
    }
    const std::string set = fs::weakly_canonical(folder).filename().string();
    Totals totals;
    for (std::size_t i = 0; i < pairs.size(); i += settings.every) {
      if (!settings.only.empty() && std::find(settings.only.begin(), settings.only.end(), i) == settings.only.end())
        continue;
      if (settings.merged && !findOtherOfTarget(pairs, i, settings))
        continue;
      const Outcome o = runPair(folder, pairs, i, settings);
      totals.add(o);
      all.add(o);
      if (settings.features) {
        const auto& cs = o.result.candidates;
        for (std::size_t k = 0; k < cs.size(); ++k)
          std::printf("CAND %s %zu %zu %d %.5f %.5f %.5f %.5f %.5f %.5f %.5f %.5f %.5f %.5f %d\n",
                      set.c_str(),
                      i,
                      k,
                      o.right_candidates[k] ? 1 : 0,
                      cs[k].score,
                      cs[k].overlap,
                      cs[k].contradiction,
                      cs[k].evidence.unmatched,
                      cs[k].probability,
                      cs[k].evidence.third_direction,
                      cs[k].evidence.patches_matched,
                      cs[k].evidence.patches_contradicted,
                      cs[k].evidence.facing_matched,
                      cs[k].evidence.facing_score,
                      o.result.source_viewpoint_used && o.result.target_viewpoint_used ? 1 : 0);
      }
      if (settings.verbose || settings.failed) {
        const auto& c = o.result.candidates;
        if (settings.verbose || !o.success) {
          std::printf("%s %zu %s->%s %s %s rot %.3f t %.3f conf %.3f overlap %.3f contra %.4f rank %d",
                      set.c_str(),
                      i,
                      pairs[i].source.c_str(),
                      pairs[i].target.c_str(),
                      o.success ? "ok" : "WRONG",
                      toString(o.result.status),
                      o.rotation_error,
                      o.translation_error,
                      o.result.confidence,
                      o.result.overlap,
                      o.result.contradiction,
                      o.truth_rank);
          for (std::size_t k = 0; k < std::min<std::size_t>(c.size(), 4); ++k)
            std::printf(" [%.3f %.3f %.4f]", c[k].score, c[k].overlap, c[k].contradiction);
          const auto& stages = o.result.stages;
          const auto searches = std::count_if(
              stages.begin(), stages.end(), [](const pcl_ssfr::StageReport& s) { return s.name == "translations"; });
          std::printf(" %td searches %.3f s\n", searches, o.seconds);
          if (!o.why.empty())
            std::printf("  lost: %s\n", o.why.c_str());
        }
      }
    }
    totals.print(set);
  }
  all.print("all");
  std::printf("\nExpected calibration error of the confidence: %.1f %%\n", 100 * calibrationError(all.confidences));
  std::printf("Mean seconds a pair:");
  for (const auto& [stage, seconds] : all.stages)
    std::printf(" %s %.4f;", stage.c_str(), seconds / static_cast<double>(std::max<std::size_t>(1, all.pairs)));
  std::printf("\n");
  return 0;
}

} // namespace

int
main(int argc, char** argv)
{
  Settings settings;
  std::vector<std::string> folders;
  bool as_is = false;
  bool comparing = false;
  po::options_description options("dataset_table [options] DATASET...");
  // clang-format off
  options.add_options()
      ("help", "this text")
      ("method", po::value(&settings.method)->default_value(settings.method),
       "ssfr, ssfr_paper2017 or icp_point_to_plane")
      ("compare", po::bool_switch(&comparing),
       "one table: default profile, paper's profile and point-to-plane ICP, turned and as they are")
      ("as-is", po::bool_switch(&as_is), "do not turn the sources")
      ("seed", po::value(&settings.seed)->default_value(settings.seed), "of the random rotations")
      ("threads", po::value(&settings.threads)->default_value(settings.threads), "of each method")
      ("every", po::value(&settings.every)->default_value(settings.every),
       "take every k-th pair (with --compare: for the methods compared with)")
      ("pairs", po::value(&settings.only)->multitoken(), "only these rows")
      ("away", po::value(&settings.away)->default_value(0), "move the origins this far from the sensors [m]")
      ("merged", po::bool_switch(&settings.merged),
       "lay the source of another pair into each target: such a cloud has no one viewpoint (pairs without such: left out)")
      ("others", po::bool_switch(&settings.others),
       "instead of the pairs of pairs.csv: those the other way round, and of scans that several pairs connect")
      ("spoil-every", po::value(&settings.spoil.every)->default_value(settings.spoil.every),
       "keep only every k-th point of each source")
      ("spoil-sector", po::value(&settings.spoil.sector_degrees)->default_value(settings.spoil.sector_degrees),
       "keep only a sector of each source, at a random place about its z axis [deg]")
      ("spoil-nearest", po::value(&settings.spoil.nearest)->default_value(settings.spoil.nearest),
       "keep only this share of each source, the points nearest to the sensor")
      ("unrelated", po::bool_switch(&settings.unrelated),
       "targets from the next folder: whatever is reported converged is wrong")
      ("mirrored", po::bool_switch(&settings.mirrored),
       "mirror each source, as a file with left-handed coordinates is: whatever is reported converged is wrong")
      ("verbose", po::bool_switch(&settings.verbose), "a line a pair")
      ("failed", po::bool_switch(&settings.failed), "a line for each pair that is not solved")
      ("why", po::bool_switch(&settings.why), "with --failed or --verbose: where the truth was lost, and its evidence")
      ("features", po::bool_switch(&settings.features),
       "a line a candidate with its evidence, for scripts/fit_confidence")
      ("dataset", po::value(&folders), "folders");
  // clang-format on
  po::positional_options_description positional;
  positional.add("dataset", -1);
  try {
    po::variables_map vm;
    po::store(po::command_line_parser(argc, argv).options(options).positional(positional).run(), vm);
    po::notify(vm);
    if (vm.count("help") || folders.empty()) {
      std::cout << options;
      return vm.count("help") ? 0 : 2;
    }
    settings.turn = !as_is;
    if (comparing)
      return compare(folders, settings);
    return run(folders, settings);
  }
  catch (const po::error& e) {
    std::cerr << "dataset_table: " << e.what() << '\n';
    return 2;
  }
  catch (const std::exception& e) {
    std::cerr << "dataset_table: " << e.what() << '\n';
    return 3;
  }
}
