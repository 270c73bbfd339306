"""Scripts that use the package as any user would: train, evaluate, and the quickstart.

- `quickstart`: the main job, end to end;
- `train`: any algorithm of Stable-Baselines3 from a configuration file, under `runs/NAME/`;
- `evaluate`: controllers and saved models on equal disturbances.

Run them from the root of the repository, as `python -m agents.quickstart --help`.
"""
