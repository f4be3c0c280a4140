"""Where audio comes from and where it goes: files and sinks."""
