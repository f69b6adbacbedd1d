# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""The examples run, and leave what they say."""

import csv
import shutil
import subprocess
import sys

import numpy as np
import pytest
from conftest import DATA, ROOT, needs_maps, register_files

EXAMPLES = ROOT / "examples" / "python"


def run(script, *words):
    return subprocess.run(
        [sys.executable, str(EXAMPLES / script), *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, check=False,
    )


def test_open3d_pair(tmp_path):
    o3d = pytest.importorskip("open3d", reason="python3-open3d is not installed")
    cloud, picture = tmp_path / "both.ply", tmp_path / "both.png"
    done = run("open3d_pair.py", DATA / "apartment_1.pcd", DATA / "apartment_0.pcd", cloud, picture)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("converged, confidence 0.999")
    both = np.asarray(o3d.io.read_point_cloud(str(cloud)).points)
    source = np.asarray(o3d.io.read_point_cloud(str(DATA / "apartment_1.pcd")).points)
    T = register_files(DATA / "apartment_1.pcd", DATA / "apartment_0.pcd").T_target_source
    assert np.abs(both[: len(source)] - (source @ T[:3, :3].T + T[:3, 3])).max() < 1e-9
    pixels = np.asarray(o3d.io.read_image(str(picture)))
    assert max(pixels.shape[:2]) == 1200 and pixels.shape[2] == 3
    assert 0.02 < (pixels.min(axis=2) < 200).mean() < 0.7, "lines of walls on white"


@needs_maps
def test_map_folder(tmp_path):
    folder, out = tmp_path / "scans", tmp_path / "map"
    folder.mkdir()
    for i in range(2):
        shutil.copy(DATA / f"apartment_{i}.pcd", folder)
    shutil.copy(DATA / "pairs.csv", folder)
    for _ in range(2):  # the second time from what the first one kept
        done = run("map_folder.py", folder, out)
        assert done.returncode == 0, done.stderr
        assert "2 of 2 scans placed, 1 components" in done.stdout
    with open(out / "poses.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["scan"] for row in rows] == [str(folder / f"apartment_{i}.pcd") for i in range(2)]
    T = np.array([[float(rows[1][f"T{r}{c}"]) for c in range(4)] for r in range(4)])
    pair = register_files(DATA / "apartment_1.pcd", DATA / "apartment_0.pcd").T_target_source
    assert np.abs(T - pair).max() < 0.01
    cloud = np.load(out / "map.npy")
    assert cloud.shape[1] == 3 and 1000 < len(cloud) < 100000


@pytest.mark.parametrize("script", ["open3d_pair.py", "map_folder.py"])
def test_usage(script):
    if script == "open3d_pair.py":
        pytest.importorskip("open3d", reason="python3-open3d is not installed")
    done = run(script)
    assert done.returncode == 1 and "Usage: python3 " + script in done.stderr
