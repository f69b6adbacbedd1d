# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""scripts/map_table: poses as sets give them, scans in rotated frames that still agree with the truth, rows."""
import array
import importlib.machinery
import importlib.util
import pathlib
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parent.parent / "scripts" / "map_table"
sys.dont_write_bytecode = True
LOADER = importlib.machinery.SourceFileLoader("map_table", str(SCRIPT))
map_table = importlib.util.module_from_spec(importlib.util.spec_from_loader("map_table", LOADER))
LOADER.exec_module(map_table)

POINTS = [[1.0, 2.0, 3.0, 0.5], [-4.0, 0.25, 8.0, 7.0]]


def apply(rotation, t, p):
    return [sum(rotation[r][k] * p[k] for k in range(3)) + t[r] for r in range(3)]


def write_scan(path, data="binary", viewpoint="0 0 0 1 0 0 0"):
    header = (f"VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {len(POINTS)}\n"
              f"HEIGHT 1\nVIEWPOINT {viewpoint}\nPOINTS {len(POINTS)}\nDATA {data}\n")
    path.write_bytes(header.encode() + array.array("f", [v for p in POINTS for v in p]).tobytes())


class MapTable(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.set = pathlib.Path(folder.name) / "set"
        self.place = pathlib.Path(folder.name) / "job"
        self.set.mkdir()
        self.place.mkdir()

    def test_poses_in_all_formats(self):
        (self.set / "poses.txt").write_text("# scan ...\na.pcd 0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1\n"
                                            "b.pcd 5 6 7 0 0 0.70710678118654752 0.70710678118654752\n")
        truth = map_table.read_truth(self.set)
        for name in ("a.pcd", "b.pcd"):
            rotation, t = truth[name]
            for got, wanted in zip(apply(rotation, t, [1, 0, 0]), [5, 7, 7]):
                self.assertAlmostEqual(got, wanted)
        (self.set / "poses.txt").unlink()
        names = [f"T{r}{c}" for r in range(4) for c in range(4)]
        (self.set / "poses.csv").write_text("file," + ",".join(names) + "\na.pcd,0,-1,0,5,1,0,0,6,0,0,1,7,0,0,0,1\n")
        self.assertEqual(map_table.read_truth(self.set)["a.pcd"], ([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [5, 6, 7]))
        (self.set / "poses.csv").unlink()
        (self.set / "poses.txt").write_text("a.pcd 1 2 3\n")
        with self.assertRaisesRegex(map_table.Failure, "a.pcd has 3 numbers"):
            map_table.read_truth(self.set)

    def test_a_rotated_scan_lies_where_it_lay(self):
        write_scan(self.set / "a.pcd")
        (self.set / "poses.txt").write_text("a.pcd 0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1\n")
        line = map_table.stage_set(self.set, self.place, True, "set__", 100.0)[0].split()
        self.assertEqual(line[0], "set__a.pcd")
        m = [float(v) for v in line[1:]]
        data = (self.place / "set__a.pcd").read_bytes()
        values = array.array("f")
        values.frombytes(data[data.index(b"DATA binary\n") + len(b"DATA binary\n"):])
        self.assertGreater(abs(values[0] - POINTS[0][0]), 0.01)  # it is rotated indeed
        for k, point in enumerate(POINTS):
            self.assertEqual(values[4 * k + 3], point[3])
            moved = apply([m[0:3], m[4:7], m[8:11]], [m[3], m[7], m[11]], values[4 * k:4 * k + 3])
            wanted = [-point[1] + 5 + 100, point[0] + 6, point[2] + 7]
            for got, want in zip(moved, wanted):
                self.assertAlmostEqual(got, want, places=5)

    def test_what_cannot_be_rotated_is_named(self):
        for options in ({"data": "ascii"}, {"viewpoint": "1 0 0 1 0 0 0"}):
            write_scan(self.set / "a.pcd", **options)
            with self.assertRaisesRegex(map_table.Failure, "a.pcd"):
                map_table.rotate_pcd(self.set / "a.pcd", self.place / "a.pcd", map_table.random_rotation("a"))
        with self.assertRaisesRegex(map_table.Failure, "neither a set"):
            map_table.find_sets([str(self.place)])
        with self.assertRaisesRegex(map_table.Failure, "--rotat"):
            map_table.main(["--rotat", str(self.set)])

    def test_rows_and_remarks(self):
        truth = {"wrong": 1, "wrong_5deg_2m": 0, "pairs_median_m": 0.01, "chain_median_m": 0.02,
                 "pose_graph_median_m": None, "median_translation_m": 0.0012, "largest_translation_m": 0.5,
                 "normalised_error_squared": 1.234,
                 "scans": [{"scan": "b", "wrong": True, "rotation_deg": 1.0, "translation_m": 0.5}]}
        result = {"scans": 3, "placed": 2, "component_sizes": [2, 1], "links": {"used": 1, "none": 2}, "truth": truth,
                  "time_s": 1.5, "memory": {"peak_rss_mib": 20.4}, "notes": ["note"]}
        self.assertEqual(map_table.row_of("set", result),
                         "| set | 3 | 2 | 1 / 0 | 10.0 | 20.0 | - | 1.2 | 500.0 | 1.2 | 3 | 1.5 | 20 |")
        poses = [{"scan": "a", "links": "1", "component": "0", "reason": ""},
                 {"scan": "b", "links": "1", "component": "0", "reason": ""},
                 {"scan": "c", "links": "0", "component": "1", "reason": "alone"}]
        self.assertEqual(list(map_table.remarks_of("set", result, poses)),
                         ["- set: note", "- set, b: WRONG by 1.0 degrees, 0.50 m (1 links, component 0)",
                          "- set, c: alone"])


if __name__ == "__main__":
    unittest.main()
