"""A daemon spoken to by paths and JSON: what scenes, jobs and comparisons need of a client."""

from __future__ import annotations

import os
import ssl
from typing import Any, Iterator, Mapping, Optional, cast

from ._files import OutputFile, Path
from ._http import Body, Query, Reply, Stream, Transport, json_body
from .errors import NothingYet
from .shapes import Json

DEFAULT_URL = "http://127.0.0.1:8080"
MOST_ITEMS = 1000  # the greatest `limit` of a page


class Daemon:
    """The base of Client, which has the routes and says what the arguments mean."""

    def __init__(self, url: Optional[str] = None, token: Optional[str] = None, *, token_file: Optional[Path] = None,
                 retry_seconds: float = 30, connect_timeout: float = 10, stall_timeout: float = 180,
                 tls: Optional[ssl.SSLContext] = None) -> None:
        if token_file is not None:
            with open(token_file, encoding="utf-8") as file:
                words = file.read().split()
            if not words:
                raise ValueError(f"there is no token in {token_file}")
            token = words[0]
        if token is None:
            token = os.environ.get("PHOTOND_TOKEN", "").strip()
        self._transport = Transport(url or os.environ.get("PHOTOND_URL") or DEFAULT_URL, token, retry_seconds,
                                    connect_timeout, stall_timeout, tls)

    @property
    def url(self) -> str:
        return self._transport.url

    def close(self) -> None:
        """Closes kept connections; the client opens new ones when it is used again."""
        self._transport.close()

    def get(self, path: str, query: Optional[Query] = None) -> Json:
        """The JSON at a path, as client.get("/v1/openapi.json")."""
        return cast(Json, self._transport.ask("GET", path, query=query).json())

    def send(self, method: str, path: str, body: Any = None, *, query: Optional[Query] = None,
             headers: Optional[Mapping[str, str]] = None, safe: bool = True) -> Json:
        """JSON there and back. Not `safe`: not repeated where it may have been carried out."""
        sent: Optional[Body] = None if body is None else json_body(body)
        return cast(Json, self._transport.ask(method, path, query=query, body=sent, headers=headers, safe=safe).json())

    def reply(self, path: str, query: Optional[Query] = None) -> Reply:
        """A file with its headers. Raises NothingYet for 202."""
        reply = self._transport.ask("GET", path, query=query)
        if reply.status == 202:
            raise NothingYet(f"there is nothing at {path} yet: no pass is done")
        return reply

    def download(self, path: str, file: Optional[Path] = None, query: Optional[Query] = None) -> bytes:
        """A file; saved whole or not at all where `file` is given, else returned. Raises NothingYet for 202."""
        if file is None:
            return self.reply(path, query).body
        with OutputFile(file) as output:
            reply = self._transport.ask("GET", path, query=query, sink=output)
            if reply.status == 202:
                raise NothingYet(f"there is nothing to save as {file} yet: no pass is done")
            output.publish()
        return b""

    def items(self, path: str, query: Optional[Query] = None, limit: Optional[int] = None) -> Iterator[Json]:
        """What a list holds, over as many pages as that takes."""
        left = limit
        cursor: Optional[str] = None
        while left is None or left > 0:
            page = MOST_ITEMS if left is None else min(MOST_ITEMS, left)
            reply = self.get(path, {**(query or {}), "limit": page, "cursor": cursor})
            yield from reply["items"]
            cursor = reply.get("next_cursor")
            if not cursor:
                return
            if left is not None:
                left -= len(reply["items"])

    def event_stream(self, path: str, headers: Mapping[str, str], silence_timeout: float) -> Optional[Stream]:
        return self._transport.stream(path, headers, silence_timeout)

    def send_file(self, path: str, file: Body, query: Optional[Query] = None) -> Json:
        """A file there, JSON back."""
        return cast(Json, self._transport.ask("POST", path, query=query, body=file).json())
