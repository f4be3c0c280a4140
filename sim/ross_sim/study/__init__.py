"""Measured tables: sweeps over rooms, layouts and talkers.

Here are the commands and the scripts; `scenes` makes what is heard, `rows` what is written down, `runs` does the tasks,
`training` has what the models learn from, `benchmark` is for other methods.
"""
