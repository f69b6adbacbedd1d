# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Newer College (2020): a sequence of the makers, raw_format/ouster_scan/cloud_SEC_NSEC.pcd and
ground_truth/registered_poses.csv (sec, nsec, x, y, z, qx, qy, qz, qw); or as BUFFER-X extracted it,
SEQUENCE/scans/NNNNNN.pcd and SEQUENCE/poses_kitti.txt."""
from .common import (Failure, Track, chosen_sequences, drive_pairs, number, pcd_with_sensor_at, pose, posed,
                     stamped_clouds, table)
from .numbered import numbered_drive

DISTANCE = 5.0           # [m]
LARGEST_GAP = 3 * 10**8  # between two poses that one is interpolated from [ns]; they come at 10 Hz
TEST_SEQUENCES = ["01_short_experiments", "05_quad_with_dynamics", "07_parkland_mound"]  # of BUFFER-X
# The poses are those of the left camera; from it to the Ouster, as the loader of KISS-ICP has it (calibration of the set).
T_CAMERA_OUSTER = pose((-0.084, -0.025, 0.050), (0, 0, 0.924, 0.383), "T_camera_ouster")


def registered_poses(path):
    poses = {}
    for line, fields in table(path, 9, "sec, nsec, x, y, z, qx, qy, qz, qw"):
        v = [number(f, path, line) for f in fields]
        poses[int(fields[0].split(".")[0]) * 10**9 + int(fields[1].split(".")[0])] = pose(v[2:5], v[5:], f"{path}:{line}")
    return Track(poses)


def of_sequence(root, prefix):
    clouds = stamped_clouds(root / "raw_format" / "ouster_scan", "raw scans of the Ouster")
    path = root / "ground_truth" / "registered_poses.csv"
    track = registered_poses(path)
    names, poses, files = [], [], {}
    for time, cloud in clouds.items():
        T_world_camera = track.at(time, LARGEST_GAP)
        if T_world_camera is not None:
            names.append(f"{prefix}_{cloud.name}")
            poses.append(T_world_camera @ T_CAMERA_OUSTER)
            files[names[-1]] = pcd_with_sensor_at(cloud, (0, 0, 0))
    if len(names) < 2:
        raise Failure(f"{path}: {len(names)} of {len(clouds)} scans have a pose at their time")
    return drive_pairs(names, poses, DISTANCE), files, dict(zip(names, poses))


def convert(root, choice):
    raw = [root] if (root / "raw_format").is_dir() else sorted(p.parent for p in root.glob("*/raw_format"))
    extracted = sorted(p.parent for p in root.glob("*/poses_kitti.txt"))
    if not raw and not extracted:
        raise Failure(f"{root}: holds neither raw_format (a sequence of Newer College) nor SEQUENCE/poses_kitti.txt")
    found = [p.name for p in raw or extracted]
    test = [name for name in TEST_SEQUENCES if name in found]
    wanted = chosen_sequences(choice, found, root) if choice.sequences or not test else test
    pairs, clouds, worlds = [], {}, []
    for folder in (p for p in raw or extracted if p.name in wanted):
        of_drive = (of_sequence(folder, folder.name) if raw else
                    numbered_drive(folder / "scans", "pcd", folder / "poses_kitti.txt", folder.name, DISTANCE))
        pairs += of_drive[0]
        clouds.update(of_drive[1])
        worlds.append(of_drive[2])
    note = f"Newer College, {', '.join(wanted)}; pairs {DISTANCE:g} m apart by the rule of BUFFER-X."
    return posed(choice, worlds, pairs, clouds, note)
