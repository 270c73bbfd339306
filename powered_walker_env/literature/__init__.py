"""What others have written about walkers, beside what comes out here.

Two tellings of one story:

- `values/`: every published number that is known here, by source: values that others printed,
  runs of other people's programs, this project's independent codes; what does not come out
  stays in the table, with the reason (`validate`, `powered-walker validate`);
- `figures/`: the thesis's figures 4, 5 and 6 redrawn in both physics, and which of its
  statements hold (`reproduce`, `powered-walker reproduce`).
"""

from powered_walker_env.literature.figures import report_text, reproduce
from powered_walker_env.literature.values import (
    FAMILIES,
    Kind,
    Row,
    table_csv,
    table_data,
    table_text,
    validate,
)

__all__ = [
    "FAMILIES",
    "Kind",
    "Row",
    "report_text",
    "reproduce",
    "table_csv",
    "table_data",
    "table_text",
    "validate",
]
