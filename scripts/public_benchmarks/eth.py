# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""ETH: the test set of 3DSmoothNet (SCENE/Hokuyo_N.ply and gt.log), or a sequence of the makers (ASL): csv_local or
local_frame with Hokuyo_N.csv, and pose_scanner_leica.csv with them or in csv_global or global_frame."""
from .common import (Conversion, Failure, Pair, chosen_sequences, first_folder, inverse, log_records, need_file, number,
                     numbered_files, posed, relative, rigid, table)

LOCAL_FOLDERS = ["csv_local", "local_frame", "."]
POSE_FOLDERS = ["csv_global", "global_frame", "leica", "csv_local", "local_frame", "."]
POSE_FILE = "pose_scanner_leica.csv"


def of_log(root, scenes):
    pairs, clouds = [], {}
    for scene in scenes:
        for first, second, T in log_records(root / scene / "gt.log"):
            names = []
            for i in (first, second):
                name = f"{scene}_{i}.ply"
                clouds[name] = need_file(root / scene / f"Hokuyo_{i}.ply", "a scan that gt.log names")
                names.append(name)
            # The matrix maps the second scan into the frame of the first; the first is the source.
            pairs.append(Pair(names[0], names[1], inverse(T)))
    return Conversion(pairs, clouds, f"ETH, test set of 3DSmoothNet: {', '.join(scenes)}.")


def pose_file(root):
    for folder in POSE_FOLDERS:
        if (root / folder / POSE_FILE).is_file():
            return root / folder / POSE_FILE
    raise Failure(f"{root}: holds no {POSE_FILE}, neither with the scans nor in csv_global or global_frame")


def of_sequence(root, choice):
    path = pose_file(root)
    scans = numbered_files(first_folder(root, [f for f in LOCAL_FOLDERS if list((root / f).glob("Hokuyo_*.csv"))] or
                                        LOCAL_FOLDERS[:2], "scans in the frame of the scanner"),
                           r"Hokuyo_(\d+)\.csv", "scans in the frame of the scanner")
    poses, clouds = {}, {}
    rows = table(path, 18, "poseId, timestamp, T00 to T33")
    if len(rows) != len(scans):
        raise Failure(f"{path}: {len(rows)} poses, but {len(scans)} scans Hokuyo_N.csv")
    for line, fields in rows:
        index = int(number(fields[0], path, line))
        if index not in scans:
            raise Failure(f"{path}:{line}: pose {index} has no scan Hokuyo_{index}.csv")
        name = f"Hokuyo_{index}.csv"
        clouds[name] = scans[index]
        poses[name] = rigid([number(f, path, line) for f in fields[2:]], f"{path}:{line}")
    names = [f"Hokuyo_{i}.csv" for i in scans]
    pairs = [Pair(b, a, relative(poses[a], poses[b])) for a, b in zip(names, names[1:])]
    note = (f"ETH (ASL) {root.name}, scans in the frame of the scanner, truth by a theodolite; "
            f"{'listed pairs' if choice.pair_list else 'each scan onto the one before it'}.")
    return posed(choice, [poses], pairs, clouds, note)


def convert(root, choice):
    scenes = sorted(p.parent.name for p in root.glob("*/gt.log"))
    if not scenes:
        return of_sequence(root, choice)
    if choice.pair_list:
        raise Failure(f"{choice.pair_list}: --pair-list needs a pose of each scan; this set has its pairs in gt.log")
    return of_log(root, chosen_sequences(choice, scenes, root))
