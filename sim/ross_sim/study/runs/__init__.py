"""How a study is run: its design, its tasks, what does them, and the folder that keeps the results."""
