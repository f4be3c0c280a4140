"""The far ends of every actuator: devices with real dynamics, their buses and wires, and their faults."""
