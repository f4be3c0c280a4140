"""A public benchmark: fixed scenes, audio that anybody can build from LibriSpeech, and scores of any method."""
