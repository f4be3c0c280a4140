"""The links of a ground station on asyncio: ports, peers, signatures, the log, and advice when nothing is heard."""
