"""What the ground asks of a payload, without input or output: orders, parameters, metadata, files."""
