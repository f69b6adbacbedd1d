# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Numbered scans with poses_kitti.txt or poses.txt: how BUFFER-X lays out TIERS, Newer College, HeLiPR."""
from .common import Failure, drive_pairs, kitti_poses, numbered_files, pcd_with_sensor_at


def numbered_drive(scans_folder, extension, pose_path, prefix, distance):
    """Pairs, clouds and poses of a folder of NNNNNN.EXTENSION with a line of poses for each."""
    scans = numbered_files(scans_folder, rf"(\d{{6}})\.{extension}", "scans")
    poses = kitti_poses(pose_path)
    if list(scans) != list(range(len(poses))):
        raise Failure(f"{pose_path}: {len(poses)} poses, but {len(scans)} scans up to number {max(scans)} in {scans_folder}")
    names = [f"{prefix}_{i:06d}.{extension}" for i in scans]
    clouds = [pcd_with_sensor_at(path, (0, 0, 0)) if extension == "pcd" else path for path in scans.values()]
    return drive_pairs(names, poses, distance), dict(zip(names, clouds)), dict(zip(names, poses))
