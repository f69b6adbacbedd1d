#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Opens a report of ssfr_map in headless Chromium: drawings, clicks on links and setups, tables, paper.

Usage: map_report_browser_test.py SSFR_MAP DATA [--screenshots DIR]    DATA: the folder data/ of the project
Needs Debian's chromium and chromium-driver; exit code 77 (skipped) where one is missing.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import report_browser_test as base

CLICK = """
const nodes = [...document.querySelectorAll(arguments[0])];
nodes[arguments[1]].dispatchEvent(new MouseEvent('click', {bubbles: true}));
return nodes.length;
"""
COUNT = "return document.querySelectorAll(arguments[0]).length"
TEXT = "return document.querySelector(arguments[0]).textContent"
ROWS = "return [...document.querySelectorAll(arguments[0] + ' tbody tr')].map((r) => [...r.cells].map((c) => c.textContent))"
# Width and height of the drawn points [m], those beyond 2 % on each side left out.
EXTENT = """
return ['plan', 'side'].map((id) => {
  const xs = [], ys = [];
  for (const path of document.querySelectorAll('#' + id + ' path'))
    for (const m of path.getAttribute('d').matchAll(/M(\\S+) (\\S+)h0/g)) { xs.push(+m[1]); ys.push(+m[2]); }
  const extent = (v) => { v.sort((a, b) => a - b); const n = Math.floor(v.length / 50); return v[v.length - 1 - n] - v[n]; };
  return [extent(xs), extent(ys)];
});
"""


