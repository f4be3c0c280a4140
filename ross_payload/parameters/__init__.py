"""The settings that may change in flight: a closed table, and the file that outlives a restart.

Wiring and safety ([audio], [array], [actuator], [guard], [links]) are not in the table: they belong to the file.
"""

from ross_payload.parameters.kept import Kept, replace_file
from ross_payload.parameters.listing import listing
from ross_payload.parameters.store import Origin, Parameters
from ross_payload.parameters.table import TABLE, Parameter, changed, value_of

__all__ = [
    "TABLE",
    "Kept",
    "Origin",
    "Parameter",
    "Parameters",
    "changed",
    "listing",
    "replace_file",
    "value_of",
]
