# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""RESSO: folders of .ply files with a .reg or .txt file of poses: the number of scans, then for each its file name and a
4x4 matrix, which maps the scan into the frame of the scene."""
from .common import Failure, Pair, chosen_sequences, need_file, number, posed, relative, rigid, text_of

PAIR_FILE = "file_pairs.txt"  # of the program PLADE: the file of the target, then that of the source, a line each


def read_poses(path):
    """File name -> T_scene_scan; None where the file is of another kind."""
    lines = [(i, text.split()) for i, text in enumerate(text_of(path, "poses").splitlines(), 1) if text.strip()]
    if not lines or len(lines[0][1]) != 1 or not lines[0][1][0].isdigit() or len(lines) < 2 or len(lines[1][1]) != 1:
        return None
    count = int(lines[0][1][0])
    if len(lines) != 1 + 5 * count:
        raise Failure(f"{path}: says {count} scans, but has {len(lines) - 1} lines for them, not {5 * count}")
    poses = {}
    for at in range(1, len(lines), 5):
        line, (name,) = lines[at]
        values = []
        for row, fields in lines[at + 1:at + 5]:
            if len(fields) != 4:
                raise Failure(f"{path}:{row}: {len(fields)} numbers in a row of a 4x4 matrix")
            values += [number(f, path, row) for f in fields]
        poses[name] = rigid(values, f"{path}:{line}")
    return poses


def scene_poses(folder):
    for path in sorted(folder.glob("*.reg")) + sorted(folder.glob("*.txt")):
        if path.name != PAIR_FILE:
            poses = read_poses(path)
            if poses:
                return path, poses
    return None


def plade_pairs(path, poses):
    names = [line.strip().replace("\\", "/").rsplit("/", 1)[-1] for line in text_of(path, "pairs").splitlines() if line.strip()]
    if len(names) % 2 != 0:
        raise Failure(f"{path}: {len(names)} file names are no pairs of a target and a source")
    for name in names:
        if name not in poses:
            raise Failure(f"{path}: '{name}' has no pose")
    return [Pair(s, t, relative(poses[t], poses[s])) for t, s in zip(names[::2], names[1::2])]


def convert(root, choice):
    scenes = {p.name: p for p in [root, *sorted(f for f in root.iterdir() if f.is_dir())] if scene_poses(p)}
    if not scenes:
        raise Failure(f"{root}: neither it nor a folder in it holds a file of poses (the number of scans, then for each its "
                      f"name and a 4x4 matrix; RESSO)")
    wanted = chosen_sequences(choice, list(scenes), root)
    pairs, clouds, worlds = [], {}, []
    for scene in wanted:
        path, poses = scene_poses(scenes[scene])
        names = {name: f"{scene}_{name}" for name in poses}
        clouds.update({names[name]: need_file(scenes[scene] / name, f"a scan that {path.name} names") for name in poses})
        worlds.append({names[name]: T for name, T in poses.items()})
        if (scenes[scene] / PAIR_FILE).is_file():
            found = plade_pairs(scenes[scene] / PAIR_FILE, poses)
        else:
            order = list(poses)
            found = [Pair(b, a, relative(poses[a], poses[b])) for a, b in zip(order, order[1:])]
        pairs += [Pair(names[p.source], names[p.target], p.T_target_source) for p in found]
    note = f"RESSO, {', '.join(wanted)}: the pairs of {PAIR_FILE} where it is there, else each scan onto the one before it."
    return posed(choice, worlds, pairs, clouds, note, viewpoint="unknown")
