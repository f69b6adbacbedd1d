# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""WHU-TLS: SCENE/1-RawPointCloud/N.las, SCENE/2-AlignedPointCloud/N.las, SCENE/3-GroundTruth/A-B/transformation.txt.

Whether the matrix of A-B maps A into B or B into A is taken from the data: an aligned cloud holds the points of the raw
one in the frame of the scene, which gives the pose of every scan and with it the direction."""
import re
import struct

import numpy

from .common import (Failure, Pair, angle_deg, chosen_sequences, first_folder, inverse, need_file, need_folder,
                     number, posed, relative, rigid, text_of)

SAMPLES = 2000           # points of a scan that its pose is fitted to
LARGEST_RESIDUAL = 0.02  # of that fit [m]: above it, the files do not hold the same points in the same order
SAME_ROTATION = 0.5      # [deg], SAME_PLACE [m]: within these two poses are the same
SAME_PLACE = 0.5


def las_header(path):
    """Offset, record length and number of points, scale and offset of coordinates of a LAS file."""
    with open(need_file(path, "a scan"), "rb") as file:
        head = file.read(375)
    if len(head) < 227 or head[:4] != b"LASF":
        raise Failure(f"{path}: is no LAS file")
    start, = struct.unpack_from("<I", head, 96)
    kind, length, count = struct.unpack_from("<BHI", head, 104)
    if kind & 0x80:
        raise Failure(f"{path}: is compressed (LAZ): docs/FORMATS.md names programs that make LAS of it")
    if head[25] >= 4 and len(head) >= 255:
        count, = struct.unpack_from("<Q", head, 247)
    return start, length, count, numpy.array(struct.unpack_from("<6d", head, 131)).reshape(2, 3)


def las_sample(path):
    """At most SAMPLES points of a LAS file at even distances in it, and the number of all."""
    start, length, count, (scale, offset) = las_header(path)
    if count == 0 or length < 12 or start + length * count > path.stat().st_size:
        raise Failure(f"{path}: {count} points of {length} bytes do not fit into the file")
    data = numpy.memmap(path, dtype=numpy.uint8, mode="r", offset=start, shape=(count, length))
    rows = numpy.linspace(0, count - 1, min(SAMPLES, count)).astype(int)
    return numpy.ascontiguousarray(data[rows, :12]).view("<i4") * scale + offset, count


def fitted(source, target):
    """The rigid motion that lays points on their counterparts, and the root mean square of what is left [m]."""
    a, b = source.mean(axis=0), target.mean(axis=0)
    u, _, v = numpy.linalg.svd((source - a).T @ (target - b))
    sign = numpy.diag([1, 1, numpy.sign(numpy.linalg.det(v.T @ u.T))])
    T = numpy.eye(4)
    T[:3, :3] = v.T @ sign @ u.T
    T[:3, 3] = b - T[:3, :3] @ a
    return T, numpy.sqrt(((source @ T[:3, :3].T + T[:3, 3] - target) ** 2).sum(axis=1).mean())


def scene_poses(scene, scans):
    """T_scene_scan of each scan from its raw and its aligned cloud; empty where these do not hold the same points."""
    aligned = scene / "2-AlignedPointCloud"
    poses = {}
    for name, raw in scans.items():
        if not (aligned / raw.name).is_file():
            return {}
        a, count = las_sample(raw)
        b, other = las_sample(aligned / raw.name)
        if count != other or count < 3:
            return {}
        poses[name], residual = fitted(a, b)
        if residual > LARGEST_RESIDUAL:
            return {}
    return poses


def is_same(A, B):
    return (angle_deg(A[:3, :3].T @ B[:3, :3]) <= SAME_ROTATION and
            numpy.linalg.norm(A[:3, 3] - B[:3, 3]) <= SAME_PLACE)


def directed(T, path, expected):
    """The matrix of a file, or its inverse where the clouds say that it is the other way round."""
    if expected is None or is_same(T, expected):
        return T
    if is_same(inverse(T), expected):
        return inverse(T)
    raise Failure(f"{path}: neither this matrix nor its inverse leads where 2-AlignedPointCloud has the scans")


def scene_pairs(scene, scans, poses, prefix):
    pairs = []
    for folder in sorted(need_folder(scene / "3-GroundTruth", f"ground truth of {scene.name}").iterdir()):
        match = re.fullmatch(r"(.+)-(.+)", folder.name)
        path = folder / "transformation.txt"
        if not match or not path.is_file():
            continue
        source, target = (f"{prefix}_{part}.las" for part in match.groups())
        for name, part in ((source, match.group(1)), (target, match.group(2))):
            if name not in scans:
                raise Failure(f"{folder}: there is no scan {part}.las in {scene / '1-RawPointCloud'}")
        fields = text_of(path, "ground truth").split()
        if len(fields) != 16:
            raise Failure(f"{path}: {len(fields)} numbers, expected the 16 of a 4x4 matrix")
        T = rigid([number(f, path, 1 + i // 4) for i, f in enumerate(fields)], path)
        expected = relative(poses[target], poses[source]) if poses else None
        pairs.append(Pair(source, target, directed(T, path, expected)))
    if not pairs:
        raise Failure(f"{scene / '3-GroundTruth'}: holds no A-B/transformation.txt")
    return pairs


def convert(root, choice):
    scenes = [root] if (root / "3-GroundTruth").is_dir() else sorted(p.parent for p in root.glob("*/3-GroundTruth"))
    if not scenes:
        raise Failure(f"{root}: neither it nor a folder in it holds 3-GroundTruth (WHU-TLS)")
    wanted = chosen_sequences(choice, [s.name for s in scenes], root)
    pairs, clouds, unchecked, worlds = [], {}, [], []
    for scene in (s for s in scenes if s.name in wanted):
        raw = first_folder(scene, ["1-RawPointCloud"], "scans in their own frames")
        scans = {f"{scene.name}_{path.stem}.las": path for path in sorted(raw.glob("*.las"))}
        if not scans:
            raise Failure(f"{raw}: holds no .las file" + (": they are compressed (LAZ), see docs/FORMATS.md"
                                                          if list(raw.glob("*.laz")) else ""))
        poses = scene_poses(scene, scans)
        if not poses:
            unchecked.append(scene.name)
        pairs += scene_pairs(scene, scans, poses, scene.name)
        clouds.update(scans)
        worlds.append(poses)
    note = (f"WHU-TLS, {', '.join(wanted)}: the pairs of 3-GroundTruth. " +
            (f"Direction of the matrices not checked, A into B assumed: {', '.join(unchecked)}." if unchecked else
             "Direction of the matrices checked against the aligned clouds."))
    return posed(choice, worlds, pairs, clouds, note, viewpoint="unknown")
