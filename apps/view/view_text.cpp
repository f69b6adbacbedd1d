// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/view/view_text.h>

#include <apps/common/degrees.h>

#include <cmath>

namespace pcl_ssfr {
namespace apps {

std::string
headlineOf(const ViewModel& model)
{
  const Result& result = model.result();
  std::string text = result.accepted() ? "Aligned" : std::string("Not aligned: ") + toString(result.status);
  const ViewedPose& best = model.poses().front();
  if (best.error && !best.is_truth && !result.candidates.empty())
    text += best.right          ? (result.accepted() ? ", and right" : ", though candidate 1 is right")
            : result.accepted() ? ", but WRONG"
                                : ", and candidate 1 is wrong";
  return text;
}

std::string
describePose(const ViewedPose& pose)
{
  const Candidate& c = pose.candidate;
  std::string text =
      formatted("rotated by %.2f deg, moved by %.2f m; matched %.1f %%, contradicted %.2f %%, score %.3f",
                Eigen::AngleAxisd(c.T_target_source.linear()).angle() * kDegreesPerRadian,
                pose.moved,
                100 * c.overlap,
                100 * c.contradiction,
                c.score);
  if (pose.error && !pose.is_truth)
    text += formatted("; %.2f deg and %.3f m from the truth: %s",
                      pose.error->rotation_deg,
                      pose.error->translation_m,
                      pose.right ? "right" : "wrong");
  return text;
}

std::vector<std::string>
describeFacts(const ViewModel& model)
{
  const Result& result = model.result();
  const Report& report = model.run().report;
  std::vector<std::string> facts;
  if (!result.message.empty())
    facts.push_back("Message: " + result.message + ".");
  std::string figures = formatted("Time %.3f s", report.run.seconds);
  if (report.run.judged)
    figures += formatted("; confidence %.3f; overlap %.1f %%, contradicted %.2f %%; rms %.1f mm",
                         result.confidence,
                         100 * result.overlap,
                         100 * result.contradiction,
                         1000 * result.rmse);
  facts.push_back(figures + ".");
  const ViewedPose& best = model.poses().front();
  if (best.error && !best.is_truth)
    facts.push_back(formatted("Candidate 1 is %.3f deg and %.4f m from the truth (right is within %g deg and %g m).",
                              best.error->rotation_deg,
                              best.error->translation_m,
                              model.run().bound.rotation_deg,
                              model.run().bound.translation_m));
  if (report.run.judged)
    facts.push_back("Sensor: " + describeSensors(result) + ".");
  for (const UnobservableDirection& open : result.unobservable)
    facts.push_back(formatted("Hardly determined: the %s (%.2f, %.2f, %.2f) of the target, with %.2f %% of the "
                              "information of the best direction.",
                              open.rotation ? "rotation about" : "translation along",
                              open.direction.x(),
                              open.direction.y(),
                              open.direction.z(),
                              100 * open.strength));
  if (!model.isOwnMethod())
    facts.push_back("The run is of " + report.method +
                    "; patches, spheres, histograms and evidence are what ssfr sees in the same scans.");
  else if (model.isPaperProfile())
    facts.emplace_back(
        "The run is of the paper's profile: spheres and histograms are of its points; patches and evidence "
        "are what the default profile sees.");
  for (const std::string& remark : model.run().remarks)
    facts.push_back(remark);
  return facts;
}

std::string
describeRun(const ViewModel& model)
{
  std::string text = headlineOf(model) + "\n";
  for (const std::string& fact : describeFacts(model))
    text += "  " + fact + "\n";
  for (const ViewedPose& pose : model.poses())
    text += "  " + pose.name + ": " + describePose(pose) + "\n";
  const std::vector<LossStep> losses = model.findLoss();
  if (!losses.empty())
    text += "Was the truth still there?\n";
  for (const LossStep& loss : losses)
    text += std::string("  ") + (loss.passed ? "yes  " : "NO   ") + loss.stage + ": " + loss.finding + "\n";
  return text;
}

} // namespace apps
} // namespace pcl_ssfr
