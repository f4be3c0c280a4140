"""The service: configuration to objects, the runner, and the payload that lives from start to shutdown."""

from ross_payload.service.assemble import explorer_of, informed_of, settings_of, tools_of
from ross_payload.service.runner import Observer, Runner

__all__ = ["Observer", "Runner", "explorer_of", "informed_of", "settings_of", "tools_of"]
