"""The control study: every controller and learner at every environment, measured alike.

    python -m agents.study            # both cores, two hours; again: what is left
    python -m agents.study --small    # the same code in half a minute

- what is compared? `cells`; with how much of everything? `budgets`;
- a cell: trained (`training`), met as a `subject`, measured: its `walks`, its closed `loops`, what
  its `decisions` cost; all of it in `measures`, kept as one of the `records`;
- all of them, on all cores, resumed: `running`;
- what comes of it: `intervals` over seeds and episodes, a `summary` in rows, `tables`, `figures`,
  `policies` as files without code, and the `commands` of every row; `publishing` puts them where
  the repository has them.
"""
