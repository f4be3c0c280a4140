"""Whatever turns the array: drivers, their registry, the motion law they share and the guard around them."""
