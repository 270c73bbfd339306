"""The same legs under all schemes: what actuation and control do for coordination and efficiency.

    python -m agents.schemes --out FOLDER    # a minute or two of one core

- which legs, at which speeds? `cases`; what is measured of a gait? `measures`, its `timing` among
  them, with the clock that the switch might be; what does feedback do? `loops`;
- what do the two numbers of a motor do? `control_map`;
- all of it as one JSON: `content`; from it alone: `figures`, and `tables` of the pages.
"""
