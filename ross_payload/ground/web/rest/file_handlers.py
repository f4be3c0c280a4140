"""Recorded flights and sessions for programs, as the page has them."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from aiohttp import hdrs, web

from ross_payload.ground.errors import GroundError
from ross_payload.ground.recordings import described
from ross_payload.ground.web import flight_files, recordings
from ross_payload.ground.web.rest import page_answers
from ross_payload.ground.web.rest.operation import Call
from ross_payload.ground.web.rest.places import OfFile, OfRecording, OfSound, Upload
from ross_payload.ground.web.rest.problems import Refusal

OCTETS = "application/octet-stream"


async def get_flights(call: Call) -> page_answers.Flights:
    """Recorded flights, the newest first: those of the folder, and those that were brought."""
    known = await asyncio.to_thread(call.operator.state.flights.known)
    return page_answers.Flights(flights=[page_answers.Flight.model_validate(each) for each in known])


async def add_flight(call: Call, query: Upload) -> page_answers.FlightName:
    """Bring a flight, as a telemetry log or an MCAP file of at most 256 MB; it is gone when the page ends."""
    name = await call.operator.state.flights.save_upload(query.name, flight_files.chunks(call.request))
    await call.browsers.refresh_flights()
    return page_answers.FlightName(name=name)


async def get_flight_sound(call: Call, where: OfSound) -> web.StreamResponse:
    """A track of a flight, WAV or FLAC, also in parts (Range)."""
    return _octets(await flight_files.sound_of(call.operator.state.flights, where.name, where.track))


async def get_recordings(call: Call) -> page_answers.Recordings:
    """Recorded sessions, the oldest first; `ross sitl --page` offers those that it records."""
    store = call.operator.state.recordings
    told = {"folder": None, "known": []} if store is None else await asyncio.to_thread(described, store)
    return page_answers.Recordings.model_validate({"folder": told["folder"], "recordings": told["known"]})


async def get_recording(call: Call, where: OfRecording) -> page_answers.RecordedFiles:
    """The files of a recorded session."""
    files = await recordings.files_of(call.operator.state.recordings, where.name)
    return page_answers.RecordedFiles(files=await asyncio.to_thread(_rows, files))


async def get_recording_archive(call: Call, where: OfRecording) -> web.StreamResponse:
    """A recorded session as a ZIP archive, made while it is sent."""
    return await recordings.archive(call.operator.state.recordings, call.request, OCTETS)


async def get_recording_file(call: Call, where: OfFile) -> web.StreamResponse:
    """A file of a recorded session, also in parts (Range)."""
    return _octets(await recordings.one_file(call.operator.state.recordings, call.request))


async def delete_recording(call: Call, where: OfRecording) -> None:
    """Delete a recorded session; not while it is recorded."""
    store = call.operator.state.recordings
    if store is None:
        raise Refusal(404, f"recording {where.name[:80]}: not found")
    try:
        await asyncio.to_thread(store.delete, where.name)
    except LookupError as error:
        raise Refusal(404, f"recording {where.name[:80]}: not found") from error
    except GroundError as error:
        raise Refusal(409, error.message) from error
    await call.browsers.refresh_recordings()


def _rows(files: Mapping[str, Path]) -> list[page_answers.RecordedFile]:
    """Return files with their sizes, but for those that have gone meanwhile."""
    rows = []
    for name, path in files.items():
        with suppress(OSError):
            rows.append(page_answers.RecordedFile(name=name, bytes=path.stat().st_size))
    return rows


def _octets(response: web.StreamResponse) -> web.StreamResponse:
    response.headers[hdrs.CONTENT_TYPE] = OCTETS
    return response
