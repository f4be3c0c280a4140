"""An autopilot that carries the payload and routes its messages."""
