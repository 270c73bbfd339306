"""The rows of a study as tables: Markdown for people, JSON for everything else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

from agents.study.cells import LEFT_OUT, LEVELS
from agents.study.intervals import METHOD
from agents.study.records import Record
from agents.study.summary import Row, over_all, summary
from powered_walker_env.controllers import Estimate

NONE = "–"


class Table(NamedTuple):
    """Cells of text under a header."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]

    def markdown(self) -> str:
        """With its title as a heading."""
        lines = [self.header, ["---"] * len(self.header), *self.rows]
        body = "\n".join("| " + " | ".join(map(_cell, line)) + " |" for line in lines)
        return f"### {self.title}\n\n{body}\n"


def study_json(records: Sequence[Record], resamples: int) -> dict[str, Any]:
    """All that the pages say: rows with their numbers, and the tables as text."""
    rows = summary(records, resamples)
    every = {level: over_all(records, level, resamples) for level in LEVELS}
    machine = next((record.machine for record in records if record.machine), {})
    listed = tables(rows, {level: found for level, found in every.items() if found})
    return {
        "method": METHOD,
        "machine": {name: machine.get(name) for name in ("versions", "git_commit")},
        "rows": [asdict(row) for row in rows],
        "over_all": every,
        "tables": [table._asdict() for table in listed],
    }


def markdown(study: dict[str, Any]) -> str:
    """The tables of `study_json`."""
    return "\n".join(Table(**table).markdown() for table in study["tables"])


def tables(rows: Sequence[Row], every: dict[str, dict[str, dict[str, Any]]]) -> list[Table]:
    """Three for each environment and level; those over all; what was left out and refused."""
    found = [_over_all(level, values) for level, values in every.items()]
    for env_id, level in dict.fromkeys((row.env_id, row.level) for row in rows):
        some = [row for row in rows if (row.env_id, row.level) == (env_id, level) and row.runs]
        for title, columns in _KINDS.items():
            if some:
                header = ("controller", *columns)
                lines = [[row.controller, *(show(row) for show in columns.values())]
                         for row in some]  # fmt: skip
                found.append(Table(f"{title}: {env_id}, {level}", header, lines))
    found.append(_left_out())
    return [*found, *_refused(rows)]


def _refused(rows: Sequence[Row]) -> list[Table]:
    """What was refused, cells with the same words together."""
    where: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        for name, words in row.refused.items():
            place = f"{row.controller} ({row.env_id}, {row.level})"
            where.setdefault((name or "all", words), []).append(place)
    lines = [(name, ", ".join(places), words) for (name, words), places in where.items()]
    return [Table("Refused", ("measure", "of", "in its words"), lines)] if lines else []


def _over_all(level: str, values: dict[str, dict[str, Any]]) -> Table:
    lines = []
    for name, each in values.items():
        lines.append([name, _share(each.get("strides")), _number(each.get("score"), 3)])
    known = next(iter(values.values()))["environments"]
    header = ("controller", f"strides, % of the limit (environments: {len(known['strides'])})",
              f"score ({len(known['score'])})")  # fmt: skip
    return Table(f"Over all environments, {level}", header, lines)


def _left_out() -> Table:
    lines = [
        (", ".join(each.controllers), ", ".join(each.env_ids), ", ".join(each.levels), each.reason)
        for each in LEFT_OUT
    ]
    return Table("Left out", ("controllers", "environments", "levels", "why"), lines)


def _passage(row: Row) -> str:
    mean, least = row.medians.get("mean_first_passage"), row.medians.get("at_least")
    if mean is not None and row.having["mean_first_passage"] == row.having["at_least"]:
        return f"{mean:.4g}"
    return NONE if least is None else f"> {least:.2g}"


def _median(name: str, text: str = ".3g", factor: float = 1.0) -> Callable[[Row], str]:
    def show(row: Row) -> str:
        value = row.medians.get(name)
        if value is None:
            return NONE
        some = "" if row.having[name] == row.runs else f" ({row.having[name]} of {row.runs})"
        return format(factor * value, text) + some

    return show


def _number(found: Estimate | None, decimals: int) -> str:
    return NONE if found is None else found.text(decimals)


def _share(found: Estimate | None) -> str:
    return NONE if found is None else Estimate(*(100.0 * value for value in found)).text()


def _trained(row: Row) -> str:
    return NONE if row.trained_strides is None else f"{row.trained_strides:,.0f}"


def _seconds(row: Row) -> str:
    return NONE if row.trained_seconds is None else f"{row.trained_seconds:.0f}"


#: Title to columns, each with what shows a row's value.
_KINDS: dict[str, dict[str, Callable[[Row], str]]] = {
    "How long it walks": {
        "runs": lambda row: str(row.runs),
        "strides [95 %]": lambda row: _number(row.strides, 1),
        "return [95 %]": lambda row: _number(row.returns, 1),
        "score [95 %]": lambda row: _number(row.score, 3),
        "to the end, %": _median("survived", ".1f", 100.0),
        "mean first passage, strides": _passage,
    },
    "How it walks": {
        "largest multiplier": _median("spectral_radius", ".4f"),
        "sensitivity to pushes": _median("push_sensitivity"),
        "to steps": _median("step_sensitivity"),
        "attracted, %": _median("basin", ".1f", 100.0),
        "walking on, %": _median("walking", ".1f", 100.0),
        "cost of transport": _median("cost_of_transport", ".4f"),
        "electrical": _median("electrical_cost", ".4f"),
    },
    "What it costs": {
        "µs a decision": _median("microseconds"),
        "flop a decision": _median("flops", ",.0f"),
        "strides of training": _trained,
        "seconds of training": _seconds,
    },
}


def _cell(value: Any) -> str:
    return " ".join(str(value).split()).replace("|", "\\|")
