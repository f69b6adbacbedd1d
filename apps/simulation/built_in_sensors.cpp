// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/built_in_sensors.h>

namespace pcl_ssfr::simulation {

namespace {

// Where a figure comes from, and which ones are assumptions, is said in docs/SIMULATOR.md.

constexpr const char* kHokuyoUtm30lx = R"json({
  "name": "hokuyo_utm30lx",
  "description": "Hokuyo UTM-30LX line scanner on a nodding unit",
  "sources": [
    "Hokuyo Automatic, Scanning Laser Range Finder UTM-30LX/LN Specification: 0.1 to 30 m, 270 deg, 0.25 deg, 25 ms a line, repeated accuracy below 10 mm to 10 m and below 30 mm to 30 m, resolution 1 mm",
    "Hokuyo Automatic, Communication Protocol Specification for SCIP 2.0, C-42-03320B, table 2: steps 0 to 1080 of 1440 a turn",
    "Assumed: the unit's angles (the floor 30 degrees in front to 30 degrees behind the zenith), 340 lines, a beam as wide as its angular step"
  ],
  "pattern": {
    "kind": "turning_line",
    "line_min_deg": -135, "line_max_deg": 135, "line_count": 1081,
    "turn_min_deg": -30, "turn_max_deg": 150, "turn_count": 340,
    "turn_axis": [0, -1, 0],
    "plane_forward": [1, 0, 0], "plane_sideways": [0, 1, 0]
  },
  "range": {
    "min_range_m": 0.1, "max_range_m": 30, "reference_reflectance": 0.9,
    "bias_m": 0, "sigma_m": 0.004, "sigma_per_metre": 0.0006, "quantum_m": 0.001,
    "angular_jitter_deg": 0.02, "beam_divergence_deg": 0.25, "beam_diameter_m": 0.005, "pulse_length_m": 0.75,
    "drop_rate": 0.001
  },
  "scan_time_s": 8.5,
  "mount_height_m": 1.0
})json";

constexpr const char* kLeicaP20 = R"json({
  "name": "leica_p20",
  "description": "Leica ScanStation P20 terrestrial scanner, 12.5 mm at 10 m",
  "sources": [
    "Leica Geosystems, Leica ScanStation P20 Product Specifications: 0.4 to 120 m at 18 % reflectivity, range noise 0.4 mm rms at 10 m, linearity error at most 1 mm, 360 x 270 deg, angular accuracy 8 arc seconds, beam 2.8 mm and 0.2 mrad, 1,000,000 points a second",
    "Assumed: growth of the noise with range, the angular jitter of a single beam, a minute a scan"
  ],
  "pattern": {
    "kind": "sphere",
    "azimuth_min_deg": 0, "azimuth_max_deg": 360, "azimuth_count": 5027,
    "elevation_min_deg": -55, "elevation_max_deg": 90, "elevation_count": 2025
  },
  "range": {
    "min_range_m": 0.4, "max_range_m": 120, "reference_reflectance": 0.18,
    "bias_m": 0, "sigma_m": 0.0003, "sigma_per_metre": 0.00001, "quantum_m": 0.0001,
    "angular_jitter_deg": 0.001, "beam_divergence_deg": 0.01146, "beam_diameter_m": 0.0028, "pulse_length_m": 0.3,
    "drop_rate": 0
  },
  "scan_time_s": 60,
  "mount_height_m": 1.6
})json";

