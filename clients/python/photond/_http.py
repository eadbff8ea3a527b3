"""Exchanges with the daemon: bearer token, repeats after 429, 503 and lost connections, problems turned into
exceptions. The same rules as photonctl's (clients/cli/daemon_client.h)."""

from __future__ import annotations

import http.client
import json
import os
import random
import selectors
import socket
import ssl
import threading
import time
import urllib.parse
from typing import Any, Callable, Dict, Iterator, List, Mapping, NamedTuple, NoReturn, Optional, Protocol, Union

from ._version import __version__
from .errors import ProtocolError, Unreachable, refusal

FIRST_PAUSE_SECONDS = 0.2
LONGEST_PAUSE_SECONDS = 5.0
CHUNK_BYTES = 1 << 18

Query = Mapping[str, Union[None, bool, int, float, str]]


class Body(Protocol):
    """What is sent; `chunks` begins anew each time it is called, so that it can be sent again. It raises no OSError:
    those are the connection's."""

    content_type: str
    size_bytes: int

    def chunks(self) -> Iterator[bytes]: ...


class BytesBody:
    def __init__(self, data: bytes, content_type: str) -> None:
        self._data = data
        self.content_type = content_type
        self.size_bytes = len(data)

    def chunks(self) -> Iterator[bytes]:
        yield self._data


def json_body(value: Any) -> BytesBody:
    return BytesBody(json.dumps(value).encode(), "application/json")


class Sink(Protocol):
    """Where a 200's body goes; `restart` before each try."""

    def restart(self) -> None: ...

    def write(self, data: bytes) -> None: ...


class Reply(NamedTuple):
    status: int
    headers: Mapping[str, str]  # lower-case names
    body: bytes

    def json(self) -> Any:
        if not self.body:
            return None
        try:
            return json.loads(self.body)
        except ValueError:
            shown = self.body[:200].decode("utf-8", "replace")
            raise ProtocolError(f"the answer is not JSON: is this a photond daemon? It says {shown!r}") from None


class _CannotConnect(Exception):
    pass


class ConnectionLost(Exception):
    """Broken off after it stood: what was asked may have been carried out."""


class _Server:
    """scheme, host, port and path of the daemon's address."""

    def __init__(self, url: str) -> None:
        parts = urllib.parse.urlsplit(url)
        try:
            port = parts.port
        except ValueError:
            raise ValueError(f"the server's address {url!r} has no usable port") from None
        if parts.scheme not in ("http", "https"):
            raise ValueError(f"the server's address {url!r} is not an http:// or https:// URL, "
                             "as http://127.0.0.1:8080 is")
        if not parts.hostname or parts.query or parts.fragment or parts.username is not None or " " in url:
            raise ValueError(f"the server's address {url!r} must be scheme, host, port and path only")
        self.tls = parts.scheme == "https"
        self.host = parts.hostname
        self.port = port or (443 if self.tls else 80)
        self.base_path = parts.path.rstrip("/")
        self.origin = f"{parts.scheme}://{parts.netloc}"


class _Connection:
    """One connection, kept open between exchanges where the server allows it."""

    def __init__(self, server: _Server, connect_timeout: float, tls: Optional[ssl.SSLContext]) -> None:
        self._origin = server.origin
        if server.tls:
            self._http: http.client.HTTPConnection = http.client.HTTPSConnection(
                server.host, server.port, timeout=connect_timeout, context=tls)
        else:
            self._http = http.client.HTTPConnection(server.host, server.port, timeout=connect_timeout)
        self.socket: Optional[socket.socket] = None

    def connect(self, stall_timeout: float) -> None:
        try:
            self._http.connect()
        except ssl.SSLError as error:
            raise _CannotConnect(f"no trusted TLS connection to {self._origin}: {error}") from error
        except socket.timeout as error:
            raise _CannotConnect(f"{self._origin} did not accept a connection in time") from error
        except OSError as error:
            raise _CannotConnect(f"cannot connect to {self._origin}: {error.strerror or error}") from error
        self.socket = self._http.sock
        self.socket.settimeout(stall_timeout)

    def send(self, method: str, path: str, headers: Mapping[str, str], body: Optional[Body]) -> http.client.HTTPResponse:
        """The head of the answer."""
        try:
            self._http.putrequest(method, path, skip_accept_encoding=True)
            for name, value in headers.items():
                self._http.putheader(name, value)
            if body is not None:
                self._http.putheader("Content-Type", body.content_type)
            if body is not None or method not in ("GET", "DELETE"):
                self._http.putheader("Content-Length", str(body.size_bytes if body else 0))
            failed_to_send: Optional[OSError] = None
            try:
                self._http.endheaders()
                for chunk in body.chunks() if body else ():
                    self._http.send(chunk)
            except OSError as error:  # a server that refuses answers before it has read everything
                failed_to_send = error
            try:
                return self._http.getresponse()
            except (OSError, http.client.HTTPException):
                if failed_to_send:
                    raise failed_to_send
                raise
        except (OSError, http.client.HTTPException) as error:
            self.lost(error)

    def lost(self, error: Exception) -> NoReturn:
        self.close()
        if isinstance(error, socket.timeout):
            what = "fell silent"
        elif isinstance(error, (http.client.RemoteDisconnected, http.client.IncompleteRead, ConnectionError)):
            what = "closed the connection before all of the answer had come"
        else:
            what = f"broke off the exchange ({error})"
        raise ConnectionLost(f"{self._origin} {what}") from error

    def idle_and_open(self) -> bool:
        """Nothing may come on an idle connection: what does is its end."""
        if self.socket is None:
            return False
        with selectors.DefaultSelector() as selector:
            selector.register(self.socket, selectors.EVENT_READ)
            return not selector.select(0)

    def close(self) -> None:
        self._http.close()
        self.socket = None


