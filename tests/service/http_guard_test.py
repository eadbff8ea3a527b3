"""Every row of the table in reliability.md, "Measured on Debian 12's packages", and the rest of what a hostile or a
slow client may try: each gets its answer, the others do not notice, and memory stays flat.

Counts, bytes and states are asserted; times only by the order in which things happen.
"""

import contextlib
import os
import pathlib
import resource
import socket
import unittest

from photond_daemon import UNDER_SANITIZER, Daemon, small_job

# Over each probe: peak resident while it runs, minus resident before. A sanitizer keeps a shadow of what was touched.
GROWTH_LIMIT_MIB = 128 if UNDER_SANITIZER else 32


def setUpModule():
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 8192), hard))


class RawClient:
    """Bytes over a socket, for requests that no library would send."""

    def __init__(self, daemon, receive_buffer=None):
        self.socket = socket.socket()
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.connect((daemon.address, daemon.port))
        self.buffer = b""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, data):
        self.socket.sendall(data)

    def send_until_refused(self, chunks):
        """Sends until the peer stops listening; returns the bytes sent."""
        sent = 0
        with contextlib.suppress(ConnectionError):
            for chunk in chunks:
                self.socket.sendall(chunk)
                sent += len(chunk)
        return sent

    def _more(self):
        try:
            data = self.socket.recv(1 << 16)
        except ConnectionResetError:
            return False
        self.buffer += data
        return bool(data)

    def read_head(self):
        """(status, headers) of the next answer; None when the connection ends first."""
        while b"\r\n\r\n" not in self.buffer:
            if not self._more():
                return None
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        lines = head.decode("latin-1").split("\r\n")
        headers = dict(line.lower().split(": ", 1) for line in lines[1:] if ": " in line)
        return int(lines[0].split()[1]), headers

    def read_answer(self):
        head = self.read_head()
        if head is None:
            return None
        length = int(head[1].get("content-length", "0"))
        while len(self.buffer) < length:
            if not self._more():
                break
        body, self.buffer = self.buffer[:length], self.buffer[length:]
        return head[0], head[1], body

    def closed(self):
        """True, once the connection is; waits for that."""
        with contextlib.suppress(ConnectionResetError):
            while self.socket.recv(1 << 16):
                pass
        return True


def get(path="/healthz", extra=b""):
    return f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n".encode() + extra + b"\r\n"


def resident_mib(daemon, field):
    for line in pathlib.Path(f"/proc/{daemon.process.pid}/status").read_text().splitlines():
        if line.startswith(field + ":"):
            return int(line.split()[1]) / 1024
    raise AssertionError(field)


class GuardTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon("--head-timeout", "2")
        cls.daemon.wait_ready()
        job = cls.daemon.wait_for_job(cls.daemon.submit(small_job(size=512))["id"])
        assert job["state"] == "succeeded", job
        cls.image = f"/v1/jobs/{job['id']}/image.exr"
        cls.image_bytes = cls.daemon.request("GET", cls.image).body
        assert len(cls.image_bytes) > 100_000
        cls.daemon.request("GET", "/v1/jobs")  # warm

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def setUp(self):
        root = os.geteuid() == 0
        if root:  # who alone may set the peak to what there is now
            pathlib.Path(f"/proc/{self.daemon.process.pid}/clear_refs").write_text("5")
        self.before_mib = resident_mib(self.daemon, "VmRSS" if root else "VmHWM")

    def tearDown(self):
        growth = resident_mib(self.daemon, "VmHWM") - self.before_mib
        self.assertLess(growth, GROWTH_LIMIT_MIB, "MiB of resident memory")
        self.assertTrue(self.daemon.running())
        self.assertEqual(self.daemon.request("GET", "/healthz").status, 200)

    def ask(self, data, **options):
        with RawClient(self.daemon, **options) as client:
            client.send(data)
            return client.read_answer()

    def assert_problem(self, answer, status, code=None):
        self.assertIsNotNone(answer, "the connection was closed without an answer")
        self.assertEqual(answer[0], status, answer)
        self.assertEqual(answer[1]["content-type"], "application/problem+json")
        if code:
            self.assertIn(f'"code":"{code}"'.encode(), answer[2])

    # --- bodies ---------------------------------------------------------------------------------------------------

    def test_a_chunked_body_of_300_mb_is_refused_early(self):
        for path, kind in (("/v1/scenes", "model/gltf-binary"), ("/v1/jobs", "application/json")):
            with RawClient(self.daemon) as client:
                client.send(f"POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: {kind}\r\n"
                            "Transfer-Encoding: chunked\r\n\r\n".encode())
                chunk = b"100000\r\n" + bytes(1 << 20) + b"\r\n"
                self.assert_problem(client.read_answer(), 411, "length_required")
                client.send_until_refused(chunk for _ in range(300))
                self.assertTrue(client.closed())

    def test_a_gzip_body_is_refused(self):
        answer = self.ask(b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                          b"Content-Encoding: gzip\r\nContent-Length: 204000\r\n\r\n" + bytes(1000))
        self.assert_problem(answer, 415, "wrong_media_type")

    def test_lengths_that_lie_are_refused(self):
        for headers, statuses in ((b"Content-Length: 5abc", (400,)), (b"Content-Length: -5", (400,)),
                                  (b"Content-Length: +5", (400,)), (b"Content-Length:", (400,)),
                                  (b"Content-Length: 5, 5", (400,)), (b"Content-Length: 0x5", (400,)),
                                  (b"Content-Length: 5\r\nContent-Length: 5", (400,)),
                                  (b"Content-Length: 5\r\nContent-Length: 6", (400,)),
                                  (b"Content-Length: 5\r\nTransfer-Encoding: chunked", (400,)),
                                  (b"Transfer-Encoding: chunked\r\nContent-Length: 5", (400,)),
                                  (b"Transfer-Encoding: gzip, chunked", (411,)),
                                  (b"Transfer-Encoding : chunked", (400,)),
                                  (b"Content-Length: 99999999999999999999999", (413,)),
                                  (b"X-Nothing: here", (411,))):
            with self.subTest(headers=headers), RawClient(self.daemon) as client:
                client.send(b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" +
                            headers + b"\r\n\r\nhello")
                answer = client.read_answer()
                self.assertIsNotNone(answer)
                self.assertIn(answer[0], statuses)
                # Nothing behind such a head may be taken for a request.
                if answer[0] != 411 or b"Transfer" in headers:
                    self.assertTrue(client.closed())

    def test_a_declared_length_over_the_limit_is_refused_before_the_body(self):
        for path, kind in (("/v1/scenes", b"model/gltf-binary"), ("/v1/jobs", b"application/json")):
            answer = self.ask(b"POST " + path.encode() + b" HTTP/1.1\r\nHost: localhost\r\nContent-Type: " + kind +
                              b"\r\nContent-Length: 9000000000\r\n\r\n")
            self.assert_problem(answer, 413, "payload_too_large")

    def test_continue_is_said_only_when_the_body_is_wanted(self):
        head = (b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: %s\r\nExpect: 100-continue\r\n"
                b"Content-Length: 2\r\n\r\n")
        with RawClient(self.daemon) as client:
            client.send(head % b"application/json")
            self.assertEqual(client.read_head()[0], 100)
            client.send(b"{}")
            self.assert_problem(client.read_answer(), 422, "missing_field")
        self.assert_problem(self.ask(head % b"text/plain"), 415)

    def test_a_get_with_a_body_is_refused(self):
        self.assert_problem(self.ask(get("/v1/jobs", b"Content-Length: 3\r\n") + b"abc"), 400)

    # --- ranges ---------------------------------------------------------------------------------------------------

    def test_many_overlapping_ranges_give_the_whole(self):
        ranges = "bytes=" + ",".join("0-" for _ in range(600))
        reply = self.daemon.request("GET", self.image, headers={"Range": ranges})
        self.assertEqual(reply.status, 200)
        self.assertEqual(reply.body, self.image_bytes)

    def test_single_ranges(self):
        size = len(self.image_bytes)
        for wanted, first, end in (("bytes=0-9", 0, 10), ("bytes=100-", 100, size), ("bytes=-7", size - 7, size),
                                   (f"bytes={size - 1}-{size + 50}", size - 1, size), (f"bytes=-{size * 2}", 0, size)):
            reply = self.daemon.request("GET", self.image, headers={"Range": wanted})
            self.assertEqual(reply.status, 206, wanted)
            self.assertEqual(reply.headers["content-range"], f"bytes {first}-{end - 1}/{size}")
            self.assertEqual(reply.body, self.image_bytes[first:end])
        for wanted in (f"bytes={size}-", "bytes=99999999999-", "bytes=-0", "bytes=18446744073709551615-"):
            reply = self.daemon.request("GET", self.image, headers={"Range": wanted})
            self.assertEqual(reply.status, 416, wanted)
            self.assertEqual(reply.headers["content-range"], f"bytes */{size}")
        for wanted in ("bytes=9-5", "bytes=a-b", "bytes=-", "lines=0-5", "bytes=99999999999999999999999-", "bytes"):
            reply = self.daemon.request("GET", self.image, headers={"Range": wanted})
            self.assertEqual((reply.status, len(reply.body)), (200, size), wanted)

    def test_validators(self):
        reply = self.daemon.request("HEAD", self.image)
        self.assertEqual((reply.status, reply.body), (200, b""))
        self.assertEqual(int(reply.headers["content-length"]), len(self.image_bytes))
        etag = reply.headers["etag"]
        self.assertRegex(etag, r'^"[^"]+"$')
        for known in (etag, f'"other", {etag}', f"W/{etag}", "*"):
            reply = self.daemon.request("GET", self.image, headers={"If-None-Match": known})
            self.assertEqual((reply.status, reply.body), (304, b""), known)
            self.assertEqual(reply.headers["etag"], etag)
        self.assertEqual(self.daemon.request("GET", self.image, headers={"If-None-Match": '"other"'}).status, 200)
        ranged = {"Range": "bytes=0-3"}
        self.assertEqual(self.daemon.request("GET", self.image, headers={**ranged, "If-Range": etag}).status, 206)
        self.assertEqual(self.daemon.request("GET", self.image, headers={**ranged, "If-Range": '"other"'}).status, 200)

    # --- heads ----------------------------------------------------------------------------------------------------

    def test_a_million_header_lines(self):
        with RawClient(self.daemon) as client:
            client.send(b"GET / HTTP/1.1\r\nHost: localhost\r\n")
            lines = b"".join(b"X-%d: y\r\n" % i for i in range(10_000))
            sent = client.send_until_refused(lines for _ in range(100))
            answer = client.read_answer()
            if answer is not None:  # a reset may overtake the answer when the client goes on sending
                self.assert_problem(answer, 431, "head_too_large")
            self.assertTrue(client.closed())
            self.assertGreater(sent, 0)
        # A client that stops to listen gets it for certain.
        self.assert_problem(self.ask(b"GET / HTTP/1.1\r\nHost: localhost\r\n" + lines[:2000]), 431, "head_too_large")

    def test_a_header_line_of_200_mb(self):
        with RawClient(self.daemon) as client:
            client.send(b"GET / HTTP/1.1\r\nHost: localhost\r\nX: ")
            client.send_until_refused(b"y" * (1 << 20) for _ in range(200))
            self.assertTrue(client.closed())
        self.assert_problem(self.ask(b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"y" * 10_000), 431)
        self.assert_problem(self.ask(b"GET /" + b"y" * 10_000), 431)

    def test_malformed_heads(self):
        for data in (b"\x16\x03\x01\x02\x00\x01\x00", b"GET / HTTP/1.1\nHost: localhost\n\n", b"GET /\r\n\r\n",
                     b"GET / HTTP/2.0\r\nHost: a\r\n\r\n", b"G\x00T / HTTP/1.1\r\n\r\n", b"GET  / HTTP/1.1\r\n\r\n",
                     b"GET / HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
                     b"GET / HTTP/1.1\r\nHost: localhost\r\n folded\r\n\r\n", b"GET / HTTP/1.1\r\nHost\r\n\r\n",
                     b"GET / HTTP/1.1\r\nHo st: localhost\r\n\r\n", b"GET / HTTP/1.1\r\nHost: local host\r\n\r\n",
                     b"GET x HTTP/1.1\r\nHost: localhost\r\n\r\n", b"GET /\xff HTTP/1.1\r\nHost: localhost\r\n\r\n",
                     b"GET /%zz HTTP/1.1\r\nHost: localhost\r\n\r\n",
                     b"GET / HTTP/1.1\r\nHost: localhost\r\nA: b\rc\r\n\r\n",
                     b"GET / HTTP/1.1\r\nHost: localhost\r\nExpect: cake\r\n\r\n",
                     b"OPTIONS * HTTP/1.1\r\nHost: localhost\r\n\r\n"):
            with self.subTest(data=data):
                self.assert_problem(self.ask(data), 400, "bad_request")

    def test_a_slow_head_is_cut(self):
        with RawClient(self.daemon) as client:
            client.send(b"GET / HTTP/1.1\r\nHost: ")
            self.assert_problem(client.read_answer(), 408, "request_timeout")
            self.assertTrue(client.closed())

    def test_a_body_that_stops_is_cut(self):
        for path, kind in (("/v1/scenes", b"model/gltf-binary"), ("/v1/jobs", b"application/json")):
            with RawClient(self.daemon) as client:
                client.send(b"POST " + path.encode() + b" HTTP/1.1\r\nHost: localhost\r\nContent-Type: " + kind +
                            b"\r\nContent-Length: 1000\r\n\r\nabc")
                self.assert_problem(client.read_answer(), 408, "request_timeout")
                self.assertTrue(client.closed())

    def test_a_reader_that_stops_is_cut(self):
        with RawClient(self.daemon, receive_buffer=4096) as client:
            request = get(self.image)
            # Pipelined: far more than the buffers of two sockets hold.
            client.send(request * 30)
            before = self.connections_to_daemon()
            self.assertGreaterEqual(before, 1)
            self.daemon.wait_until(lambda: self.connections_to_daemon() < before, "its connection is closed")

    def connections_to_daemon(self):
        """Sockets the daemon holds that are connected to a client."""
        local = f"{self.daemon.port:04X}"
        rows = [line.split() for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]]
        return sum(1 for row in rows if row[1].endswith(":" + local) and row[3] == "01")

    def test_pipelined_requests_are_all_answered(self):
        with RawClient(self.daemon) as client:
            client.send(get("/healthz") * 200 + get("/v1/methods") + get(self.image) + get("/nothing") + get())
            statuses = [client.read_answer()[0] for _ in range(204)]
            self.assertEqual(statuses, [200] * 202 + [404, 200])

    def test_connections_are_kept_and_closed_as_asked(self):
        with RawClient(self.daemon) as client:
            for _ in range(3):
                client.send(get())
                self.assertEqual(client.read_answer()[0], 200)
            client.send(get(extra=b"Connection: close\r\n"))
            status, headers, _ = client.read_answer()
            self.assertEqual((status, headers["connection"]), (200, "close"))
            self.assertTrue(client.closed())
        with RawClient(self.daemon) as client:
            client.send(b"GET /healthz HTTP/1.0\r\n\r\n")
            self.assertEqual(client.read_answer()[0], 200)
            self.assertTrue(client.closed())

    # --- browsers -------------------------------------------------------------------------------------------------

    def test_foreign_hosts_and_origins_are_refused(self):
        def with_host(host):
            return self.ask(b"GET /v1/jobs HTTP/1.1\r\nHost: " + host + b"\r\n\r\n")
        for host in (b"localhost", b"localhost:8080", b"127.0.0.1", b"127.0.0.1:1", b"[::1]:80", b"LOCALHOST"):
            self.assertEqual(with_host(host)[0], 200, host)
        for host in (b"evil.example", b"localhost.evil.example", b"127.0.0.1.evil.example", b"10.0.0.1", b"localhost."):
            self.assert_problem(with_host(host), 403, "forbidden")

        def post(origin):
            return self.daemon.request("POST", "/v1/jobs", json_body={}, headers={"Origin": origin})
        own = f"http://{self.daemon.address}:{self.daemon.port}"
        self.assertEqual(post(own).status, 422)
        for origin in ("http://evil.example", "null", own + "0", "http://localhost:1"):
            self.assertEqual(post(origin).status, 403, origin)
        self.assertEqual(self.daemon.request("DELETE", "/v1/jobs/none", headers={"Origin": "null"}).status, 403)
        for second in (own, "http://evil.example"):
            self.assert_problem(self.ask(b"POST /v1/jobs HTTP/1.1\r\nHost: " + own[7:].encode() + b"\r\nOrigin: " +
                                         own.encode() + b"\r\nOrigin: " + second.encode() +
                                         b"\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{}"),
                                403, "forbidden")

    def test_browsers_say_when_a_page_of_another_site_sends(self):
        for site, status in (("cross-site", 403), ("same-origin", 422), ("none", 422)):
            headers = {"Sec-Fetch-Site": site}
            self.assertEqual(self.daemon.request("POST", "/v1/jobs", json_body={}, headers=headers).status, status, site)
            self.assertEqual(self.daemon.request("GET", "/v1/jobs?limit=1", headers=headers).status, 200, "a link leads here")

    def test_text_is_utf_8(self):
        for charset, status in (("utf-8", 422), ('"UTF-8"', 422), ("latin1", 415), ("utf-16", 415), ('""', 415)):
            reply = self.daemon.request("POST", "/v1/jobs", body=b"{}",
                                        headers={"Content-Type": f"application/json; charset={charset}"})
            self.assertEqual(reply.status, status, charset)

    def test_messages_do_not_tell_where_uploads_lie(self):
        exr = self.image_bytes
        broken = [exr[:8], exr[:200], exr[:-5], exr[:300] + bytes(len(exr) - 300), exr[:4] + bytes(300),
                  b"#?RADIANCE\n", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 10 +X 10\n"]
        uploads = [("/v1/images", kind, body) for body in broken for kind in ("image/x-exr", "image/vnd.radiance")]
        uploads += [("/v1/scenes", kind, body) for body in (b"glTF" + bytes(20), b"PK\3\4" + bytes(50))
                    for kind in ("model/gltf-binary", "application/zip")]
        for path, kind, body in uploads:
            reply = self.daemon.request("POST", path, body=body, headers={"Content-Type": kind})
            self.assertEqual(reply.status, 422, reply)
            self.assertNotIn(str(self.daemon.data_dir), reply.text)
            self.assertNotIn("spool", reply.text)

    def test_standard_headers_everywhere(self):
        for method, path in (("GET", "/"), ("GET", "/v1/jobs"), ("GET", "/nothing"), ("PUT", "/v1/jobs"),
                             ("GET", self.image), ("OPTIONS", "/v1/jobs")):
            reply = self.daemon.request(method, path)
            self.assertIn("default-src 'self'", reply.headers["content-security-policy"])
            self.assertEqual(reply.headers["x-content-type-options"], "nosniff")
            self.assertNotIn("access-control-allow-origin", reply.headers)
            if reply.status >= 400:
                self.assertEqual(reply.headers["content-type"], "application/problem+json")

    def test_unknown_paths_and_methods(self):
        for path in ("/v1", "/v2/jobs", "/v1/jobs/", "/v1/jobs/a/b/c", "//", "/v1//jobs", "/../etc/passwd",
                     "/v1/jobs/..%2f..%2fx", "/v1/scenes/%2e%2e", "/v1/jobs/x%00y", "/v1/comparison",
                     "/v1/jobs/x/flip.png"):
            reply = self.daemon.request("GET", path)
            self.assertEqual(reply.status, 404, path)
            self.assertEqual(reply.json["code"], "not_found")
        for method, path, allow in (("PUT", "/v1/jobs", "GET, HEAD, POST"), ("POST", "/healthz", "GET, HEAD"),
                                    ("PUT", "/v1/jobs/x", "DELETE, GET, HEAD, PATCH"), ("GET", "/v1/jobs/x/retry", "POST"),
                                    ("TRACE", "/", "GET, HEAD")):
            reply = self.daemon.request(method, path)
            self.assertEqual((reply.status, reply.headers["allow"]), (405, allow))
        self.assertEqual(self.daemon.request("GET", "/v1/jobs?limt=3").json["errors"][0]["pointer"], "/limt")
        self.assertIn("limit", self.daemon.request("GET", "/v1/jobs?limt=3").json["errors"][0]["detail"])

    # --- many clients ---------------------------------------------------------------------------------------------

    def test_streams_idle_connections_and_slow_heads_hold_no_thread(self):
        with contextlib.ExitStack() as clients:
            def opened(data):
                client = clients.enter_context(RawClient(self.daemon))
                client.send(data)
                return client
            streams = [opened(get("/v1/events")) for _ in range(300)]
            for stream in streams:
                self.assertEqual(stream.read_head()[0], 200)
            for _ in range(300):
                self.assertEqual(opened(get()).read_answer()[0], 200)  # and left open
            for _ in range(300):
                opened(b"GET /healthz HTTP/1.1\r\nHost: local")
            for _ in range(100):  # bodies that never come
                opened(b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
                       b"Content-Length: 100\r\n\r\n{")
                opened(b"POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Type: model/gltf-binary\r\n"
                       b"Content-Length: 100\r\n\r\ng")
            for path in ("/healthz", "/v1/jobs", "/v1/methods", self.image):
                self.assertEqual(self.daemon.request("GET", path).status, 200)

    def test_a_thousand_simultaneous_connects_are_all_served(self):
        with contextlib.ExitStack() as clients:
            sockets = []
            for _ in range(1000):
                client = clients.enter_context(socket.socket())
                client.setblocking(False)
                client.connect_ex((self.daemon.address, self.daemon.port))
                sockets.append(client)
            served = 0
            for client in sockets:
                client.setblocking(True)
                client.sendall(get())
            for client in sockets:
                served += client.recv(1 << 16).startswith(b"HTTP/1.1 200")
            self.assertEqual(served, 1000)


class LimitsTest(unittest.TestCase):
    def test_connections_beyond_the_limit_are_told_so(self):
        with Daemon("--max-connections", "20") as daemon, contextlib.ExitStack() as clients:
            daemon.wait_ready()
            held = [clients.enter_context(RawClient(daemon)) for _ in range(20)]
            for client in held:
                client.send(get())
                self.assertEqual(client.read_answer()[0], 200)
            with RawClient(daemon) as one_more:
                status, _, body = one_more.read_answer()
                self.assertEqual(status, 503)
                self.assertIn(b"20 connections", body)
            held[0].socket.close()
            for client in held[1:]:  # they are not disturbed
                client.send(get())
                self.assertEqual(client.read_answer()[0], 200)

            def served():
                with RawClient(daemon) as one_more, contextlib.suppress(ConnectionError):
                    one_more.send(get())
                    return one_more.read_answer()[0] == 200
            daemon.wait_until(served, "the closed one's place is free")  # it is once the daemon has seen it

    def test_the_rate_limit_knows_clients_by_their_real_address(self):
        with Daemon("--max-rate", "0.5") as daemon:
            replies = [daemon.request("GET", "/v1/methods", headers={"REMOTE_ADDR": f"10.0.0.{i}",
                                                                     "X-Forwarded-For": f"10.1.0.{i}"})
                       for i in range(3)]
            self.assertEqual(replies[0].status, 200)
            for reply in replies[1:]:
                self.assertEqual(reply.status, 429)
                self.assertEqual(reply.json["code"], "too_many_requests")
                self.assertIn(reply.headers["retry-after"], ("1", "2"))
            self.assertEqual(daemon.request("GET", "/healthz").status, 200)


if __name__ == "__main__":
    unittest.main()
