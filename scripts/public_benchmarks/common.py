# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""What all layouts share: reading poses and lists, choosing pairs, writing a dataset folder. Metres; T_a_b maps b to a."""
import bisect
import dataclasses
import json
import pathlib
import re
from decimal import Decimal, InvalidOperation
from typing import Callable, Dict, List, Optional, Union

import numpy

RIGID_TOLERANCE = 1e-3  # of R^T R from the identity; poses are published with four to seven digits
HEADER_BYTES = 4096     # of a PCD file, at most
SEARCH_WINDOW = 100     # frames after a source in which its target is looked for, as in BUFFER-X


class Failure(Exception):
    """What a user can put right, in one line that names the file."""


@dataclasses.dataclass
class Pair:
    """Two scans by their names in the dataset folder, and the true pose of the source in the frame of the target."""

    source: str
    target: str
    T_target_source: numpy.ndarray


@dataclasses.dataclass
class Conversion:
    """What a layout makes of a folder."""

    pairs: List[Pair]
    clouds: Dict[str, Union[pathlib.Path, Callable]]  # name in scans/ -> file to link to, or a function that writes it
    note: str
    poses: Dict[str, numpy.ndarray] = dataclasses.field(default_factory=dict)  # T_world_scan, where all share a world
    viewpoint: str = "sensor"


@dataclasses.dataclass
class Choice:
    """What the user may choose."""

    sequences: Optional[List[str]] = None
    pair_list: Optional[pathlib.Path] = None


# ---- files -----------------------------------------------------------------------------------------------------------


def need_folder(path, what):
    if not path.is_dir():
        raise Failure(f"{path}: there is no such folder ({what})")
    return path


def need_file(path, what):
    if not path.is_file():
        raise Failure(f"{path}: there is no such file ({what})")
    return path


def first_folder(root, names, what):
    """The first of several places that exists."""
    for name in names:
        if (root / name).is_dir():
            return root / name
    raise Failure(f"{root}: holds none of the folders {', '.join(names)} ({what})")


def text_of(path, what):
    try:
        return need_file(path, what).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise Failure(f"{path}: cannot be read as text: {error}") from error


def number(text, path, line):
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not numpy.isfinite(value):
        raise Failure(f"{path}:{line}: '{text}' is not a finite number")
    return value


def table(path, columns, what):
    """Rows of a table of numbers as (line number, fields); blanks, commas or semicolons between, comments and a header
    skipped."""
    rows = []
    for line, text in enumerate(text_of(path, what).splitlines(), 1):
        fields = [field for field in re.split(r"[,;\s]+", text.strip()) if field]
        if not fields or fields[0].startswith("#") or (not rows and re.match(r"[A-Za-z_]", fields[0])):
            continue
        if len(fields) != columns:
            raise Failure(f"{path}:{line}: {len(fields)} columns, expected {columns}")
        rows.append((line, fields))
    if not rows:
        raise Failure(f"{path}: holds no row ({what})")
    return rows


def numbered_files(folder, pattern, what):
    """Files by the number in their names, in order; the pattern has one group."""
    files = {}
    for path in sorted(need_folder(folder, what).iterdir()):
        match = re.fullmatch(pattern, path.name)
        if match:
            files[int(match.group(1))] = path
    if not files:
        raise Failure(f"{folder}: holds no file like {pattern} ({what})")
    return dict(sorted(files.items()))


def stamped_clouds(folder, what):
    """cloud_SEC_NSEC.pcd of Newer College and Oxford Spires, by time [ns]."""
    clouds = {}
    for path in need_folder(folder, what).iterdir():
        match = re.fullmatch(r"cloud_(\d+)_(\d{1,9})\.pcd", path.name)
        if match:
            clouds[int(match.group(1)) * 10**9 + int(match.group(2))] = path
    if not clouds:
        raise Failure(f"{folder}: holds no cloud_SEC_NSEC.pcd ({what})")
    return dict(sorted(clouds.items()))


# ---- poses -----------------------------------------------------------------------------------------------------------


