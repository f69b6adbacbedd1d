// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/pairs/result_row.h>

#include <apps/io/csv_line.h>
#include <apps/io/text_scanner.h>
#include <apps/io/transform_file.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <type_traits>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr const char* kColumns =
    "dataset,source,target,method,status,converged,success,rotation_error_deg,translation_error_m,rmse_m,gt_rmse_m,"
    "overlap,confidence,time_s,cpu_s,peak_rss_mib,message,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23,T30,T31,T32,"
    "T33,pair,found_overlap,resolution_m,noise_m,outliers,overlap_limit,perturb,seed,source_points,target_points,"
    "G00,G01,G02,G03,G10,G11,G12,G13,G20,G21,G22,G23,G30,G31,G32,G33,pairs_from,origin_offset_m,merge_target,"
    "mirror_source,degrade_every,degrade_sector_deg,degrade_nearest,target_dataset,right_rank,lost_at";

/// Fields of a variation, in the order of forEachField(): the first are in the middle of a row, the others at its end.
constexpr std::size_t kEarlyFields = 5;
constexpr std::size_t kAllFields = std::numeric_limits<std::size_t>::max();

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

template <typename Value>
std::string
textOf(const Value& value)
{
  if constexpr (std::is_enum_v<Value>)
    return toString(value);
  else if constexpr (std::is_same_v<Value, bool>)
    return value ? "1" : "0";
  else if constexpr (std::is_integral_v<Value>)
    return std::to_string(value);
  else
    return number(value);
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
  variation(const Variation& variation, std::size_t begin, std::size_t end)
  {
    std::size_t place = 0;
    forEachField(variation, [&](const char*, const auto& value) {
      if (place >= begin && place < end)
        *this << textOf(value);
      ++place;
    });
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
  void
  variation(Variation& variation, std::size_t begin, std::size_t end)
  {
    std::size_t place = 0;
    forEachField(variation, [&](const char*, auto& value) {
      if (place >= begin && place < end)
        read(value);
      ++place;
    });
  }
  std::invalid_argument
  wrong(const std::string& what) const
  {
    return std::invalid_argument("column " + names_[next_ - 1] + ": " + io::inQuotes(fields_[next_ - 1]) + " " + what);
  }

private:
  void
  read(double& value)
  {
    value = number();
    if (!std::isfinite(value))
      throw wrong("is not a number");
  }
  void
  read(bool& value)
  {
    value = truth();
  }
  void
  read(std::size_t& value)
  {
    value = whole();
  }
  void
  read(Perturbation& value)
  {
    value = parsed(parsePerturbation);
  }
  void
  read(PairsFrom& value)
  {
    value = parsed(parsePairsFrom);
  }
  template <typename Value>
  Value
  parsed(Value (*parse)(const std::string&))
  {
    try {
      return parse(text());
    }
    catch (const std::invalid_argument& error) {
      throw std::invalid_argument("column " + names_[next_ - 1] + ": " + error.what());
    }
  }

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
  line << std::to_string(row.pair) << shortNumber(row.found_overlap);
  line.variation(row.variation, 0, kEarlyFields);
  line << std::to_string(row.seed) << number(row.source_points) << number(row.target_points);
  line.pose(row.truth);
  line.variation(row.variation, kEarlyFields, kAllFields);
  line << io::csvField(row.target_dataset) << number(row.right_rank) << io::csvField(row.lost_at);
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
  fields.variation(row.variation, 0, kEarlyFields);
  row.seed = fields.whole();
  row.source_points = fields.number();
  row.target_points = fields.number();
  row.truth = fields.pose();
  fields.variation(row.variation, kEarlyFields, kAllFields);
  row.target_dataset = fields.text();
  row.right_rank = fields.number();
  row.lost_at = fields.text();
  return row;
}

std::string
rowKey(const std::string& dataset,
       const std::string& target_dataset,
       std::size_t pair,
       const Variation& variation,
       const std::string& method)
{
  // Names as the file holds them: a folder's may have line ends.
  return io::csvField(dataset) + '\n' + io::csvField(target_dataset) + '\n' + std::to_string(pair) + '\n' +
         toJson(variation).dump() + '\n' + io::csvField(method);
}

} // namespace apps
} // namespace pcl_ssfr