class MapReport(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = base.Browser(base.FOLDER / "profile")

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()

    def setUp(self):
        self.browser.size(*base.WIDE)
        self.browser.messages()
        self.open("map")

    def tearDown(self):
        self.assertEqual(self.browser.messages(), [])

    def open(self, name):
        self.browser.open(name)
        self.assertEqual(self.run_script("return performance.getEntriesByType('resource').map((e) => e.name)"), [])

    def run_script(self, *arguments):
        return self.browser.run(*arguments)

    def rows(self, table):
        return self.run_script(ROWS, "#" + table)

    def test_drawsThePlanUpright(self):
        for view in ("plan", "side"):
            self.assertEqual(self.run_script(COUNT, f"#{view} circle.setup"), 8)
            self.assertEqual(self.run_script(COUNT, f"#{view} path"), 8)
            self.assertGreater(self.run_script(COUNT, f"#{view} .link"), 7)
            self.assertGreater(self.run_script(COUNT, f"#{view} text"), 2)
        # A flat of some 10 m by 8 m and 2.5 to 2.9 m high, whose scans are rotated at random.
        (length, width), (_, height) = self.run_script(EXTENT)
        self.assertGreater(min(length, width), 6)
        self.assertTrue(2.2 < height < 3.1, height)
        self.browser.screenshot("map")

    def test_aLinkShowsItsFiguresAndBothScans(self):
        self.run_script(CLICK, "#plan .hit", 3)
        for view in ("plan", "side"):
            self.assertEqual(self.run_script(COUNT, f"#{view} path"), 2)
            self.assertEqual(self.run_script(COUNT, f"#{view} circle.setup"), 2)
        text = self.run_script(TEXT, "#chosen")
        for what in ("overlap", "RMS", "residual", "below 6 mm", "balance", "confidence"):
            self.assertIn(what, text)
        self.browser.screenshot("map_link", whole=False)
        self.run_script(CLICK, "#plan", 0)  # the background
        self.assertEqual(self.run_script(COUNT, "#plan path"), 8)
        self.assertIn("Click a setup", self.run_script(TEXT, "#chosen"))

    def test_aSetupShowsItsLinks(self):
        self.run_script(CLICK, "#side circle.setup", 2)
        text = self.run_script(TEXT, "#chosen")
        self.assertRegex(text, r"scan_2\.pcd: \d+ links, σ \d+\.\d mm, \d+\.\d+ deg; linked to scan_")
        linked = text.split("linked to ")[1].split(".pcd.")[0].count("scan_")
        self.assertEqual(self.run_script(COUNT, "#plan circle.setup"), linked + 1)

    def test_rowsChooseToo(self):
        self.run_script(CLICK, "#links tbody tr", 0)
        source, target = self.rows("links")[0][:2]
        self.assertIn(f"{source} – {target}", self.run_script(TEXT, "#chosen"))
        self.run_script(CLICK, "#setups tbody tr", 4)
        self.assertIn(self.rows("setups")[4][0] + ": ", self.run_script(TEXT, "#chosen"))

    def test_tablesSort(self):
        residuals = [float(row[10]) for row in self.rows("links")]
        self.assertEqual(residuals, sorted(residuals, reverse=True))  # the largest first
        for _ in range(2):
            self.run_script(CLICK, "#links th", 4)  # overlap
        overlaps = [float(row[4]) for row in self.rows("links")]
        self.assertEqual(overlaps, sorted(overlaps, reverse=True))
        self.assertGreater(len(set(overlaps)), 3)
        loops = [float(row[1]) for row in self.rows("loops")]
        self.assertGreater(len(loops), 5)
        self.assertEqual(loops, sorted(loops, reverse=True))

    def test_whatStandsApartHasItsReasonAndWhatHelps(self):
        rows = {row[0]: row for row in self.rows("unplaced")}
        self.assertEqual(set(rows), {"broken.pcd", "street.pcd"})
        self.assertIn("broken.pcd", rows["broken.pcd"][2])
        self.assertIn("another copy", rows["broken.pcd"][3])
        self.assertGreater(len(rows["street.pcd"][2]), 10)
        self.assertIn("a scan ", rows["street.pcd"][3])
        # A component of one scan is drawn as well.
        self.run_script("const s = document.getElementById('component'); s.value = 1; s.dispatchEvent(new Event('change'));")
        self.assertEqual(self.run_script(COUNT, "#plan circle.setup"), 1)

    def test_scansThatAreWrongAreCounted(self):
        self.assertIn("1 of 8placed scans wrong by the truth", self.run_script(TEXT, "#figures"))
        self.assertRegex(self.run_script(TEXT, "#figures"), r"[0-9.]+ mmmedian error of the others")

    def test_whereNothingIsPlacedEveryScanHasItsReason(self):
        self.open("apart")
        self.assertEqual({row[0] for row in self.rows("unplaced")}, {"scan_0.pcd", "street.pcd"})

    def test_scansOfASmallerComponentSayWhyAndWhatWouldJoinThem(self):
        self.open("two_places")
        rows = {row[0]: row for row in self.rows("unplaced")}
        self.assertEqual(set(rows), {"hall_0.pcd", "hall_1.pcd"})
        for row in rows.values():
            self.assertEqual(row[2:], ["no scan of another component shares enough with it",
                                       "a scan that shows this place and a part of the others"])
        self.open("cut")
        rows = self.rows("unplaced")
        self.assertEqual(len(rows), 2)
        for row in rows:
            self.assertRegex(row[2], r"^the best link to another component, to scan_\d\.pcd \(\d\.\d\d\): rejected by a ")
            self.assertRegex(row[3], r"^a scan between it and scan_\d\.pcd ")

    def test_printsAndFitsAPhone(self):
        pdf = self.browser.pdf("map")
        self.assertTrue(pdf.startswith(b"%PDF"))
        self.assertGreater(len(pdf), 20000)
        self.browser.size(*base.PHONE, mobile=True)
        self.open("map")
        width = self.run_script("return Math.max(document.documentElement.scrollWidth, document.body.scrollWidth)")
        self.assertLessEqual(width, base.PHONE[0])
        self.browser.screenshot("map_phone")


def main():
    if len(sys.argv) not in (3, 5) or (len(sys.argv) == 5 and sys.argv[3] != "--screenshots"):
        sys.exit(__doc__)
    for program in ("chromium", "chromedriver"):
        if not shutil.which(program):
            print(f"skipped: {program} was not found (Debian: chromium, chromium-driver)")
            sys.exit(base.SKIPPED)
    if len(sys.argv) == 5:
        base.SCREENSHOTS = pathlib.Path(sys.argv[4]).resolve()
        base.SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        base.FOLDER = pathlib.Path(folder)
        scans = base.FOLDER / "scans"
        shutil.copytree(pathlib.Path(sys.argv[2]) / "building", scans)
        shutil.copy(pathlib.Path(sys.argv[2]) / "street_0.pcd", scans / "street.pcd")
        (scans / "broken.pcd").write_text("no cloud\n")
        truth = base.FOLDER / "truth.txt"
        lines = (scans / "poses.txt").read_text().splitlines()
        scan, x, *others = lines[-1].split()
        truth.write_text("\n".join(lines[:-1] + [" ".join([scan, str(float(x) + 1), *others])]))
        rejected = [word for a in (0, 3) for b in (4, 7) for word in ("--reject", f"scan_{a}.pcd,scan_{b}.pcd")]
        halls = [pathlib.Path(sys.argv[2]) / f"hall_{i}.pcd" for i in range(2)]
        for name, inputs in (("map", [scans, "--truth", truth]), ("apart", [scans / "scan_0.pcd", scans / "street.pcd"]),
                             ("two_places", [*(scans / f"scan_{i}.pcd" for i in range(3)), *halls]),
                             ("cut", [*(scans / f"scan_{i}.pcd" for i in (0, 3, 4, 7)), *rejected])):
            made = subprocess.run([sys.argv[1], *inputs, "--out", base.FOLDER / name], capture_output=True, check=False)
            if made.returncode != 1:  # several components
                sys.exit(made.stderr.decode())
        result = unittest.main(argv=[sys.argv[0]], exit=False, verbosity=2).result
    sys.exit(0 if result.wasSuccessful() else 1)


if __name__ == "__main__":
    main()
