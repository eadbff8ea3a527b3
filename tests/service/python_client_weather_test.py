"""The Python client through connections that break and daemons that restart: held to the promises photonctl makes."""

import http.client
import http.server
import socket
import threading
import time
import unittest
import unittest.mock

from bad_weather import BadWeather
from photond_daemon import Daemon
from python_client_case import SMALL, Case, fixture, photond, url_of

setUpModule, tearDownModule = fixture.start, fixture.stop


def counted_connections():
    """Counts, as its call_count, how often the client connects."""
    return unittest.mock.patch("http.client.HTTPConnection.connect", autospec=True,
                               side_effect=http.client.HTTPConnection.connect)


class Weather(Case):
    """Through a proxy with faults; every one of them must have been met."""

    def through(self, *faults, **options):
        proxy = BadWeather(url_of(self.daemon), faults)
        proxy.__enter__()
        client = photond.Client(proxy.url, **options)
        self.addCleanup(proxy.__exit__)
        self.addCleanup(lambda: self.assertEqual(proxy.faults, [], "not every fault was met"))
        return client, proxy

    def labelled(self, label):
        return list(self.client.jobs(label=label))

    def test_a_submission_whose_answer_was_lost_is_one_job(self):
        client, proxy = self.through(("POST", "^/v1/jobs$", "drop"), ("POST", "^/v1/jobs$", "drop"))
        job = client.submit("furnace", **SMALL, labels={"lost": "1"})
        keys = [headers["Idempotency-Key"] for method, _, headers in proxy.seen if method == "POST"]
        self.assertEqual((len(keys), len(set(keys))), (3, 1))
        self.assertEqual([found.id for found in self.labelled("lost=1")], [job.id])

    def test_so_is_a_comparison_and_a_merged_job(self):
        client, proxy = self.through(("POST", "^/v1/comparisons$", "drop"), ("POST", "^/v1/jobs/merge$", "drop"))
        before = len(list(self.client.comparisons()))
        client.compare("furnace", ["path_tracing"], **SMALL, reference="path_tracing:2")
        self.assertEqual(len(list(self.client.comparisons())), before + 1)
        part = self.client.render("furnace", **SMALL)
        merged = len(list(self.client.jobs(role="merged")))
        client.merge([part])
        self.assertEqual(len(list(self.client.jobs(role="merged"))), merged + 1)

    def test_the_same_key_is_the_same_submission(self):
        first = self.client.submit("furnace", **SMALL, idempotency_key="mine")
        self.assertEqual(self.client.submit("furnace", **SMALL, idempotency_key="mine").id, first.id)
        with self.assertRaises(photond.Invalid) as raised:
            self.client.submit("furnace", **{**SMALL, "passes": 3}, idempotency_key="mine")
        self.assertEqual(raised.exception.code, "idempotency_mismatch")

    def test_busy_answers_are_waited_out(self):
        client, proxy = self.through(("GET", "status", "503"), ("POST", "^/v1/jobs$", "429"), ("GET", "image.exr", "503"))
        begun = time.monotonic()
        client.status()
        client.render("furnace", **SMALL, labels={"busy": "1"}).exr()
        self.assertGreaterEqual(time.monotonic() - begun, 3)  # each said Retry-After: 1
        self.assertEqual(len([1 for method, _, _ in proxy.seen if method == "POST"]), 2)
        self.assertEqual(len(self.labelled("busy=1")), 1)

    def test_no_repeats_where_none_are_wanted(self):
        client, proxy = self.through(("GET", "status", "503"), ("POST", "^/v1/jobs$", "429"), retry_seconds=0)
        with self.assertRaises(photond.Unavailable):
            client.status()
        with self.assertRaises(photond.Busy):
            client.submit("furnace", **SMALL)
        self.assertEqual(len(proxy.seen), 2)

    def test_a_refusal_is_not_repeated(self):
        client, proxy = self.through(("GET", "status", "404"))
        with self.assertRaises(photond.NotFound):
            client.status()
        self.assertEqual(len(proxy.seen), 1)

    def test_what_may_have_been_carried_out_is_not_repeated_unless_that_is_harmless(self):
        job = self.long_job()
        job.cancel().wait(check=False)
        client, proxy = self.through(("POST", "/retry$", "drop"))
        with self.assertRaisesRegex(photond.Unreachable, "may have been carried out"):
            photond.Job(client, job.data).retry()
        self.assertEqual(len(proxy.seen), 1)
        self.assertIn(job.refresh().state, ("queued", "running"))

    def test_a_download_that_breaks_off_is_whole_in_the_end(self):
        job = self.client.render("cornell-box", **SMALL)
        client, _ = self.through(("GET", "image.exr", "half"), ("GET", "image.exr", "drop"), ("GET", "pixels", "half"))
        through = photond.Job(client, job.data)
        through.save(self.folder / "whole.exr")
        self.assertEqual((self.folder / "whole.exr").read_bytes(), job.exr())
        self.assertEqual(through.pixels().data, job.pixels().data)

    def test_an_upload_is_sent_again(self):
        path = self.client.render("cornell-box", **SMALL).save(self.folder / "again.exr")
        client, proxy = self.through(("POST", "images", "drop"), ("POST", "images", "503"))
        self.assertEqual(client.upload_image(path).width, 24)
        self.assertEqual(len(proxy.seen), 3)

    def streams(self, count, *faults, then=0):
        """What was asked of a job's event stream until it was cancelled, once the proxy has_seen() that."""
        client, proxy = self.through(*faults)
        job = self.long_job(client)

        def cancel():
            self.daemon.wait_until(lambda: proxy.has_seen(count, then), "it asks that often", job=job.id)
            self.daemon.request("DELETE", f"/v1/jobs/{job.id}")
        canceller = threading.Thread(target=cancel)
        canceller.start()
        self.assertEqual(job.wait(check=False).state, "cancelled")
        canceller.join()
        self.assertEqual(job.data, self.daemon.job(job.id))
        return proxy.streams()

    def test_a_broken_event_stream_is_taken_up_where_it_broke(self):
        streams = self.streams(2, ("GET", "/events$", "cut"))
        self.assertGreaterEqual(len(streams), 2)
        self.assertNotIn("Last-Event-ID", streams[0])
        self.assertTrue(streams[1]["Last-Event-ID"].isdigit())

    def test_without_event_streams_the_job_is_asked_again_and_again(self):
        self.assertEqual(len(self.streams(3, *[("GET", "/events$", "404")] * 3, then=3)), 3)


