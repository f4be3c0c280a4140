"""What is heard in a study: rooms, talkers, noise, and what both microphones hear of them."""
