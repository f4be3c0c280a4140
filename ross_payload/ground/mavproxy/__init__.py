"""RoSS in MAVProxy: a launcher that teaches it our dialect, and a module with commands. MAVProxy is optional."""
