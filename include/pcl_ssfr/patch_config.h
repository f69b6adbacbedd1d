// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>

#include <array>
#include <string>
#include <vector>

namespace pcl_ssfr {

// The tuned numbers of Profile::Default, for those who experiment: nobody has to set them. Lengths are for a scene of
// scale 1 (rooms to streets) and are multiplied by the scale of the pair once (METHOD, "Scale"). Where a number comes
// from is said next to it; "fitted" means by scripts/fit_posterior. Which ones matter: RESULTS, "What a number changes"
// (scripts/number_table): halved or doubled, half of all numbers change none of 221 hard pairs of 13 sets, most of the
// others one to four; distances and angles of a match, which the posterior was fitted with, change up to twenty.
// Unless said otherwise lengths are > 0, angles in (0, pi/2], counts >= 1, shares in [0, 1] and fitted weights >= 0;
// validate() says which one is not.

/** \brief How a scan's sensor is looked for among its points where its place is not known (METHOD, "The place of the
 * sensor").
 *
 * A place is rated by the directions in which something is seen from it, less those in which returns lie at two depths:
 * a sensor sees one. Places on a grid are rated by few points, the best of them moved to where they rate higher by more
 * and more. Measured on 131 scans of 13 sets and 110 merged clouds; lengths are those at scale 1.
 */
struct ViewpointSearchConfig {
  /// One level of the search. Points are drawn evenly.
  struct Level {
    int places{};  ///< rated, the best of the level before; of the first level: on the grid
    int points{};  ///< that rate a place
    double step{}; ///< of the grid [m], wider where it would have more places; below: places move until none is better
  };
  /// The best places of each are rated by more points in the next.
  std::array<Level, 4> levels{{{1500, 1500, 1.0}, {150, 6000, 1.0}, {3, 12000, 0.25}, {1, 40000, 0.0625}}};
  /// Directions for each point that rates the places of the grid, at most four for each point of the scan; elsewhere
  /// four. Few points make wide directions, in which ground seen at a grazing angle has two depths from the sensor too:
  /// with four, most of the sensors on an open road are missed. In narrow ones returns hardly meet where a place moves.
  int grid_directions = 8;
  double reach = 0.25;          ///< of the grid: mean log range of the points above the least; sensors: within 0.25
  double depth_ratio = 1.25;    ///< two depths: the farthest return is beyond this multiple of the nearest and
                                ///< PreparationConfig::margin; with 1.5 places in car parks are 6 m off
  double two_depth_weight = 10; ///< of a direction with two depths, in directions that see something; with 5: as above
  /// A place is accepted when it is rated this much higher than the mean of six places around it, as a share of the
  /// points: 129 of 131 sensors of single scans are, and of 366 places 50 m off none reaches 0.03 (with 6,000 points
  /// one of 297 reaches 0.047).
  double min_contrast = 0.05;
  /// Bound on the share of directions with two depths, of those that hold several returns, seen from a place that was
  /// found. Single scans: car parks 0.099 and less, a street 0.134; ten of twelve merged ones of car parks 0.142 and
  /// more. Poses of merged clouds are right with any bound up to this.
  double max_two_depths = 0.135;
  double contrast_distance = 5; ///< of these places from it [m]: at 3 wide streets have no contrast, at 8 no sensor has
};

/// Planar patches: octree cells that a plane fits (METHOD, "Patches").
struct PatchConfig {
  double range_noise = 0.001; ///< growth of the thickness with range [m/m]
  double max_flatness = 0.3;  ///< thickness over the second extent (both standard deviations), (0, 1)
  int finest_level = 3;       ///< finest cells have an edge of leaf * 2^finest_level, [0, 20)
  int coarsest_level = 6;     ///< coarsest cells have an edge of leaf * 2^coarsest_level, [finest_level, 20)
  int min_points = 5;         ///< fewest thinned points of a patch, >= 3
};

/** \brief Preparation of one scan in the default profile. Lengths are those at scale 1 [m], of rooms to streets; the
 * scale of the scene multiplies them once, see scaled().
 */
struct PreparationConfig {
  int min_points = 50; ///< returns of a scan that is registered

  // Scale of the scene.
  double smallest_radius = 1.5; ///< scenes of a radius (see ScanExtent) from this ...
  double largest_radius = 120;  ///< ... to this have scale 1 [m]
  int min_points_per_cell = 12; ///< thinned points in the coarsest cell of a typical point; else the scale is doubled

