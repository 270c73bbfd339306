"""Benchmarks that anyone can run: `python -m benchmarks`. One file tells one story.

- `precision`: strides a second beside their error, ours and those of other people's integrators;
- `roofline`: what the machine's arithmetic allows;
- `scaling`: with the number of walkers, and of cores;
- `environments`, `startup`: what stands between a stride and its user;
- `processors`: older ones.

All solve the problem of `strides`, by the walker's `equations` written once more for others
(`taylor`: heyoka), and are timed by `timing`.
"""