constexpr const char* kVelodyneHdl32e = R"json({
  "name": "velodyne_hdl32e",
  "description": "Velodyne HDL-32E, 32 rings, 10 turns a second",
  "sources": [
    "Velodyne, HDL-32E User's Manual and Programming Guide, 63-9113: vertical angles of the 32 lasers (laser firing sequence), 5 cm to 100 m, distances in steps of 2 mm, laser spot 4 x 2 inches at 100 feet",
    "Velodyne, HDL-32E Data Sheet, 97-0038: accuracy 2 cm (one sigma at 25 m), 5 to 20 Hz, up to 695,000 points a second",
    "Assumed: the range holds for half of the light coming back, 0.1 % lost"
  ],
  "pattern": {
    "kind": "rings",
    "azimuth_min_deg": 0, "azimuth_max_deg": 360, "azimuth_count": 2170,
    "ring_elevations_deg": [
      -30.67, -29.33, -28, -26.67, -25.33, -24, -22.67, -21.33, -20, -18.67, -17.33, -16, -14.67, -13.33, -12, -10.67,
      -9.33, -8, -6.67, -5.33, -4, -2.67, -1.33, 0, 1.33, 2.67, 4, 5.33, 6.67, 8, 9.33, 10.67
    ]
  },
  "range": {
    "min_range_m": 0.05, "max_range_m": 100, "reference_reflectance": 0.5,
    "bias_m": 0, "sigma_m": 0.02, "sigma_per_metre": 0, "quantum_m": 0.002,
    "angular_jitter_deg": 0.01, "beam_divergence_deg": 0.135, "beam_diameter_m": 0.01, "pulse_length_m": 0.75,
    "drop_rate": 0.001
  },
  "scan_time_s": 0.1,
  "mount_height_m": 1.9
})json";

constexpr const char* kVelodyneVlp16 = R"json({
  "name": "velodyne_vlp16",
  "description": "Velodyne VLP-16 (Puck), 16 rings, 10 turns a second",
  "sources": [
    "Velodyne LiDAR, VLP-16 User Manual, 63-9243 Rev. D: 16 lasers from -15 to 15 deg in steps of 2 deg, all fired every 55.296 microseconds, up to 100 m, typical accuracy 3 cm, distances in steps of 2 mm",
    "Velodyne LiDAR, VLS-128 User Manual, 63-9483, table F-1: beam divergence 3.0 x 1.5 mrad (the same laser pulse)",
    "Assumed: the range holds for half of the light coming back, nothing nearer than 0.5 m, accuracy read as one sigma, 0.1 % lost"
  ],
  "pattern": {
    "kind": "rings",
    "azimuth_min_deg": 0, "azimuth_max_deg": 360, "azimuth_count": 1808,
    "ring_elevations_deg": [-15, -13, -11, -9, -7, -5, -3, -1, 1, 3, 5, 7, 9, 11, 13, 15]
  },
  "range": {
    "min_range_m": 0.5, "max_range_m": 100, "reference_reflectance": 0.5,
    "bias_m": 0, "sigma_m": 0.03, "sigma_per_metre": 0, "quantum_m": 0.002,
    "angular_jitter_deg": 0.01, "beam_divergence_deg": 0.12, "beam_diameter_m": 0.01, "pulse_length_m": 0.75,
    "drop_rate": 0.001
  },
  "scan_time_s": 0.1,
  "mount_height_m": 1.2
})json";

constexpr const char* kSickLms200 = R"json({
  "name": "sick_lms200",
  "description": "SICK LMS 200 line scanner on a nodding unit",
  "sources": [
    "SICK, Technical Description LMS200/211/221/291 Laser Measurement Systems, 8008970: 180 deg, 0.5 deg in 26.67 ms, 10 m at 10 % reflectivity, resolution 10 mm, systematic error +-15 mm, statistical error 5 mm (one sigma)",
    "Ye, Borenstein, Characterization of a 2-D Laser Scanner for Mobile Robot Obstacle Negotiation, ICRA 2002: mixed pixels",
    "Assumed: the unit's angles (-50 to 70 deg), 226 lines, 25 m (the paper's set DS4-S), growth of the noise with range, a beam as wide as its angular step"
  ],
  "pattern": {
    "kind": "turning_line",
    "line_min_deg": -90, "line_max_deg": 90, "line_count": 361,
    "turn_min_deg": -50, "turn_max_deg": 70, "turn_count": 228,
    "turn_axis": [0, -1, 0],
    "plane_forward": [1, 0, 0], "plane_sideways": [0, 1, 0]
  },
  "range": {
    "min_range_m": 0.1, "max_range_m": 25, "reference_reflectance": 0.625,
    "bias_m": 0, "sigma_m": 0.005, "sigma_per_metre": 0.0002, "quantum_m": 0.01,
    "angular_jitter_deg": 0.02, "beam_divergence_deg": 0.25, "beam_diameter_m": 0.01, "pulse_length_m": 0.75,
    "drop_rate": 0.001
  },
  "scan_time_s": 6.1,
  "mount_height_m": 0.8
})json";