def rigid(values, where):
    """A 4x4 rigid motion of 12 or 16 numbers, row by row, its rotation made orthogonal."""
    T = numpy.eye(4)
    T[:len(values) // 4] = numpy.asarray(values, dtype=float).reshape(-1, 4)
    R = T[:3, :3]
    if (not numpy.allclose(R.T @ R, numpy.eye(3), atol=RIGID_TOLERANCE) or numpy.linalg.det(R) < 0 or
            not numpy.allclose(T[3], (0, 0, 0, 1), atol=RIGID_TOLERANCE)):
        raise Failure(f"{where}: the matrix is no rigid motion")
    u, _, v = numpy.linalg.svd(R)
    T[:3, :3] = u @ v
    T[3] = (0, 0, 0, 1)
    return T


def pose(translation, quaternion, where):
    """Of x, y, z and qx, qy, qz, qw."""
    q = numpy.asarray(quaternion, dtype=float)
    if abs(numpy.linalg.norm(q) - 1) > 0.01:
        raise Failure(f"{where}: the quaternion has the length {numpy.linalg.norm(q):.3g}, not 1")
    x, y, z, w = q / numpy.linalg.norm(q)
    T = numpy.eye(4)
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = translation
    return T


def quaternion_of(R):
    """(qx, qy, qz, qw) of a rotation, qw >= 0; by the largest eigenvector of Bar-Itzhack's matrix."""
    K = numpy.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
                     [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                     [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], 0],
                     [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]]])
    _, vectors = numpy.linalg.eigh(K / 3)
    q = vectors[:, 3]
    return q if q[3] >= 0 else -q


