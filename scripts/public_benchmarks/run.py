# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""The command: convert a folder, run ssfr_benchmark, print our row with the published ones."""
import argparse
import dataclasses
import json
import os
import pathlib
import subprocess
import sys
from typing import Callable

from . import eth, helipr, kitti, newer_college, oxford_spires, resso, scannetpp, tiers, whu_tls
from .common import Choice, Failure, need_folder, write_dataset
from .published import CRITERIA, published_rows

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DONE, USAGE, INPUT = 0, 2, 3


@dataclasses.dataclass(frozen=True)
class Layout:
    """A public data set."""

    title: str
    sensor: str
    criterion: str
    convert: Callable


LAYOUTS = {
    "eth": Layout("ETH", "Hokuyo UTM-30LX, tilted", "eth", eth.convert),
    "whu_tls": Layout("WHU-TLS", "terrestrial laser scanners", "ours", whu_tls.convert),
    "resso": Layout("RESSO", "terrestrial laser scanners", "ours", resso.convert),
    "tiers": Layout("TIERS", "VLP-16, OS0, OS1, Livox", "outdoor", tiers.convert),
    "newer_college": Layout("Newer College", "Ouster OS1-64", "outdoor", newer_college.convert),
    "oxford_spires": Layout("Oxford Spires", "Hesai QT64", "outdoor", oxford_spires.convert),
    "kitti": Layout("KITTI odometry", "Velodyne HDL-64E", "outdoor", kitti.convert),
    "helipr": Layout("HeLiPR", "Ouster, Velodyne, Livox Avia, Aeva", "outdoor", helipr.convert),
    "scannetpp": Layout("ScanNet++ (FARO)", "FARO Focus", "indoor", scannetpp.convert),
}


def parser():
    result = argparse.ArgumentParser(
        prog="scripts/public_benchmark",
        description="Makes a dataset folder of a public data set as its makers publish it (docs/PUBLIC_BENCHMARKS.md says how "
        "to get each and what is expected), runs ssfr_benchmark on it, and prints our row with the published ones.",
        epilog="Options of ssfr_benchmark follow after --, for instance: -- --random-rotation --jobs 4 --resume")
    result.add_argument("set", nargs="?", choices=sorted(LAYOUTS), metavar="SET", help=", ".join(LAYOUTS))
    result.add_argument("folder", nargs="?", type=pathlib.Path, metavar="FOLDER", help="the data set; it is only read")
    result.add_argument("--out", type=pathlib.Path, help="gets dataset/ (links where the format is read), run/, table.md")
    result.add_argument("--sequences", type=lambda text: text.split(","), metavar="A,B",
                        help="sequences, scenes or sensors (default: those of the published figures, else all)")
    result.add_argument("--pair-list", type=pathlib.Path, metavar="FILE",
                        help="lines of source and target, names of scans in dataset/scans, in place of the set's pairs")
    result.add_argument("--criterion", choices=sorted(CRITERIA), help="in place of that of the set")
    result.add_argument("--methods", default="ssfr", help="of ssfr_benchmark (default: ssfr)")
    result.add_argument("--convert-only", action="store_true", help="run nothing")
    place = result.add_mutually_exclusive_group()
    place.add_argument("--build-dir", type=pathlib.Path, default=ROOT / "build" / "release", help="default: build/release")
    place.add_argument("--program", type=pathlib.Path, help="path of ssfr_benchmark")
    result.add_argument("--list", action="store_true", help="list the sets, their criteria and their published figures")
    return result


def list_sets():
    for key, layout in LAYOUTS.items():
        criterion = CRITERIA[layout.criterion]
        print(f"{key:<14} {layout.title}; success: {criterion.source}")
        rows = published_rows(key)
        print(f"{'':<15}{rows[0][2]}:" if rows else f"{'':<15}no figure found")
        for method, success, _ in rows:
            print(f"{'':<15}{success:6.2f} % {method}")


def convert(key, folder, out, choice, criterion=None):
    """The dataset folder of a set; returns what is said of it."""
    layout = LAYOUTS[key]
    need_folder(folder, layout.title)
    if folder.resolve() == out.resolve() or folder.resolve() in out.resolve().parents:
        raise Failure(f"{out}: --out lies in the folder of the data set, which is only read")
    criterion = CRITERIA[criterion or layout.criterion]
    try:
        conversion = layout.convert(folder, choice)
        pairs, scans = write_dataset(out / "dataset", key, layout.sensor, criterion, conversion)
    except OSError as error:
        raise Failure(f"{error.filename or folder}: {error.strerror or error}") from error
    return f"{pairs} pairs of {scans} scans in {out / 'dataset'}. {conversion.note} Success: {criterion.source}."


def run(program, out, methods, more):
    command = [str(program), "--dataset", str(out / "dataset"), "--methods", methods, "--out", str(out / "run"), *more]
    if not program.is_file() or not os.access(program, os.X_OK):
        raise Failure(f"{program}: there is no such program; build it or name it with --program or --build-dir")
    code = subprocess.run(command, stdout=sys.stderr, check=False).returncode
    if code != 0:
        raise Failure(f"{program} ended with exit code {code}: {' '.join(command)}")


def result_table(key, summary):
    """A Markdown table: a row for each method that was run, then the published rows."""
    def value(entry, name, digits, factor=1):
        return "-" if entry.get(name) is None else f"{factor * entry[name]:.{digits}f}"
    lines = ["| method | pairs | solved | accepted | false positives | rotation, median | translation, median | source |",
             "|---|---|---|---|---|---|---|---|"]
    for entry in (e for e in summary["methods"] if e.get("dataset") == key):
        share = 100 * entry["solved"] / entry["pairs"] if entry["pairs"] else 0
        lines.append(f"| {entry['method']} | {entry['pairs']} | {share:.2f} % | {entry['accepted']} | "
                     f"{entry['false_positives']} | {value(entry, 'median_rotation_error_deg', 3)} deg | "
                     f"{value(entry, 'median_translation_error_m', 1, 100)} cm | this run |")
    lines += [f"| {method} | - | {success:.2f} % | - | - | - | - | {source} |"
              for method, success, source in published_rows(key)]
    if not published_rows(key):
        lines.append("| published | - | - | - | - | - | - | no figure found |")
    return "\n".join(lines) + "\n"


def main(arguments):
    more = []
    if "--" in arguments:
        arguments, more = arguments[:arguments.index("--")], arguments[arguments.index("--") + 1:]
    options = parser().parse_args(arguments)
    if options.list:
        list_sets()
        return DONE
    if options.set is None or options.folder is None or options.out is None:
        parser().error("SET, FOLDER and --out are needed")
    try:
        choice = Choice(options.sequences, options.pair_list)
        note = convert(options.set, options.folder, options.out, choice, options.criterion)
        print(note)
        if options.convert_only:
            return DONE
        run(options.program or options.build_dir / "apps" / "ssfr_benchmark", options.out, options.methods, more)
        summary = json.loads((options.out / "run" / "summary.json").read_text(encoding="utf-8"))
        table = result_table(options.set, summary)
        (options.out / "table.md").write_text(f"{note}\n\n{table}", encoding="utf-8")
        print("\n" + table, end="")
    except Failure as failure:
        print(f"public_benchmark: {failure}", file=sys.stderr)
        return INPUT
    return DONE
