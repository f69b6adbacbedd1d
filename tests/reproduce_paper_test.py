# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""The tables of scripts/reproduce_paper on made-up rows of results.csv: reproduce_paper_test.py"""
import importlib.machinery
import importlib.util
import math
import pathlib
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parent.parent / "scripts" / "reproduce_paper"
sys.dont_write_bytecode = True
LOADER = importlib.machinery.SourceFileLoader("reproduce_paper", str(SCRIPT))
paper = importlib.util.module_from_spec(importlib.util.spec_from_loader("reproduce_paper", LOADER))
LOADER.exec_module(paper)


def pose(letter, degrees):
    """A turn about z as fields of a row."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    matrix = [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    return {f"{letter}{i}{j}": repr(matrix[i][j]) for i in range(4) for j in range(4)}


def row(method, pair=0, success="1", rmse="0.02", time="1.5", **more):
    """One row of results.csv."""
    fields = {"dataset": "made_up", "source": f"s{pair}.pcd", "target": "t.pcd", "method": method, "status": "converged",
              "converged": "1", "success": success, "rmse_m": rmse, "gt_rmse_m": "0.014", "time_s": "9", "cpu_s": time,
              "translation_error_m": "0.005", "pair": str(pair), "resolution_m": "0"}
    fields.update(more)
    return fields


def line(table, *starts):
    """The cells of the only line of a table that begins with these cells."""
    lines = [[cell.strip() for cell in text.strip("|").split("|")] for text in table.strip().split("\n")]
    found = [cells for cells in lines if cells[:len(starts)] == list(starts)]
    assert len(found) == 1, (starts, table)
    return found[0]


class Rows(unittest.TestCase):
    """Reading results.csv."""

    def read(self, text):
        """What read_rows makes of a file."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "results.csv"
            path.write_text(text, encoding="utf-8")
            return paper.read_rows(path)

    def test_last_row_of_a_pair_counts(self):
        rows = self.read("dataset,source,method,success,pair,resolution_m\n"
                         "d,a,ssfr,0,0,0\nd,a,ssfr,1,0,0\nd,a,ssfr,0,0,0.1\n")
        self.assertEqual([r["success"] for r in rows], ["1", "0"])

    def test_other_tables_are_refused(self):
        with self.assertRaisesRegex(paper.Failure, "method and success are missing"):
            self.read("a,b\n1,2\n")

    def test_numbers(self):
        self.assertIsNone(paper.number({"rmse_m": ""}, "rmse_m"))
        self.assertEqual(paper.number({"rmse_m": "0.5"}, "rmse_m"), 0.5)
        with self.assertRaisesRegex(paper.Failure, "rmse_m = 'x'"):
            paper.number({"rmse_m": "x"}, "rmse_m")


class Figures(unittest.TestCase):
    """Single figures against values worked out by hand."""

    def test_wilson(self):
        low, high = paper.wilson(5, 5)
        self.assertAlmostEqual(low, 56.55, places=2)
        self.assertAlmostEqual(high, 100)
        low, high = paper.wilson(5, 10)
        self.assertAlmostEqual(low, 23.66, places=2)
        self.assertAlmostEqual(high, 76.34, places=2)

    def test_axis_errors(self):
        errors = paper.axis_errors({**pose("T", 30), **pose("G", 30.25)})
        for value, expected in zip(errors, (0, 0, 0.25)):
            self.assertAlmostEqual(value, expected)
        self.assertEqual(paper.axis_errors({**pose("T", 30), **pose("G", 30)}), [0, 0, 0])
        self.assertIsNone(paper.axis_errors({**pose("G", 30), "T00": ""}))

    def test_group(self):
        group = paper.Group([row("ssfr", 0, rmse="0.02", time="1"), row("ssfr", 1, rmse="0.04", time="2"),
                             row("ssfr", 2, success="0", rmse="9", time="3"),
                             row("ssfr", 3, success="0", rmse="", time="", status="timeout")])
        self.assertEqual(group.success(), "2 of 4, 50 % (15-85), 1 out of time")
        self.assertEqual(group.rmse(), "3.00")  # of the solved pairs only
        self.assertEqual(group.time(), "2.00")  # of all that have one
        self.assertEqual(paper.Group([]).success(), "not run")
        self.assertEqual(paper.Group([]).rmse(), "-")


