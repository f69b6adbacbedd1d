# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""ScanNet++ (FARO): data/SCENE/scans/pc_aligned.ply, all scans of a scene in one cloud, and scanner_poses.json.

The makers publish no single scans. As BUFFER-X does, each scanner is given the points that it sees, the nearest one in
each of 1800 x 900 directions, and pairs are those that share 30 % of the voxels of 5 cm of one of the two. Where its own
scripts ran, trans_faro_1800x900_scanner_N.ply and gt.log are taken as they are."""
import functools
import json
import re

import numpy

from .common import (Failure, Pair, chosen_sequences, log_records, need_file, posed, relative, rigid, write_pcd)

DIRECTIONS = (1800, 900)  # azimuth, elevation
LEAST_RANGE = 0.6         # of a point from the scanner [m]
LEAST_OVERLAP = 0.3
VOXEL = 0.05              # [m]
PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
             "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4",
             "float64": "f8"}


def read_ply(path):
    """x, y, z of the vertices of a binary PLY file."""
    data = need_file(path, "the cloud of a scene").read_bytes()
    end = re.search(rb"^end_header\r?\n", data[:65536], re.MULTILINE)
    if not data.startswith(b"ply") or not end:
        raise Failure(f"{path}: is no PLY file")
    lines = [line.split() for line in data[:end.start()].decode("ascii", "replace").splitlines()]
    order = next((line[1] for line in lines if line[:1] == ["format"]), "")
    if order not in ("binary_little_endian", "binary_big_endian"):
        raise Failure(f"{path}: PLY format '{order}' is not binary")
    elements = [line for line in lines if line[:1] == ["element"]]
    if not elements or elements[0][1] != "vertex":
        raise Failure(f"{path}: the first element is not 'vertex'")
    fields = []
    for line in lines[lines.index(elements[0]) + 1:]:
        if line[:1] != ["property"]:
            break
        if line[1] not in PLY_TYPES:
            raise Failure(f"{path}: a vertex property of type '{line[1]}' is not read")
        fields.append((line[2], ("<" if "little" in order else ">") + PLY_TYPES[line[1]]))
    record, count = numpy.dtype(fields), int(elements[0][2])
    if not {"x", "y", "z"} <= set(record.names or ()) or end.end() + count * record.itemsize > len(data):
        raise Failure(f"{path}: {count} vertices with x, y, z are not in the file")
    vertices = numpy.frombuffer(data, dtype=record, count=count, offset=end.end())
    return numpy.stack([vertices[name].astype(float) for name in "xyz"], axis=1)


def read_poses(path):
    """T_scene_scanner of each scanner."""
    try:
        matrices = json.loads(need_file(path, "the poses of the scanner").read_text(encoding="utf-8"))
        values = numpy.array(matrices, dtype=float)
    except (ValueError, TypeError, UnicodeDecodeError) as error:
        raise Failure(f"{path}: is no list of 4x4 matrices: {error}") from error
    if values.ndim != 3 or values.shape[1:] != (4, 4):
        raise Failure(f"{path}: is no list of 4x4 matrices")
    return [rigid(T.reshape(16), f"{path}: pose {i}") for i, T in enumerate(values)]


def seen_from(cloud, T_scene_scanner):
    """The points of a scene that a scanner sees, in its frame: the nearest in each direction."""
    points = cloud - T_scene_scanner[:3, 3]
    ranges = numpy.linalg.norm(points, axis=1)
    points, ranges = points[ranges >= LEAST_RANGE], ranges[ranges >= LEAST_RANGE]
    azimuth = numpy.arctan2(points[:, 1], points[:, 0]) % (2 * numpy.pi)
    elevation = numpy.arcsin(numpy.clip(points[:, 2] / ranges, -1, 1)) + numpy.pi / 2
    cells = (numpy.ceil(azimuth / (2 * numpy.pi) * (DIRECTIONS[0] - 1)).astype(numpy.int64) * DIRECTIONS[1] +
             numpy.ceil(elevation / numpy.pi * (DIRECTIONS[1] - 1)).astype(numpy.int64))
    order = numpy.lexsort((ranges, cells))
    _, first = numpy.unique(cells[order], return_index=True)
    return points[order[first]] @ T_scene_scanner[:3, :3]


def thinned(points):
    """Centroids of the voxels."""
    keys = numpy.floor(points / VOXEL).astype(numpy.int64)
    _, voxels = numpy.unique(keys, axis=0, return_inverse=True)
    voxels = voxels.reshape(-1)
    counts = numpy.bincount(voxels)
    return numpy.stack([numpy.bincount(voxels, points[:, k]) / counts for k in range(3)], axis=1)


def share_near(points, others):
    """Share of the points with one of the others within a voxel's width."""
    def keyed(cells):
        return (cells[:, 0] * 2097152 + cells[:, 1]) * 2097152 + cells[:, 2]
    low = numpy.minimum(points.min(axis=0), others.min(axis=0)) - 2 * VOXEL
    cells, other_cells = (numpy.floor((p - low) / VOXEL).astype(numpy.int64) for p in (points, others))
    other_keys = keyed(other_cells)
    order = numpy.argsort(other_keys, kind="stable")
    sorted_keys = other_keys[order]
    near = numpy.zeros(len(points), dtype=bool)
    for step in numpy.ndindex(3, 3, 3):
        keys = keyed(cells + numpy.array(step) - 1)
        begin, end = (numpy.searchsorted(sorted_keys, keys, side=side) for side in ("left", "right"))
        for i in range(int((end - begin).max(initial=0))):
            rows = numpy.nonzero((begin + i < end) & ~near)[0]
            distances = numpy.linalg.norm(others[order[begin[rows] + i]] - points[rows], axis=1)
            near[rows[distances <= VOXEL]] = True
    return near.mean()