class Restarts(Case):
    def test_a_job_is_followed_across_a_restart_of_the_daemon(self):
        with Daemon("--save-seconds", "0.1", "--threads", 1) as daemon, BadWeather(url_of(daemon), []) as proxy:
            daemon.wait_ready()
            job = photond.Client(proxy.url).submit("cornell-box", width=64, height=64, seconds=2)
            restarted, seen = [], []

            def restart():
                daemon.kill()
                daemon.start()
                proxy.upstream = url_of(daemon)

            def watch(job, event):
                seen.append(event)
                if job.passes_done > 0 and not restarted:
                    restarted.append(threading.Thread(target=restart))
                    restarted[0].start()

            job.wait(on_event=watch)
            restarted[0].join()
            self.assertEqual(job.state, "succeeded")
            self.assertEqual(job.data, daemon.job(job.id))
            self.assertGreaterEqual(len(job.data["attempts"]), 2)
            resumed = [headers["Last-Event-ID"] for _, path, headers in proxy.seen
                       if path.endswith("/events") and "Last-Event-ID" in headers]
            self.assertTrue(resumed)
            ids = [event.id for event in seen if event.id is not None]
            self.assertEqual(ids, sorted(ids))

    def test_a_refused_connection_is_an_error_first_and_a_restart_later(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        client = photond.Client(f"http://127.0.0.1:{port}")
        with counted_connections() as connect, self.assertRaisesRegex(photond.Unreachable, "Is the daemon running there"):
            client.status()
        self.assertEqual(connect.call_count, 1, "nobody waits for a daemon that never was")
        with BadWeather(url_of(self.daemon), [], port):
            client.status()

        proxies = []

        def later():
            time.sleep(1)
            proxies.append(BadWeather(url_of(self.daemon), [], port).__enter__())

        thread = threading.Thread(target=later)
        thread.start()
        self.assertTrue(client.status()["ready"])
        thread.join()
        proxies[0].__exit__()
        with self.assertRaises(photond.Unreachable):
            photond.Client(f"http://127.0.0.1:{port}", retry_seconds=0).status()

    def test_kept_connections_that_ended_meanwhile_are_not_used(self):
        accepted = []

        class Fickle(http.server.BaseHTTPRequestHandler):
            """Ends each connection after its first answer, without having said so."""
            protocol_version = "HTTP/1.1"

            def setup(self):
                super().setup()
                accepted.append(self.client_address)

            def do_GET(self):
                self.send_response(200)
                self.send_header("Content-Length", "2")
                self.end_headers()
                self.wfile.write(b"{}")
                self.close_connection = True

            def log_message(self, *_):
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Fickle) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            client = photond.Client(f"http://127.0.0.1:{server.server_port}", retry_seconds=0)
            for _ in range(3):
                client.status()
                time.sleep(0.05)
            server.shutdown()
        self.assertEqual(len(accepted), 3)

    def test_connections_are_kept_where_they_last(self):
        client = photond.Client(url_of(self.daemon))
        with counted_connections() as connect:
            for _ in range(5):
                client.status()
        self.assertEqual(connect.call_count, 1)

    def test_a_body_too_large_is_told_before_all_of_it_is_sent(self):
        with Daemon("--max-body", 1 << 20) as daemon:
            daemon.wait_ready()
            large = self.folder / "large.glb"
            large.write_bytes(bytes(64 << 20))
            with self.assertRaises(photond.TooLarge):
                photond.Client(url_of(daemon)).upload_scene(large)


if __name__ == "__main__":
    unittest.main()
