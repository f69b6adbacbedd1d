#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""scripts/open3d_multiway on a made-up map of four scans; exit code 77 where Open3D or numpy is missing."""
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "scripts" / "open3d_multiway"
SYSTEM_PYTHON = "/usr/bin/python3"


def yaw(angle, x, y):
    """A 4x4 pose as rows."""
    c, s = math.cos(angle), math.sin(angle)
    return [[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]]


def inverse(T):
    R = [[T[k][r] for k in range(3)] for r in range(3)]
    return [R[r] + [-sum(R[r][k] * T[k][3] for k in range(3))] for r in range(3)] + [[0, 0, 0, 1]]


def multiply(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)] for r in range(4)]


def entries(T):
    return [f"{v:.12g}" for row in T for v in row]


def room_seen_from(pose):
    """Points of a room of 6 m by 5 m by 3 m in the frame of a scan."""
    generator, T, points = random.Random(4), inverse(pose), []
    size = (6, 5, 3)
    for _ in range(4000):
        p = [generator.uniform(0, s) for s in size]
        axis = generator.randrange(3)
        p[axis] = generator.choice((0, size[axis]))
        points.append([sum(T[r][k] * (*p, 1)[k] for k in range(4)) for r in range(3)])
    return points


class Job:
    """A map of ssfr_map as files: scans, truth, poses, and links of which one errs."""

    def __init__(self, folder, error):
        self.folder = folder
        self.truth = [yaw(0, 1, 1), yaw(1, 4, 1), yaw(2.5, 4, 4), yaw(-1, 1, 4)]
        names = [f"s{i}.ply" for i in range(4)]
        (folder / "scans").mkdir()
        (folder / "map").mkdir()
        for name, pose in zip(names, self.truth):
            points = room_seen_from(pose)
            lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
            lines += [f"property float {axis}" for axis in "xyz"] + ["end_header"]
            lines += [" ".join(f"{v:.6f}" for v in p) for p in points]
            (folder / "scans" / name).write_text("\n".join(lines) + "\n")
        (folder / "truth.txt").write_text("".join(f"{n} {' '.join(entries(T))}\n" for n, T in zip(names, self.truth)))
        columns = [f"T{r}{c}" for r in range(4) for c in range(4)]
        T_map_truth = inverse(self.truth[0])
        poses = [",".join(["scan", "component"] + columns)]
        poses += [",".join([n, "0"] + entries(multiply(T_map_truth, T))) for n, T in zip(names, self.truth)]
        links = [",".join(["source", "target", "status", "confidence"] + columns)]
        for source, target in ((0, 1), (1, 2), (2, 3), (0, 2), (1, 3), (0, 3)):
            T = multiply(inverse(self.truth[target]), self.truth[source])
            if (source, target) == (0, 3):
                T[0][3] += error
            confidence = 0.9 if (source, target) == (0, 3) else 0.99 - 0.01 * source
            links.append(",".join([names[source], names[target], "used", str(confidence)] + entries(T)))
        (folder / "map" / "poses.csv").write_text("\n".join(poses) + "\n")
        (folder / "map" / "links.csv").write_text("\n".join(links) + "\n")
        self.write_wrong({})

    def write_wrong(self, wrong):
        scans = [{"scan": f"s{i}.ply", "wrong": wrong.get(i, False)} for i in range(4)]
        (self.folder / "map" / "map.json").write_text(json.dumps({"truth": {"scans": scans}}))

    def run(self, *options):
        return subprocess.run([str(SCRIPT), *options, str(self.folder / "scans"), str(self.folder / "map"),
                               str(self.folder / "truth.txt")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def errors_of(done):
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def main():
    if subprocess.run([SYSTEM_PYTHON, "-c", "import numpy, open3d"], stderr=subprocess.DEVNULL).returncode:
        print("skipped: no numpy or Open3D for", SYSTEM_PYTHON)
        return 77
    with tempfile.TemporaryDirectory() as work:
        for name in ("exact", "little"):
            (pathlib.Path(work) / name).mkdir()
        exact = Job(pathlib.Path(work) / "exact", 0.0)
        errors = errors_of(exact.run())
        assert errors["scans"] == 4 and errors["largest_m"] < 1e-6 and errors["our_largest_m"] < 1e-6, errors
        # A link that errs by 2 cm pulls the scans by some of it, and our poses not at all.
        little = Job(pathlib.Path(work) / "little", 0.02)
        errors = errors_of(little.run())
        assert 0.001 < errors["largest_m"] < 0.02 and errors["our_largest_m"] < 1e-6, errors
        # Scans that are in a wrong place do not count.
        little.write_wrong({1: True})
        assert errors_of(little.run())["scans"] == 3
        little.write_wrong({0: True, 1: True, 2: True})
        errors = errors_of(little.run())
        assert errors["scans"] == 0 and errors["median_m"] is None, errors
        # What is wrong is named in one line.
        (little.folder / "map" / "map.json").write_text("{}")
        for done, word in ((little.run(), str(little.folder / "map")), (exact.run("--voxel", "0"), "--voxel")):
            assert done.returncode == 1 and word in done.stderr and done.stderr.count("\n") == 1, done.stderr
    return 0


if __name__ == "__main__":
    sys.exit(main())
