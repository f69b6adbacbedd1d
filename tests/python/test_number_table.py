# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""scripts/number_table: rows of numbers halved and doubled, going on, and what cannot be read."""
import csv
import os
import pathlib
import shutil
import subprocess
import sys

import pcl_ssfr

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(pcl_ssfr.__file__).resolve().parents[2]


def run(out, *arguments):
    command = [sys.executable, os.fspath(ROOT / "scripts" / "number_table"), "--build-dir", os.fspath(BUILD), "--jobs", "1"]
    return subprocess.run([*command, "--out", os.fspath(out), *map(os.fspath, arguments)], capture_output=True, text=True)


def test_a_number_that_matters_and_one_that_does_not(tmp_path):
    out = tmp_path / "rows.csv"
    done = run(out, "--numbers", "judgement.prior.guess", ROOT / "data")
    assert done.returncode == 0, done.stderr
    with open(out, newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["number"], row["factor"]) for row in rows[:3]] == [
        ("", "1"), ("judgement.prior.guess_trust", "0.5"), ("judgement.prior.guess_trust", "2.0")]
    assert all((row["solved"], row["accepted"], row["false"], row["changed"]) == ("3", "3", "0", "0") for row in rows)
    assert "| `judgement.prior.guess_deviation` | 0 | 3 / 3 / 0 | 0 | 3 / 3 / 0 |" in done.stdout

    done = run(out, "--numbers", "judgement.decided", ROOT / "data")
    assert done.returncode == 0, done.stderr
    assert "| `judgement.decided` | 0 | 3 / 3 / 0 | - | - |" in done.stdout  # there is no probability of 1.8

    done = run(tmp_path / "coarse.csv", "--numbers", "preparation.leaf", "--factors", "60", ROOT / "data")
    assert done.returncode == 0, done.stderr
    assert "| `preparation.leaf` | 3 | 0 / 0 / 0 |" in done.stdout

    before = out.read_bytes()
    assert run(out, "--numbers", "judgement.prior.guess", ROOT / "data").returncode == 0
    assert out.read_bytes() == before


def test_scans_in_a_folder_of_their_own_as_the_simulator_writes_them(tmp_path):
    simulated = tmp_path / "simulated"
    (simulated / "scans").mkdir(parents=True)
    shutil.copy(ROOT / "data" / "pairs.csv", simulated)
    for scan in (ROOT / "data").glob("*.pcd"):
        shutil.copy(scan, simulated / "scans")
    done = run(tmp_path / "rows.csv", "--numbers", "judgement.prior.guess_trust", "--factors", "2", simulated)
    assert done.returncode == 0, done.stderr
    assert "| `judgement.prior.guess_trust` | 0 | 3 / 3 / 0 |" in done.stdout


def test_what_cannot_be_read_is_named(tmp_path):
    done = run(tmp_path / "rows.csv", tmp_path)
    assert done.returncode == 1 and str(tmp_path / "pairs.csv") in done.stderr
    done = run(tmp_path / "rows.csv", "--overlap-below", "-1", ROOT / "data")
    assert done.returncode == 1 and "no pair" in done.stderr
    assert not (tmp_path / "rows.csv").exists()
