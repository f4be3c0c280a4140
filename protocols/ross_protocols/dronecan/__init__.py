"""DroneCAN: messages, services and transfers to CAN frames and back. No bus, no clock, no threads."""
