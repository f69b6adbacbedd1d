#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Opens reports in headless Chromium: no console message, sorts, filters, opens rows, fits a phone, prints.

Usage: report_browser_test.py MADE_UP_REPORTS [--screenshots DIR]
Needs Debian's chromium and chromium-driver; exit code 77 (skipped) where one is missing.
"""
import base64
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.request

SKIPPED = 77
WIDE = (1280, 900)
PHONE = (390, 844)
SCREENSHOTS = None
FOLDER = None


class Browser:
    """A session of chromedriver, by the W3C WebDriver protocol."""

    def __init__(self, profile):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.driver = subprocess.Popen(
            ["chromedriver", f"--port={self.port}", "--log-level=OFF"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            self.wait_for_driver()
            arguments = ["--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", f"--user-data-dir={profile}"]
            if os.geteuid() == 0:
                arguments.append("--no-sandbox")
            options = {"args": arguments, "binary": shutil.which("chromium")}
            wanted = {"browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
            self.base = "/session/" + self.call("/session", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]
        except BaseException:
            self.driver.kill()
            self.driver.wait()
            raise

    def wait_for_driver(self):
        for _ in range(300):
            try:
                if self.call("/status")["ready"]:
                    return
            except OSError:
                time.sleep(0.1)
        raise RuntimeError("chromedriver does not answer")

    def call(self, path, body=None):
        request = urllib.request.Request(
            f"http://127.0.0.1:{self.port}{path}",
            data=None if body is None else json.dumps(body).encode(),
            headers={"Content-Type": "application/json"},
        )
        try:
            # No proxy stands between us and ourselves.
            with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from None

    def close(self):
        try:
            request = urllib.request.Request(f"http://127.0.0.1:{self.port}{self.base}", method="DELETE")
            urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=20).close()
        except OSError:
            pass
        self.driver.terminate()
        self.driver.wait()

    def devtools(self, command, **parameters):
        return self.call(self.base + "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def size(self, width, height, mobile=False):
        self.devtools("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile)

    def colours(self, scheme):
        self.devtools("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def open(self, name):
        self.call(self.base + "/url", {"url": (FOLDER / name / "report.html").as_uri()})

    def run(self, script, *arguments):
        return self.call(self.base + "/execute/sync", {"script": script, "args": list(arguments)})

    def messages(self):
        return [entry["message"] for entry in self.call(self.base + "/se/log", {"type": "browser"})]

    def screenshot(self, name, whole=True):
        if SCREENSHOTS:
            picture = self.devtools("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
            (SCREENSHOTS / f"{name}.png").write_bytes(base64.b64decode(picture["data"]))

    def pdf(self, name):
        content = base64.b64decode(self.call(self.base + "/print", {"page": {"width": 21, "height": 29.7}, "background": False}))
        if SCREENSHOTS:
            (SCREENSHOTS / f"{name}.pdf").write_bytes(content)
        return content


# Read a column of the table of runs, found by its title and unit.
COLUMN = """
const [title, unit] = arguments;
const heads = [...document.querySelectorAll('#runs thead th')];
const at = heads.findIndex((h) => (h.querySelector('button') || h).textContent === title &&
                                  (!unit || (h.querySelector('.unit') || {}).textContent === unit));
