# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""scripts/fit_posterior: the numbers that made-up data was drawn with. Exits with 77 without numpy or scipy."""
import contextlib
import csv
import importlib.machinery
import importlib.util
import io
import pathlib
import sys
import tempfile
import unittest

try:
    import numpy
    import scipy  # pylint: disable=unused-import
except ImportError:
    print("skipped: numpy or scipy is missing")
    sys.exit(77)

SCRIPT = pathlib.Path(__file__).resolve().parent.parent / "scripts" / "fit_posterior"
sys.dont_write_bytecode = True
LOADER = importlib.machinery.SourceFileLoader("fit_posterior", str(SCRIPT))
fit_posterior = importlib.util.module_from_spec(importlib.util.spec_from_loader("fit_posterior", LOADER))
LOADER.exec_module(fit_posterior)

SEEING = numpy.array([-3.0, 1.0, 1.2, 0.8, 1.5, 1.0, 1.6, 1.0])
BLIND = numpy.array([0.5, 0.8, 1.0, 0.7, 1.0, 2.0, 0.0, 0.0])


def model(candidates, numbers):
    """Probabilities of candidates and of none of them: the formulas of docs/METHOD.md, written once more."""
    known, any_matches, any_third, matches, second, third, clutter, contradictions = numbers
    weights = numpy.array([
        (1 + c["beyond_planes"] * c["facing_patches"]) ** matches * (1 + c["held_second"]) ** second *
        (1 + c["held_third"]) ** third * (1 + c["clutter"]) ** clutter /
        (1 + (c["patches_contradicted"] / 0.003) ** 2) ** (contradictions / 2) for c in candidates])
    leader = candidates[weights.argmax()]
    matched, left, beyond = (leader[name] * leader["facing_patches"]
                             for name in ("facing_matched", "facing_score", "beyond_planes"))
    odds = (known + any_matches * numpy.log(beyond + 1) + any_third * numpy.log(leader["third_direction"] + 0.001) +
            numpy.log(1 + leader["clutter"]) - numpy.log(1 + (matched - left) / 14))
    poses = weights / weights.sum() / (1 + numpy.exp(-odds))
    return poses, 1 - poses.sum()


def draw_pair(random, numbers, blind):
    """Candidates of a pair whose truth is drawn by the model."""
    patches, facing = 10 ** random.uniform(1, 3), random.uniform(0.5, 1)
    scores = numpy.sort(10 ** random.uniform(-2, -0.3, random.integers(1, 6)))[::-1]
    candidates = []
    for rank, score in enumerate(scores, 1):
        matched = random.uniform(0.01, 0.4)
        candidates.append({"rank": rank, "score": score, "patches_matched": random.uniform(0.01, 0.6),
                           "patches_contradicted": 0 if blind else 10 ** random.uniform(-4, -1),
                           "held_second": 10 ** random.uniform(-1, 2), "held_third": 10 ** random.uniform(-2, 1.5),
                           "clutter": 0 if blind else random.integers(0, 200), "facing_matched": matched,
                           "beyond_planes": matched * random.uniform(0, 1),
                           "facing_score": matched * (1 if blind else random.uniform(0.1, 1)),
                           "third_direction": 10 ** random.uniform(-3, -0.6), "patches": patches,
                           "facing_patches": facing * patches, "viewpoints_used": 0 if blind else 1})
    poses, none = model(candidates, numbers)
    truth = random.choice(len(poses) + 1, p=[*poses, none])
    for k, candidate in enumerate(candidates):
        candidate.update({"right": int(k == truth), "probability": poses[k], "probability_of_none": none})
    return candidates


def write_folder(folder, pairs):
    """results.csv and candidates.csv of (dataset, target's dataset, candidates); a row of another method in between."""
    results, rows = [], []
    for dataset, target, candidates in pairs:
        results.append({"dataset": dataset, "target_dataset": target, "method": "ssfr",
                        "confidence": candidates[0]["probability"] if candidates else ""})
        rows += [{"row": len(results), "method": "ssfr", **c} for c in candidates]
        results.append({"dataset": dataset, "target_dataset": target, "method": "other", "confidence": 0.5})
        rows += [{"row": len(results), "method": "other", **c, "right": 1 - c["right"]} for c in candidates]
    for name, lines in (("results.csv", results), ("candidates.csv", rows)):
        with open(pathlib.Path(folder) / name, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, lines[0])
            writer.writeheader()
            writer.writerows(lines)


