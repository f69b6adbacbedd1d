# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""What the tests of the Python package share. ctest sets the environment; by hand:

PYTHONPATH=build/release/python PCL_SSFR_ALIGN=build/release/apps/ssfr_align python3 -m pytest tests/python
"""

import csv
import json
import os
import pathlib
import subprocess

import pytest

import pcl_ssfr

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "data"
needs_maps = pytest.mark.skipif(not hasattr(pcl_ssfr, "ScanMap"), reason="built without Ceres and SQLite")


def program(variable):
    """The program that an environment variable names; skips where it is not built."""
    path = os.environ.get(variable)
    if not path:
        pytest.skip(f"{variable} names no program")
    return path


def aligned_by_program(source, target, *options):
    """The JSON of ssfr_align."""
    done = subprocess.run(
        [program("PCL_SSFR_ALIGN"), str(source), str(target), "--json", "-", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout)


def pairs_of(folder):
    """Paths of source and target of each pair of a dataset folder."""
    with open(folder / "pairs.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))

    def found(name):
        return folder / name if (folder / name).exists() else folder / "scans" / name

    return [(found(row["source"]), found(row["target"])) for row in rows]


def assert_same_bits(result, found):
    """Every number that both give, to the last bit."""
    assert (str(result.status), result.converged, result.message) == (
        found["status"],
        found["converged"],
        found["message"],
    )
    assert result.T_target_source.tolist() == found["T_target_source"]
    assert result.information.tolist() == found["information"]
    assert result.overlap == found["overlap"]
    assert result.rmse == found["rmse_m"]
    if found["confidence"] is not None:
        assert result.confidence == found["confidence"]
        assert result.probability_of_none == found["probability_of_none"]
    for side in ("source", "target"):
        place = getattr(result, f"{side}_viewpoint")
        assert (None if place is None else place.tolist()) == found[f"{side}_viewpoint_m"]
    assert [
        (c.T_target_source.tolist(), c.probability, c.score, c.overlap, c.contradiction) for c in result.candidates
    ] == [
        (c["T_target_source"], c["probability"], c["score"], c["overlap"], c["contradiction"])
        for c in found["candidates"]
    ]
    assert [(s.name, s.count_in, s.count_out) for s in result.stages] == [
        (s["name"], s["in"], s["out"]) for s in found["stages"]
    ]


def register_files(source, target, **options):
    """As a user does: read_scan() and register_scans()."""
    points, viewpoint = pcl_ssfr.read_scan(source)
    target_points, target_viewpoint = pcl_ssfr.read_scan(target)
    return pcl_ssfr.register_scans(
        points, target_points, source_viewpoint=viewpoint, target_viewpoint=target_viewpoint, **options
    )


@pytest.fixture(scope="session")
def apartment():
    """Source and target that lie 121 degrees and 2 m apart."""
    return pcl_ssfr.read_scan(DATA / "apartment_1.pcd")[0], pcl_ssfr.read_scan(DATA / "apartment_0.pcd")[0]


@pytest.fixture(scope="session")
def aligned(apartment):
    return pcl_ssfr.register_scans(*apartment)
