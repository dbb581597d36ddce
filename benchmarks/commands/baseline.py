"""`obstaclewatch baseline`: what later runs are compared with."""

from __future__ import annotations

from pathlib import Path

import click


@click.group()
def baseline() -> None:
    """Make or show the baseline that gates compare runs with."""


@baseline.command()
@click.argument("run_folders", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--reason", required=True, help="why the results changed; kept in the file's history")
@click.option("--gates", "gates_file", default="project", show_default=True, help="gates file whose baseline it is")
@click.option("--baseline", "file", type=click.Path(path_type=Path), help="the file itself, instead of --gates")
def update(run_folders: tuple[Path, ...], reason: str, gates_file: str, file: Path | None) -> None:
    """Take what RUN_FOLDERS measured as the new baseline of their suites, tiers and seeds."""
    from benchmarks.gates.baseline import load_baseline, save_baseline, updated
    from benchmarks.runs.manifest import other_source
    from benchmarks.runs.results import load_run

    path = file or _of_gates(gates_file)
    before = load_baseline(path) if path.is_file() else None
    runs = [load_run(folder) for folder in run_folders]
    for folder, run in zip(run_folders, runs, strict=True):
        if note := other_source(run.manifest):
            click.echo(f"{folder}: {note}", err=True)
    after = updated(before, runs, reason)
    save_baseline(path, after)
    for key, counts in after.history[-1]["runs"].items():
        for detector, text in counts.items():
            click.echo(f"{key} {detector}: {text}")
    click.echo(f"{path.resolve()}: {path.stat().st_size / 1024:.0f} kB")


@baseline.command()
@click.option("--gates", "gates_file", default="project", show_default=True, help="gates file whose baseline it is")
@click.option("--baseline", "file", type=click.Path(path_type=Path), help="the file itself, instead of --gates")
def history(gates_file: str, file: Path | None) -> None:
    """Say when and why the baseline changed, and what its rates were."""
    from benchmarks.gates.baseline import load_baseline

    for entry in load_baseline(file or _of_gates(gates_file)).history:
        click.echo(f"{entry['date']} {entry['reason']}")
        for key, counts in entry["runs"].items():
            for detector, text in counts.items():
                click.echo(f"  {key} {detector}: {text}")


def _of_gates(gates_file: str) -> Path:
    from benchmarks.gates.config import gates_path, load_gates

    path = gates_path(gates_file)
    name = load_gates(path).baseline
    if name is None:
        raise ValueError(f"gates file '{path}' must name a baseline, got none; use --baseline")
    return path.parent / name
