# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""scripts/check_links and scripts/check_readme: what they find on documents made up for it. Help of scripts."""
import importlib.machinery
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent / "scripts"
sys.dont_write_bytecode = True


def load(name):
    loader = importlib.machinery.SourceFileLoader(name, str(SCRIPTS / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


check_links = load("check_links")
check_readme = load("check_readme")


class Help(unittest.TestCase):
    def test_speed_table_builds_nothing(self):
        # Without a PATH whatever it would run is not found.
        command = ["/bin/bash", SCRIPTS / "speed_table", "--help"]
        with tempfile.TemporaryDirectory() as tools:
            pathlib.Path(tools, "sed").symlink_to(shutil.which("sed"))
            done = subprocess.run(command, env={"PATH": tools}, stdout=subprocess.PIPE, check=True, text=True)
        self.assertIn("scripts/speed_table [OPTIONS] DATASET...", done.stdout)


class Links(unittest.TestCase):
    """Documents in a folder of their own, no git there."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()
        (self.root / "docs").mkdir()
        (self.root / "docs" / "A.md").write_text("# One `two`, three\n\n## Twice\n\n## Twice\n", encoding="utf-8")

    def found(self, text, name="README.md"):
        (self.root / name).write_text(text, encoding="utf-8")
        return [f"{number}: {problem}" for number, problem in check_links.problems_of(self.root, name)]

    def test_links_that_lead_somewhere(self):
        self.assertEqual(self.found("[a](docs/A.md) [b](docs/A.md#one-two-three) [c](docs/A.md#twice-1) ![d](docs)\n"
                                    "[e](https://example.org/x) [over\ntwo lines](docs/A.md) [f](#head)\n# Head\n"
                                    "`[g](nowhere)` `docs/A.md` `docs/*.md` build/x\n\n[h]: docs/A.md\n\n```\n[i](nowhere)\n```\n"), [])

    def test_links_that_lead_nowhere(self):
        for link in ("docs/B.md", "docs/A.md#four", "#head", "/docs/A.md", "../x.md"):
            self.assertEqual(len(self.found(f"\n[a]({link})\n")), 1, link)
            self.assertIn("2: ", self.found(f"\n[a]({link})\n")[0])
        self.assertEqual(len(self.found("a [link over\ntwo lines](nowhere) b\n")), 1)
        self.assertEqual(len(self.found("[a]: nowhere\n")), 1)

    def test_paths_in_code(self):
        self.assertEqual(self.found("`docs/B.md`\n\n```\nscripts/none x\n```\n"),
                         ["1: path 'docs/B.md': there is no such file", "4: path 'scripts/none': there is no such file"])
        self.assertEqual(len(self.found("`docs/B*.md`\n")), 1)
        self.assertEqual(self.found("`src/gone.cpp`\n", "CHANGELOG.md"), [])

    def test_long_lines_and_a_long_readme(self):
        long = "x " * 61
        self.assertEqual(len(self.found(long + "\n")), 1)
        self.assertEqual(self.found(f"| {long} |\n\n```\n{long}\n```\n\n    {long}\n\nhttps://example.org {long}\n"), [])
        self.assertEqual(len(self.found("x\n" * 161)), 1)
        self.assertEqual(self.found("x\n" * 160), [])

    def test_exit_codes(self):
        script = [sys.executable, str(SCRIPTS / "check_links"), str(self.root)]
        self.assertEqual(subprocess.run(script, stdout=subprocess.DEVNULL, check=False).returncode, 0)
        (self.root / "B.md").write_text("[a](nowhere)\n", encoding="utf-8")
        done = subprocess.run(script, stdout=subprocess.PIPE, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (1, "B.md:1: link 'nowhere': there is no such file\n"))


class Readme(unittest.TestCase):
    """The comparison of what README shows with what its program prints."""

    SHOWN = "converged, overlap 0.88\n  1.0 -2e-05\n"

    def test_digits_may_differ(self):
        self.assertIsNone(check_readme.difference(self.SHOWN, "converged, overlap 0.9012\n0.999999   0\n\n"))

    def test_words_numbers_and_lines_may_not(self):
        for printed in ("ambiguous, overlap 0.88\n1.0 -2e-05\n", "converged, overlap 0.7\n1.0 -2e-05\n",
                        "converged, overlap 0.88\n1.0\n", "converged, overlap 0.88\n", self.SHOWN + "more\n"):
            self.assertIsNotNone(check_readme.difference(self.SHOWN, printed), printed)

    def test_readme_has_a_program_a_build_and_a_run(self):
        text = (SCRIPTS.parent / "README.md").read_text(encoding="utf-8")
        name, arguments, shown = check_readme.command_and_output(text)
        self.assertIn(f"add_executable({name} main.cpp)", check_readme.only(check_readme.blocks_of(text, "cmake"), ""))
        self.assertTrue(arguments and shown.strip())
        with self.assertRaises(check_readme.Failure):
            check_readme.only(check_readme.blocks_of(text + "```cpp\n```\n", "cpp"), "programs")


if __name__ == "__main__":
    unittest.main()
