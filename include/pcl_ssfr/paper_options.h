// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>

namespace pcl_ssfr {

// Options of the stages of the method as published (Profile::Paper2017); the constants are those of the
// implementation of July 2017 unless another year is named.

/// Options of the paper's point sampling and normals (paper, section 3.1; METHOD stage 1).
struct NormalOptions {
  double pre_leaf = 0.01; ///< keep one real point per voxel of this size before the normals [m]; 0: keep all
  double radius = 0;      ///< PCA radius r [m]; 0: from the data
  double leaf = 0;        ///< keep one real point per voxel of this size after the normals [m]; 0: from the data
  double max_range = 0;   ///< drop points farther than this from the viewpoint [m]; 0: no bound
  bool away_from_viewpoint = false; ///< sign of the normals: towards the viewpoint (2017) or away from it (2019)
  bool use_given_normals = true;    ///< take finite unit normals that the scan already carries
};

/// Options of the density filter on the Gaussian sphere (paper, section 3.2; METHOD stages 3 and 4).
struct DensityOptions {
  /// How a neighbour counts.
  enum class Kernel {
    Count,   ///< weight of the neighbours within \ref radius (implementation of 2017)
    Gaussian ///< weight times exp(-d^2 / (radius/2)^2) (implementation of 2019)
  };
  double radius = 0.06;                ///< r_d, chord on the unit sphere, (0, 1]
  Kernel kernel = Kernel::Count;       ///< how a neighbour counts
  int max_regions = 6;                 ///< number of densest regions to take, >= 1
  double silence_chord = 0.3;          ///< directions this near to a taken peak are no further peaks, chord (0, 2]
  double min_relative_density = 0;     ///< stop at peaks below this share of the densest one, [0, 1]
  bool reject_elongated = false;       ///< drop regions that curved surfaces leave (implementation of 2019)
  double max_elongation = 3;           ///< ratio of the two largest covariance eigenvalues that counts as elongated
  double max_elongated_chord = 0.1743; ///< spread 2 sqrt(l1) beyond which an elongated region is dropped, chord
  int max_region_points = 3000;        ///< at most so many (evenly strided) directions are kept in a region, >= 1
  int max_queries = 0;                 ///< at most so many (evenly strided) directions may be peaks, >= 0; 0: all
};

/// Options of the mean shift on the Gaussian sphere (paper, section 3.3; METHOD stage 5).
struct MeanShiftOptions {
  double bandwidth = 0.1;   ///< chord on the unit sphere, (0, 2]
  double tolerance = 1e-7;  ///< stop when the shift is shorter, chord, > 0
  int max_iterations = 200; ///< per region, >= 1
  double merge_chord = 0.5; ///< modes closer than this are one (the heavier stays), chord [0, 2)
};

/// Options of the candidate rotations (paper, section 3.4; METHOD stages 6 to 8).
struct RotationOptions {
  double max_abs_cos = 0.9;      ///< two main normals form a pair when |cos| is below this, (0, 1)
  double angle_tolerance = 0.05; ///< inner angles of matched pairs agree within this [rad], (0, pi/2)
  double merge_angle = 0;        ///< rotations closer than this are one [rad]; 0: keep all (as in the paper)
  double refit_angle = 0.1;      ///< when merging: a main normal supports a rotation within this [rad]
};

/// Options of the histograms along an axis (paper, section 3.5; METHOD stage 10).
struct HistogramOptions {
  /// Which surfaces are projected, by the angle between their normal and the axis.
  enum class Facing {
    Either,  ///< |cos| > parallel_cos: both signs of the normal fall into one histogram (the paper)
    Forward, ///< cos > parallel_cos: only surfaces that face along the axis
    Backward ///< cos < -parallel_cos: only surfaces that face against the axis
  };
  /// How full bins, large walls, are bounded.
  enum class Clip {
    None,        ///< not at all
    UniformMean, ///< bins above clip_factor times the mean over all bins (2017: 3)
    MeanSigma    ///< bins above the mean + clip_factor standard deviations of the bins (2019: 2)
  };
  double bin_width = 0.015;        ///< [m], > 0
  double parallel_cos = 0.99;      ///< a sample counts when its normal is parallel to the axis, (0, 1]
  Facing facing = Facing::Either;  ///< which surfaces are projected
  Clip clip = Clip::UniformMean;   ///< how full bins are bounded
  double clip_factor = 3;          ///< > 0, see Clip
  bool normalise = true;           ///< divide by the total weight before clipping
  Eigen::Index max_bins = 1000000; ///< bound on the memory of one histogram; wider data throw std::length_error
};

/// Options of the peaks of a correlation (paper, section 3.5; METHOD stage 11).
struct CorrelationOptions {
  int envelope_half_window = 10; ///< bins; subtract the running median envelope first (2017); 0: plain
  int max_peaks = 1;             ///< >= 1
  double min_separation = 0;     ///< peaks nearer than this to a higher one are dropped [m], >= 0
  bool sub_bin = false;          ///< refine each peak by a parabola through its neighbours
};

/// Options of the translation by 1-D correlations (paper, section 3.5; METHOD stages 9 to 11).
struct TranslationOptions {
  /// How the third axis is chosen once a target pair gives the first two.
  enum class ThirdAxis {
    FirstMode,   ///< first target main normal with |cos| < max_abs_cos to both and |triple product| >
                 ///< min_triple_product; none: the candidate is dropped (2017)
    CrossProduct ///< main normal within cross_angle of a x b best matched by a rotated source normal, else a x b (2019)
  };
  ThirdAxis third_axis = ThirdAxis::FirstMode; ///< how the third axis is chosen
  double max_abs_cos = 0.9;                    ///< of two axes, (0, 1)
  double min_triple_product = 0.1;             ///< of the three axes, [0, 1)
  double cross_angle = 1.0472;                 ///< see ThirdAxis::CrossProduct [rad]
  HistogramOptions histogram;                  ///< along each axis
  CorrelationOptions correlation;              ///< of the two histograms of an axis
};

/// Options of the paper's selection and fine pass (METHOD stages 12 and 13).
struct LcpOptions {
  double leaf = 0;              ///< both scans are thinned to this, and it is the inlier radius [m]; 0: from the data
  bool kernel_sum = false;      ///< score by sum of exp(-d/t) (2019) instead of the count (2017)
  int fine_factor = 100;        ///< the fine pass uses bin_width / fine_factor; 0: no fine pass
  double fine_smoothing = 0.01; ///< width of the mean filter of the fine pass [m]
  double fine_range_bins = 1.5; ///< shifts are searched within so many coarse bins
};

/// All stages of the method as published.
struct PaperOptions {
  NormalOptions normals;          ///< normals
  DensityOptions density;         ///< densest regions of the Gaussian sphere
  MeanShiftOptions mean_shift;    ///< main normals
  RotationOptions rotation;       ///< candidate rotations
  TranslationOptions translation; ///< translations
  LcpOptions lcp;                 ///< selection and fine pass
};

} // namespace pcl_ssfr
