"""How far something is that is waited for, shown in one place: in a notebook a bar that is updated, at a terminal one line
that is written over, elsewhere a line at each tenth of the way.
"""

from __future__ import annotations

import html
import sys
from typing import Any, Callable, Optional, TypeVar, Union, cast

from ._optional import needed
from .work import Work

W = TypeVar("W", bound=Work)
#: What `wait` and `render` take: True and False, a function that is called with what is waited for at each change, or None:
#: shown in a notebook and nowhere else.
Progress = Union[None, bool, Callable[[W], object]]

STEP = 0.1  # of the whole, between two lines of text


def shown(progress: "Progress[W]") -> "Optional[Callable[[W], object]]":
    """What is to be called at each change; None where nothing is to be shown."""
    if callable(progress):
        return progress
    display = _notebook_display()
    if progress is None and display is None or progress is False:
        return None
    if display is not None:
        return _Bar(display)
    return _Line() if sys.stderr.isatty() else _Lines()


def _notebook_display() -> Optional[Callable[..., Any]]:
    """IPython's, where somebody looks at a notebook and not at a terminal."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None and hasattr(ipython, "get_ipython") else None
    if shell is None or not hasattr(shell, "kernel"):
        return None
    return cast(Callable[..., Any], needed("IPython.display", "progress in a notebook").display)


class _Picture:
    """One look at the work: a bar where HTML is shown, else its text."""

    def __init__(self, work: Work) -> None:
        self.text = work.describe()
        self.share = 1.0 if work.is_over else work.progress

    def __repr__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return f'<progress max="1" value="{self.share:.3f}"></progress> {html.escape(self.text)}'


class _Bar:
    def __init__(self, display: Callable[..., Any]) -> None:
        self._display = display
        self._handle: Any = None

    def __call__(self, work: Work) -> None:
        if self._handle is None:
            self._handle = self._display(_Picture(work), display_id=True)
        else:
            self._handle.update(_Picture(work))


class _Line:
    def __init__(self) -> None:
        self._length = 0

    def __call__(self, work: Work) -> None:
        text = work.describe()
        sys.stderr.write("\r" + text.ljust(self._length) + ("\n" if work.is_over else ""))
        sys.stderr.flush()
        self._length = len(text)


class _Lines:
    def __init__(self) -> None:
        self._state = ""
        self._share = 0.0

    def __call__(self, work: Work) -> None:
        if work.state == self._state and work.progress < self._share + STEP:
            return
        self._state, self._share = work.state, work.progress
        print(work.describe(), file=sys.stderr, flush=True)
