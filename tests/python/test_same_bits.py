# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""The package gives what ssfr_align gives, to the last bit.

PCL_SSFR_PYTHON_ALL_PAIRS=1 takes all pairs of all real sets: ten minutes; else all of the sets with few pairs, and
the first and the middle one of the others.
"""

import os
import pathlib

import numpy as np
import pytest
from conftest import DATA, aligned_by_program, assert_same_bits, needs_maps, pairs_of, register_files

import pcl_ssfr

FEW_PAIRS = 6  # of a set that is taken whole
REAL = os.environ.get("PCL_SSFR_TEST_DATA_DIR", "")


def real_pairs():
    if not REAL:
        return [pytest.param(None, None, marks=pytest.mark.skip(reason="PCL_SSFR_TEST_DATA_DIR is empty"))]
    pairs = []
    for table in sorted(pathlib.Path(REAL).glob("*/pairs.csv")):
        of_set = pairs_of(table.parent)
        if len(of_set) > FEW_PAIRS and not os.environ.get("PCL_SSFR_PYTHON_ALL_PAIRS"):
            of_set = [of_set[0], of_set[len(of_set) // 2]]
        pairs += [pytest.param(*p, id=f"{table.parent.name}-{p[0].stem}-{p[1].stem}") for p in of_set]
    return pairs


@pytest.mark.parametrize("source,target", real_pairs())
def test_real_pairs(source, target):
    assert_same_bits(register_files(source, target), aligned_by_program(source, target))


@pytest.mark.parametrize("source,target", pairs_of(DATA), ids=lambda path: path.stem)
def test_pairs_of_the_repository(source, target):
    assert_same_bits(register_files(source, target, threads=1), aligned_by_program(source, target, "--threads", "2"))


def test_options(tmp_path, apartment, aligned):
    source, target = DATA / "apartment_1.pcd", DATA / "apartment_0.pcd"
    guess = tmp_path / "guess.txt"
    np.savetxt(guess, aligned.T_target_source)
    found = aligned_by_program(
        source, target, "--leaf", "0.05", "--viewpoint", "unknown", "--guess", str(guess), "--guess-tolerance", "20,1",
        "--no-refine", "--gravity", "0,0,3", "--gravity-tolerance", "170", "--min-confidence", "0.999",
    )
    result = pcl_ssfr.register_scans(
        *apartment,
        leaf=0.05,
        viewpoint_mode="unknown",
        guess=pcl_ssfr.read_transform(guess),
        guess_tolerance=(20, 1),
        refine=False,
        gravity=(0, 0, 3),
        gravity_tolerance_deg=170,
        min_confidence=0.999,
    )
    assert_same_bits(result, found)
    assert result.source_viewpoint_found


def test_profile_of_the_paper():
    source, target = DATA / "apartment_1.pcd", DATA / "apartment_0.pcd"
    result = register_files(source, target, profile="paper2017")
    assert result.confidence == 0
    assert_same_bits(result, aligned_by_program(source, target, "--profile", "paper2017"))


def write_text(path, points):
    np.savetxt(path, points, fmt="%.4f", header="x,y,z", delimiter=",", comments="")


def test_large_coordinates_lose_nothing(tmp_path, apartment):
    """Clouds in a map's frame: doubles, the offset is taken off before the cast, as in the programs."""
    far = np.array([4.5e5, 5.4e6, 120.0])
    files = [tmp_path / "source.csv", tmp_path / "target.csv"]
    for path, points, offset in zip(files, apartment, (far, 2 * far)):
        write_text(path, points[::3].astype(np.float64) + offset)
    points, _ = pcl_ssfr.read_scan(files[0])
    assert points.dtype == np.float64
    viewpoints = {"source_viewpoint": far, "target_viewpoint": 2 * far}
    result = register_files(*files)
    assert result.converged
    assert_same_bits(result, aligned_by_program(*files))
    assert np.linalg.norm(result.source_viewpoint - far) < 1, "found in the points, in the coordinates of the file"
    given = pcl_ssfr.register_scans(points, pcl_ssfr.read_scan(files[1])[0], **viewpoints)
    assert given.source_viewpoint.tolist() == far.tolist() and not given.source_viewpoint_found
    near = pcl_ssfr.register_scans(apartment[0][::3], apartment[1][::3]).T_target_source
    back = np.eye(4)
    back[:3, 3] = -2 * far
    there = np.eye(4)
    there[:3, 3] = far
    assert np.abs(back @ given.T_target_source @ there - near).max() < 2e-3


@needs_maps
def test_large_coordinates_of_maps(tmp_path, apartment):
    far = np.array([4.5e5, 5.4e6, 120.0])
    here = pcl_ssfr.map_scans([apartment[1], apartment[0]])
    there = pcl_ssfr.map_scans(
        [(points.astype(np.float64) + far, far) for points in (apartment[1], apartment[0])], names=["a", "b"]
    )
    assert there.components == 1
    T = there.scans[1].T_map_scan
    moved = T[:3, :3] @ far + T[:3, 3] - far
    assert np.abs(moved - here.scans[1].T_map_scan[:3, 3]).max() < 1e-3
    assert np.abs(T[:3, :3] - here.scans[1].T_map_scan[:3, :3]).max() < 1e-4
