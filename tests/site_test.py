# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""scripts/build_site: the site of the documents is whole, its links lead somewhere, and its search finds things, in a
browser from the disk too. Exits with 77 without python3-markdown; without Doxygen the API is left out, without Chromium
the browser."""
import html.parser
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

try:
    import markdown  # pylint: disable=unused-import
except ImportError:
    print("skipped: python3-markdown is missing")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "scripts" / "build_site"
sys.dont_write_bytecode = True
LOADER = importlib.machinery.SourceFileLoader("build_site", str(SCRIPT))
build_site = importlib.util.module_from_spec(importlib.util.spec_from_loader("build_site", LOADER))
LOADER.exec_module(build_site)


class Page(html.parser.HTMLParser):
    """Links, pictures, identifiers and text of a page, read without the code that wrote it."""

    def __init__(self, path):
        super().__init__()
        self.links, self.pictures, self.identifiers, self.text, self.code = [], [], [], [], 0
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.identifiers += [attrs[key] for key in ("id",) if key in attrs]
        if tag == "a" and "href" in attrs:
            self.links.append(attrs["href"])
        if tag == "img":
            self.pictures.append(attrs["src"])
        self.code += tag in ("code", "pre", "script", "style")

    def handle_endtag(self, tag):
        self.code -= tag in ("code", "pre", "script", "style")

    def handle_data(self, data):
        if not self.code:
            self.text.append(data)


class Site(unittest.TestCase):
    """The site of this checkout, built once."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        top = pathlib.Path(cls.folder.name)
        cls.out = top / "site"
        cls.out.mkdir()
        command = [sys.executable, str(SCRIPT), str(cls.out)]
        cls.has_api = shutil.which("doxygen") is not None
        if cls.has_api:
            settings = (ROOT / "Doxyfile").read_text() + f"\nOUTPUT_DIRECTORY = {top}\nGENERATE_TAGFILE = {top}/api.tag\n"
            subprocess.run(["doxygen", "-"], input=settings, text=True, cwd=ROOT, check=True, stdout=subprocess.DEVNULL,
                           env={**os.environ, "PCL_SSFR_VERSION": "0"})
            command += ["--api", f"{top}/api.tag"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        cls.pages = {path: Page(path) for path in sorted(cls.out.rglob("*.html")) if "api" not in path.relative_to(cls.out).parts}
        text = (cls.out / "site" / "search_index.js").read_text(encoding="utf-8")
        cls.index = json.loads(re.fullmatch(r"window\.SEARCH_INDEX = (.*);\n", text, re.DOTALL).group(1))

    def page(self, name):
        return self.pages[self.out / name]

    def test_every_document_is_a_page_of_the_navigation(self):
        start = {urllib.parse.unquote(link) for link in self.page("index.html").links}
        for document in sorted((ROOT / "docs").glob("*.md")):
            name = f"docs/{document.stem}.html"
            self.assertIn(self.out / name, self.pages)
            self.assertIn(name, start)
        self.assertIn("Global registration of LiDAR scans", " ".join(self.page("index.html").text))
        self.assertIn("CHANGELOG.html", start)

    def test_links_and_anchors_lead_somewhere(self):
        api = {}
        checked = 0
        for path, page in self.pages.items():
            for link in page.links:
                parts = urllib.parse.urlsplit(link)
                if parts.scheme:
                    continue
                target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
                self.assertTrue(target.is_file(), f"{path}: {link}")
                if parts.fragment:
                    there = self.pages.get(target) or api.setdefault(target, Page(target))
                    self.assertIn(urllib.parse.unquote(parts.fragment), there.identifiers, f"{path}: {link}")
                checked += 1
        self.assertGreater(checked, 1000)

    def test_nothing_is_taken_from_the_network(self):
        for path in self.pages:
            text = path.read_text(encoding="utf-8")
            self.assertEqual(re.findall(r'<(?:script|img|link)[^>]*(?:src|href)="(?:https?:)?//[^"]*"', text), [], path)

    def test_pictures_are_there(self):
        shown = {(path.parent / urllib.parse.unquote(link)).resolve() for path, page in self.pages.items() for link in page.pictures}
        for picture in shown:
            self.assertTrue(picture.is_file(), picture)
        wanted = re.findall(r"!\[[^\]]*\]\(([^)\s]+)", "".join(p.read_text() for p in (ROOT / "docs").glob("*.md")))
        self.assertGreater(len(wanted), 3)
        for link in wanted:
            self.assertIn((self.out / "docs" / link).resolve(), shown)

    def test_identifiers_are_unique(self):
        for path, page in self.pages.items():
            self.assertEqual(sorted(page.identifiers), sorted(set(page.identifiers)), path)

    def test_no_markdown_is_left_over(self):
        for path, page in self.pages.items():
            text = "".join(page.text)
            for mark in ("```", "|---", "](", "**"):
                self.assertNotIn(mark, text, path)

    def test_bars_in_tables_have_no_backslash(self):
        self.assertIn("<code>--perturb none|rotation|se3</code>", (self.out / "docs" / "BENCHMARK.html").read_text())

    def test_the_search_has_the_words_of_guides_and_api(self):
        def found(word):
            return {url for title, url, text in self.index if word.lower() in (title + " " + text).lower()}
        self.assertIn("docs/MAPS.html#from-c", found("MultiwayRegistration"))
        self.assertTrue(any(url.startswith("docs/STATUSES.html#unobservable") for url in found("corridor without an end")))
        self.assertTrue(any(url.startswith("docs/RESULTS.html") for url in found("false positives")))
        for title, url, _ in self.index:
            self.assertTrue((self.out / url.partition("#")[0]).is_file(), f"{title}: {url}")
        if self.has_api:
            names = {title for title, url, _ in self.index if url.startswith("api/")}
            for name in ("pcl_ssfr::StructuredSceneRegistration::setGravity", "pcl_ssfr::Result",
                         "pcl_ssfr::Result::information", "pcl_ssfr::prepareScan"):
                self.assertIn(name, names)

    def test_anchors_of_api_names_exist(self):
        if not self.has_api:
            self.skipTest("doxygen is missing")
        pages = {}
        for title, url, _ in self.index:
            name, _, anchor = url.partition("#")
            if name.startswith("api/") and anchor:
                if name not in pages:
                    pages[name] = set(re.findall(r'(?:id|name)="([^"]+)"', (self.out / name).read_text(encoding="utf-8")))
                self.assertIn(anchor, pages[name], title)

    def browse(self, page, query):
        """The page as a browser has it after its scripts ran, from the disk."""
        browser = shutil.which("chromium")
        if browser is None:
            self.skipTest("chromium is missing")
        command = [browser, "--headless=new", "--disable-gpu", "--disable-dev-shm-usage", "--dump-dom",
                   f"--user-data-dir={self.folder.name}/profile", f"{(self.out / page).as_uri()}?q={urllib.parse.quote(query)}"]
        if os.geteuid() == 0:
            command.insert(1, "--no-sandbox")
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
        path = pathlib.Path(self.folder.name) / "dump.html"
        path.write_text(done.stdout, encoding="utf-8")
        results = re.search(r'<ol id="site-results"[^>]*>(.*?)</ol>', done.stdout, re.DOTALL)
        return re.findall(r'<a href="([^"]*)"', results.group(1)), results.group(1)

    def test_the_search_works_in_a_browser_from_the_disk(self):
        links, _ = self.browse("index.html", "unobservable")
        self.assertTrue(links[0].startswith("docs/STATUSES.html#unobservable"), links)
        links, _ = self.browse("docs/MAPS.html", "correspondence distance")
        self.assertTrue(any(link == "../docs/METHOD.html#correspondence-distance" for link in links[:3]), links)
        links, text = self.browse("index.html", "xyzzyplugh")
        self.assertEqual((links, "Nothing found" in text), ([], True))
        if self.has_api:
            links, _ = self.browse("index.html", "setGravity")
            self.assertTrue(links[0].startswith("api/"), links)


class Parts(unittest.TestCase):
    """The generator on made-up pages."""

    def test_anchors_are_those_of_github(self):
        anchors = build_site.Anchors()
        self.assertEqual([anchors(text, "-") for text in ("One `two`, three", "Twice", "Twice", "a_b c-d")],
                         ["one-two-three", "twice", "twice-1", "a_b-c-d"])

    def test_bare_addresses_become_links_outside_of_code(self):
        self.assertEqual(build_site.linked_addresses("see https://a.org/b. `https://c.org`\n```\nhttps://d.org\n```\n"
                                                     "[e](https://e.org) <https://f.org>"),
                         "see <https://a.org/b>. `https://c.org`\n```\nhttps://d.org\n```\n[e](https://e.org) <https://f.org>")

    def test_dead_links_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            (out / "a.html").write_text('<h1 id="x"></h1><a href="b.html"></a><a href="#x"></a><a href="#y"></a>'
                                        '<img src="p.png"><a href="https://z"></a>')
            self.assertEqual(list(build_site.dead_links(out)),
                             ["a.html: 'b.html': there is no such page or file", "a.html: '#y': the page has no such anchor",
                              "a.html: 'p.png': there is no such page or file"])

    def test_wrong_use(self):
        for arguments in ([], ["--fast"], ["a", "b"]):
            done = subprocess.run([sys.executable, str(SCRIPT), *arguments], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 2)
            self.assertIn("Usage", done.stderr)
        done = subprocess.run([sys.executable, str(SCRIPT), "--help"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
