"""Benchmarks that anyone can run: `powered-walker bench`.

- `equations`: the walker for other people's integrators; `problem`: what all have to solve;
- `contenders`, `taylor`: who solves it; `precision`: their speed beside their accuracy;
- `roofline`, `counting`: what the machine allows;
- `scaling`: with the number of walkers, and of cores;
- `environments`, `startup`: what stands between a stride and its user;
- `timing`: how all is timed; `machine`: on what; `tables`, `drawings`: how it is told.
"""
