"""A pneumatic muscle in twenty lines, as a plant: mgpi pil --plant-command 'python3 examples/plant.py'.

Each line in is `time_s command_bar`, each line out `pressure_bar contraction_mm` at that time.
"""
import math
import sys

pressure_bar, last_s = 0.0, None
plays = [[width_bar, 0.0] for width_bar in (0.05, 0.1, 0.2, 0.4)]  # half-widths in bar and states of four plays

for line in sys.stdin:
    time_s, command_bar = map(float, line.split())
    elapsed_s = 0.0 if last_s is None else time_s - last_s
    last_s = time_s
    # The valve: limits, and a lag of 50 ms.
    target_bar = min(max(command_bar, 0.0), 6.0)
    pressure_bar += (target_bar - pressure_bar) * (1.0 - math.exp(-elapsed_s / 0.05))
    # The muscle: plays give the hysteresis, an S-shaped curve the rest.
    for play in plays:
        play[1] = max(pressure_bar - play[0], min(pressure_bar + play[0], play[1]))
    felt_bar = sum(state for _, state in plays) / len(plays)
    contraction_mm = 130.0 * felt_bar**2 / (felt_bar**2 + 4.0)
    print(pressure_bar, contraction_mm, flush=True)
