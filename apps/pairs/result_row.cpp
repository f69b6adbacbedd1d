// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/pairs/result_row.h>

#include <apps/io/csv_line.h>
#include <apps/io/text_scanner.h>
#include <apps/io/transform_file.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr const char* kColumns =
    "dataset,source,target,method,status,converged,success,rotation_error_deg,translation_error_m,rmse_m,gt_rmse_m,"
    "overlap,confidence,time_s,cpu_s,peak_rss_mib,message,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23,T30,T31,T32,"
    "T33,pair,found_overlap,resolution_m,noise_m,outliers,overlap_limit,perturb,seed,source_points,target_points,"
    "G00,G01,G02,G03,G10,G11,G12,G13,G20,G21,G22,G23,G30,G31,G32,G33";

/// Enough digits to read the same number back, no more than it takes.
std::string
number(double value)
{
  if (!std::isfinite(value))
    return {};
  std::array<char, 40> text{};
  for (const int digits : {6, 9, 17}) {
    std::snprintf(text.data(), text.size(), "%.*g", digits, value);
    if (io::parseNumber(text.data()) == value)
      break;
  }
  return text.data();
}

/// Seconds, errors and the like: what is below a millionth is noise.
std::string
shortNumber(double value)
{
  std::array<char, 40> text{};
  if (!std::isfinite(value))
    return {};
  std::snprintf(text.data(), text.size(), "%.7g", value);
  return text.data();
}

/// Writes fields one after the other.
class Line {
public:
  Line&
  operator<<(const std::string& field)
  {
    text_ += (first_ ? "" : ",") + field;
    first_ = false;
    return *this;
  }
  void
  pose(const std::optional<Eigen::Isometry3d>& T)
  {
    for (Eigen::Index i = 0; i < 16; ++i)
      *this << (T ? number(T->matrix()(i / 4, i % 4)) : std::string());
  }
  const std::string&
  text() const
  {
    return text_;
  }

private:
  std::string text_;
  bool first_ = true;
};

/// Reads fields one after the other and knows their names.
class Fields {
public:
  explicit Fields(std::string_view line) : fields_(io::splitCsvLine(line)), names_(io::splitCsvLine(kColumns))
  {
    if (fields_.size() != names_.size())
      throw std::invalid_argument(std::to_string(fields_.size()) + " columns, not " + std::to_string(names_.size()));
  }

  const std::string&
  text()
  {
    return fields_[next_++];
  }
  double
  number()
  {
    const std::string& field = text();
    if (field.empty())
      return ResultRow::kUnknown;
    const auto value = io::parseNumber(field);
    if (!value)
      throw wrong("is not a number");
    return *value;
  }
  bool
  truth()
  {
    const std::string& field = text();
    if (field != "0" && field != "1")
      throw wrong("is not 0 or 1");
    return field == "1";
  }
  std::uint64_t
  whole()
  {
    const std::string& field = text();
    std::uint64_t value = 0;
    for (const char c : field) {
      if (c < '0' || c > '9' || value > std::numeric_limits<std::uint64_t>::max() / 10)
        throw wrong("is not a whole number");
      value = value * 10 + static_cast<std::uint64_t>(c - '0');
    }
    if (field.empty())
      throw wrong("is not a whole number");
    return value;
  }
  std::optional<Eigen::Isometry3d>
  pose()
  {
    Eigen::Matrix4d matrix;
    bool known = true;
    for (Eigen::Index i = 0; i < 16; ++i) {
      matrix(i / 4, i % 4) = number();
      known = known && std::isfinite(matrix(i / 4, i % 4));
    }
    if (!known)
      return std::nullopt;
    try {
      return io::toRigidMotion(matrix);
    }
    catch (const std::invalid_argument& error) {
      throw std::invalid_argument("columns " + names_[next_ - 16] + " to " + names_[next_ - 1] + ": the matrix " +
                                  error.what());
    }
  }
  std::invalid_argument
  wrong(const std::string& what) const
  {
    return std::invalid_argument("column " + names_[next_ - 1] + ": " + io::inQuotes(fields_[next_ - 1]) + " " + what);
  }

private:
  std::vector<std::string> fields_;
  std::vector<std::string> names_;
  std::size_t next_ = 0;
};

} // namespace

