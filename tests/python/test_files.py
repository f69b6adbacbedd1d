# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Reading files, and `python3 -m pcl_ssfr`."""

import json
import pathlib
import subprocess
import sys

import numpy as np
import pytest
from conftest import DATA, aligned_by_program

import pcl_ssfr

POINTS = np.array([[1, 2, 3], [4, 5, 6], [7, 8, 9.5]], np.float32)


def write_pcd(path, viewpoint="0 0 0 1 0 0 0", fields="x y z", rows=POINTS):
    count = len(fields.split())
    head = f"""VERSION 0.7
FIELDS {fields}
SIZE {' '.join('4' * count)}
TYPE {' '.join('F' * count)}
COUNT {' '.join('1' * count)}
WIDTH {len(rows)}
HEIGHT 1
VIEWPOINT {viewpoint}
POINTS {len(rows)}
DATA ascii
"""
    path.write_text(head + "\n".join(" ".join(map(str, row)) for row in rows) + "\n", encoding="ascii")
    return path


class TestReading:
    def test_points_and_viewpoint(self, tmp_path):
        points, viewpoint = pcl_ssfr.read_scan(write_pcd(tmp_path / "scan.pcd"))
        assert points.dtype == np.float32 and points.flags.c_contiguous and points.flags.writeable
        assert np.array_equal(points, POINTS) and viewpoint is None
        points, viewpoint = pcl_ssfr.read_scan(str(write_pcd(tmp_path / "seen.pcd", "1 2 -3 1 0 0 0")))
        assert viewpoint.tolist() == [1, 2, -3] and viewpoint.dtype == np.float64

    def test_what_else_a_file_holds(self, tmp_path):
        rows = np.hstack([POINTS, [[10.0], [20.0], [30.0]], np.eye(3)])
        scan = pcl_ssfr.read_scan_file(
            write_pcd(tmp_path / "scan.pcd", fields="x y z intensity normal_x normal_y normal_z", rows=rows)
        )
        assert np.array_equal(scan.points, POINTS) and scan.viewpoint is None and scan.T_file_scan is None
        assert scan.intensity.tolist() == [10, 20, 30] and np.array_equal(scan.normals, np.eye(3))
        plain = pcl_ssfr.read_scan_file(write_pcd(tmp_path / "plain.pcd"))
        assert plain.intensity is None and plain.normals is None

    def test_not_finite_points_stay(self, tmp_path):
        rows = [[1, 2, 3], ["nan", "nan", "nan"], [7, 8, 9]]
        points, _ = pcl_ssfr.read_scan(write_pcd(tmp_path / "scan.pcd", rows=rows))
        assert np.isfinite(points).all(axis=1).tolist() == [True, False, True]

    def test_large_coordinates_are_doubles(self, tmp_path):
        path = tmp_path / "scan.csv"
        path.write_text("x,y,z\n450000.125,5400000.25,100.5\n450001.125,5400001.25,101.5\n", encoding="ascii")
        points, _ = pcl_ssfr.read_scan(path)
        assert points.dtype == np.float64
        assert points.tolist() == [[450000.125, 5400000.25, 100.5], [450001.125, 5400001.25, 101.5]]

    def test_names_of_any_bytes(self, tmp_path):
        path = tmp_path / "s\u00e4ule \u6307 .pcd"
        assert len(pcl_ssfr.read_scan(write_pcd(path))[0]) == 3

    def test_formats(self):
        assert {".pcd", ".ply", ".las", ".e57"} <= set(pcl_ssfr.READABLE_FORMATS)

    @pytest.mark.parametrize("reader", ["read_scan", "read_scan_file", "list_e57_scans", "read_transform"])
    def test_no_such_file(self, reader):
        with pytest.raises(pcl_ssfr.FileError, match="nowhere.e57") as raised:
            getattr(pcl_ssfr, reader)("nowhere.e57")
        assert isinstance(raised.value, ValueError) and isinstance(raised.value, OSError)

    def test_damaged_and_unknown(self, tmp_path):
        path = tmp_path / "scan.pcd"
        path.write_text("no cloud\n", encoding="ascii")
        with pytest.raises(ValueError, match="scan.pcd"):
            pcl_ssfr.read_scan(path)
        with pytest.raises(ValueError, match="unknown format"):
            pcl_ssfr.read_scan(tmp_path / "scan.xls")
        with pytest.raises(TypeError):
            pcl_ssfr.read_scan(3)

    def test_transform(self, tmp_path):
        path = tmp_path / "T.txt"
        path.write_text("0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n", encoding="ascii")
        assert pcl_ssfr.read_transform(path).tolist() == [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
        path.write_text("1 2 3\n", encoding="ascii")
        with pytest.raises(ValueError, match="16 numbers, found 3"):
            pcl_ssfr.read_transform(path)


def run(*words):
    return subprocess.run(
        [sys.executable, "-m", "pcl_ssfr", *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        check=False,
    )


class TestCommand:
    SOURCE, TARGET = DATA / "apartment_1.pcd", DATA / "apartment_0.pcd"

    def test_aligns(self, aligned):
        done = run(self.SOURCE, self.TARGET)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith(f"Aligned {self.SOURCE} onto {self.TARGET}\n")
        rows = [[float(n) for n in line.split()] for line in done.stdout.splitlines()[2:6]]
        assert np.abs(np.array(rows) - aligned.T_target_source).max() < 1e-8

    def test_json_is_that_of_the_program(self, tmp_path):
        done = run(self.SOURCE, self.TARGET, "--json", "-", "--transform", tmp_path / "T.txt")
        found = json.loads(done.stdout)
        expected = aligned_by_program(self.SOURCE, self.TARGET)
        only_there = {"loading_s", "source_path", "target_path", "options", "guess"}
        assert set(found) == set(expected) - only_there
        for key in set(found) - {"time_s", "stages", "peak_rss_mib"}:
            assert found[key] == expected[key], key
        assert [(s["name"], s["in"], s["out"]) for s in found["stages"]] == [
            (s["name"], s["in"], s["out"]) for s in expected["stages"]
        ]
        assert found["time_s"] > 0 and found["peak_rss_mib"] > 1
        assert pcl_ssfr.read_transform(tmp_path / "T.txt").tolist() == found["T_target_source"]
        done = run(self.SOURCE, self.TARGET, "--json", tmp_path / "r.json", "--profile", "paper2017")
        assert done.returncode in (0, 1)
        assert json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))["confidence"] is None

    def test_pose_to_standard_output(self, aligned):
        done = run(self.SOURCE, self.TARGET, "--transform", "-")
        assert (done.returncode, done.stderr) == (0, "")
        assert [[float(n) for n in line.split()] for line in done.stdout.splitlines()] == aligned.T_target_source.tolist()
        done = run(self.SOURCE, self.TARGET, "--transform", "-", "--gravity", "0,0,1")
        assert (done.returncode, done.stdout) == (1, "")
        assert done.stderr.startswith("pcl_ssfr: Not aligned, ") and done.stderr.count("\n") == 1
        done = run(self.SOURCE, self.TARGET, "--transform", "-", "--json", "-")
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == "pcl_ssfr: --json: '-' is also --transform\n"

    def test_not_aligned(self):
        done = run(self.SOURCE, self.TARGET, "--gravity", "0,0,1", "--leaf", "0.05")
        assert done.returncode == 1 and done.stdout.startswith("Not aligned, ")

    def test_gravity_of_negative_numbers(self):
        for words in (["--gravity", "-0.0,0.01,1"], ["--gravity", "-.01,0,1"], ["--gravity=-0.01,0,1"]):
            done = run(self.SOURCE, self.TARGET, *words)  # the scans are tilted otherwise
            assert (done.returncode, done.stderr) == (1, "")

    @pytest.mark.parametrize(
        "words,code,text",
        [
            ([], 2, "SOURCE"),
            (["--leaf", "-1"], 2, "leaf = -1, must be 0 or positive"),
            (["--gravity", "up"], 2, "--gravity: 'up' is not x,y,z"),
            (["--gravity", "0,1"], 2, "gravity = [0.0, 1.0], must be"),
            (["--threads", "-3"], 2, "threads = -3"),
            (["--threads", "x"], 2, "--threads"),
            (["--thread", "1"], 2, "--thread"),
            (["--guess", "nowhere.txt"], 3, "nowhere.txt"),
            (["--json", "nowhere/r.json"], 3, "nowhere/r.json: cannot be written"),
        ],
    )
    def test_errors(self, words, code, text):
        done = run(*([self.SOURCE, self.TARGET] if words else []), *words)
        assert (done.returncode, done.stdout) == (code, "")
        assert text in done.stderr and "Traceback" not in done.stderr

    def test_files(self, tmp_path):
        done = run("nowhere.pcd", self.TARGET)
        assert (done.returncode, done.stderr) == (3, "pcl_ssfr: nowhere.pcd: no such file\n")
        empty = write_pcd(tmp_path / "empty.pcd", rows=[["nan"] * 3])
        done = run(empty, self.TARGET)
        assert (done.returncode, done.stderr) == (1, "")
        assert done.stdout == f"Not aligned, too_few_points: {empty}: none of its 1 points is finite\n"
        found = json.loads(run(self.SOURCE, empty, "--json", "-").stdout)
        assert (found["status"], found["converged"]) == ("too_few_points", False)

    def test_version(self):
        done = run("--version")
        root = pathlib.Path(__file__).resolve().parents[2]
        assert done.stdout == f"pcl_ssfr {pcl_ssfr.__version__}\n"
        project = (root / "CMakeLists.txt").read_text(encoding="utf-8")
        assert f"project(pcl_ssfr VERSION {pcl_ssfr.__version__} " in project