constexpr const char* kLivoxMid360 = R"json({
  "name": "livox_mid360",
  "description": "Livox Mid-360, non-repetitive, one second of beams",
  "sources": [
    "Livox, Mid-360 User Manual v1.0 (2023), specifications: 40 m at 10 % reflectivity, 360 x -7 to 52 deg, range precision 2 cm (one sigma at 10 m), angular precision better than 0.15 deg, nothing nearer than 0.1 m, 200,000 points a second",
    "Assumed: the curve of the beams, their divergence, a scan of one second (ten frames), 0.1 % lost"
  ],
  "pattern": {
    "kind": "rosette",
    "azimuth_min_deg": 0, "azimuth_max_deg": 360,
    "elevation_min_deg": -7, "elevation_max_deg": 52,
    "beam_count": 200000
  },
  "range": {
    "min_range_m": 0.1, "max_range_m": 40, "reference_reflectance": 0.1,
    "bias_m": 0, "sigma_m": 0.02, "sigma_per_metre": 0, "quantum_m": 0.001,
    "angular_jitter_deg": 0.1, "beam_divergence_deg": 0.15, "beam_diameter_m": 0.005, "pulse_length_m": 0.75,
    "drop_rate": 0.001
  },
  "scan_time_s": 1,
  "mount_height_m": 1.0
})json";

constexpr const char* kOusterOs1128 = R"json({
  "name": "ouster_os1_128",
  "description": "Ouster OS1-128, 128 rings, 10 turns a second",
  "sources": [
    "Ouster, OS1 Datasheet (OS1-128): 45 deg vertical and 360 deg horizontal, 512 to 2048 columns a turn, 10 to 20 Hz, 0.8 to 120 m at 80 % reflectivity, range resolution 1.2 cm, repeatability 1.5 cm (one sigma) where the signal is strong, beam 10 mm and 0.18 deg",
    "Assumed: evenly spaced rings, 1024 columns, growth of the noise with range, 0.1 % lost"
  ],
  "pattern": {
    "kind": "rings",
    "azimuth_min_deg": 0, "azimuth_max_deg": 360, "azimuth_count": 1024,
    "ring_elevations_deg": [
      -22.5, -22.15, -21.79, -21.44, -21.08, -20.73, -20.37, -20.02, -19.67, -19.31, -18.96, -18.6, -18.25, -17.89,
      -17.54, -17.19, -16.83, -16.48, -16.12, -15.77, -15.41, -15.06, -14.7, -14.35, -14, -13.64, -13.29, -12.93,
      -12.58, -12.22, -11.87, -11.52, -11.16, -10.81, -10.45, -10.1, -9.74, -9.39, -9.04, -8.68, -8.33, -7.97, -7.62,
      -7.26, -6.91, -6.56, -6.2, -5.85, -5.49, -5.14, -4.78, -4.43, -4.07, -3.72, -3.37, -3.01, -2.66, -2.3, -1.95,
      -1.59, -1.24, -0.89, -0.53, -0.18, 0.18, 0.53, 0.89, 1.24, 1.59, 1.95, 2.3, 2.66, 3.01, 3.37, 3.72, 4.07, 4.43,
      4.78, 5.14, 5.49, 5.85, 6.2, 6.56, 6.91, 7.26, 7.62, 7.97, 8.33, 8.68, 9.04, 9.39, 9.74, 10.1, 10.45, 10.81,
      11.16, 11.52, 11.87, 12.22, 12.58, 12.93, 13.29, 13.64, 14, 14.35, 14.7, 15.06, 15.41, 15.77, 16.12, 16.48,
      16.83, 17.19, 17.54, 17.89, 18.25, 18.6, 18.96, 19.31, 19.67, 20.02, 20.37, 20.73, 21.08, 21.44, 21.79, 22.15,
      22.5
    ]
  },
  "range": {
    "min_range_m": 0.8, "max_range_m": 120, "reference_reflectance": 0.8,
    "bias_m": 0, "sigma_m": 0.015, "sigma_per_metre": 0.0003, "quantum_m": 0.012,
    "angular_jitter_deg": 0.01, "beam_divergence_deg": 0.18, "beam_diameter_m": 0.01, "pulse_length_m": 0.75,
    "drop_rate": 0.001
  },
  "scan_time_s": 0.1,
  "mount_height_m": 1.8
})json";

