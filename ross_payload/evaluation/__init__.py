"""How well recordings separate: the paper's measured-data protocol, X1 with and without interference."""
