"""Two fixed microphones on a multicopter: its autopilot yaws the vehicle."""
