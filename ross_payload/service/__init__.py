"""The service: configuration to objects, the runner, and the payload that lives from start to shutdown."""