return [...document.querySelectorAll('#runs tbody tr.run')].map((r) => r.cells[at].textContent.trim());
"""
SORT = """
[...document.querySelectorAll('#runs thead button')].find((b) => b.textContent === arguments[0]).click();
"""
CHOOSE = """
const select = document.getElementById(arguments[0]);
select.value = [...select.options].find((o) => o.textContent === arguments[1]).value;
select.dispatchEvent(new Event('change', {bubbles: true}));
"""
# Share of a canvas's pixels that are painted, and number of distinct colours (coarsely).
PAINTED = """
return [...document.querySelectorAll(arguments[0])].map((canvas) => {
  const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  const seen = {};
  let painted = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    if (pixels[i + 3] < 128) continue;
    ++painted;
    const hue = pixels[i] > pixels[i + 2] + 40 ? 'warm' : pixels[i + 2] > pixels[i] + 40 ? 'cold' : 'grey';
    seen[hue] = (seen[hue] || 0) + 1;
  }
  return {share: painted / (pixels.length / 4), warm: seen.warm || 0, cold: seen.cold || 0};
});
"""


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = Browser(FOLDER / "profile")

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()

    def setUp(self):
        self.browser.size(*WIDE)
        self.browser.colours("light")
        self.browser.messages()

    def tearDown(self):
        self.assertEqual(self.browser.messages(), [])

    def open(self, name):
        self.browser.open(name)
        self.assertEqual(self.run_script("return performance.getEntriesByType('resource').map((e) => e.name)"), [])

    def run_script(self, *arguments):
        return self.browser.run(*arguments)

    def column(self, title, unit=""):
        return self.run_script(COLUMN, title, unit)

    def count(self):
        return int(self.run_script("return document.getElementById('count').textContent").split()[0])

    def numbers(self, title, unit):
        """Of a column, without what is not known, which comes last in any order."""
        texts = self.column(title, unit)
        known = [text for text in texts if text != "\u2013"]
        self.assertTrue(all(text == "\u2013" for text in texts[len(known) :]), texts)
        return [float(text) for text in known]

    def test_showsTablesAndCharts(self):
        self.open("usual")
        self.assertEqual(self.run_script("return document.querySelectorAll('#summary tbody tr').length"), 7)
        self.assertEqual(self.run_script("return document.querySelectorAll('#overview tbody tr').length"), 7)
        charts = self.run_script(PAINTED, "#charts canvas")
        self.assertEqual(len(charts), 8)
        for chart in charts:
            self.assertGreater(chart["share"], 0.003)
        self.assertIn("a made up machine", self.run_script("return document.getElementById('subtitle').textContent"))
        self.assertIn("leaf_share", self.run_script("return document.getElementById('settings').textContent"))
        self.browser.screenshot("usual_wide")
        # Another dataset, other numbers.
        before = self.run_script("return document.getElementById('summary').textContent")
        self.run_script(CHOOSE, "dataset", "office_floor")
        self.assertNotEqual(self.run_script("return document.getElementById('summary').textContent"), before)
        self.assertIn("office_floor", self.run_script("return document.getElementById('summary-caption').textContent"))

    def test_messagesWouldBeSeen(self):
        self.open("usual")
        self.run_script("console.error('an error'); const i = new Image(); i.src = 'https://example.invalid/x.png';")
        time.sleep(0.5)
        messages = " ".join(self.browser.messages())
        self.assertIn("an error", messages)
        self.assertIn("Content Security Policy", messages)  # nothing can be loaded even by mistake

    def test_methodsCanBeHiddenInCharts(self):
        self.open("usual")
        lines = "return Chart.getChart(document.querySelector('#degree-curve canvas')).data.datasets.map((d) => d.label)"
        self.assertEqual(len(self.run_script(lines)), 7)
        self.run_script("document.querySelector('#chips .chip').click()")
        self.assertNotIn("ssfr", self.run_script(lines))
        self.assertEqual(len(self.run_script(lines)), 6)

    def test_sorts(self):
        self.open("usual")
        self.assertEqual(self.count(), 280)
        self.run_script(SORT, "time")
        times = self.numbers("time", "s")
        self.assertEqual(len(times), 50)
        self.assertEqual(times, sorted(times))
        self.assertEqual(self.run_script("return document.querySelectorAll('#runs [aria-sort=ascending]').length"), 1)
        self.run_script(SORT, "time")
        slowest = self.numbers("time", "s")
        self.assertEqual(slowest, sorted(slowest, reverse=True))
        self.assertGreater(slowest[0], times[-1])
        self.run_script(SORT, "confidence")
        self.numbers("confidence", "")
        self.run_script("document.querySelectorAll('#summary thead button')[1].click()")  # by success
        rates = self.run_script("return [...document.querySelectorAll('#summary tbody strong')].map((s) => parseInt(s.textContent))")
        self.assertEqual(rates, sorted(rates))

    def test_filters(self):
        self.open("usual")
        self.run_script(CHOOSE, "filter-method", "gicp")
        self.assertEqual(self.count(), 40)
        self.assertEqual(set(self.column("method")), {"gicp"})
        self.run_script(CHOOSE, "filter-dataset", "office_floor")
        self.assertEqual(self.count(), 20)
        self.assertEqual(set(self.column("dataset")), {"office_floor"})
        self.run_script("document.getElementById('filter-clear').click()")
        self.assertEqual(self.count(), 280)
        self.run_script(CHOOSE, "filter-verdict", "false positive")
        wrong = self.count()
        self.assertTrue(0 < wrong < 280)
        self.assertEqual(set(self.column("result")), {"false positive"})
        self.run_script(CHOOSE, "filter-verdict", "all")
        self.run_script(CHOOSE, "filter-status", "crashed")
        self.assertEqual(set(self.column("status")), {"crashed"})
        self.run_script("document.getElementById('filter-clear').click()")
        self.run_script(
            "const t = document.getElementById('filter-text'); t.value = 'SCAN_7.pcd'; t.dispatchEvent(new Event('input'));"
        )
        time.sleep(0.5)
        self.assertEqual(self.count(), 28)  # as source and as target
        self.run_script(
            "const t = document.getElementById('filter-text'); t.value = 'no such text'; t.dispatchEvent(new Event('input'));"
        )
        time.sleep(0.5)
        self.assertEqual(self.count(), 0)
        self.assertIn("No run is like that", self.run_script("return document.getElementById('runs').textContent"))

    def open_row(self):
        self.run_script("document.querySelector('#runs tbody tr.run').click()")
        self.browser.call(
            self.browser.base + "/execute/async",
            {"script": "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()));", "args": []},
        )

    def test_rowsOpenToPictures(self):
        self.open("usual")
        self.run_script(CHOOSE, "filter-verdict", "false positive")
        self.run_script(SORT, "pair")
        self.open_row()
        self.assertEqual(self.run_script("return document.querySelector('.opener').getAttribute('aria-expanded')"), "true")
        text = self.run_script("return document.querySelector('tr.detail').textContent")
        self.assertIn("false positive", text)
        pictures = self.run_script(PAINTED, "tr.detail canvas")
        self.assertEqual(len(pictures), 6)  # before, after, truth, from above and the side
        for picture in pictures:
            self.assertGreater(picture["warm"], 200)
            self.assertGreater(picture["cold"], 200)
        self.run_script("document.querySelector('tr.detail').scrollIntoView({block: 'center'})")
        self.browser.screenshot("usual_row", whole=False)
        self.run_script("document.querySelector('.opener').click()")
        self.assertEqual(self.run_script("return document.querySelectorAll('tr.detail').length"), 0)

    def test_failuresShowTheirReason(self):
        self.open("usual")
        self.run_script(CHOOSE, "filter-status", "crashed")
        self.run_script(SORT, "pair")
        self.open_row()
        text = self.run_script("return document.querySelector('tr.detail').textContent")
        self.assertIn("signal 11: about to fall", text)

    def test_sweepsAreDrawn(self):
        self.open("sweep")
        sweep = "return Chart.getChart(document.querySelector('#sweep canvas')).data.datasets.map((d) => d.data.map((p) => p.x))"
        lines = self.run_script(sweep)
        self.assertEqual(len(lines), 15)
        for line in lines:
            self.assertEqual(line, [0.05, 0.1, 0.2, 0.4])
        self.browser.screenshot("sweep_wide")

    def test_hostileNamesStayText(self):
        self.open("hostile")
        self.assertIsNone(self.run_script("return window.broken || null"))
        self.assertIn("</script><script>window.broken=1</script>", self.column("dataset"))
        self.assertEqual(self.run_script("return document.querySelectorAll('img, table script').length"), 0)
        self.open_row()
        self.run_script("for (const b of document.querySelectorAll('th button, .chip')) b.click()")
        self.assertIsNone(self.run_script("return window.broken || null"))

    def test_opensWithoutRuns(self):
        self.open("empty")
        self.assertIn("No run has ended yet", self.run_script("return document.getElementById('runs').textContent"))
        self.assertIn("0 of 12 runs", self.run_script("return document.getElementById('partial').textContent"))
        self.browser.screenshot("empty")

    def test_tenThousandRowsStayUsable(self):
        self.open("large")
        self.assertGreaterEqual(self.count(), 10000)
        self.assertEqual(len(self.column("pair")), 50)
        took = self.run_script(
            """const start = performance.now();
            for (const b of document.querySelectorAll('#runs thead button')) b.click();
            document.getElementById('next').click();
            return (performance.now() - start) / document.querySelectorAll('#runs thead button').length;"""
        )
        self.assertLess(took, 1500)  # milliseconds a sort, on a busy machine
        self.assertIn("page 2 of", self.run_script("return document.getElementById('pager').textContent"))
        self.run_script(CHOOSE, "filter-method", "ndt")
        self.assertIn("page 1 of", self.run_script("return document.getElementById('pager').textContent"))

    def test_fitsAPhone(self):
        self.browser.size(*PHONE, mobile=True)
        for name in ("usual", "sweep", "hostile", "empty"):
            self.open(name)
            if name == "usual":
                self.open_row()
            width = self.run_script("return Math.max(document.documentElement.scrollWidth, document.body.scrollWidth)")
            self.assertLessEqual(width, PHONE[0], name)
            self.browser.screenshot(f"{name}_phone")

    def test_darkAndLight(self):
        self.open("usual")
        colour = "return getComputedStyle(document.body).backgroundColor.match(/\\d+/g).slice(0, 3).reduce((a, b) => a + +b, 0)"
        self.assertGreater(self.run_script(colour), 600)
        self.browser.colours("dark")
        self.assertLess(self.run_script(colour), 150)
        self.open_row()
        self.browser.screenshot("usual_dark")

    def test_prints(self):
        self.browser.colours("dark")  # paper stays white
        self.open("usual")
        self.open_row()
        pdf = self.browser.pdf("usual")
        self.assertTrue(pdf.startswith(b"%PDF"))
        self.assertGreater(len(pdf), 20000)


def main():
    global SCREENSHOTS, FOLDER
    if len(sys.argv) not in (2, 4) or (len(sys.argv) == 4 and sys.argv[2] != "--screenshots"):
        sys.exit(__doc__)
    for program in ("chromium", "chromedriver"):
        if not shutil.which(program):
            print(f"skipped: {program} was not found (Debian: chromium, chromium-driver)")
            sys.exit(SKIPPED)
    if len(sys.argv) == 4:
        SCREENSHOTS = pathlib.Path(sys.argv[3]).resolve()
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        FOLDER = pathlib.Path(folder)
        subprocess.run([sys.argv[1], folder], check=True)
        result = unittest.main(argv=[sys.argv[0]], exit=False, verbosity=2).result
    sys.exit(0 if result.wasSuccessful() else 1)


if __name__ == "__main__":
    main()
