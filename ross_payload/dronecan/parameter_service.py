"""The settings that may change in flight, as parameters of our node: the same table, limits and file as for MAVLink."""

from __future__ import annotations

import logging
from collections.abc import Callable

from ross_payload.config.parameter_store import Parameters
from ross_payload.config.parameter_table import TABLE, Parameter
from ross_payload.dronecan.node import Node
from ross_payload.errors import ConfigError
from ross_protocols.dronecan import params

NAMES = tuple(TABLE)
log = logging.getLogger(__name__)


class ParameterService:
    """Answers what is asked of our node about parameters.

    Parameters
    ----------
    node
        Ours.
    parameters
        What is in force, and keeps what is set.
    changed
        Is told the name and the value of everything that is set.
    may_set
        Whether anything can be set; else it can only be read.
    """

    def __init__(
        self, node: Node, parameters: Parameters, changed: Callable[[str, float], None], *, may_set: bool
    ) -> None:
        self._parameters = parameters
        self._changed = changed
        self._may_set = may_set
        self._last_warning = ""
        node.serve(params.GetSetRequest, self.get_set)
        node.serve(params.OpcodeRequest, self.execute)

    def get_set(self, request: params.GetSetRequest) -> params.GetSetResponse:
        """Set a value when there is one and it is allowed; return which one is in force."""
        name = request.name or (NAMES[request.index] if request.index < len(NAMES) else "")
        if name not in TABLE:
            return params.GetSetResponse()
        if isinstance(request.value, (bool, int, float)):
            self._set(name, float(request.value))
        row = TABLE[name]
        return params.GetSetResponse(
            name=name,
            value=_typed(row, self._parameters.value(name)),
            default=_typed(row, self._parameters.configured(name)),
            maximum=None if _is_switch(row) else _number(row, row.upper),
            minimum=None if _is_switch(row) else _number(row, row.lower),
        )

    def execute(self, request: params.OpcodeRequest) -> params.OpcodeResponse:
        """Erase: what the configuration says is in force again. Save: what is set is in a file at once, without it."""
        if request.opcode == params.Opcode.ERASE and self._may_set:
            return params.OpcodeResponse(self._erase())
        return params.OpcodeResponse(request.opcode == params.Opcode.SAVE and not self._parameters.trouble)

    def _erase(self) -> bool:
        """Set everything back, in an order in which each step is allowed."""
        left = [name for name in NAMES if self._parameters.value(name) != self._parameters.configured(name)]
        while left:
            refused = [name for name in left if not self._set(name, self._parameters.configured(name))]
            if refused == left:
                return False
            left = refused
        return True

    def _set(self, name: str, value: float) -> bool:
        before = self._parameters.value(name)
        if not self._may_set:
            self._warn(f"{name} is not set: dronecan.may_set is false")
            return False
        try:
            self._parameters.set(name, value)
        except ConfigError as error:
            self._warn(str(error))
            return False
        if self._parameters.value(name) != before:
            self._changed(name, self._parameters.value(name))
        return True

    def _warn(self, text: str) -> None:
        """Log a line, but not the same one over and over."""
        if text != self._last_warning:
            log.warning("DroneCAN: %s", text)
        self._last_warning = text


def _is_switch(row: Parameter) -> bool:
    return row.whole and (row.lower, row.upper) == (0, 1)


def _typed(row: Parameter, value: float) -> params.ParameterValue:
    return bool(value) if _is_switch(row) else _number(row, value)


def _number(row: Parameter, value: float) -> int | float:
    return int(value) if row.whole else float(value)
