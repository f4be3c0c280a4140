"""Whose word about the vehicle counts."""

from types import SimpleNamespace

from ross_payload.trusted_autopilot import TrustedAutopilot


def received(system=1, component=1, role="autopilot"):
    return SimpleNamespace(role=role, packet=SimpleNamespace(system_id=system, component_id=component))


def test_component_1_counts_and_no_other():
    assert TrustedAutopilot().sent(received())
    assert not TrustedAutopilot().sent(received(component=154))


def test_a_link_of_another_role_tells_nothing_of_the_vehicle():
    autopilot = TrustedAutopilot()
    assert not autopilot.sent(received(system=7, role="ground"))
    assert autopilot.sent(received(system=3)), "nor does it choose the system"


def test_the_first_autopilot_is_the_vehicle_and_keeps_it():
    autopilot = TrustedAutopilot()
    assert [autopilot.sent(received(system)) for system in (3, 4, 3)] == [True, False, True]
    assert autopilot.system_id == 3


def test_a_configured_system_is_the_only_one():
    assert [TrustedAutopilot(4).sent(received(system)) for system in (3, 4)] == [False, True]
