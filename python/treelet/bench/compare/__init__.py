"""Suites of scenes and recipes: measured in sessions that complete each other, compared, reported.

Everything a report says comes from two files of JSON lines: docs/evaluation.md.
"""

from treelet.bench.compare.estimate import Forecast, describe_seconds, scene_seconds, try_recipes
from treelet.bench.compare.journal import Journal, open_journal
from treelet.bench.compare.page import write_page
from treelet.bench.compare.plots import write_plots
from treelet.bench.compare.report import short_tables, summary, write_markdown
from treelet.bench.compare.results import Results, gather, read_results
from treelet.bench.compare.session import Failure, run_session
from treelet.bench.compare.suite import Suite, load_suite
from treelet.bench.compare.survey import Survey, survey
from treelet.bench.compare.work import find_work

__all__ = [
    "Failure",
    "Forecast",
    "Journal",
    "Results",
    "Suite",
    "Survey",
    "describe_seconds",
    "find_work",
    "gather",
    "load_suite",
    "open_journal",
    "read_results",
    "run_session",
    "scene_seconds",
    "short_tables",
    "summary",
    "survey",
    "try_recipes",
    "write_markdown",
    "write_page",
    "write_plots",
]
