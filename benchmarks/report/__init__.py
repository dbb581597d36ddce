"""The report of a run: pages, cases, verdicts, replays."""
