"""``ross doctor``: whether this computer can do what a configuration asks, and what to do when not. Nothing moves."""
