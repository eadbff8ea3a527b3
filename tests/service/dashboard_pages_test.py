"""The dashboard's files as the daemon serves them: at every page, compressed or not, kept by browsers as long as they may."""

import gzip
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from photond_daemon import BIN, Daemon, DaemonTestCase  # noqa: E402

PAGES = ("/", "/jobs", "/jobs/J17", "/render", "/compare", "/studies", "/studies/new", "/scenes", "/scenes/cornell-box", "/api",
         "/scenes/hard-case%2Fcorner-90")


class DashboardPagesTest(DaemonTestCase):
    def files(self):
        """Every file below /assets that the page and its files name."""
        found, waiting = {}, set(re.findall(r"/assets/[\w.-]+", self.daemon.request("GET", "/").text))
        while waiting:
            path = waiting.pop()
            found[path] = self.daemon.request("GET", path)
            self.assertEqual(found[path].status, 200, path)
            named = re.findall(r"assets/([\w.-]+\.(?:js|css))", found[path].text)
            named += re.findall(r"[\"'`]\./([\w.-]+\.(?:js|css))[\"'`]", found[path].text)
            waiting |= {"/assets/" + name for name in named} - set(found)
        return found

    def test_every_page_is_the_dashboard(self):
        first = self.daemon.request("GET", "/").body
        for path in PAGES:
            reply = self.daemon.request("GET", path)
            self.assertEqual((reply.status, reply.body), (200, first), path)
            self.assertEqual(reply.headers["content-type"], "text/html; charset=utf-8")
        for path in ("/nothing", "/jobs/J17/more", "/assets/nothing.js", "/assets/..%2Findex.html"):
            self.assertEqual(self.daemon.request("GET", path).status, 404, path)

    def test_a_browser_is_shown_a_page_where_there_is_none(self):
        page = self.daemon.request("GET", "/").body
        browser = {"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"}
        missing = self.daemon.request("GET", "/nowhere", headers=browser)
        self.assertEqual((missing.status, missing.body), (404, page))
        again = self.daemon.request("GET", "/no/where", headers={**browser, "If-None-Match": missing.headers["etag"]})
        self.assertEqual(again.status, 304)
        for method, path in (("GET", "/v1/nothing"), ("POST", "/nowhere")):
            refused = self.daemon.request(method, path, headers=browser)
            self.assertEqual((refused.status, refused.headers["content-type"]), (404, "application/problem+json"), path)

    def test_policy_permits_nothing_from_elsewhere(self):
        policy = self.daemon.request("GET", "/").headers["content-security-policy"]
        self.assertIn("default-src 'self'", policy)
        for word in ("unsafe", "http:", "https:", "data:", "*"):
            self.assertNotIn(word, policy)

    def test_files_are_named_by_content_and_kept(self):
        files = self.files()
        self.assertGreater(len(files), 5)
        for path, reply in files.items():
            self.assertIn("immutable", reply.headers["cache-control"], path)
            again = self.daemon.request("GET", path, headers={"If-None-Match": reply.headers["etag"]})
            self.assertEqual((again.status, again.body), (304, b""), path)
        page = self.daemon.request("GET", "/")
        self.assertEqual(page.headers["cache-control"], "no-cache")
        self.assertEqual(self.daemon.request("GET", "/", headers={"If-None-Match": page.headers["etag"]}).status, 304)

    def test_compressed_where_that_is_taken(self):
        plain = self.daemon.request("GET", "/")
        for accepted in ("gzip", "deflate, gzip;q=0.5", "br, *", "x-gzip"):
            reply = self.daemon.request("GET", "/", headers={"Accept-Encoding": accepted})
            self.assertEqual(reply.headers.get("content-encoding"), "gzip", accepted)
            self.assertEqual(gzip.decompress(reply.body), plain.body)
            self.assertNotEqual(reply.headers["etag"], plain.headers["etag"])
            self.assertEqual(reply.headers["vary"], "Accept-Encoding")
        for accepted in ("identity", "gzip;q=0", "gzip; q=0.000", "br", ""):
            reply = self.daemon.request("GET", "/", headers={"Accept-Encoding": accepted})
            self.assertNotIn("content-encoding", reply.headers, accepted)
            self.assertEqual(reply.body, plain.body)

    def test_the_whole_of_it_is_small(self):
        total = 0
        for path in ("/", "/favicon.svg", *self.files()):
            total += len(self.daemon.request("GET", path, headers={"Accept-Encoding": "gzip"}).body)
        print(f"the dashboard is {total} bytes compressed")
        self.assertLess(total, 250_000)

    def test_the_start_pages_pictures_come_with_it(self):
        pictures = {name for reply in self.files().values() for name in re.findall(r"assets/([\w.-]+\.jpg)", reply.text)}
        self.assertEqual(len(pictures), 2, pictures)
        for name in pictures:
            reply = self.daemon.request("GET", "/assets/" + name)
            self.assertEqual((reply.status, reply.headers["content-type"], reply.body[:3]),
                             (200, "image/jpeg", b"\xff\xd8\xff"))
            self.assertLess(len(reply.body), 40_000)

    def test_pages_need_no_token_and_what_they_ask_for_does(self):
        output = subprocess.run([str(BIN / "photond"), "--new-token", "reader:read"], check=True, capture_output=True,
                                text=True).stdout
        with tempfile.TemporaryDirectory() as folder:
            tokens = pathlib.Path(folder) / "tokens"
            tokens.write_text(output.split("line:")[1].strip() + "\n")
            tokens.chmod(0o600)
            with Daemon("--tokens", tokens) as daemon:
                daemon.wait_ready()
                for path in (*PAGES, *self.files()):
                    self.assertEqual(daemon.request("GET", path).status, 200, path)
                self.assertEqual(daemon.request("GET", "/v1/status").status, 401)


if __name__ == "__main__":
    unittest.main()