class Tables(unittest.TestCase):
    """Every table: the right rows in the right cells, beside the paper's numbers."""

    def test_basic_model(self):
        rows = [row("ndt", 0, rmse="0.01", time="0.5"), row("ndt", 1, success="0", rmse="0.7"),
                row("ndt", 2, success="0", rmse="", time="60", status="timeout")]
        cells = line(paper.basic_model_table(rows), "NDT")
        self.assertEqual(cells[1:], ["solved, 1.00 cm, 0.50 s", "wrong, 70.00 cm, 1.50 s", "timeout, - cm, 60.00 s",
                                     "solves the first"])
        self.assertEqual(line(paper.basic_model_table(rows), "Go-ICP")[1], "not run")

    def test_ds1h(self):
        text = paper.ds1h_table([row("fgr", 0, rmse="0.02"), row("fgr", 1, success="0"), row("ndt", 0, success="0")])
        self.assertEqual(line(text, "FGR")[1:], ["1 of 2, 50 % (9-91)", "100 %", "2.00", "2.3", "1.50", "3.9"])
        self.assertEqual(line(text, "NDT")[3], "-")
        self.assertEqual(line(text, "ground truth")[3:5], ["1.40", "1.4"])
        self.assertEqual(line(text, "Super4PCS")[1:3], ["not run", "-"])

    def test_resolution(self):
        text = paper.resolution_table([row("ssfr", 0, resolution_m="0.16", rmse="0.03"),
                                       row("ssfr", 0, resolution_m="0.08", success="0")])
        label = paper.LABELS["ssfr"]
        self.assertEqual(line(text, label, "16")[2:], ["1 of 1, 100 % (21-100)", "3.00", "1.40", "0.50", "1.50",
                                                     "100 %, 2.5 cm"])
        self.assertEqual(line(text, label, "8")[2], "0 of 1, 0 % (0-79)")
        self.assertEqual(line(text, label, "4")[2], "not run")

    def test_radius(self):
        rows = {radius: [] for radius in paper.RADII}
        rows[0.1] = [row("ssfr_paper2017", time="24")]
        rows[0.03] = [row("ssfr_paper2017", success="0", rmse="", status="no_candidate")]
        text = paper.radius_table(rows)
        self.assertEqual(line(text, "10")[1:], ["1 of 1, 100 % (21-100)", "2.00", "24.00", "1.8 cm, 24 s", "-"])
        self.assertEqual(line(text, "3")[1:], ["0 of 1, 0 % (0-79)", "-", "1.50", "1.8 cm", "no_candidate"])
        self.assertEqual(line(text, "0.1")[1:], ["not run", "-", "-", "0.7 s", "-"])

    def test_ds2l(self):
        text = paper.ds2l_table([row("ssfr", **pose("T", 10), **pose("G", 10.1))])
        self.assertEqual(line(text, paper.LABELS["ssfr"])[2:], ["2.00", "1.40", "0.50", "0.000, 0.000, 0.100", "1.50"])
        self.assertEqual(line(text, "SSFR in the paper")[2:], ["2.91", "2.66", "0.54", "0.026 each", "24"])

    def test_navigation(self):
        text = paper.navigation_table([row("ssfr", time="1")], [row("ssfr", success="0", time="3")])
        self.assertEqual(line(text, paper.LABELS["ssfr"])[1:],
                         ["1 of 1, 100 % (21-100)", "0 of 1, 0 % (0-79)", "1 of 2, 50 % (9-91)", "100 %", "1.00", "3.00"])


class Document(unittest.TestCase):
    """The whole file."""

    def facts(self, quick):
        """What heads the file."""
        return {"quick": quick, "every": 1, "baselines_every": 4, "slow_pairs": 3, "date": "2026-01-02", "machine": "made up",
                "commit": "abc", "jobs": 1, "cpu_timeout": 60, "slow": 50, "rule": "leaf 0", "bound": "2 deg and 0.3 m",
                "sets": {"ds1h": "45 scans"}}

    def test_says_what_it_is(self):
        rows = {name: [] for name in paper.plan(True)}
        quick = paper.document(rows, self.facts(True), "\nOur note.\n")
        self.assertIn("**A quick run:**", quick)
        self.assertIn("Our note.", quick)
        for text in ("2026-01-02, made up, version abc", "2 deg and 0.3 m", "## DS2-L", "## Basic model, three motions"):
            self.assertIn(text, quick)
        self.assertIn("killed after\n60 s of processor time", quick)
        full = paper.document(rows, self.facts(False), "")
        self.assertNotIn("quick run", full)
        self.assertIn("SSFR ran on every pair of a set, ICP, NDT, FGR and the sweep over the radius on every 4th pair",
                      " ".join(full.split()))

    def test_notes_are_kept(self):
        rows = {name: [] for name in paper.plan(False)}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "PAPER.md"
            self.assertEqual(paper.kept_notes(path), "\nNot looked into yet.\n")
            path.write_text(paper.document(rows, self.facts(False), "\nBecause.\n"), encoding="utf-8")
            self.assertEqual(paper.kept_notes(path), "\nBecause.\n")


class Plan(unittest.TestCase):
    """Which methods run on which pairs."""

    def every(self, run):
        """What --every of a run is, 1 without."""
        options = run["options"]
        return options[options.index("--every") + 1] if "--every" in options else 1

    def test_ours_and_others_have_their_own_share_of_the_pairs(self):
        all_pairs, some = paper.plan(False), paper.plan(False, 2, 4, 5)
        self.assertEqual(list(all_pairs), list(some))
        for name, run in some.items():
            self.assertEqual(self.every(all_pairs[name]), 1)
            slow, basic = name.endswith("_slow"), name.startswith("basic_model")
            others = name.endswith("_baselines") or name.startswith("radius")
            self.assertEqual(self.every(run), 1 if slow or basic else 4 if others else 2, name)
            pairs = None if basic or not slow else [0] if name.startswith("ds2l") else [0, 1, 2, 3, 4]
            self.assertEqual(run["pairs"], pairs, name)
        for data in ("ds1h", "ds2l", "ds3v", "ds4s"):
            methods = [m for name in (data, f"{data}_baselines", f"{data}_slow") for m in some[name]["methods"]]
            self.assertEqual(sorted(methods), sorted(paper.LABELS))


class CommandLine(unittest.TestCase):
    """Options."""

    def test_options(self):
        options = paper.parse(["--quick", "--out", "x", "--jobs", "2"])
        self.assertEqual((options["quick"], options["out"], options["jobs"]), (True, "x", 2))
        self.assertEqual(paper.parse(["--every", "3"])["baselines-every"], 3)
        self.assertEqual(paper.parse(["--every", "3", "--baselines-every", "6"])["baselines-every"], 6)
        for wrong, message in ((["--fast"], "unknown option '--fast'"), (["--out"], "--out needs a value"),
                               (["--jobs", "0"], "--jobs = '0'"), (["--slow-pairs", "x"], "--slow-pairs = 'x'"),
                               (["--baselines-every", "0"], "--baselines-every = '0'"), (["x"], "unknown option 'x'")):
            with self.assertRaisesRegex(ValueError, message):
                paper.parse(wrong)


if __name__ == "__main__":
    unittest.main()
