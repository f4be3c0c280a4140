"""What a person reads about pipelined and informed missions."""

import numpy as np

from ross_payload.events import Doubted, Estimate, SourceEstimate, SourcesEstimated
from ross_payload.telemetry.texts import line
from ross_protocols.values import Severity
from ross_sim.live import in_words

TOLD = SourcesEstimated(
    2.0, Estimate((SourceEstimate(np.pi / 2, 0.01, 1.0, resolved=True),)), rotations=0, final=True, informed=True
)
DOUBTED = Doubted(9.0, "none of 1 voices is the target's")


def test_what_was_told_is_not_said_to_be_found():
    assert line(TOLD) == (Severity.INFO, "1 source told from outside")
    assert in_words(TOLD) == "told from outside: K = 1 at 90.0 deg"


def test_the_end_of_belief_is_a_warning_with_its_reason():
    severity, words = line(DOUBTED)
    assert severity is Severity.WARNING
    assert DOUBTED.reason in words
    assert "explor" in words
    assert DOUBTED.reason in in_words(DOUBTED)
