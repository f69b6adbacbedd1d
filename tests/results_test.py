# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""scripts/results: its tables from made-up output of the programs, and their places in docs/RESULTS.md."""
import importlib.machinery
import importlib.util
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parent.parent / "scripts" / "results"
sys.dont_write_bytecode = True
LOADER = importlib.machinery.SourceFileLoader("results", str(SCRIPT))
results = importlib.util.module_from_spec(importlib.util.spec_from_loader("results", LOADER))
LOADER.exec_module(results)



def entry(dataset, pairs, solved, accepted, wrong, **more):
    """What summary.json says of a method on a dataset."""
    return {"method": "ssfr", "dataset": dataset, "pairs": pairs, "solved": solved, "accepted": accepted,
            "false_positives": wrong, "median_rotation_error_deg": 0.1, "median_translation_error_m": 0.01,
            "median_time_s": 0.2, "log_loss": 0.25, "calibration_error": 0.025,
            "lost_at": {}, **more}


SUMMARY = {"methods": [entry("room", 3, 2, 2, 1), entry("hall", 1, 0, 0, 0, median_rotation_error_deg=None,
                                                        median_translation_error_m=None),
                       entry(None, 4, 2, 2, 1, lost_at={"rotation": 1, "evidence": 3})]}
SINGLE = {"methods": [entry("room", 3, 2, 2, 1)]}


class Document(unittest.TestCase):
    """Tables in the document."""

    TEXT = ("# Results\n\n<!-- results: speed -->\nold\n<!-- end of results: speed -->\n\nwords\n\n"
            "<!-- results: growth -->\n<!-- end of results: growth -->\nend\n")

    def test_only_the_named_table_is_replaced(self):
        new = results.replace_table(self.TEXT, "speed", "| a |\n|---|\n| 1 |\n\n")
        self.assertEqual(new, self.TEXT.replace("old\n", "| a |\n|---|\n| 1 |\n"))
        self.assertEqual(results.replace_table(new, "speed", "old"), self.TEXT)

    def test_a_table_without_a_place_is_an_error(self):
        for name in ("success", "spee"):
            with self.assertRaisesRegex(results.Failure, "no place"):
                results.replace_table(self.TEXT, name, "x")
        begin, end = results.marks("speed")
        for text in (self.TEXT.replace(end, ""), self.TEXT + begin, end + "\n" + begin):
            with self.assertRaisesRegex(results.Failure, "no place"):
                results.replace_table(text, "speed", "x")

    def test_the_document_has_a_place_for_every_table(self):
        document = results.DOCUMENT.read_text(encoding="utf-8")
        self.assertEqual(sorted(results.tables_of(document)), sorted(results.NAMES))
        for name in results.NAMES:
            self.assertIn("x", results.replace_table(document, name, "x"))

    def test_every_table_has_a_measure(self):
        self.assertEqual(sorted(results.MEASURES), sorted(results.NAMES))


