"""Server-sent events."""

from __future__ import annotations

from typing import List, NamedTuple


class ServerEvent(NamedTuple):
    kind: str
    id: str  # empty: this event moved none
    data: str


class EventParser:
    """Bytes in, events out. Across connections it keeps nothing but the last id.

    >>> parser = EventParser()
    >>> parser.feed(b"event: state\\nid: 7\\nda")
    []
    >>> parser.feed(b"ta: {}\\n\\n")
    [ServerEvent(kind='state', id='7', data='{}')]
    >>> parser.last_event_id
    '7'
    """

    def __init__(self) -> None:
        self.last_event_id = ""
        self._rest = b""
        self._begin()

    def _begin(self) -> None:
        self._kind, self._id, self._data = "", "", ""

    def reconnect(self) -> None:
        self._rest = b""
        self._begin()

    def feed(self, data: bytes) -> List[ServerEvent]:
        self._rest += data
        # A carriage return at the end may be half of a line's end.
        held = b"\r" if self._rest.endswith(b"\r") else b""
        text = self._rest[:len(self._rest) - len(held)].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        lines = text.split(b"\n")
        self._rest = lines.pop() + held
        events: List[ServerEvent] = []
        for line in lines:
            self._take(line.decode("utf-8", "replace"), events)
        return events

    def _take(self, line: str, events: List[ServerEvent]) -> None:
        if not line:
            if self._data:
                events.append(ServerEvent(self._kind or "message", self._id, self._data[:-1]))
            self._begin()
            return
        field, _, value = line.partition(":")
        if value.startswith(" "):
            value = value[1:]
        if field == "event":
            self._kind = value
        elif field == "data":
            self._data += value + "\n"
        elif field == "id":
            self.last_event_id = self._id = value