def overlap(source, target, T_target_source):
    """The larger of the shares of the two that are near the other."""
    moved = source @ T_target_source[:3, :3].T + T_target_source[:3, 3]
    return max(share_near(moved, target), share_near(target, moved))


def of_log(folder, scene):
    """The pairs that the scripts of BUFFER-X made; their matrices map the first scan into the second."""
    pairs, clouds = [], {}
    for first, second, T in log_records(folder / "gt.log"):
        names = [f"{scene}_{i}.ply" for i in (first, second)]
        for name, i in zip(names, (first, second)):
            clouds[name] = need_file(folder / f"trans_faro_{DIRECTIONS[0]}x{DIRECTIONS[1]}_scanner_{i}.ply", "a scan of gt.log")
        pairs.append(Pair(names[0], names[1], T))
    return pairs, clouds, {}


@functools.lru_cache(maxsize=1)
def scene_scans(folder):
    """What each scanner of a scene sees. Scenes are large: one is kept, and made again when its scans are written."""
    cloud = read_ply(folder / "pc_aligned.ply")
    return [seen_from(cloud, T) for T in read_poses(folder / "scanner_poses.json")]


def scan_writer(folder, number):
    return lambda path: write_pcd(path, scene_scans(folder)[number])


def of_scene(folder, scene):
    poses = read_poses(folder / "scanner_poses.json")
    scans = scene_scans(folder)
    coarse = [thinned(scan) if len(scan) else scan for scan in scans]
    names = [f"{scene}_{i}.pcd" for i in range(len(poses))]
    pairs = []
    for i in range(len(poses)):
        for j in range(i + 1, len(poses)):
            T = relative(poses[j], poses[i])
            if len(scans[i]) and len(scans[j]) and overlap(coarse[i], coarse[j], T) >= LEAST_OVERLAP:
                pairs.append(Pair(names[i], names[j], T))
    clouds = {name: scan_writer(folder, i) for i, name in enumerate(names)}
    return pairs, clouds, dict(zip(names, poses))


def convert(root, choice):
    data = root / "data" if (root / "data").is_dir() else root
    found = {p.parent.parent.name: p.parent for p in sorted(data.glob("*/scans/scanner_poses.json"))}
    if not found:
        raise Failure(f"{data}: holds no SCENE/scans/scanner_poses.json (ScanNet++)")
    wanted = chosen_sequences(choice, list(found), data)
    pairs, clouds, worlds = [], {}, []
    for scene in wanted:
        of_one = of_log(found[scene], scene) if (found[scene] / "gt.log").is_file() else of_scene(found[scene], scene)
        pairs += of_one[0]
        clouds.update(of_one[1])
        worlds.append(of_one[2])
    note = (f"ScanNet++, {len(wanted)} scenes: what each position of the FARO sees of pc_aligned.ply; pairs that share "
            f"{LEAST_OVERLAP:.0%} by the rule of BUFFER-X.")
    return posed(choice, worlds, pairs, clouds, note)
