# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""TIERS: indoor sequences as BUFFER-X extracted them from the makers' bags: SEQUENCE/SENSOR/scans/NNNNNN.pcd and
SEQUENCE/SENSOR/poses_kitti.txt."""
from .common import Failure, chosen_sequences, posed
from .numbered import numbered_drive

DISTANCE = 2.0  # [m]
TEST_SEQUENCES = [f"tiers_indoor{number}" for number in ("06", "08", "09", "10", "11")]  # of BUFFER-X


def convert(root, choice):
    found = sorted({p.parent.parent.name for p in root.glob("*/*/poses_kitti.txt")})
    if not found:
        bags = " (bag files of ROS are not read: extract them first)" if list(root.glob("*.bag")) else ""
        raise Failure(f"{root}: holds no SEQUENCE/SENSOR/poses_kitti.txt (TIERS){bags}")
    test = [name for name in TEST_SEQUENCES if name in found]
    wanted = chosen_sequences(choice, found, root) if choice.sequences or not test else test
    pairs, clouds, worlds, sensors = [], {}, [], set()
    for sequence in wanted:
        for pose_path in sorted((root / sequence).glob("*/poses_kitti.txt")):
            sensor = pose_path.parent.name
            sensors.add(sensor)
            of_drive = numbered_drive(pose_path.parent / "scans", "pcd", pose_path, f"{sequence}_{sensor}", DISTANCE)
            pairs += of_drive[0]
            clouds.update(of_drive[1])
            worlds.append(of_drive[2])
    note = f"TIERS, {', '.join(wanted)}, {', '.join(sorted(sensors))}; pairs {DISTANCE:g} m apart by the rule of BUFFER-X."
    return posed(choice, worlds, pairs, clouds, note)
