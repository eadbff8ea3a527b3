"""A proxy before a daemon that breaks connections, to hold clients to what they promise about repeats.

    with BadWeather("http://127.0.0.1:8080", [("POST", "^/v1/jobs$", "drop")]) as proxy:
        ...                                        # the client talks to proxy.url
        proxy.seen                                 # [(method, path, headers), ...]
        proxy.faults                               # those that were not met
"""

import http.server
import re
import socket
import struct
import threading
import urllib.error
import urllib.request


class BadWeather(http.server.ThreadingHTTPServer):
    """`faults`: list of (method, path's pattern, what), each used once, what being a status ("429", "503", "404",
    with Retry-After), "drop" (carried out, answer lost), "half" (half of the answer's body, then the end) or "cut" (the
    first event, then the end). `upstream` may change: the daemon was started anew. `port` 0 picks a free one."""

    def __init__(self, upstream, faults, port=0):
        super().__init__(("127.0.0.1", port), Forwarder)
        self.upstream = upstream
        self.faults = list(faults)
        self.lock = threading.Lock()
        self.seen = []  # (method, path, headers)

    @property
    def url(self):
        return f"http://127.0.0.1:{self.server_port}"

    def streams(self):
        """The headers of what asked for an event stream."""
        return [headers for _, path, headers in list(self.seen) if path.endswith("/events")]

    def has_seen(self, streams, then=0):
        """Whether event streams were asked for that often, and `then` times for something else after the last."""
        asked = [path.endswith("/events") for _, path, _ in list(self.seen)]
        return sum(asked) >= streams and asked[::-1].index(True) >= then

    def fault_for(self, method, path):
        with self.lock:
            for fault in self.faults:
                if fault[0] == method and re.search(fault[1], path):
                    self.faults.remove(fault)
                    return fault[2]
        return None

    def __enter__(self):
        threading.Thread(target=self.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_):
        self.shutdown()
        self.server_close()


class Forwarder(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.0"  # one request a connection

    def log_message(self, *_):
        pass

    def forward(self):
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self.server.seen.append((self.command, self.path, dict(self.headers)))
        fault = self.server.fault_for(self.command, self.path)
        if fault in ("503", "429", "404"):
            self.send_response(int(fault))
            self.send_header("Retry-After", "1")
            self.end_headers()
            return
        headers = {k: v for k, v in self.headers.items() if k not in ("Host", "Connection")}
        upstream = urllib.request.Request(self.server.upstream + self.path, data=body or None, headers=headers,
                                          method=self.command)
        try:
            reply = urllib.request.urlopen(upstream)
        except urllib.error.HTTPError as refusal:
            reply = refusal
        except OSError:  # the daemon is away, or went
            return self.abort()
        with reply:
            if fault == "drop":
                reply.read()
                return self.abort()
            self.send_response(reply.status)
            for name, value in reply.headers.items():
                if name.lower() not in ("connection", "transfer-encoding", "date", "server"):
                    self.send_header(name, value)
            self.end_headers()
            if fault == "half":
                whole = reply.read()
                self.wfile.write(whole[:len(whole) // 2])
                return
            self.stream(reply, fault)

    def stream(self, reply, fault):
        while True:
            try:
                piece = reply.read1(65536)
                self.wfile.write(piece)
            except OSError:
                return
            if not piece or (fault == "cut" and b"data:" in piece):
                return

    def abort(self):
        """Ends the connection without an answer."""
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.close_connection = True
        self.connection.shutdown(socket.SHUT_RDWR)

    do_GET = do_POST = do_DELETE = do_PATCH = forward
