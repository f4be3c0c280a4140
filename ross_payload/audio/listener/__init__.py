"""``ross listen``: play or write what a payload streams, whichever way it comes."""