std::string
csvHeader()
{
  return kColumns;
}

std::string
toCsvLine(const ResultRow& row)
{
  Line line;
  line << io::csvField(row.dataset) << io::csvField(row.source) << io::csvField(row.target) << io::csvField(row.method)
       << io::csvField(row.status) << (row.converged ? "1" : "0") << (row.success ? "1" : "0")
       << shortNumber(row.rotation_error_deg) << shortNumber(row.translation_error_m) << shortNumber(row.rmse_m)
       << shortNumber(row.gt_rmse_m) << shortNumber(row.overlap) << shortNumber(row.confidence)
       << shortNumber(row.time_s) << shortNumber(row.cpu_s) << shortNumber(row.peak_rss_mib)
       << io::csvField(row.message);
  line.pose(row.T_target_source);
  line << std::to_string(row.pair) << shortNumber(row.found_overlap) << number(row.variation.resolution_m)
       << number(row.variation.noise_m) << number(row.variation.outliers) << number(row.variation.overlap)
       << toString(row.variation.perturbation) << std::to_string(row.seed) << number(row.source_points)
       << number(row.target_points);
  line.pose(row.truth);
  return line.text();
}

ResultRow
rowFromCsv(std::string_view line)
{
  Fields fields(line);
  ResultRow row;
  row.dataset = fields.text();
  row.source = fields.text();
  row.target = fields.text();
  row.method = fields.text();
  row.status = fields.text();
  row.converged = fields.truth();
  row.success = fields.truth();
  for (double* value : {&row.rotation_error_deg,
                        &row.translation_error_m,
                        &row.rmse_m,
                        &row.gt_rmse_m,
                        &row.overlap,
                        &row.confidence,
                        &row.time_s,
                        &row.cpu_s,
                        &row.peak_rss_mib})
    *value = fields.number();
  row.message = fields.text();
  row.T_target_source = fields.pose();
  row.pair = fields.whole();
  row.found_overlap = fields.number();
  for (double* value :
       {&row.variation.resolution_m, &row.variation.noise_m, &row.variation.outliers, &row.variation.overlap}) {
    *value = fields.number();
    if (!std::isfinite(*value))
      throw fields.wrong("is not a number");
  }
  try {
    row.variation.perturbation = parsePerturbation(fields.text());
  }
  catch (const std::invalid_argument&) {
    throw fields.wrong("is not none, rotation or se3");
  }
  row.seed = fields.whole();
  row.source_points = fields.number();
  row.target_points = fields.number();
  row.truth = fields.pose();
  return row;
}

std::string
rowKey(const std::string& dataset, std::size_t pair, const Variation& variation, const std::string& method)
{
  // Names as the file holds them: a folder's may have line ends.
  return io::csvField(dataset) + '\n' + std::to_string(pair) + '\n' + number(variation.resolution_m) + '\n' +
         number(variation.noise_m) + '\n' + number(variation.outliers) + '\n' + number(variation.overlap) + '\n' +
         toString(variation.perturbation) + '\n' + io::csvField(method);
}

std::string
describeVariation(const Variation& variation)
{
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (variation.resolution_m > 0)
    add("thinned to " + number(variation.resolution_m) + " m");
  if (variation.noise_m > 0)
    add("noise " + number(variation.noise_m) + " m");
  if (variation.outliers > 0)
    add("outliers " + number(100 * variation.outliers) + " %");
  if (variation.overlap > 0)
    add("overlap at most " + number(100 * variation.overlap) + " %");
  if (variation.perturbation == Perturbation::Rotation)
    add("source turned at random");
  if (variation.perturbation == Perturbation::Se3)
    add("source moved at random");
  return text.empty() ? "as it is" : text;
}

} // namespace apps
} // namespace pcl_ssfr