class FitPosterior(unittest.TestCase):
    """Folders of made-up results."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.random = numpy.random.default_rng(7)

    def drawn(self, count, numbers=SEEING, blind=False, datasets=("a", "b", "c")):
        return [(datasets[k % len(datasets)], "", draw_pair(self.random, numbers, blind)) for k in range(count)]

    def read(self, pairs):
        write_folder(self.folder, pairs)
        return fit_posterior.read_folder(self.folder)

    def run_main(self, *arguments):
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            code = fit_posterior.main(list(arguments))
        return code, output.getvalue(), errors.getvalue()

    def test_numbers_are_found_again(self):
        for numbers, blind in ((SEEING, False), (BLIND, True)):
            pairs = self.read(self.drawn(6000, numbers, blind))
            found = fit_posterior.fit(pairs)
            # Four standard deviations of such a fit, as drawn with other seeds.
            error = numpy.abs(found - numbers)
            bounds = [0.7, 0.15, 0.15, 0.2, 0.2, 0.25, 0.25, 0.2]
            self.assertTrue((error < bounds).all(), f"{found} for {numbers}")
            if blind:
                self.assertEqual(list(found[6:]), [0] * 2)

    def test_the_derivative_is_that_of_the_loss(self):
        for blind in (False, True):
            padded = fit_posterior.Padded(self.read(self.drawn(200, BLIND if blind else SEEING, blind)))
            numbers = SEEING + 0.3 * self.random.normal(size=SEEING.size)
            leaders = padded.leaders(numbers)
            _, derivative = padded.loss(numbers, leaders)
            step = 1e-6 * numpy.eye(SEEING.size)
            differences = [(padded.loss(numbers + s, leaders)[0] - padded.loss(numbers - s, leaders)[0]) / 2e-6
                           for s in step]
            numpy.testing.assert_allclose(derivative, differences, rtol=1e-5, atol=1e-4)

    def test_posterior_is_that_of_the_model(self):
        for blind in (False, True):
            numbers = BLIND if blind else SEEING
            for pair in self.read(self.drawn(50, numbers, blind)):
                poses, none = pair.posterior(numbers)
                numpy.testing.assert_allclose(poses, pair.probabilities, atol=1e-9)
                self.assertAlmostEqual(none, pair.none, places=9)

    def test_what_matches_nothing_is_no_pose(self):
        candidates = draw_pair(self.random, SEEING, False)
        for candidate in candidates:
            candidate["patches_matched"] = 0
        pair, = self.read([("a", "", candidates)])
        self.assertEqual(pair.posterior(SEEING)[1], 1)

    def test_a_place_is_judged_by_the_fit_to_the_others(self):
        drawn = self.drawn(400, datasets=("a", "b"))
        # The place "c" is lost throughout, and so are its pairs with "b": no other fit may know of either.
        lost = self.drawn(200, datasets=("c",))
        for k, (_, _, candidates) in enumerate(lost):
            for candidate in candidates:
                candidate["right"] = 0
            if k % 2:
                lost[k] = ("b", "c", candidates)
        pairs = self.read(drawn + lost)
        fits = fit_posterior.held_out_fits(pairs)
        without = {"c": [p for p in pairs if p.places <= {"a", "b"}], "b": [p for p in pairs if "b" not in p.places]}
        for dataset, others in without.items():
            numpy.testing.assert_array_equal(fits[dataset], fit_posterior.fit(others))
        self.assertEqual(len(without["c"]), 400)

    def test_what_held_the_confidence_holds_the_fitted_one(self):
        pairs = self.read(self.drawn(100))
        pair = max(pairs, key=lambda p: p.probabilities[0])
        self.assertGreater(pair.probabilities[0], 0.7)
        judged = fit_posterior.Judged()
        judged.add_fitted(pair, SEEING)
        pair.cap = 0.3
        judged.add_fitted(pair, SEEING)
        self.assertEqual(judged.accepted(), 1)
        self.assertEqual(judged.confidences[1], 0.3)

    def test_calibration_and_false_positives(self):
        pairs = self.read(self.drawn(300))
        judged = fit_posterior.Judged()
        for pair in pairs[:10]:
            pair.right[:] = False
            pair.right[0] = len(judged.rights) < 6
            judged.add(pair, pair.probabilities, pair.none, 0, 0.8)
        self.assertEqual((judged.accepted(), judged.false_positives()), (10, 4))
        self.assertAlmostEqual(judged.calibration_error(), 0.2)

    def test_the_program_prints_numbers_and_tables(self):
        write_folder(self.folder, self.drawn(90) + [("a", "", [])])
        code, output, _ = self.run_main(self.folder, self.folder)
        self.assertEqual(code, 0)
        self.assertIn("With free space: 180 pairs", output)
        self.assertIn("Blind: 0 pairs, too few to fit", output)
        self.assertRegex(output, r"\{-?\d+\.\d\d(, -?\d+\.\d\d){5}\}")
        self.assertRegex(output, r"    clutter = \d+\.\d\d, contradictions = \d+\.\d\d\n")
        rows = [line for line in output.splitlines() if line.startswith("| ")]
        self.assertEqual([r.split(" | ")[0] for r in rows[1:]], ["| a", "| b", "| c", "| **all**"])
        self.assertEqual({r.count("|") for r in rows}, {13})

    def test_a_single_place_has_no_others(self):
        write_folder(self.folder, self.drawn(30, datasets=("a",)))
        code, output, _ = self.run_main(self.folder)
        self.assertEqual(code, 0)
        self.assertIn("| - | - | - |", output)

    def test_wrong_files_and_usage(self):
        self.assertEqual(self.run_main()[0], 2)
        self.assertEqual(self.run_main("--blind")[0], 2)
        self.assertEqual(self.run_main("--help")[0], 0)
        code, _, errors = self.run_main(self.folder)
        self.assertEqual(code, 1)
        self.assertIn("results.csv", errors)
        for change, text in (({"facing_patches": "many"}, "many"), ({"facing_patches": ""}, "candidates.csv:2"),
                             ({"clutter": "nan"}, "not finite")):
            pairs = self.drawn(3)
            pairs[0][2][0].update(change)
            write_folder(self.folder, pairs)
            code, _, errors = self.run_main(self.folder)
            self.assertEqual(code, 1)
            self.assertIn(text, errors)
        path = pathlib.Path(self.folder) / "candidates.csv"
        path.write_text(path.read_text(encoding="utf-8").replace("third_direction", "third"), encoding="utf-8")
        self.assertIn("no column 'third_direction'", self.run_main(self.folder)[2])


if __name__ == "__main__":
    unittest.main()
