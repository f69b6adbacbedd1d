// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/drawing/drawing.h>

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A chart within a picture: where it lies [pixels] and what its axes span. Values outside are cut off.
struct Chart {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;
  double x_low = 0;
  double x_high = 1;
  double y_low = 0;
  double y_high = 1;

  double
  x(double value) const
  {
    return left + (value - x_low) / (x_high - x_low) * width;
  }
  double
  y(double value) const
  {
    return top + (y_high - value) / (y_high - y_low) * height;
  }
  bool
  spans(double x_value) const
  {
    return x_value >= x_low && x_value <= x_high;
  }
};

/// Round values for the marks of an axis, about \p count of them.
std::vector<double>
roundTicks(double low, double high, int count);

/// Frame, marks and labels of both axes, and the title above; \p percent writes the marks of y as per cent.
void
drawChartFrame(cairo_t* context,
               const Chart& chart,
               const std::string& title,
               const std::string& x_label,
               const std::string& y_label,
               bool percent = false);

/// A line through points; \p x and \p y of the same size.
void
drawChartLine(cairo_t* context,
              const Chart& chart,
              const std::vector<double>& x,
              const std::vector<double>& y,
              const Colour& colour,
              double width = 1.6);

/// A histogram as steps from \p first with \p step a bin; filled when \p fill > 0 (its opacity), \p sign -1: downwards.
void
drawChartSteps(cairo_t* context,
               const Chart& chart,
               double first,
               double step,
               const Eigen::VectorXd& counts,
               const Colour& colour,
               double fill,
               double sign = 1);

/// A vertical line over the whole height, dashed where asked for.
void
drawChartMark(cairo_t* context, const Chart& chart, double x, const Colour& colour, double width, bool dashed);

/// Text in a colour; \p align 0: starts at x, 0.5: centred, 1: ends there.
void
drawAlignedText(cairo_t* context,
                double x,
                double y,
                const std::string& text,
                double size,
                double align,
                const Colour& colour = kInk,
                bool bold = false);

/// A number inside a disc, for marks that a table explains.
void
drawNumberedMark(cairo_t* context, double x, double y, int number, const Colour& colour);

/// Text broken into lines of at most \p width pixels in the given size; returns the baseline after the last one.
double
drawParagraph(cairo_t* context, double x, double y, double width, const std::string& text, double size);

} // namespace apps
} // namespace pcl_ssfr
