"""A CiA 402 drive on a CANopen bus."""
