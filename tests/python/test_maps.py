# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Many scans in one frame."""

import csv
import os
import subprocess
import threading

import numpy as np
import pytest
from conftest import DATA, needs_maps, program

import pcl_ssfr

pytestmark = needs_maps
FILES = [DATA / f"apartment_{i}.pcd" for i in range(4) if (DATA / f"apartment_{i}.pcd").exists()]


@pytest.fixture(scope="module")
def arrays():
    return [pcl_ssfr.read_scan(path)[0] for path in FILES]


@pytest.fixture(scope="module")
def found(arrays):
    return pcl_ssfr.map_scans(arrays)


def poses(scan_map):
    return [scan.T_map_scan.tolist() for scan in scan_map.scans]


def test_fields(found):
    assert found.components == 1 and found.placed == len(FILES)
    assert [scan.name for scan in found.scans] == [f"scan {i}" for i in range(len(FILES))]
    for scan in found.scans:
        assert scan.usable and scan.component == 0 and scan.reason == "" and scan.links > 0
        assert scan.T_map_scan.shape == (4, 4) and scan.covariance.shape == (6, 6)
    assert found.scans[0].T_map_scan.tolist() == np.eye(4).tolist()
    link = found.links[0]
    assert link.status is pcl_ssfr.LinkStatus.USED and (link.source, link.target) == (0, 1)
    assert link.strength.shape == (3,) and link.T_target_source.shape == (4, 4)
    assert "1 component" in repr(found)


def test_pairs(arrays, found):
    """So few scans are all candidates of each other."""
    for pairs in ("all", "candidates"):
        assert poses(pcl_ssfr.map_scans(arrays, pairs=pairs)) == poses(found)


def test_bits_of_the_program(tmp_path, found):
    """Files in C++, files in Python, arrays in Python: one map."""
    command = [program("PCL_SSFR_MAP"), *map(str, FILES), "--out", str(tmp_path / "map")]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    assert done.returncode == 0, done.stdout
    with open(tmp_path / "map" / "poses.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    expected = [[[float(row[f"T{r}{c}"]) for c in range(4)] for r in range(4)] for row in rows]
    assert poses(found) == expected
    from_files = pcl_ssfr.map_scans(FILES, threads=1)
    assert poses(from_files) == expected
    assert [scan.name for scan in from_files.scans] == list(map(str, FILES))


def test_project_is_taken_up_again(tmp_path, found, arrays):
    project = tmp_path / "map.sqlite"
    linked = []

    def progress(stage, done, total):
        assert 0 <= done <= total
        linked.append((stage, done, total, threading.get_ident()))

    first = pcl_ssfr.map_scans(arrays, project=project, progress=progress)
    assert poses(first) == poses(found) and os.path.getsize(project) > 0
    assert {stage for stage, *_ in linked} >= {"prepare", "link"}
    linked.clear()
    again = pcl_ssfr.map_scans(arrays, project=project, resume=True, progress=progress)
    assert poses(again) == poses(found)
    pairs = len(arrays) * (len(arrays) - 1) // 2
    assert [done for stage, done, total, _ in linked if stage == "link"][0] == pairs, "nothing is linked anew"


def test_decisions(arrays):
    names = [f"s{i}" for i in range(len(arrays))]
    pinned = pcl_ssfr.map_scans(arrays, names=names, pins=["s1"])
    assert pinned.scans[1].T_map_scan.tolist() == np.eye(4).tolist()
    pairs = [(names[i], names[1]) for i in range(len(names)) if i != 1]
    alone = pcl_ssfr.map_scans(arrays, names=names, reject=pairs)
    assert alone.components > 1 and alone.scans[1].reason
    shifted = np.eye(4)
    shifted[:3, 3] = 10, 20, 30
    known = pcl_ssfr.map_scans(arrays, names=names, poses={"s0": shifted}, pose_tolerance=(5, 0.5))
    assert np.abs(known.scans[0].T_map_scan - shifted).max() < 0.5


def test_what_cannot_be_read_is_a_scan_with_a_reason(tmp_path, arrays):
    scans = [FILES[0], tmp_path / "nowhere.pcd", arrays[1], np.full((4, 3), np.nan)]
    scan_map = pcl_ssfr.map_scans(scans)
    assert scan_map.placed == 2 and scan_map.components == 3
    assert "no such file" in scan_map.scans[1].reason and "is finite" in scan_map.scans[3].reason
    assert not scan_map.scans[1].usable


@pytest.mark.parametrize(
    "words,text",
    [
        ({"names": ["a"]}, "names: 1 for 2 scans"),
        ({"names": ["a", "a"]}, "two scans are named a"),
        ({"names": ["a", ""]}, "a scan has no name"),
        ({"pins": ["z"]}, "pin: z is none of the scans"),
        ({"accept": [("scan 0", "z")]}, "accept: z is none of the scans"),
        ({"reject": [("scan 0", "scan 0"), ("z", "z")]}, "z is none of the scans"),
        ({"poses": {"z": np.eye(4)}}, "poses: z is none of the scans"),
        ({"poses": {"scan 0": np.eye(3)}}, "poses: scan 0: must be an array of numbers of shape (4, 4)"),
        ({"poses": {"scan 0": np.eye(4)}, "pose_tolerance": (0, 1)}, "tolerance of a pose prior must be positive"),
        ({"gravity": [0, 0]}, "gravity = [0, 0], must be three finite numbers"),
        ({"pairs": "some"}, "pairs: 'some' is neither 'auto', 'all' nor 'candidates'"),
        ({"leaf": -1}, "leaf = -1"),
        ({"guess_tolerance": (3, 1)}, "guess_tolerance: a map has no guess"),
        ({"progress": 3}, "progress = 3, must be callable"),
        ({"pins": "scan 0"}, "pins = 'scan 0', must be a list of names"),
        ({"pins": [0]}, "pins = [0], must be a list of names"),
        ({"accept": [(0, 1)]}, "accept: (0, 1), must be two names of scans"),
        ({"accept": ["ab"]}, "accept: 'ab', must be two names of scans"),
        ({"reject": [("scan 0", "scan 1", "z")]}, "reject: ('scan 0', 'scan 1', 'z'), must be two names of scans"),
        ({"reject": 7}, "reject: 7, must be two names of scans"),
        ({"leef": 1}, "leef is no option"),
        ({"project": "/nowhere/map.sqlite"}, "/nowhere/map.sqlite"),
    ],
)
def test_wrong_arguments(arrays, words, text):
    with pytest.raises(ValueError) as raised:
        pcl_ssfr.map_scans([points[::20] for points in arrays[:2]], **words)
    assert text in str(raised.value)


def test_wrong_scans(arrays):
    with pytest.raises(ValueError, match="a map takes two scans or more, 1 of 1"):
        pcl_ssfr.map_scans(arrays[:1])
    with pytest.raises(ValueError, match="^scan 1: a tuple of 3, must be points and viewpoint"):
        pcl_ssfr.map_scans([arrays[0], (arrays[1], None, None)])
    with pytest.raises(ValueError, match=r"^scan 1: an array of dtype float32 and shape \(3, 2\)"):
        pcl_ssfr.map_scans([arrays[0], np.zeros((3, 2), np.float32)])


def test_progress_that_raises(arrays):
    calls = []

    def progress(*words):
        calls.append(words)
        raise KeyError("stop")

    with pytest.raises(KeyError, match="stop"):
        pcl_ssfr.map_scans([points[::10] for points in arrays[:2]], progress=progress)
    assert len(calls) == 1
