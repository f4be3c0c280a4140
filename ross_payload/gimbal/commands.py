"""What others command: messages on request, control, and set-points."""

from __future__ import annotations

from ross_payload.errors import ConfigError
from ross_payload.gimbal.control import AWAY, UNCHANGED
from ross_payload.gimbal.rules import Rules
from ross_payload.links import Heard
from ross_payload.telemetry.allowance import Allowance
from ross_payload.telemetry.identity import Endpoint
from ross_payload.telemetry.requests import ACCEPTED, Requests, Verdict
from ross_protocols.commands import CancelRequest, Command, Result, acknowledgement, command_of
from ross_protocols.gimbal import CONFIGURE, Address
from ross_protocols.own_gimbal import PITCHYAW, commanded

BURST, RATE = 40, 20.0  # commands at once, and [1/s]; what is more is not even answered


class Commands:
    """Answers the commands that are meant for the gimbal.

    Parameters
    ----------
    endpoint
        Who we are.
    requests
        Obeys the commands that ask for messages.
    rules
        Judge set-points and control; None: somebody else is the manager.
    device_ids
        That mean our gimbal.
    """

    def __init__(
        self, endpoint: Endpoint, requests: Requests, rules: Rules | None, device_ids: tuple[int, ...]
    ) -> None:
        self._endpoint = endpoint
        self._requests = requests
        self._rules = rules
        self._device_ids = device_ids
        self._allowance = Allowance(BURST, RATE)

    def heard(self, heard: Heard, now: float) -> None:
        """Take a packet; what is no command, or not for us, passes by."""
        request = command_of(heard.packet.message)
        if request is None or not self._endpoint.meant(request.system_id, request.component_id):
            return
        if isinstance(request, CancelRequest) or not self._allowance.take(now):
            return
        who = heard.packet.system_id, heard.packet.component_id
        result = self._obey(request, heard, who, now).result
        if result is Result.ACCEPTED or not request.to_all:  # nobody asked us in particular
            self._endpoint.send(acknowledgement(request.number, result, *who))

    def _obey(self, command: Command, heard: Heard, who: Address, now: float) -> Verdict:
        if not heard.may_order:
            return Verdict(Result.DENIED)
        if self._rules is not None and command.number in (PITCHYAW, CONFIGURE):
            if command.numbers[6] not in self._device_ids:
                return Verdict(Result.DENIED)
            obey = self._point if command.number == PITCHYAW else self._configure
            return obey(self._rules, command, who, now)
        return self._requests.obey(command, heard.link, now) or Verdict(Result.UNSUPPORTED)

    def _point(self, rules: Rules, command: Command, who: Address, now: float) -> Verdict:
        aim = commanded(command)
        return Verdict(Result.DENIED) if aim is None else rules.point(aim, who, now)

    def _configure(self, rules: Rules, command: Command, who: Address, now: float) -> Verdict:
        numbers = command.numbers[:4]
        try:
            control = rules.control.configured(numbers, who)
        except ConfigError as error:
            return Verdict(Result.DENIED, str(error))
        rules.configure(control, who, taken=numbers[0] not in (UNCHANGED, AWAY))
        return ACCEPTED
