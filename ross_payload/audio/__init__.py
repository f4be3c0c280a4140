"""Where audio comes from (sound cards, files, TCP), how it is, and where it goes."""
