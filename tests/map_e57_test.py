#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""The E57 file of ssfr_map, read by a decoder of its own: pages with checksums, an XML parser, packets, poses.

Usage: map_e57_test.py SSFR_MAP DATA    DATA: the folder data/ of the project
"""
import csv
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

E57 = "{http://www.astm.org/COMMIT/E57/2010-e57-v1.0}"
PAGE = 1024
TABLE = []
for value in range(256):
    for _ in range(8):
        value = value >> 1 ^ (0x82F63B78 if value & 1 else 0)
    TABLE.append(value)


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = TABLE[(crc ^ byte) & 255] ^ crc >> 8
    return crc ^ 0xFFFFFFFF


def logical_of(data):
    assert len(data) % PAGE == 0
    pages = [data[at:at + PAGE] for at in range(0, len(data), PAGE)]
    for page in pages[:40] + pages[-40:]:  # all of them take long in Python
        assert crc32c(page[:-4]) == struct.unpack(">I", page[-4:])[0], "checksum"
    return b"".join(page[:-4] for page in pages)


def to_logical(physical):
    return physical // PAGE * (PAGE - 4) + physical % PAGE


def number(node, *path):
    for name in path:
        node = node.find(E57 + name)
    return float(node.text)


def read_e57(path):
    """Name -> (rotation, translation, points) of each scan; single precision and no more than coordinates."""
    data = logical_of(path.read_bytes())
    signature, major, _, length, xml_at, xml_length, page = struct.unpack("<8sIIQQQQ", data[:48])
    assert (signature, major, page, length) == (b"ASTM-E57", 1, PAGE, path.stat().st_size)
    xml_at = to_logical(xml_at)
    root = ElementTree.fromstring(data[xml_at:xml_at + xml_length].decode())
    scans = {}
    for scan in root.find(E57 + "data3D"):
        pose = scan.find(E57 + "pose")
        w, x, y, z = (number(pose, "rotation", axis) for axis in "wxyz")
        assert abs(w * w + x * x + y * y + z * z - 1) < 1e-12
        rotation = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
        translation = [number(pose, "translation", axis) for axis in "xyz"]
        points = scan.find(E57 + "points")
        fields = [field.tag[len(E57):] for field in points.find(E57 + "prototype")]
        assert fields == ["cartesianX", "cartesianY", "cartesianZ"], fields
        streams = [b""] * len(fields)
        at = to_logical(int(points.get("fileOffset")))
        kind, section, first, _ = struct.unpack("<B7xQQQ", data[at:at + 32])
        assert kind == 1
        packet, end = to_logical(first), at + section
        while packet < end:
            kind, size = data[packet], struct.unpack("<H", data[packet + 2:packet + 4])[0] + 1
            if kind == 1:
                lengths = struct.unpack(f"<{len(fields)}H", data[packet + 6:packet + 6 + 2 * len(fields)])
                part = packet + 6 + 2 * len(fields)
                for k, bytes_of_stream in enumerate(lengths):
                    streams[k] += data[part:part + bytes_of_stream]
                    part += bytes_of_stream
            packet += size
        count = int(points.get("recordCount"))
        name = scan.find(E57 + "name").text
        assert name not in scans
        scans[name] = (rotation, translation, list(zip(*(struct.unpack(f"<{count}f", stream) for stream in streams))))
    return scans


def read_pcd(path):
    header, data = path.read_bytes().split(b"DATA binary\n", 1)
    assert b"FIELDS x y z\n" in header
    return list(struct.iter_unpack("<3f", data))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    building = pathlib.Path(sys.argv[2]) / "building"
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        subprocess.run([sys.argv[1], building, "--out", folder / "map", "--e57", folder / "map.e57"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        scans = read_e57(folder / "map.e57")
        with open(folder / "map" / "poses.csv", newline="", encoding="utf-8") as lines:
            rows = list(csv.DictReader(lines))
        assert [row["scan"][:-4] for row in rows] == list(scans), "every scan, in order"
        assert len(scans) == 8
        for row in rows:
            rotation, translation, points = scans[row["scan"][:-4]]
            for r in range(3):
                assert math.isclose(translation[r], float(row[f"T{r}3"]), abs_tol=1e-12)
                for c in range(3):
                    assert math.isclose(rotation[r][c], float(row[f"T{r}{c}"]), abs_tol=1e-12)
            assert points == read_pcd(building / row["scan"]), "the same points, bit by bit"
    print(f"{len(scans)} scans as they were, with the poses of the map")


if __name__ == "__main__":
    main()