class Transport:
    """Thread-safe; every thread's exchange has a connection to itself."""

    def __init__(self, url: str, token: str, retry_seconds: float, connect_timeout: float, stall_timeout: float,
                 tls: Optional[ssl.SSLContext]) -> None:
        self._server = _Server(url)
        self.url = url.rstrip("/")
        self._token = token
        self.retry_seconds = retry_seconds
        self._connect_timeout = connect_timeout
        self._stall_timeout = stall_timeout
        self._tls = tls
        self._spoken_to = False  # one reply has come: a refused connection now means a restart
        self._lock = threading.Lock()
        self._idle: List[_Connection] = []
        self._process = os.getpid()

    def close(self) -> None:
        with self._lock:
            for connection in self._idle:
                connection.close()
            self._idle = []

    def __del__(self) -> None:
        for connection in getattr(self, "_idle", []):  # an address that is none: nothing was opened
            connection.close()

    def ask(self, method: str, path: str, *, query: Optional[Query] = None, body: Optional[Body] = None,
            headers: Optional[Mapping[str, str]] = None, safe: bool = True, sink: Optional[Sink] = None) -> Reply:
        """Any 2xx reply. Repeats 429 and 503 after the Retry-After they name (else 0.2 s doubling to 5 s, jittered),
        lost connections where it is `safe`, and refused ones once the daemon has been spoken to; all within
        `retry_seconds`. Raises Refused or Unreachable."""
        target = path + query_text(query)
        give_up = time.monotonic() + self.retry_seconds
        pauses = _Pauses()

        def pause_or_give_up(asked_for: float) -> bool:
            pause = max(asked_for, pauses.next())
            if time.monotonic() + pause > give_up:
                return False
            time.sleep(pause)
            return True

        while True:
            try:
                reply = self._exchange(method, target, headers or {}, body, safe, sink)
            except _CannotConnect as error:
                if self._spoken_to and pause_or_give_up(0):
                    continue
                raise Unreachable(f"{error}. Is the daemon running there? Start it with deploy/quickstart or `photond "
                                  "--data DIR`; PHOTOND_URL or Client(url=...) names another") from error
            except ConnectionLost as error:
                if safe and pause_or_give_up(0):
                    continue
                doubt = "" if safe else f"; {method} {path} may have been carried out, and was not repeated"
                raise Unreachable(f"{error}{doubt}") from error
            self._spoken_to = True
            if 200 <= reply.status < 300:
                return reply
            if reply.status in (429, 503) and pause_or_give_up(_retry_after(reply)):
                continue
            raise refusal(_problem(reply), reply.status, f"{method} {path}")

    def stream(self, path: str, headers: Mapping[str, str], silence_timeout: float) -> Optional["Stream"]:
        """An open event stream; None where the answer is none. Raises ConnectionLost."""
        connection = _Connection(self._server, self._connect_timeout, self._tls)
        try:
            connection.connect(silence_timeout)
        except _CannotConnect as error:
            raise ConnectionLost(str(error)) from error
        response = connection.send("GET", self._server.base_path + path,
                                   {**self._common_headers(), "Accept": "text/event-stream", **headers}, None)
        if response.status != 200:
            connection.close()
            return None
        return Stream(connection, response)

    def _common_headers(self) -> Dict[str, str]:
        headers = {"User-Agent": f"photond-python/{__version__}"}
        if self._token:
            headers["Authorization"] = f"Bearer {self._token}"
        return headers

    def _exchange(self, method: str, target: str, headers: Mapping[str, str], body: Optional[Body], safe: bool,
                  sink: Optional[Sink]) -> Reply:
        # A kept connection may end just as it is used; where that would leave in doubt what was done, a fresh one goes.
        connection = self._take() if safe else self._fresh()
        kept = False
        try:
            response = connection.send(method, self._server.base_path + target, {**self._common_headers(), **headers}, body)
            try:
                if sink is not None and response.status in (200, 206):
                    sink.restart()
                    _copy(response, sink.write)
                    data = b""
                else:
                    data = response.read()
            except (http.client.HTTPException, ConnectionError, socket.timeout) as error:
                connection.lost(error)
            kept = not response.will_close
            return Reply(response.status, {name.lower(): value for name, value in response.getheaders()}, data)
        finally:
            if kept:
                self._give(connection)
            else:
                connection.close()

    def _fresh(self) -> _Connection:
        connection = _Connection(self._server, self._connect_timeout, self._tls)
        connection.connect(self._stall_timeout)
        return connection

    def _take(self) -> _Connection:
        with self._lock:
            if self._process != os.getpid():  # after a fork the connections are the parent's
                self._idle, self._process = [], os.getpid()
            while self._idle:
                connection = self._idle.pop()
                if connection.idle_and_open():
                    return connection
                connection.close()
        return self._fresh()

    def _give(self, connection: _Connection) -> None:
        with self._lock:
            self._idle.append(connection)


