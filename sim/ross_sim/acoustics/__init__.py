"""What reaches the microphones: rooms, responses, noise."""