def inverse(T):
    result = numpy.eye(4)
    result[:3, :3] = T[:3, :3].T
    result[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return result


def relative(T_world_target, T_world_source):
    """T_target_source. Places in a world may be large: only their difference is taken."""
    result = numpy.eye(4)
    R = T_world_target[:3, :3]
    result[:3, :3] = R.T @ T_world_source[:3, :3]
    result[:3, 3] = R.T @ (T_world_source[:3, 3] - T_world_target[:3, 3])
    return result


def angle_deg(R):
    sine = numpy.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    return numpy.degrees(numpy.arctan2(sine, (numpy.trace(R) - 1) / 2))


def kitti_poses(path):
    """Twelve numbers a line."""
    return [rigid([number(f, path, line) for f in fields], f"{path}:{line}")
            for line, fields in table(path, 12, "a pose of twelve numbers per scan")]


def nanoseconds(text, path, line, unit=1):
    try:
        return int(Decimal(text) * unit)
    except (InvalidOperation, ValueError, OverflowError):
        raise Failure(f"{path}:{line}: '{text}' is no time") from None


def tum_poses(path, unit):
    """The track of a file with lines "time x y z qx qy qz qw"; unit: nanoseconds in a unit of time."""
    poses = {}
    for line, fields in table(path, 8, "time x y z qx qy qz qw"):
        v = [number(f, path, line) for f in fields[1:]]
        poses[nanoseconds(fields[0], path, line, unit)] = pose(v[:3], v[3:], f"{path}:{line}")
    return Track(poses)


def log_records(path):
    """The records of a gt.log of 3DMatch: (first, second, matrix as written)."""
    lines = [(i, text.split()) for i, text in enumerate(text_of(path, "ground truth of pairs").splitlines(), 1) if text.strip()]
    if not lines or len(lines) % 5 != 0:
        raise Failure(f"{path}: {len(lines)} lines are not records of five")
    records = []
    for at in range(0, len(lines), 5):
        line, head = lines[at]
        if len(head) != 3 or not all(re.fullmatch(r"\d+", field) for field in head):
            raise Failure(f"{path}:{line}: expected the numbers of two scans and their count")
        values = []
        for row, fields in lines[at + 1:at + 5]:
            if len(fields) != 4:
                raise Failure(f"{path}:{row}: {len(fields)} numbers in a row of a 4x4 matrix")
            values += [number(f, path, row) for f in fields]
        records.append((int(head[0]), int(head[1]), rigid(values, f"{path}:{line}")))
    return records


class Track:
    """Poses at times [ns]."""

    def __init__(self, poses):
        self.times = sorted(poses)
        self.poses = poses

    def __contains__(self, time):
        return time in self.poses

    def __getitem__(self, time):
        return self.poses[time]

    def at(self, time, largest_gap):
        """The pose at a time, between two that are at most so many nanoseconds apart; None where there are none."""
        if time in self.poses:
            return self.poses[time]
        after = bisect.bisect(self.times, time)
        if after in (0, len(self.times)) or self.times[after] - self.times[after - 1] > largest_gap:
            return None
        a, b = self.poses[self.times[after - 1]], self.poses[self.times[after]]
        share = (time - self.times[after - 1]) / (self.times[after] - self.times[after - 1])
        motion = quaternion_of(a[:3, :3].T @ b[:3, :3])
        sine = numpy.linalg.norm(motion[:3])
        half = numpy.arctan2(sine, motion[3]) * share
        axis = motion[:3] / sine if sine > 0 else numpy.zeros(3)
        result = a @ pose((0, 0, 0), [*(axis * numpy.sin(half)), numpy.cos(half)], "interpolated")
        result[:3, 3] = (1 - share) * a[:3, 3] + share * b[:3, 3]
        return result


# ---- pairs -----------------------------------------------------------------------------------------------------------


def spaced_pairs(positions, distance):
    """Indices (source, target) of a drive by the rule of BUFFER-X: the target is the last scan before the first one
    that lies more than a distance [m] away, within 100 scans; the next source is the scan after the target."""
    positions = numpy.asarray(positions)
    pairs = []
    source = 0
    while source < len(positions):
        window = positions[source:source + SEARCH_WINDOW]
        beyond = numpy.nonzero(numpy.linalg.norm(window - positions[source], axis=1) > distance)[0]
        target = source + int(beyond[0]) - 1 if len(beyond) else source
        if target > source:
            pairs.append((source, target))
            source = target + 1
        else:
            source += 1
    return pairs


def drive_pairs(names, poses, distance):
    """Pairs of a drive of posed scans, sources first."""
    return [Pair(names[s], names[t], relative(poses[t], poses[s]))
            for s, t in spaced_pairs([T[:3, 3] for T in poses], distance)]


def listed_pairs(path, worlds):
    """Pairs of a list of "source target" a line, by the names of scans or these without extension. Each world is a dict of
    poses in one frame; both scans of a pair must be in the same."""
    by_name = {}
    for world in worlds:
        for name in world:
            by_name[name] = by_name[pathlib.Path(name).stem] = (name, world)
    pairs = []
    for line, text in enumerate(text_of(path, "--pair-list").splitlines(), 1):
        fields = [f for f in re.split(r"[,;\s]+", text.strip()) if f]
        if not fields or fields[0].startswith("#") or fields[:2] == ["source", "target"]:
            continue
        if len(fields) < 2:
            raise Failure(f"{path}:{line}: expected a source and a target")
        for field in fields[:2]:
            if field not in by_name:
                raise Failure(f"{path}:{line}: '{field}' is no scan with a pose")
        (source, world), (target, other) = (by_name[field] for field in fields[:2])
        if world is not other:
            raise Failure(f"{path}:{line}: the poses of '{source}' and '{target}' are not in one frame")
        pairs.append(Pair(source, target, relative(world[target], world[source])))
    if not pairs:
        raise Failure(f"{path}: lists no pair")
    return pairs


def posed(choice, worlds, pairs, clouds, note, viewpoint="sensor"):
    """A conversion of posed scans: the pairs of --pair-list where it is given, else those of the layout."""
    return Conversion(listed_pairs(choice.pair_list, worlds) if choice.pair_list else pairs, clouds, note,
                      worlds[0] if len(worlds) == 1 else {}, viewpoint)


def chosen_sequences(choice, found, where):
    """The sequences to take, of those that are there."""
    if not choice.sequences:
        return found
    for name in choice.sequences:
        if name not in found:
            raise Failure(f"{where}: there is no sequence '{name}' (there are {', '.join(found) or 'none'})")
    return choice.sequences


# ---- clouds ----------------------------------------------------------------------------------------------------------


def write_pcd(path, points):
    """A binary PCD of x, y, z as floats, sensor at the origin."""
    points = numpy.ascontiguousarray(points, dtype="<f4")
    header = ("# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
              f"WIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\nDATA binary\n")
    path.write_bytes(header.encode() + points.tobytes())


def pcd_with_sensor_at(source, place):
    """A function that makes a PCD file whose sensor is at this place of its frame: SLAM systems keep a pose in that line
    of the header, while the points are in the frame of the scan. A link where the line says so already."""
    def write(path):
        with open(source, "rb") as file:
            head = file.read(HEADER_BYTES)
        end = re.search(rb"^DATA [^\n]*\n", head, re.MULTILINE)
        if not end:
            raise Failure(f"{source}: is no PCD file: it has no line DATA")
        found = re.search(rb"^VIEWPOINT([^\n\r]*)", head[:end.start()], re.MULTILINE)
        place_in_file = [float(f) for f in found.group(1).split()[:3]] if found else [0, 0, 0]
        if numpy.allclose(place_in_file, place):
            path.symlink_to(source.resolve())
            return
        viewpoint = b"VIEWPOINT %g %g %g 1 0 0 0" % tuple(place)
        header = head[:end.start()]
        header = (header[:found.start()] + viewpoint + header[found.end():] if found else
                  re.sub(rb"^(POINTS )", viewpoint + rb"\n\1", header, flags=re.MULTILINE))
        path.write_bytes(header + source.read_bytes()[end.start():])
    return write


# ---- the dataset folder ----------------------------------------------------------------------------------------------


def write_cloud(source, path):
    if path.is_symlink() or path.exists():
        path.unlink()
    if callable(source):
        source(path)
    else:
        path.symlink_to(source.resolve())


def write_dataset(folder, name, sensor, criterion, conversion):
    """pairs.csv, poses.txt, dataset.json and the clouds of the pairs, as links where their format is read."""
    used = sorted({scan for pair in conversion.pairs for scan in (pair.source, pair.target)})
    if not used:
        raise Failure(f"{folder}: no pair of scans: too few scans, or all nearer than the distance of pairs")
    (folder / "scans").mkdir(parents=True, exist_ok=True)
    for scan in used:
        write_cloud(conversion.clouds[scan], folder / "scans" / scan)
    columns = [f"T{r}{c}" for r in range(4) for c in range(4)]
    rows = [",".join(["source", "target", "rot_deg", "trans_m", *columns])]
    for pair in conversion.pairs:
        T = pair.T_target_source
        rows.append(",".join([pair.source, pair.target, f"{angle_deg(T[:3, :3]):.3f}", f"{numpy.linalg.norm(T[:3, 3]):.3f}",
                              *(f"{value:.12g}" for value in T.flatten())]))
    (folder / "pairs.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    lines = [f"{scan} " + " ".join(f"{v:.12g}" for v in (*conversion.poses[scan][:3, 3],
                                                         *quaternion_of(conversion.poses[scan][:3, :3])))
             for scan in used if scan in conversion.poses]
    if lines:
        (folder / "poses.txt").write_text("# scan tx ty tz qx qy qz qw\n" + "\n".join(lines) + "\n", encoding="utf-8")
    elif (folder / "poses.txt").exists():
        (folder / "poses.txt").unlink()
    description = {"name": name, "sensor": sensor, "viewpoint": conversion.viewpoint,
                   "success": {"rotation_deg": criterion.rotation_deg, "translation_m": criterion.translation_m},
                   "note": f"{conversion.note} Success: {criterion.source}."}
    (folder / "dataset.json").write_text(json.dumps(description, indent=1) + "\n", encoding="utf-8")
    return len(conversion.pairs), len(used)
