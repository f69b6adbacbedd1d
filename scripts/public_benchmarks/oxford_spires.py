# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Oxford Spires: sequences/SEQUENCE/processed with trajectory/gt-tum.txt (pose of the base) and clouds
cloud_SEC_NSEC.pcd: vilens-slam/undist-clouds in the frame of the base, or lidar-undistortion/... in that of the LiDAR."""
import numpy

from .common import (Failure, chosen_sequences, drive_pairs, pcd_with_sensor_at, pose, posed, stamped_clouds,
                     tum_poses)

DISTANCE = 10.0          # [m]; the makers publish no pairs
LARGEST_GAP = 2 * 10**8  # between two poses that one is interpolated from [ns]; they come at 20 Hz
# T_base_lidar_t_xyz_q_xyzw of config/sensor.yaml of the makers' tools.
T_BASE_LIDAR = pose((0, 0, 0.124), (0, 0, 1, 0), "T_base_lidar")
CLOUDS = [("vilens-slam/undist-clouds", numpy.eye(4), T_BASE_LIDAR[:3, 3]),  # folder, T_base_cloud, sensor in the cloud
          ("lidar-undistortion/undist-clouds-image-synced", T_BASE_LIDAR, numpy.zeros(3)),
          ("lidar-undistortion/undist-clouds", T_BASE_LIDAR, numpy.zeros(3))]


def of_sequence(sequence):
    processed = sequence / "processed"
    for folder, T_base_cloud, sensor in CLOUDS:
        if (processed / folder).is_dir():
            break
    else:
        raise Failure(f"{processed}: holds none of {', '.join(c[0] for c in CLOUDS)} (unpack the .zip files)")
    clouds = stamped_clouds(processed / folder, "undistorted clouds")
    path = processed / "trajectory" / "gt-tum.txt"
    track = tum_poses(path, 10**9)
    names, poses, files = [], [], {}
    for time, cloud in clouds.items():
        T_world_base = track.at(time, LARGEST_GAP)
        if T_world_base is not None:
            names.append(f"{sequence.name}_{cloud.name}")
            poses.append(T_world_base @ T_base_cloud)
            files[names[-1]] = pcd_with_sensor_at(cloud, sensor)
    if len(names) < 2:
        raise Failure(f"{path}: {len(names)} of {len(clouds)} clouds have a pose at their time")
    return drive_pairs(names, poses, DISTANCE), files, dict(zip(names, poses)), folder


def convert(root, choice):
    sequences = [root] if (root / "processed").is_dir() else sorted(
        p.parent for p in [*root.glob("*/processed"), *root.glob("sequences/*/processed")])
    if not sequences:
        raise Failure(f"{root}: neither it nor a folder in it holds 'processed' (a sequence of Oxford Spires)")
    wanted = chosen_sequences(choice, [s.name for s in sequences], root)
    pairs, clouds, worlds, kinds = [], {}, [], set()
    for sequence in (s for s in sequences if s.name in wanted):
        found = of_sequence(sequence)
        pairs += found[0]
        clouds.update(found[1])
        worlds.append(found[2])
        kinds.add(found[3])
    note = f"Oxford Spires, {', '.join(wanted)}, {', '.join(sorted(kinds))}; pairs {DISTANCE:g} m apart."
    return posed(choice, worlds, pairs, clouds, note)
