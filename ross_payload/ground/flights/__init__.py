"""Flights of the past: telemetry logs and session folders, looked at, played, drawn and handed on."""
