"""CANopen (CiA 301) and drives by CiA 402: values to CAN frames and back. No bus, no clock, no threads."""
