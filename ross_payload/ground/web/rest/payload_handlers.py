"""What programs may look at: the ground station, its payloads, and the sections that the page draws of each."""

from __future__ import annotations

from typing import Any, TypeVar

from ross_payload import __version__
from ross_payload.ground.model.view import SECTIONS
from ross_payload.ground.web.overview import overview
from ross_payload.ground.web.rest import page_answers
from ross_payload.ground.web.rest.operation import Call
from ross_payload.ground.web.rest.places import OfPayload
from ross_payload.ground.web.rest.view_answers import Answer
from ross_payload.json_values import finite

Told = TypeVar("Told", bound=Answer)


async def get_station(call: Call) -> page_answers.Station:
    """The ground station: its links, who has control, and what to do when nothing is received."""
    state = call.operator.state
    fields = page_answers.Link.model_fields
    told = {
        "version": __version__,
        "mode": "live" if state.live else "flight",
        "now": state.station.now(),
        "control": call.operator.control(),
        "links": [{name: getattr(each, name) for name in fields} for each in state.station.links()],
        "advice": "" if state.over else state.station.advice(),
        "over": state.over,
        "pace": state.pace,
    }
    return page_answers.Station.model_validate(finite(told))


async def get_payloads(call: Call) -> page_answers.Payloads:
    """All payloads that are received, where they stand, and where their bearings intersect.

    At most 64 are listed: those that are watched or were commanded, and those received most steadily.
    """
    state = call.operator.state
    told = overview(state.station.fleet, (), state.positions, state.station.now())
    return page_answers.Payloads.model_validate(
        finite({name: told[name] for name in page_answers.Payloads.model_fields})
    )


async def get_payload(call: Call, where: OfPayload) -> page_answers.PayloadState:
    """What a payload does, where it points, how far its mission is, and how it is."""
    return _told(call, where, page_answers.PayloadState, "standing", "pointing", "mission", "health")


async def get_sources(call: Call, where: OfPayload) -> page_answers.Sources:
    """Sources of the latest estimate, each with its trail."""
    return _told(call, where, page_answers.Sources, "sources")


async def get_plan(call: Call, where: OfPayload) -> page_answers.AlignmentPlan:
    """Alignment candidates in order of travel."""
    return page_answers.AlignmentPlan.model_validate({**_head(call, where), **_section(call, where, "plan")})


async def get_exploration(call: Call, where: OfPayload) -> page_answers.Exploration:
    """What the latest exploration measured: ITD densities, and how well headings set a source apart."""
    return _told(call, where, page_answers.Exploration, "densities", "isolation")


async def get_separation(call: Call, where: OfPayload) -> page_answers.Separation:
    """The latest separation, group by group."""
    return _told(call, where, page_answers.Separation, "groups")


async def get_streams(call: Call, where: OfPayload) -> page_answers.Streams:
    """Live listening: every stream, also those that have ended; orders change them."""
    return _told(call, where, page_answers.Streams, "streams")


async def get_history(call: Call, where: OfPayload) -> page_answers.History:
    """K, score and state over time, oldest first."""
    return _told(call, where, page_answers.History, "history")


async def get_texts(call: Call, where: OfPayload) -> page_answers.Texts:
    """The latest texts for people (STATUSTEXT), oldest first."""
    return page_answers.Texts.model_validate({**_head(call, where), "texts": _section(call, where, "events")})


def _told(call: Call, where: OfPayload, answer: type[Told], *sections: str) -> Told:
    """Return an answer that holds sections of the view by their names."""
    return answer.model_validate({**_head(call, where), **{name: _section(call, where, name) for name in sections}})


def _head(call: Call, where: OfPayload) -> dict[str, Any]:
    call.operator.known(where.who)
    state = call.operator.state
    return {"id": where.payload, "now": state.station.now(), "heard": state.last_packet_ms(where.who)}


def _section(call: Call, where: OfPayload, name: str) -> Any:
    """Draw a section of what is known now."""
    settings = call.operator.state.client.values(where.who)
    return finite(SECTIONS[name](call.operator.known(where.who), settings))