constexpr const char* kLivoxAvia = R"json({
  "name": "livox_avia",
  "description": "Livox Avia, solid state, 70 x 77 deg, non-repetitive, half a second of beams",
  "sources": [
    "Livox, Avia User Manual: 70.4 x 77.2 deg (non-repetitive), 190 m at 10 % reflectivity, 240,000 points a second, range precision 2 cm (one sigma at 20 m), angular precision below 0.05 deg, nothing nearer than 1 m, divergence 0.28 x 0.03 deg",
    "Assumed: the curve of the beams in a rectangle of angles, a scan of half a second (five frames), a round beam of 0.09 deg, 0.1 % lost"
  ],
  "pattern": {
    "kind": "rosette",
    "azimuth_min_deg": -35.2, "azimuth_max_deg": 35.2,
    "elevation_min_deg": -38.6, "elevation_max_deg": 38.6,
    "beam_count": 120000
  },
  "range": {
    "min_range_m": 1, "max_range_m": 190, "reference_reflectance": 0.1,
    "bias_m": 0, "sigma_m": 0.02, "sigma_per_metre": 0, "quantum_m": 0.001,
    "angular_jitter_deg": 0.03, "beam_divergence_deg": 0.09, "beam_diameter_m": 0.01, "pulse_length_m": 0.75,
    "drop_rate": 0.001
  },
  "scan_time_s": 0.5,
  "mount_height_m": 1.7
})json";

constexpr const char* kAevaAeries2 = R"json({
  "name": "aeva_aeries2",
  "description": "Aeva Aeries II, FMCW, 120 x 30 deg, 10 frames a second",
  "sources": [
    "Aeva, Aeries II product brief: frequency modulated continuous wave, 120 x 30 deg, up to 500 m, precision of centimetres",
    "Assumed: 64 lines of 1000 beams evenly over the view, 2 cm as one sigma, 300 m at reflectance 0.3, divergence 0.1 deg, one return a beam at a resolution of 0.3 m, 0.1 % lost"
  ],
  "pattern": {
    "kind": "sphere",
    "azimuth_min_deg": -60, "azimuth_max_deg": 60, "azimuth_count": 1000,
    "elevation_min_deg": -15, "elevation_max_deg": 15, "elevation_count": 64
  },
  "range": {
    "min_range_m": 0.5, "max_range_m": 300, "reference_reflectance": 0.3,
    "bias_m": 0, "sigma_m": 0.02, "sigma_per_metre": 0, "quantum_m": 0.001,
    "angular_jitter_deg": 0.01, "beam_divergence_deg": 0.1, "beam_diameter_m": 0.01, "pulse_length_m": 0.3,
    "drop_rate": 0.001
  },
  "scan_time_s": 0.1,
  "mount_height_m": 1.7
})json";

} // namespace

std::vector<BuiltInSensor>
builtInSensors()
{
  return {{"hokuyo_utm30lx", kHokuyoUtm30lx},
          {"leica_p20", kLeicaP20},
          {"velodyne_hdl32e", kVelodyneHdl32e},
          {"velodyne_vlp16", kVelodyneVlp16},
          {"sick_lms200", kSickLms200},
          {"livox_mid360", kLivoxMid360},
          {"ouster_os1_128", kOusterOs1128},
          {"livox_avia", kLivoxAvia},
          {"aeva_aeries2", kAevaAeries2}};
}

} // namespace pcl_ssfr::simulation
