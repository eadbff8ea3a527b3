"""The methods a daemon has, and their parameters as it declares them."""

from __future__ import annotations

import difflib
from typing import Any, Dict, Iterator, List, Mapping, Optional

from ._daemon import Daemon
from ._text import TextTable, human_number
from .errors import PhotondError
from .shapes import JobMethod, Json


class UnknownName(PhotondError, KeyError):
    """A method or parameter the daemon does not have; the message names the nearest one."""

    def __str__(self) -> str:  # KeyError's own shows the repr
        return str(self.args[0])


def _unknown(what: str, name: str, known: List[str]) -> UnknownName:
    near = difflib.get_close_matches(name, known, 1)
    return UnknownName(f"{what} {name!r}" + (f"; did you mean {near[0]!r}?" if near else "; there is " + ", ".join(known)))


class Parameter:
    """One parameter of a method: `name`, `kind`, `unit`, `default`, `minimum`, `maximum`, `choices`, `text`."""

    def __init__(self, name: str, schema: Mapping[str, Any]) -> None:
        self.name = name
        self.schema = dict(schema)
        types = schema.get("type", [])
        kinds = [types] if isinstance(types, str) else list(types)
        #: boolean, integer, number or string
        self.kind: str = next((kind for kind in kinds if kind != "null"), "string")
        self.nullable = "null" in kinds
        self.unit: str = schema.get("x-unit", "")
        #: Title of the group that forms show it in.
        self.group: str = schema.get("x-group", "")
        self.default: Any = schema.get("default")
        self.minimum: Optional[float] = schema.get("minimum")
        self.maximum: Optional[float] = schema.get("maximum")
        self.choices: List[Any] = [choice for choice in schema.get("enum", []) if choice is not None]
        self.text: str = schema.get("description", "")

    @property
    def range_text(self) -> str:
        if self.choices:
            return ", ".join(map(str, self.choices))
        if self.kind == "boolean":
            return "true, false"
        low, high = self.minimum, self.maximum
        if low is not None and high is not None:
            return f"{human_number(low)} to {human_number(high)}"
        if low is not None:
            return f"at least {human_number(low)}"
        return f"at most {human_number(high)}" if high is not None else ""

    def __repr__(self) -> str:
        return f"<Parameter {self.name} = {human_number(self.default)}{' ' + self.unit if self.unit else ''}: {self.text}>"


class Method:
    """One method. Printed, it is its page of help; called, it makes a choice of parameters for a request, whose names are
    checked at once (values the daemon judges).

    >>> method = client.methods["photon_mapping"]
    >>> method.title
    'Photon mapping'
    >>> method.parameters["photons"].unit, method.parameters["gather"].choices
    ('photons', ['direct', 'final'])
    >>> method(photons=5000, gather="direct")
    {'name': 'photon_mapping', 'parameters': {'photons': 5000, 'gather': 'direct'}}
    >>> method(photon=5000)
    Traceback (most recent call last):
        ...
    photond.methods.UnknownName: photon_mapping has no parameter 'photon'; did you mean 'photons'?
    """

    def __init__(self, data: Json) -> None:
        self.data = data
        self.name: str = data["name"]
        self.title: str = data["title"]
        #: What it does, where it is good and where it is not.
        self.line: str = data.get("line", "")
        self.family: str = data["family"]
        #: Kinds it runs on: cpu, gpu.
        self.devices: List[str] = data["devices"]
        #: Layers it can fill on request.
        self.layers: List[str] = data.get("layers", [])
        self.sources: List[str] = data.get("sources", [])
        self.mergeable: bool = data["mergeable"]
        schema = data["parameters"]
        order = schema.get("x-order", [])
        properties: Mapping[str, Any] = schema.get("properties", {})
        names = sorted(properties, key=lambda name: order.index(name) if name in order else len(order))
        self.parameters: Dict[str, Parameter] = {name: Parameter(name, properties[name]) for name in names}

    def __call__(self, *, device: Optional[str] = None, **parameters: Any) -> JobMethod:
        for name in parameters:
            if name not in self.parameters:
                raise _unknown(f"{self.name} has no parameter", name, list(self.parameters))
        choice: JobMethod = {"name": self.name}
        if device is not None:
            choice["device"] = device
        if parameters:
            choice["parameters"] = parameters
        return choice

    def _table(self) -> TextTable:
        table = TextTable(["parameter", ">default", "unit", "range", ""])
        for parameter in self.parameters.values():
            table.add([parameter.name, human_number(parameter.default), parameter.unit, parameter.range_text,
                       parameter.text])
        return table

    def __str__(self) -> str:
        lines = [f"{self.title} ({self.name}): {self.family}", *([self.line] if self.line else []), f"devices: {', '.join(self.devices)}"]
        if self.layers:
            lines.append(f"layers on request: {', '.join(self.layers)}")
        lines += self.sources
        return "\n".join([*lines, "", str(self._table())])

    def __repr__(self) -> str:
        return f"<Method {self.name}: {len(self.parameters)} parameters, on {', '.join(self.devices)}>"

    def _repr_html_(self) -> str:
        return self._table().html(f"{self.title} ({self.name}), on {', '.join(self.devices)}")


class Methods(Mapping[str, Method]):
    """By name, asked of the daemon when first needed.

    >>> "path_tracing" in client.methods
    True
    >>> client.methods["path_trcing"]
    Traceback (most recent call last):
        ...
    photond.methods.UnknownName: the daemon has no method 'path_trcing'; did you mean 'path_tracing'?
    """

    def __init__(self, client: Daemon) -> None:
        self._client = client
        self._known: Optional[Dict[str, Method]] = None

    def _all(self) -> Dict[str, Method]:
        if self._known is None:
            self._known = {item["name"]: Method(item) for item in self._client.items("/v1/methods")}
        return self._known

    def refresh(self) -> None:
        """Forgets what was asked before, for a daemon that was replaced."""
        self._known = None

    def __getitem__(self, name: str) -> Method:
        try:
            return self._all()[name]
        except KeyError:
            raise _unknown("the daemon has no method", name, list(self._all())) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())

    def _table(self) -> TextTable:
        table = TextTable(["method", "devices", "title"])
        for method in self.values():
            table.add([method.name, ", ".join(method.devices), method.title])
        return table

    def __str__(self) -> str:
        return str(self._table())

    def __repr__(self) -> str:
        return f"<Methods {', '.join(self)}>"

    def _repr_html_(self) -> str:
        return self._table().html()