  // Patches.
  PatchConfig patches;       ///< their shape
  double leaf = 0.025;       ///< spacing of thinned points; patches have edges of 8 to 64 leaves [m]
  double thickness = 0.03;   ///< largest standard deviation across a patch of a scan of usual noise [m]
  double max_noise = 4;      ///< noisy scans may have patches up to so many times as thick
  double thin_share = 0.25;  ///< of the surface, the thinnest: clutter leaves it alone, so it shows the noise
  double noise_factor = 1.6; ///< thickness that is allowed, over that of the thickest patch of the thin share

  // Main normals, chords on the unit sphere.
  int max_main_normals = 14;          ///< bound on the pairs of them that are tried as rotations
  double density_radius = 0.1;        ///< width of the kernel; half the bandwidth, and closer modes are one
  double min_relative_density = 0.02; ///< of the densest region
  int max_density_queries = 8192;     ///< >= 0; bound on the time of scans with very many patches

  // What the pair is searched, refined and judged by.
  double same_facing = 0.35;   ///< [rad] surface whose normal is within this of a main normal belongs to it, and in the
                               ///< fine refinement and the evidence patches match whose normals are
  double loose_facing = 0.5;   ///< [rad] the same in the search and the coarse refinement
  int votes = 160;             ///< places that vote in the search for translations
  double range_cell = 0.01745; ///< [rad] width of a direction of the range image
  /// [m] of a match, where the fine refinement ends and what counts for a pose: patches whose plane and edges are
  /// within this of a place are found, wherever the grid of the index lies. Histograms along an axis have bins as wide.
  /// Of a noisy scan more, as its matches are as much farther apart.
  double match = 0.1;
  /// [m] beyond the edge of a patch it is still the patch, in front of the nearest return it is not yet free space, and
  /// so much behind it the farthest one of a direction may lie before they are two depths.
  double margin = 0.3;
  int coarse_patches = 600; ///< that stand for all in the coarse refinement, and where scans are seen along an axis
  /// >= 0, points that fit no plane, of a scan, that are laid into the other one: one of a finest cell. They are part
  /// of the furniture of maps, too.
  int clutter_points = 1000;
  int polish_points = 2;         ///< of each ...
  int polish_group = 25;         ///< ... thinned points of a patch for the polish; larger groups ...
  int max_polish_points = 20000; ///< ... where they would be more in all than this

