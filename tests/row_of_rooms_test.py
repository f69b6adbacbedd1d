# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""scripts/row_of_rooms: pieces of one building lie in one frame; with the path of ssfr_simulate also its scans."""
import importlib.machinery
import importlib.util
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parent.parent / "scripts" / "row_of_rooms"
sys.dont_write_bytecode = True
LOADER = importlib.machinery.SourceFileLoader("row_of_rooms", str(SCRIPT))
row_of_rooms = importlib.util.module_from_spec(importlib.util.spec_from_loader("row_of_rooms", LOADER))
LOADER.exec_module(row_of_rooms)


class RowOfRooms(unittest.TestCase):
    def test_pieces_share_their_rooms(self):
        first, second = set(row_of_rooms.corners_of(0, 16, 1)), set(row_of_rooms.corners_of(10, 16, 1))
        self.assertGreater(len(first & second), 0.2 * len(first))
        begin = min(x for x, _, _ in second)
        # All of the first piece behind there but the wall at its end.
        end = max(x for x, _, _ in first) - 2 * row_of_rooms.WALL
        self.assertEqual({v for v in first if begin + 1 < v[0] < end}, {v for v in second if begin + 1 < v[0] < end})

    def test_another_seed_is_another_building(self):
        self.assertEqual(row_of_rooms.corners_of(0, 3, 5), row_of_rooms.corners_of(0, 3, 5))
        self.assertNotEqual(row_of_rooms.corners_of(0, 3, 5), row_of_rooms.corners_of(0, 3, 6))

    @unittest.skipUnless(sys.argv[-1].endswith("ssfr_simulate"), "without ssfr_simulate")
    def test_a_set_has_its_scans_and_poses(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "set"
            build = pathlib.Path(PROGRAM).parent.parent
            command = [sys.executable, SCRIPT, "--points", "500", "--build-dir", build, "2", out]
            subprocess.run(command, check=True)
            names = sorted(path.name for path in (out / "scans").iterdir())
            poses = [line.split() for line in (out / "poses.txt").read_text().splitlines()]
            self.assertEqual(len(names), 100)
            self.assertEqual([pose[0] for pose in poses], names)
            # The pieces follow each other along x, and overlap.
            places = [float(pose[1]) for pose in poses]
            self.assertLess(places[50], places[49])
            self.assertGreater(places[50], places[35])
            again = subprocess.run(command, capture_output=True, text=True)
            self.assertNotEqual(again.returncode, 0)
            self.assertIn(str(out), again.stderr)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop() if len(sys.argv) > 1 else ""  # it may be empty
    unittest.main()
