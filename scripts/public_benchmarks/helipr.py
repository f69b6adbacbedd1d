# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""HeLiPR: a sequence of the makers, LiDAR/SENSOR/STAMP.bin and LiDAR_GT/SENSOR_gt.txt (stamp [ns] x y z qx qy qz qw);
or as BUFFER-X extracted KAIST05, SENSOR/velodyne/NNNNNN.bin (x, y, z, intensity) and SENSOR/poses.txt."""
import re

import numpy

from .common import Failure, chosen_sequences, drive_pairs, posed, tum_poses, write_pcd
from .numbered import numbered_drive

DISTANCE = 10.0                       # [m]
SENSORS = ["Avia", "Aeva", "Ouster"]  # of BUFFER-X
AEVA_INTENSITY_SINCE = 1691936557946849179  # [ns]: later scans have records of 29 bytes, earlier ones of 25 (makers' toolbox)
XYZ = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
RECORDS = {  # packed, as in the makers' toolbox
    "Ouster": XYZ + [("intensity", "<f4"), ("t", "<u4"), ("reflectivity", "<u2"), ("ring", "<u2"), ("ambient", "<u2")],
    "Velodyne": XYZ + [("intensity", "<f4"), ("ring", "<u2"), ("time", "<f4")],
    "Avia": XYZ + [("reflectivity", "u1"), ("tag", "u1"), ("line", "u1"), ("offset_time", "<u4")],
    "Aeva": XYZ + [("reflectivity", "<f4"), ("velocity", "<f4"), ("time_offset_ns", "<i4"), ("line_index", "u1")],
}


def read_scan(path, sensor, stamp):
    """Points that are finite and not at the origin, where there was no return."""
    fields = list(RECORDS[sensor])
    if sensor == "Aeva" and stamp > AEVA_INTENSITY_SINCE:
        fields.append(("intensity", "<f4"))
    record = numpy.dtype(fields)
    data = path.read_bytes()
    if not data or len(data) % record.itemsize != 0:
        raise Failure(f"{path}: {len(data)} bytes are not a whole number of {sensor} points of {record.itemsize} bytes")
    scan = numpy.frombuffer(data, dtype=record)
    points = numpy.stack([scan["x"], scan["y"], scan["z"]], axis=1)
    return points[numpy.isfinite(points).all(axis=1) & (points != 0).any(axis=1)]


def scan_writer(source, sensor, stamp):
    return lambda path: write_pcd(path, read_scan(source, sensor, stamp))


def of_sensor(root, sensor):
    folder = root / "LiDAR" / sensor
    stamps = sorted(int(p.stem) for p in folder.iterdir() if re.fullmatch(r"\d+\.bin", p.name))
    path = root / "LiDAR_GT" / f"{sensor}_gt.txt"
    track = tum_poses(path, 1)
    known = [stamp for stamp in stamps if stamp in track]
    if len(known) < 2:
        raise Failure(f"{path}: {len(known)} of the {len(stamps)} scans in {folder} have a pose of their time stamp")
    names = [f"{sensor}_{stamp}.pcd" for stamp in known]
    poses = [track[stamp] for stamp in known]
    clouds = {name: scan_writer(folder / f"{stamp}.bin", sensor, stamp) for name, stamp in zip(names, known)}
    return drive_pairs(names, poses, DISTANCE), clouds, dict(zip(names, poses))


def convert(root, choice):
    makers = (root / "LiDAR").is_dir()
    found = sorted(s for s in RECORDS if (root / "LiDAR" / s if makers else root / s / "velodyne").is_dir())
    if not found:
        raise Failure(f"{root}: holds neither LiDAR/SENSOR (a sequence of HeLiPR) nor SENSOR/velodyne; sensors: "
                      f"{', '.join(RECORDS)}")
    wanted = chosen_sequences(choice, found, root) if choice.sequences else [s for s in SENSORS if s in found] or found
    pairs, clouds, poses = [], {}, {}
    for sensor in wanted:
        of_drive = (of_sensor(root, sensor) if makers else
                    numbered_drive(root / sensor / "velodyne", "bin", root / sensor / "poses.txt", sensor, DISTANCE))
        pairs += of_drive[0]
        clouds.update(of_drive[1])
        poses.update(of_drive[2])
    note = f"HeLiPR {root.name}, {', '.join(wanted)}, as they are; pairs {DISTANCE:g} m apart by the rule of BUFFER-X."
    return posed(choice, [poses], pairs, clouds, note)
