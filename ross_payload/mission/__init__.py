"""The mission: a coroutine that hears, decides and asks for turns; it does no input or output of its own."""
