# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""All scans of a folder in one frame: poses as a table, and one thinned cloud of the largest component.

Usage: python3 map_folder.py FOLDER OUT     writes OUT/poses.csv and OUT/map.npy, keeps its work in OUT/map.sqlite
"""

import csv
import pathlib
import sys

import numpy as np

import pcl_ssfr

LEAF = 0.1  # of the cloud [m]
TABLES = {"pairs.csv", "poses.csv", "poses.txt"}  # go with scans and are none


def scans_of(folder):
    """The files of scans, by name; of an E57 file each of its scans."""
    paths = []
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() == ".e57":
            paths += pcl_ssfr.list_e57_scans(path)
        elif path.suffix.lower() in pcl_ssfr.READABLE_FORMATS and path.name not in TABLES:
            paths.append(str(path))
    return paths


def thinned(points):
    """One point for each cube of edge LEAF that holds any."""
    points = points[np.isfinite(points).all(axis=1)]
    _, first = np.unique(np.floor(points / LEAF).astype(np.int64), axis=0, return_index=True)
    return points[np.sort(first)]


def main(folder, out):
    out.mkdir(parents=True, exist_ok=True)
    paths = scans_of(folder)
    project = out / "map.sqlite"

    def progress(stage, done, total):
        print(f"\r{stage} {done} of {total}   ", end="", file=sys.stderr)

    found = pcl_ssfr.map_scans(paths, project=project, resume=project.exists(), progress=progress)
    print(file=sys.stderr)
    clouds = []
    with open(out / "poses.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["scan", "component", *(f"T{r}{c}" for r in range(4) for c in range(4)), "reason"])
        for path, scan in zip(paths, found.scans):
            table.writerow([scan.name, scan.component, *map(repr, scan.T_map_scan.ravel().tolist()), scan.reason])
            if scan.component == 0 and scan.usable:
                T = scan.T_map_scan
                clouds.append(thinned(pcl_ssfr.read_scan(path)[0] @ T[:3, :3].T + T[:3, 3]))
    np.save(out / "map.npy", thinned(np.vstack(clouds)))
    print(f"{found.placed} of {len(paths)} scans placed, {found.components} components, "
          f"surfaces {1000 * found.bundle_error:.1f} mm apart")
    return 0 if found.components == 1 else 1


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])))
