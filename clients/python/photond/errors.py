"""What can go wrong, one class a kind. All are `PhotondError`. What tells of a job or a comparison lies beside that.

What the daemon refuses carries its problem document with every fault and the place of each:

>>> try:
...     client.submit("cornell-box", width=0, height=8, passes=1, filter="bx")
... except photond.Invalid as refusal:
...     for fault in sorted(refusal.faults):
...         print(fault.pointer, "-", fault.detail)
/image/filter - "bx" is not one of "box", "gaussian", "blackman_harris" (did you mean "box"?)
/image/width - 0 is outside [1, 65536]
"""

from __future__ import annotations

from typing import Any, Dict, Mapping, NamedTuple, Optional, Tuple, Type, cast

from .shapes import Problem


class Fault(NamedTuple):
    """One thing that is wrong, and where: a JSON pointer into the request or the glTF, empty for the whole. Of which kind
    it is says `code`, such as "out_of_range"; it is empty in what older daemons kept."""

    pointer: str
    detail: str
    code: str = ""

    def __str__(self) -> str:
        return f"{self.pointer}: {self.detail}" if self.pointer else self.detail


class PhotondError(Exception):
    """Whatever this package raises of its own."""


class Unreachable(PhotondError, ConnectionError):
    """No daemon answers, or it was lost for longer than is retried."""


class TimedOut(PhotondError, TimeoutError):
    """A `timeout` passed; what was waited for goes on."""


class ProtocolError(PhotondError):
    """What answers does not speak photond's protocol."""


class NothingYet(PhotondError):
    """There is no film yet: no pass is done."""


class BadFile(PhotondError, ValueError):
    """A file cannot be sent; nothing was."""


class MissingPackage(PhotondError, ImportError):
    """An optional package is needed for this and not installed."""


class WithProblem(PhotondError):
    def __init__(self, message: str, problem: Mapping[str, Any]) -> None:
        self.problem = cast(Problem, dict(problem))
        errors = problem.get("errors")
        self.faults: Tuple[Fault, ...] = tuple(
            Fault(str(error.get("pointer", "")), str(error.get("detail", "")), str(error.get("code", "")))
            for error in (errors if isinstance(errors, list) else [])
            if isinstance(error, dict)
        )
        lines = [message]
        if len(self.faults) > 1:
            lines += [f"  {fault}" for fault in self.faults]
        elif self.faults and self.faults[0].detail not in message:
            lines.append(f"  {self.faults[0]}")
        elif self.faults and self.faults[0].pointer not in message:
            lines[0] += f" (at {self.faults[0].pointer})"
        super().__init__("\n".join(lines))

    @property
    def code(self) -> str:
        """The problem's kind, as `out_of_range`; empty where the answer was none of photond's."""
        return str(self.problem.get("code", ""))

    @property
    def title(self) -> str:
        return str(self.problem.get("title", ""))

    @property
    def detail(self) -> str:
        return str(self.problem.get("detail", ""))


class Refused(WithProblem):
    """The daemon refused a request. `status`, `code`, `title`, `detail`, `faults`; `problem` is the whole document."""

    def __init__(self, problem: Mapping[str, Any], status: int, asked: str) -> None:
        self.status = status
        title = str(problem.get("title") or f"HTTP {status}")
        detail = str(problem.get("detail") or "")
        errors = problem.get("errors")
        listed = isinstance(errors, list) and len(errors) > 1  # the detail then counts them and tells the first
        says_more = bool(detail) and detail != title and not listed
        super().__init__(f"{asked}: {status} {title}" + (f": {detail}" if says_more else ""), problem)


class BadRequest(Refused):
    """400, 405, 408, 411, 415, 416, 431: malformed, or not what the resource takes."""


class Denied(Refused):
    """401, 403: a token is missing, unknown or may not do this."""


class NotFound(Refused, LookupError):
    """404."""


class WrongState(Refused):
    """409: not in the state it is in."""


class TooLarge(Refused):
    """413: a body over the daemon's limit."""


class Invalid(Refused, ValueError):
    """422: well-formed, with faults; `faults` has them all."""


class Busy(Refused):
    """429, for longer than is retried: the queue is full, or too many requests."""


class Unavailable(Refused):
    """503, for longer than is retried: it starts or stops, or the processors are a job's."""


class NoSpace(Refused):
    """507: the daemon's disk is full."""


class ServerFault(Refused):
    """500 and other failures of the service itself."""


_KINDS: Dict[int, Type[Refused]] = {
    400: BadRequest, 405: BadRequest, 408: BadRequest, 411: BadRequest, 415: BadRequest, 416: BadRequest,
    431: BadRequest, 401: Denied, 403: Denied, 404: NotFound, 409: WrongState, 413: TooLarge, 422: Invalid, 429: Busy,
    503: Unavailable, 507: NoSpace,
}


def refusal(problem: Mapping[str, Any], status: int, asked: str) -> Refused:
    """The exception for an answer that is no 2xx; `asked` as "POST /v1/jobs"."""
    kind = _KINDS.get(status, ServerFault if status >= 500 else Refused)
    return kind(problem, status, asked)