class Tables(unittest.TestCase):
    """Tables from the programs' output."""

    def test_padding_and_words_around_a_table_are_dropped(self):
        lines = results.table_lines("words\n| set  |  s |\n|------|----|\n| room |  3 |\nmore\n")
        self.assertEqual(lines, ["| set | s |", "|---|---|", "| room | 3 |"])

    def test_no_table_is_an_error(self):
        with self.assertRaisesRegex(results.Failure, "no table"):
            results.table_lines("nothing\n| but | this |\n")

    def test_entries_of_all_are_those_of_one_where_there_is_one(self):
        single, total = results.entries(SUMMARY)
        self.assertEqual([e["dataset"] for e in single], ["room", "hall"])
        self.assertIsNone(total["dataset"])
        self.assertEqual(results.entries(SINGLE)[1]["dataset"], "room")
        for methods in ([], SUMMARY["methods"][:2], SUMMARY["methods"] * 2):
            with self.assertRaisesRegex(results.Failure, "ssfr"):
                results.entries({"methods": methods})
        with self.assertRaisesRegex(results.Failure, "icp"):
            results.entries(SUMMARY, "icp")

    def test_marks(self):
        _, total = results.entries(SUMMARY)
        lines = results.marks_table([("rotated", total), ("ICP", {**total, "log_loss": None, "calibration_error": None})])
        self.assertEqual(lines[2], "| rotated | 4 | 2 (50.0 %) | 2 | 1 | 2.5 % | 0.250 | 3 evidence, 1 rotation |")
        self.assertEqual(lines[3], "| ICP | 4 | 2 (50.0 %) | 2 | 1 | - | - | 3 evidence, 1 rotation |")
        self.assertEqual(len({line.count("|") for line in lines}), 1)

    def test_sets(self):
        lines = results.sets_table(SUMMARY)
        self.assertEqual(lines[2], "| room | 3 | 2 (66.7 %) | 2 | 1 | 0.100 | 1.0 | 0.200 | - |")
        self.assertEqual(lines[3], "| hall | 1 | 0 (0.0 %) | 0 | 0 | - | - | 0.200 | - |")
        self.assertEqual(lines[4], "| all | 4 | 2 (50.0 %) | 2 | 1 | 0.100 | 1.0 | 0.200 | 3 evidence, 1 rotation |")

    def test_pairs(self):
        lines = results.pairs_table([("listed", SUMMARY), ("unlisted", {"methods": [entry("room", 6, 5, 4, 0)]})])
        self.assertEqual(lines[0], "| set | listed | lost at | unlisted | lost at |")
        self.assertEqual(lines[2], "| room | 2 / 2 / 1 of 3 | - | 5 / 4 / 0 of 6 | - |")
        self.assertEqual(lines[3], "| hall | 0 / 0 / 0 of 1 | - | - | - |")
        self.assertEqual(lines[4], "| all | 2 / 2 / 1 of 4 | 3 evidence, 1 rotation | 5 / 4 / 0 of 6 | - |")
        self.assertEqual(len({line.count("|") for line in lines}), 1)

    def test_success(self):
        def of(method, *entries):
            return {"methods": [{**e, "method": method} for e in entries]}
        every = of("icp_point_to_plane", entry("room", 1, 0, 1, 1))  # every 6th pair: none of the hall
        runs = {(method, rotated): of(method, *SUMMARY["methods"]) for _, method in results.COMPARED
                for rotated in (True, False)}
        runs["icp_point_to_plane", True] = every
        runs["ssfr", False] = of("ssfr", entry("room", 3, 3, 3, 0), entry("hall", 1, 1, 1, 0), entry(None, 4, 4, 4, 0))
        lines = results.success_table(runs)
        self.assertEqual(lines[2], "| room | 2 / 3 | 3 / 3 | 2 / 3 | 2 / 3 | 0 / 1 | 2 / 3 | 0.100 deg, 1.0 cm | 1 |")
        self.assertEqual(lines[3], "| hall | 0 / 1 | 1 / 1 | 0 / 1 | 0 / 1 | - | 0 / 1 | -, - | 0 |")
        self.assertEqual(lines[4], "| all | 2 / 4 | 4 / 4 | 2 / 4 | 2 / 4 | 0 / 1 | 2 / 4 | 0.100 deg, 1.0 cm | 1 |")
        self.assertEqual(len({line.count("|") for line in lines}), 1)

    def test_targets_that_two_scans_lie_in(self):
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "pairs.csv"
            table.write_text("source,target,T00\na,b,1\nb,c,1\na,b,1\n", encoding="utf-8")
            self.assertFalse(results.has_shared_targets(folder))
            table.write_text("source,target,T00\na,b,1\nc,b,1\n", encoding="utf-8")
            self.assertTrue(results.has_shared_targets(folder))

    def test_stages(self):
        report = {"benchmarks": [
            {"name": "thinning/30000/real_time", "time_unit": "ms", "cpu_time": 2.1234, "over_pcl": 1.2},
            {"name": "thinning/300000/real_time", "time_unit": "ms", "cpu_time": 30.0, "over_pcl": 1.3},
            {"name": "polish/30000/real_time", "time_unit": "ms", "cpu_time": 7.0}]}
        lines = results.stage_rows(report)
        self.assertEqual(lines[0], "| stage | 30000 points, ms | 300000 points, ms | over PCL's, 30000 | over PCL's, 300000 |")
        self.assertEqual(lines[2], "| thinning | 2.12 | 30 | 1.2 | 1.3 |")
        self.assertEqual(lines[3], "| polish | 7 | - | - | - |")
        report["benchmarks"][0]["time_unit"] = "us"
        with self.assertRaisesRegex(results.Failure, "milliseconds"):
            results.stage_rows(report)


class CommandLine(unittest.TestCase):
    """Errors in use."""

    def run_script(self, *arguments):
        """The finished process."""
        return subprocess.run([sys.executable, str(SCRIPT), *arguments], capture_output=True, text=True, check=False)

    def test_wrong_use_is_named(self):
        for arguments, message in ((["--fast"], "unknown option '--fast'"), (["--only"], "needs a value"),
                                   (["--only", "speed,sped"], "'sped'"), (["--every", "0"], "--every: '0'"),
                                   (["--jobs", "x"], "--jobs: 'x'"), (["/no/such/folder"], "no pairs.csv")):
            done = self.run_script(*arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(message, done.stderr)
            self.assertEqual(done.stdout, "")

    def test_help(self):
        done = self.run_script("--help")
        self.assertEqual(done.returncode, 0)
        self.assertIn("Usage: scripts/results", done.stdout)

    def test_a_build_without_the_programs_is_an_error(self):
        done = self.run_script("--only", "speed", "--build-dir", str(SCRIPT.parent))
        self.assertEqual(done.returncode, 3)
        self.assertIn("no program ssfr_benchmark", done.stderr)


if __name__ == "__main__":
    unittest.main()
