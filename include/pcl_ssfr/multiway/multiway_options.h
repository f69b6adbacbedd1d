// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>
#include <pcl_ssfr/options.h>

#include <Eigen/Core>

#include <cstddef>
#include <optional>

namespace pcl_ssfr {

/// What linking keeps of each pair.
struct LinkConfig {
  int hypotheses = 4;              ///< most probable poses of a pair that are kept, [1, 10]
  double least_probability = 0.02; ///< of a kept pose, (0, 1): below, a building has no use for it
  /// SearchConfig::plans_below, at most, (0, 1]: of pairs that plan views alone solve nearly all have less, of rooms,
  /// most of whose pairs share nothing, few.
  double plans_below = 0.3;
};

/// Which pairs of scans are linked.
enum class PairRule {
  Auto,      ///< all up to CandidateConfig::all_up_to scans, candidates above
  All,       ///< all
  Candidates ///< those that are likely to share a place, their number in proportion to that of the scans
};

/// How pairs are chosen that are likely to share a place. Lengths are for scenes of scale 1.
struct CandidateConfig {
  std::size_t all_up_to = 150;   ///< scans: their 11,175 pairs take 18 to 35 minutes of a processor
  std::size_t alike = 6;         ///< partners of each scan by likeness: some four of them share a place with it
  std::size_t most = 30;         ///< partners of a scan that links lead to: in dense jobs more of them add no accuracy
  std::size_t near = 8;          ///< partners of each scan that are looked at as their sensors are nearest
  std::size_t apart_of_scan = 2; ///< partners by likeness of each scan in other parts where parts stay apart, ...
  std::size_t apart = 12;        ///< ... but of a part of few scans so many in all ...
  std::size_t apart_rounds = 10; ///< ... so many times, as long as parts come together
  double reach = 12;             ///< [m] longest of the distances between parallel planes that make scans alike: across
                                 ///< a large room
};

/// How the poses are chosen that make one consistent map. Lengths are for scenes of scale 1.
struct ChoiceConfig {
  double same_rotation = 0.07;   ///< [rad] two ways to a scan agree within this: two links of 2 degrees each
  double same_translation = 0.4; ///< [m] and this: two links at the bound of distinct poses (0.3 m), added in squares
  double loop_weight = 1.5;      ///< log odds that a loop of two sure links adds to, or takes from, a link
  double loop_bound = 6;         ///< log odds that loops may add at most: links of one building err together
  double sure = 0.5;             ///< probability from which on a link speaks for and against others
  /// Odds that a placed scan must have against each rival: of a hundred that are doubtful, one may be wrong. They are
  /// those of the links times those of the surfaces: links of places alike err together, so they never decide alone.
  double clear_odds = 100;
  double score_power = 9; ///< of the ratio of their scores, for the odds of the surfaces; fitted to poses of pairs
  double rival = 0.1;     ///< probability of a link from which on its pose is compared with the one chosen
  double lone = 0.95; ///< probability of a pair from which on it is sure by itself: it leads to more candidates, and
                      ///< to doubt where the map contradicts it too often
  /// Factor on matching distances and margins before the poses are exact, and on same_rotation and same_translation:
  /// what does not agree even so is another place.
  double loose = 2;
};

/// Storeys alike: when a storey of the map may be several, laid onto one another. Lengths [m] are those of buildings.
struct AliasConfig {
  bool check = true;              ///< look for them
  double level_normal = 0.97;     ///< cosine to the vertical from which on a surface is level: 14 degrees
  double most_floor = 3;          ///< [m] floors are at most this far below a sensor, and looked for as far to the side
  double flat_view = 0.4;         ///< variance of a field of view along its axis over that across: rings 0.1, a dome of
                                  ///< 60 degrees 0.2, all but a cone below the scanner 0.6
  double least_level_share = 0.7; ///< of the scans, that agree on a vertical: else none is known
  double same_level = 0.35;       ///< [m] sensors within this height are on one level, or as far above their floor:
                                  ///< two steps of a stair are more
  std::size_t least_scans = 3;    ///< at one height that make a level, or at one place: rooms may be alike instead
  double same_view = 0.8;         ///< share of the surface of two scans that meets, from which on they see the same
  double storey = 4.5; ///< [m] the way to the next level is shorter than this; floor and ceiling are seen within it
};

/// What distinguishes places that look alike: furniture, the patches of no large plane and the points of none. Lengths
/// and areas are for scenes of scale 1.
struct FurnitureConfig {
  double most_area = 1;    ///< [m^2] of the plane that such a patch is part of: less than a wall or a table
  double reach = 4;        ///< [m] within which patches are counted to that plane: across a room
  double thickness = 0.06; ///< [m] from the plane within which patches are of it
  double parallel = 0.985; ///< cosine between the normals of a plane: 10 degrees
  /// Factor on the margins of free space of a pair's score, (0, 1]: a chair stands nearer to the wall than those allow.
  double margin = 0.65;
  /// Share of the furniture in view that the other scan sees through, (0, 1), in the mean: at right poses ...
  double seen_through = 0.007;
  double seen_through_alike = 0.07; ///< ... and at those of places alike; fitted to seven simulated towers
  /// Factor on odds for one place, [0, 1]: what a scan sees of several others, which see the same of a place, is not
  /// new evidence each time. With 1 somewhat more scans are placed, and half as many again wrongly.
  double agreement = 0.75;
  /// Share of sure links that furniture must find false: there places look alike, and it distinguishes them, storeys
  /// too. Of six real places at most 0.04 are, of simulated towers 0.37 and more, of twin wings 0.15 and more.
  double least_false = 0.17;
};

/// The joint adjustment over the surfaces.
struct AdjustmentConfig {
  int rounds = 20;             ///< at most
  double last_step = 2e-5;     ///< [m], [rad] it stops when every scan moves less
  double least_matched = 0.02; ///< share of the patches of a pair that meet, from which on the pair takes part
  double damping = 1e-4;       ///< of the diagonal: what nothing determines stays where the pose graph puts it
  /// No more than this over n^4, n the scans of the part: a row of n scans bends against some 1 / n^4 of the diagonal,
  /// and a damping above that keeps it bent and calls it exact. Of 547 scans a thousandth of it gives the same poses
  /// and covariances.
  double damping_of_row = 10;
};

/// Everything that can be set of a multiway registration. The defaults need no change.
struct MultiwayOptions {
  Options registration;                   ///< of the pairs; its threads and time limit are not read
  unsigned threads = 0;                   ///< 0: all processors; the map never depends on it
  std::optional<Eigen::Vector3d> gravity; ///< up in the frame of every scan, any length > 0
  double gravity_tolerance = 0.0873;      ///< of it [rad], (0, pi]
  PairRule pairs = PairRule::Auto;        ///< which pairs are linked ...
  CandidateConfig candidates;             ///< ... and how those are found that are worth it
  LinkConfig link;                        ///< which hypotheses of a pair are kept
  ChoiceConfig choice;                    ///< which of them make the map
  AliasConfig alias;                      ///< what looks alike and is not the same: storeys ...
  FurnitureConfig furniture;              ///< ... and what distinguishes it
  AdjustmentConfig adjustment;            ///< of the poses
};

/** \brief Check every field.
 * \throw std::invalid_argument with the text "group.name = value, must ..." for the first that is out of range
 */
PCL_SSFR_EXPORT void
validate(const MultiwayOptions& options);

} // namespace pcl_ssfr
