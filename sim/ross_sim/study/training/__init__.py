"""What the models of the payload are trained on, and the steps of their training."""
