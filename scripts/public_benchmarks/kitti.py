# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""KITTI odometry: sequences/NN/velodyne/NNNNNN.bin, sequences/NN/calib.txt, poses/NN.txt (devkit of the makers)."""
import numpy

from .common import (Failure, Pair, chosen_sequences, drive_pairs, inverse, kitti_poses, need_folder, number,
                     numbered_files, posed, rigid, text_of)

TEST_SEQUENCES = ["08", "09", "10"]  # the usual ones
DISTANCE = 10.0                      # between the two scans of a pair [m]
WRONG_PAIR = ("08", 15, 58)          # left out by BUFFER-X: its pose is wrong


def velodyne_to_camera(path):
    """T_camera0_velodyne: the line "Tr:" of calib.txt."""
    for line, text in enumerate(text_of(path, "calibration").splitlines(), 1):
        fields = text.split()
        if fields and fields[0] in ("Tr:", "Tr_velo_to_cam:"):
            if len(fields) != 13:
                raise Failure(f"{path}:{line}: {len(fields) - 1} numbers after Tr, expected 12")
            return rigid([number(f, path, line) for f in fields[1:]], f"{path}:{line}")
    raise Failure(f"{path}: has no line 'Tr:' from the Velodyne to the camera")


def refined(folder, sequence, source, target):
    """The pose that BUFFER-X refined where its cache of .npy files lies with the data, else None."""
    path = folder / f"{int(sequence)}_{source}_{target}.npy"
    if not path.is_file():
        return None
    try:
        return rigid(numpy.load(path, allow_pickle=False).reshape(16), path)
    except ValueError as error:
        raise Failure(f"{path}: is no 4x4 matrix: {error}") from error


def convert(root, choice):
    data = root / "dataset" if (root / "dataset" / "sequences").is_dir() else root
    sequences = need_folder(data / "sequences", "KITTI odometry")
    found = sorted(p.name for p in sequences.iterdir() if (data / "poses" / f"{p.name}.txt").is_file())
    chosen = chosen_sequences(choice, found, sequences) if choice.sequences else TEST_SEQUENCES
    pairs, clouds, worlds, replaced = [], {}, [], 0
    for sequence in chosen:
        scans = numbered_files(sequences / sequence / "velodyne", r"(\d{6})\.bin", f"scans of sequence {sequence}")
        T_camera_velodyne = velodyne_to_camera(sequences / sequence / "calib.txt")
        cameras = kitti_poses(data / "poses" / f"{sequence}.txt")
        if list(scans) != list(range(len(cameras))):
            raise Failure(f"{data / 'poses' / sequence}.txt: {len(cameras)} poses, but {len(scans)} scans up to number "
                          f"{max(scans)} in {sequences / sequence / 'velodyne'}")
        names = {f"{sequence}_{i:06d}.bin": i for i in scans}
        clouds.update(zip(names, scans.values()))
        # Pairs are chosen by the places of the camera, as BUFFER-X does.
        for pair in drive_pairs(list(names), cameras, DISTANCE):
            source, target = names[pair.source], names[pair.target]
            if (sequence, source, target) == WRONG_PAIR:
                continue
            T = refined(root / "icp", sequence, source, target)
            replaced += T is not None
            if T is None:
                T = inverse(T_camera_velodyne) @ pair.T_target_source @ T_camera_velodyne
            pairs.append(Pair(pair.source, pair.target, T))
        worlds.append({name: camera @ T_camera_velodyne for name, camera in zip(names, cameras)})
    note = (f"KITTI odometry, sequences {', '.join(chosen)}; pairs {DISTANCE:g} m apart by the rule of BUFFER-X. "
            f"Truth: GPS and IMU" + (f", {replaced} poses from icp/." if replaced else ", not refined by ICP."))
    return posed(choice, worlds, pairs, clouds, note)