class Stream:
    """The bytes of an event stream as they come."""

    def __init__(self, connection: _Connection, response: http.client.HTTPResponse) -> None:
        self._connection = connection
        self._response = response
        assert connection.socket is not None
        self._socket = connection.socket

    def read(self, timeout: float) -> bytes:
        """What has come, empty at the end. Raises ConnectionLost, also when nothing came for `timeout`."""
        self._socket.settimeout(max(timeout, 1e-3))
        try:
            return self._response.read1(CHUNK_BYTES)
        except (OSError, http.client.HTTPException) as error:
            self._connection.lost(error)

    def close(self) -> None:
        self._response.close()
        self._connection.close()


class _Pauses:
    """Doubling pauses, each between half and all of its length, so that clients turned away together do not return
    together."""

    def __init__(self) -> None:
        self._length = FIRST_PAUSE_SECONDS

    def next(self) -> float:
        pause = self._length * random.uniform(0.5, 1)
        self._length = min(2 * self._length, LONGEST_PAUSE_SECONDS)
        return pause


def _copy(response: http.client.HTTPResponse, write: Callable[[bytes], None]) -> None:
    expected = response.length
    received = 0
    while True:
        piece = response.read(CHUNK_BYTES)
        if not piece:
            break
        received += len(piece)
        write(piece)
    if expected is not None and received < expected:  # read(n) does not tell an early end
        raise http.client.IncompleteRead(b"", expected - received)


def _retry_after(reply: Reply) -> float:
    """In whole seconds; the form with a date is not used by the daemon."""
    text = reply.headers.get("retry-after", "")
    return float(text) if text.isdigit() else 0.0


def _problem(reply: Reply) -> Dict[str, Any]:
    try:
        problem = json.loads(reply.body)
    except ValueError:
        problem = None
    if isinstance(problem, dict):
        return problem
    text = reply.body[:300].decode("utf-8", "replace")
    return {"title": f"HTTP {reply.status}", "status": reply.status, "detail": text}


def query_text(query: Optional[Query]) -> str:
    """
    >>> query_text({"layer": "beauty", "purge": True, "curve": None})
    '?layer=beauty&purge=true'
    """
    given = {name: ("true" if value else "false") if isinstance(value, bool) else str(value)
             for name, value in (query or {}).items() if value is not None}
    return "?" + urllib.parse.urlencode(given, quote_via=urllib.parse.quote) if given else ""


def resource_path(kind: str, name: str) -> str:
    """"/v1/KIND/NAME" with the name encoded."""
    return f"/v1/{kind}/{urllib.parse.quote(name, safe='')}"
