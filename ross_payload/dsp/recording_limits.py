"""What no recording of sound exceeds: a header or samples beyond are damaged, or mean something else."""

HIGHEST_RATE = 192_000  # [Hz]: the filter that resamples grows with it
HIGHEST_PEAK = 1e6  # re full scale: some float files count as 16 bits do; beyond, powers leave the range of numbers
