"""The payload as a node on a DroneCAN bus: who it is, what it says and answers, and who shares the bus with it."""
