// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/drawing/chart.h>

#include "common/angles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kLabelSize = 13; // [pixels]
constexpr double kTickSize = 12;
constexpr Colour kGrid{0.88, 0.88, 0.88};
constexpr Colour kFrame{0.45, 0.45, 0.45};

std::string
tickText(double value, double step, bool percent)
{
  if (std::abs(value) < 1e-9 * step)
    value = 0;
  std::array<char, 40> text{};
  if (percent)
    std::snprintf(text.data(), text.size(), "%.4g %%", 100 * value);
  else
    std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

/// Everything that is drawn until the object ends stays within the chart.
class Clip {
public:
  Clip(cairo_t* context, const Chart& chart) : context_(context)
  {
    cairo_save(context);
    cairo_rectangle(context, chart.left, chart.top, chart.width, chart.height);
    cairo_clip(context);
  }
  ~Clip() { cairo_restore(context_); }
  Clip(const Clip&) = delete;
  Clip&
  operator=(const Clip&) = delete;

private:
  cairo_t* context_;
};

} // namespace

std::vector<double>
roundTicks(double low, double high, int count)
{
  std::vector<double> ticks;
  if (!(high > low) || count < 1)
    return ticks;
  const double rough = (high - low) / count;
  const double decade = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * decade;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * decade >= rough)
      step = factor * decade;
  for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i)
    ticks.push_back(i * step);
  return ticks;
}

void
drawChartFrame(cairo_t* context,
               const Chart& chart,
               const std::string& title,
               const std::string& x_label,
               const std::string& y_label,
               bool percent)
{
  constexpr double kPixelsATick = 46;
  constexpr double kPixelsAMark = 30;
  const double right = chart.left + chart.width;
  const double bottom = chart.top + chart.height;
  cairo_set_line_width(context, 1);
  const auto x_ticks = roundTicks(chart.x_low, chart.x_high, static_cast<int>(chart.width / kPixelsATick));
  const auto y_ticks = roundTicks(chart.y_low, chart.y_high, static_cast<int>(chart.height / kPixelsAMark));
  const auto stepOf = [](const std::vector<double>& ticks) { return ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0; };
  for (const double tick : x_ticks) {
    const double x = std::round(chart.x(tick)) + 0.5;
    setColour(context, kGrid);
    cairo_move_to(context, x, chart.top);
    cairo_line_to(context, x, bottom);
    cairo_stroke(context);
    drawAlignedText(context, x, bottom + 15, tickText(tick, stepOf(x_ticks), false), kTickSize, 0.5);
  }
  for (const double tick : y_ticks) {
    const double y = std::round(chart.y(tick)) + 0.5;
    setColour(context, kGrid);
    cairo_move_to(context, chart.left, y);
    cairo_line_to(context, right, y);
    cairo_stroke(context);
    drawAlignedText(context, chart.left - 6, y + 4, tickText(tick, stepOf(y_ticks), percent), kTickSize, 1);
  }
  cairo_rectangle(context,
                  std::round(chart.left) + 0.5,
                  std::round(chart.top) + 0.5,
                  std::round(chart.width),
                  std::round(chart.height));
  setColour(context, kFrame);
  cairo_stroke(context);
  drawText(context, chart.left, chart.top - 8, title, 14, true);
  drawAlignedText(context, chart.left + chart.width / 2, bottom + 33, x_label, kLabelSize, 0.5);
  if (!y_label.empty()) {
    cairo_save(context);
    cairo_translate(context, chart.left - 48, chart.top + chart.height / 2);
    cairo_rotate(context, -kPi / 2);
    drawAlignedText(context, 0, 0, y_label, kLabelSize, 0.5);
    cairo_restore(context);
  }
}

void
drawChartLine(cairo_t* context,
              const Chart& chart,
              const std::vector<double>& x,
              const std::vector<double>& y,
              const Colour& colour,
              double width)
{
  if (x.empty())
    return;
  const Clip clip(context, chart);
  cairo_new_path(context);
  for (std::size_t i = 0; i < x.size(); ++i)
    cairo_line_to(context, chart.x(x[i]), chart.y(y[i]));
  setColour(context, colour);
  cairo_set_line_width(context, width);
  cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
  cairo_stroke(context);
}

void
drawChartSteps(cairo_t* context,
               const Chart& chart,
               double first,
               double step,
               const Eigen::VectorXd& counts,
               const Colour& colour,
               double fill,
               double sign)
{
  if (counts.size() == 0)
    return;
  const Clip clip(context, chart);
  cairo_new_path(context);
  cairo_move_to(context, chart.x(first), chart.y(0));
  for (Eigen::Index i = 0; i < counts.size(); ++i) {
    const double y = chart.y(sign * counts[i]);
    cairo_line_to(context, chart.x(first + static_cast<double>(i) * step), y);
    cairo_line_to(context, chart.x(first + static_cast<double>(i + 1) * step), y);
  }
  cairo_line_to(context, chart.x(first + static_cast<double>(counts.size()) * step), chart.y(0));
  if (fill > 0) {
    setColour(context, colour, fill);
    cairo_fill_preserve(context);
  }
  setColour(context, colour);
  cairo_set_line_width(context, 1.2);
  cairo_stroke(context);
}

void
drawChartMark(cairo_t* context, const Chart& chart, double x, const Colour& colour, double width, bool dashed)
{
  if (!chart.spans(x))
    return;
  const Clip clip(context, chart);
  const std::array<double, 2> dashes{{7, 4}};
  cairo_set_dash(context, dashes.data(), dashed ? 2 : 0, 0);
  cairo_move_to(context, chart.x(x), chart.top);
  cairo_line_to(context, chart.x(x), chart.top + chart.height);
  setColour(context, colour);
  cairo_set_line_width(context, width);
  cairo_stroke(context);
  cairo_set_dash(context, nullptr, 0, 0);
}

void
drawAlignedText(cairo_t* context,
                double x,
                double y,
                const std::string& text,
                double size,
                double align,
                const Colour& colour,
                bool bold)
{
  cairo_select_font_face(
      context, "sans-serif", CAIRO_FONT_SLANT_NORMAL, bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(context, size);
  setColour(context, colour);
  cairo_move_to(context, x - align * textWidth(context, text), y);
  cairo_show_text(context, text.c_str());
}

void
drawNumberedMark(cairo_t* context, double x, double y, int number, const Colour& colour)
{
  constexpr double kRadius = 9; // [pixels]
  drawDot(context, x, y, kRadius, colour);
  drawAlignedText(context, x, y + 4, std::to_string(number), 11.5, 0.5, {1, 1, 1}, true);
}

double
drawParagraph(cairo_t* context, double x, double y, double width, const std::string& text, double size)
{
  std::istringstream words(text);
  std::string line;
  std::string word;
  drawAlignedText(context, 0, -100, "", size, 0); // sets the font that widths are measured in
  const double step = 1.4 * size;
  while (words >> word) {
    std::string longer = line;
    longer += (line.empty() ? "" : " ") + word;
    if (!line.empty() && textWidth(context, longer) > width) {
      drawText(context, x, y, line, size);
      y += step;
      line = word;
    }
    else {
      line = longer;
    }
  }
  if (!line.empty()) {
    drawText(context, x, y, line, size);
    y += step;
  }
  return y;
}

} // namespace apps
} // namespace pcl_ssfr
