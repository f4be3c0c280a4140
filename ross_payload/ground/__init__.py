"""The ground side: it knows payloads only through MAVLink, live or recorded, and imports `ross_protocols` alone."""
