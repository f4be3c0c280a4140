"""Byte transports under the payload's links, the ground's links and the actuators' wires: UDP, TCP, serial, log files.

Everything is polled: ``send`` and ``receive`` never wait. An event loop that wants to know when to poll watches
``fileno()``, which stays the same while a connection is lost and opened again.
"""
