"""An alignment with a number of its own in every field."""

from ross_protocols.mavlink.values import Alignment, CandidateState, Rule

ALIGNMENT = Alignment(
    time_usec=5_000_000,
    earth=True,
    plan=3,
    candidate=1,
    count=2,
    heading=1.0,
    joint=0.25,
    source=0,
    aliased=(1, 2),
    isolation=125e-6,
    gain=3.5,
    rule=Rule.BISECTOR,
    state=CandidateState.TURNING,
)
