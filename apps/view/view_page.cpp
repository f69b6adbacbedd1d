// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/version.h>

#include <apps/io/file_bytes.h>
#include <apps/view/view_pictures.h>
#include <apps/view/view_text.h>

#include <filesystem>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr const char* kStyle =
    "body{font:16px/1.5 sans-serif;color:#222;max-width:1440px;margin:0 auto;padding:1em}"
    "h1{font-size:1.6em;margin:.3em 0}h2{font-size:1.2em;margin:1.6em 0 .3em}"
    "img{max-width:100%;height:auto;border:1px solid #ccc}"
    "table{border-collapse:collapse;font-size:.92em}td,th{padding:.2em .7em;border-bottom:1px solid "
    "#ddd;text-align:right}"
    "td:first-child,th:first-child{text-align:left}.wide td:last-child,.wide th:last-child{text-align:left}"
    ".yes{color:#00792f;font-weight:bold}.no{color:#c4001a;font-weight:bold}"
    "nav a{margin-right:1em}p.caption{margin:.2em 0 .6em}.scroll{overflow-x:auto}";

std::string
escaped(const std::string& text)
{
  std::string result;
  for (const char c : text) {
    switch (c) {
    case '&':
      result += "&amp;";
      break;
    case '<':
      result += "&lt;";
      break;
    case '>':
      result += "&gt;";
      break;
    case '"':
      result += "&quot;";
      break;
    default:
      result += c;
    }
  }
  return result;
}

std::string
cell(const std::string& text, const char* style = "")
{
  return std::string("<td") + (*style ? std::string(" class=\"") + style + "\"" : "") + ">" + escaped(text) + "</td>";
}

std::string
candidateTable(const ViewModel& model)
{
  const bool truth = model.truth() != nullptr;
  std::string html = "<div class=\"scroll\"><table><tr><th>pose</th><th>score</th><th>matched</th><th>contradicted</th>"
                     "<th>in view, unlike</th><th>patches met</th>";
  html += truth ? "<th>deg from truth</th><th>m from truth</th><th></th></tr>\n" : "</tr>\n";
  for (const ViewedPose& pose : model.poses()) {
    const Candidate& c = pose.candidate;
    html += "<tr>" + cell(pose.name) + cell(formatted("%.3f", c.score)) + cell(formatted("%.1f %%", 100 * c.overlap)) +
            cell(formatted("%.2f %%", 100 * c.contradiction)) + cell(formatted("%.1f %%", 100 * c.evidence.unmatched)) +
            cell(formatted("%.0f %%", 100 * c.evidence.patches_matched));
    if (truth && pose.error)
      html += cell(formatted("%.3f", pose.error->rotation_deg)) + cell(formatted("%.3f", pose.error->translation_m)) +
              cell(pose.is_truth ? ""
                   : pose.right  ? "right"
                                 : "wrong",
                   pose.right ? "yes" : "no");
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string
lossTable(const ViewModel& model)
{
  const std::vector<LossStep> losses = model.findLoss();
  if (losses.empty())
    return {};
  std::string html =
      "<h2 id=\"loss\">Was the truth still there?</h2>\n<table class=\"wide\"><tr><th>stage</th><th></th>"
      "<th>what was found</th></tr>\n";
  for (const LossStep& loss : losses)
    html += "<tr>" + cell(loss.stage) + cell(loss.passed ? "yes" : "no", loss.passed ? "yes" : "no") +
            cell(loss.finding) + "</tr>\n";
  return html + "</table>\n";
}

std::string
stageTable(const ViewModel& model)
{
  std::string html = "<table><tr><th>stage</th><th>in</th><th>out</th><th>seconds</th></tr>\n";
  for (const StageReport& stage : model.result().stages)
    html += "<tr>" + cell(stage.name) + cell(std::to_string(stage.count_in)) + cell(std::to_string(stage.count_out)) +
            cell(formatted("%.4f", stage.seconds)) + "</tr>\n";
  return html + "</table>\n";
}

} // namespace

void
writeViewPage(const std::string& folder, const ViewModel& model, const std::vector<ViewPicture>& pictures)
{
  const Report& report = model.run().report;
  const auto name = [](const std::string& path) { return std::filesystem::path(path).filename().string(); };
  const std::string title = name(report.source) + " onto " + name(report.target);
  std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
                     "<meta name=\"viewport\" content=\"width=device-width\"><title>" +
                     escaped(title) + "</title>\n<style>" + kStyle + "</style></head><body>\n";
  html += "<h1>" + escaped(title) + "</h1>\n<p><b>" + escaped(headlineOf(model)) + "</b> (" + escaped(report.method) +
          ", pcl_ssfr " PCL_SSFR_VERSION ")</p>\n<ul>\n";
  for (const std::string& fact : describeFacts(model))
    html += "<li>" + escaped(fact) + "</li>\n";
  html += "</ul>\n<nav>";
  for (const ViewPicture& picture : pictures)
    html += "<a href=\"#" + picture.file + "\">" + escaped(picture.title) + "</a> ";
  html += "</nav>\n" + lossTable(model) + "<h2>Poses</h2>\n" + candidateTable(model);
  for (const ViewPicture& picture : pictures)
    html += "<h2 id=\"" + picture.file + "\">" + escaped(picture.title) + "</h2>\n<p class=\"caption\">" +
            escaped(picture.caption) + "</p>\n<a href=\"" + picture.file + "\"><img src=\"" + picture.file +
            "\" alt=\"" + escaped(picture.title) + "\" loading=\"lazy\"></a>\n";
  html += "<h2>Stages</h2>\n" + stageTable(model) + "</body></html>\n";
  io::writeFile((std::filesystem::path(folder) / "index.html").string(), html);
}

} // namespace apps
} // namespace pcl_ssfr