  ViewpointSearchConfig viewpoint; ///< where the place of the sensor is not known
};

/// One pass of the search for poses: how many of them it looks at.
struct SearchPass {
  int peaks_first{};     ///< correlation peaks tried along the best observed axis, >= 1
  int peaks_second{};    ///< and along the second, >= 1
  int refined{};         ///< hypotheses refined, at most, >= 1
  int distinct{};        ///< distinct poses that go on to the fine refinement, >= 1
  bool little_overlap{}; ///< by the votes for a pose for each one against it: scans that share little
};

/// The search for poses (METHOD, "Search").
struct SearchConfig {
  double direction_error = 0.12; ///< [rad] a main normal is this exact at worst: inner angles of matched pairs agree
                                 ///< within it, rotations that are closer are merged, and surface faces
                                 ///< along an axis within twice it, as both may err
  int rotations = 24;            ///< best supported rotations that are searched: as many as a Manhattan room has
  int sweep_axes = 2; ///< >= 0; main normals about which rotations are swept where others do not determine them: three
                      ///< solve no more real pairs and no more simulated ones
  int sweep_steps = 40; ///< rotations about an axis, 9 degrees apart: half of it is in reach of the refinement
  /// A scene is round about an axis when, of the surface that faces across it, at most this share does in the fullest
  /// third of all directions (as many as sweep_steps): then the main normals across the axis are arbitrary.
  double round_share = 0.6;
  /// Plan views are drawn where no rotation lays main normals on each other that stand for this share of the surface,
  /// besides those along the best supported of them: 1: always, as a pair has nothing else left; maps have other pairs.
  double plans_below = 1;
  double screening_share = 0.5;    ///< of the best count of votes so far, that an eighth of them must promise
  double contradiction_weight = 2; ///< of a vote against a pose of scans that share much, rough as it is yet
  /// Share of the most votes that poses have which are refined first. Of 271 real pairs all solved ones had a pose near
  /// the truth with 0.65 of them, of 375 simulated ones 373 with 0.4.
  double promising = 0.4;
  SearchPass much_overlap = {5, 8, 80, 8, false}; ///< for scans that share much, first
  /// For scans that share little, when the first pass does not decide: three times as many poses. As few peaks as in
  /// the first pass solve as many listed pairs, and lose one of a map that has 12 % in common.
  SearchPass little_overlap = {8, 24, 240, 16, true};
};

/// Refinement and polish of poses, and which of them are the same (METHOD, "Refinement").
struct RefinementConfig {
  double coarse_reach = 0.5;      ///< [m] plane distance of a match at the start of the coarse refinement; half of it
                                  ///< is the step of the exhaustive search for translations
  int coarse_steps = 6;           ///< of the coarse refinement
  int fine_steps = 8;             ///< of the fine refinement, at most; smaller steps than match_noise end it
  double match_noise = 0.001;     ///< [m] what matches are good to, at best: smaller motions find no other ones
  double kept_score = 0.9;        ///< share of the score that a refinement, which makes a pose more exact, may cost
  double distinct_distance = 0.3; ///< [m] poses nearer than this at the source's sensor ...
  double distinct_angle = 0.05;   ///< [rad] ... and than this are one. So the polish looks for matches as far; it ends
                                  ///< at PreparationConfig::match, or at less: what the matches leave,
                                  ///< UncertaintyConfig::bound_deviations times to either side
  double explored_deviation = 0.01; ///< [m] standard deviation of the matched surface along a motion from which on the
                                    ///< neighbourhood along it is searched for another optimum; 0.005 finds no more
};

/// What is a match and what contradicts a pose (METHOD, "Evidence"), besides PreparationConfig::match and margin.
struct EvidenceConfig {
  double loose_match = 0.2;         ///< [m] of a match where the coarse refinement ends and the fine one starts
  double range_margin = 0.05;       ///< of a range, before and behind what was seen, in addition
  double contradiction_weight = 14; ///< of the score: contradictions are rare and precious
};

/** \brief The posterior over the poses of a pair and "none of them" (METHOD, "Posterior"). Fitted; only ratios of
 * evidence count.
 *
 * Log odds that the truth is among them: known + any_matches log(b + 1) + any_third log(t), where, of the most probable
 * pose, b is the weighted number of matches that face their sensor and are in none of the three planes that determine a
 * pose, and t the share of the surface that matches and faces the least represented direction. Among them pose k has
 * the log weight matches log(b + 1) + second log(m2 + 1) + third log(m3 + 1): m2 and m3 the matched surface that faces
 * the second and the third of the directions that it faces, in square metres at scale 1: so much may meet by chance. To
 * both FreeSpaceConfig adds what was seen of free space.
 */
struct PosteriorConfig {
  double known{};       ///< for "any of them", constant
  double any_matches{}; ///< for "any of them"
  double any_third{};   ///< for "any of them"
  double matches{};     ///< a corner fits any corner: what matches besides distinguishes poses
  double second{};      ///< ground laid on ground matches wherever it is laid: the first direction says nothing
  double third{};       ///< without it much surface may meet, and the pose still slides
};

/** \brief What the free space that both sensors saw adds to the posterior (METHOD, "Posterior"). Fitted with it.
 *
 * For "any of them" log((u + 1) / (x + 1)), and for pose k clutter log(u + 1) - contradictions log(c^2 + 1) / 2: u the
 * number of points that fit no plane and lie at the depth that the other sensor saw, x the weighted number of patches
 * that face their sensor and contradict, c the share of all that contradict in JudgementConfig::chance_contradictions.
 */
struct FreeSpaceConfig {
  double clutter = 3.4;        ///< a crown of leaves has no planes to match, but stands where it was seen
  double contradictions = 6.3; ///< a car that has moved is twenty patches of a near scan, and two of a far one
};

/// How well a polished pose is known (METHOD, "Uncertainty").
struct UncertaintyConfig {
  /// Standard deviation of each patch and of each match, besides what is seen [m], at least: what the errors of
  /// simulated pairs of a terrestrial scanner (0.4 mm of noise) leave; without it they are twice as large as claimed.
  double noise_floor = 0.0003;
  /// And by the noise of the matches: no patch is better known than the mean of the hundred points that it has. It
  /// counts where few patches of few rings seem to agree.
  double patch_noise = 0.1;
  /// Share of the curvature that matches keep where a patch does not face its sensor: they are found again wherever the
  /// pose is, so they pull less than their distances say. Fitted by likelihood to the errors of 285 pairs of four
  /// simulated sensors; 0.1 to 0.3 are as good for those with 32 rings and more, of which few matches are such.
  double unseen_curvature = 0.2;
  /// Least strength of a translation that is determined. Relative, because no deviation shows it: in a corridor without
  /// an end small tilted patches err alike in both scans, and claim a place along it to a few centimetres.
  double min_translation = 0.005;
  /// Largest standard deviation of a rotation that is determined [rad]: nine of ten such poses are right to two
  /// degrees.
  double max_rotation = 0.0212;
  /// Standard deviations that a bound stands for, 99.7 %: the tolerance of a given vertical, correspondence_distance
  /// and the scales of matches.
  double bound_deviations = 3;
};

/// What is known of a pose beforehand, and how far it counts (METHOD, "Priors").
struct PriorConfig {
  double pose_error = 0.01;       ///< [rad] of the rotation of a refined pose
  double match_inflation = 5;     ///< deviation of a tilt over what its matches claim, which err where they are few
  double guess_trust = 30;        ///< prior odds of a pose at the guess over one far from it
  double guess_deviation = 1;     ///< [m] of a guess without a tolerance, rotations at the radius of the scan
  double sensor_on_sensor = 0.05; ///< prior odds of a sensor that has not moved, by a bin of the histograms: the
                                  ///< patterns of the rays coincide there, which looks like evidence
};

/// What follows from the posterior.
struct JudgementConfig {
  EvidenceConfig evidence;                                       ///< what counts for a pose and against it
  PriorConfig prior;                                             ///< what is known beforehand
  UncertaintyConfig uncertainty;                                 ///< how well a pose is known
  PosteriorConfig posterior = {-3.1, 0.74, 0.7, 0.67, 1.3, 2.5}; ///< where both sensors' places are known or found
  FreeSpaceConfig free_space;                                    ///< and with it what they saw through
  /// Else, where nothing can contradict. The last three are half of what fits: most half turns of a place fit there.
  PosteriorConfig posterior_blind = {-1.95, 1.35, 1, 1.9, 0.8, 1.9};
  /// Share of the patches that may contradict a pose by chance, added in squares to those that do: with half of it
  /// exact half turns of a room differ by noise alone.
  double chance_contradictions = 0.003;
  /// Probability that the truth is among the poses from which on no other is looked for. Poses whose odds against the
  /// best one are what this leaves, 1 : 10, are polished too, and refined from the square of that on: less is known
  /// then.
  double decided = 0.9;
  double unsettled = 0.5; ///< confidence, at most, of the best pose of a search that was cut short, and of one
                          ///< with a direction that the scene does not determine
  /// Share of the surface from which on a status names it as the reason: that contradicts, of what is visible; with
  /// less that meets, a message doubts that the scans show one place.
  double named_share = 0.1;
};

/// All numbers of Profile::Default beyond the options.
struct PatchProfileConfig {
  PreparationConfig preparation; ///< of each scan
  SearchConfig search;           ///< for poses
  RefinementConfig refinement;   ///< of poses
  JudgementConfig judgement;     ///< of poses
};

/// The preparation of a scene of another \p scale > 0: every length that is given at scale 1 is multiplied by it.
PCL_SSFR_EXPORT PreparationConfig
scaled(const PreparationConfig& config, double scale);

/// Names of all numbers, such as "search.rotations", in the order of their definition.
PCL_SSFR_EXPORT std::vector<std::string>
numberNames();

/** \brief Set one number by its name.
 * \throw std::invalid_argument with the text "group.name = value, must ..." when it may not have this value, or saying
 * that there is no such number
 */
PCL_SSFR_EXPORT void
setNumber(PatchProfileConfig& config, const std::string& name, double value);

/** \brief Check every field.
 * \throw std::invalid_argument with the text "group.name = value, must ..." for the first that is out of range.
 */
PCL_SSFR_EXPORT void
validate(const PatchProfileConfig& config);

} // namespace pcl_ssfr
