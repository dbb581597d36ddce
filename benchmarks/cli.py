"""The command line `obstaclewatch`. Commands are imported when called, so `--help` answers at once."""

from __future__ import annotations

import importlib
import sys
import tempfile
import traceback
from typing import Any

import click

from benchmarks.interrupts import Terminated, interruptible, mute, tell

COMMANDS = {
    "run": "Run a suite: simulate, detect, score, draw, report. Resumes what is there.",
    "export": "Write a labelled data set of a suite: recordings, truth, paths, splits, a card.",
    "status": "Say how far a run is.",
    "figures": "Draw a run's figures again from its stored results.",
    "report": "Write a run's report again from its stored results.",
    "gate": "Judge a run by its gates: green, red, or nothing measured.",
    "baseline": "Make or show the baseline that gates compare runs with.",
    "history": "Accuracy and cost over stored runs and commits: table and pictures.",
    "compare": "Compare two runs, or two detectors, on the same walks.",
    "ls": "List suites, scenes, phones, figures, gates or checks.",
    "validate": "Check a suite file or a gates file.",
    "doctor": "Check that this installation works, and say what to do if not.",
    "beep": "Write the beeps for a phone of your own to play, as a WAV file.",
    "calibrate": "Read a phone's geometry, delay and phase from a recording before a wall.",
    "simulate": "Render what a phone records on a walk, to a WAV or FLAC file.",
    "detect": "Run a detector on a stereo WAV or FLAC file.",
    "scene": "Check or draw a scene or an approach.",
}
EXAMPLES = {
    "run": ["run paper --tier smoke -j 2", "run paper --tier full -k 'dustbin and not campus' -j 2", "run speed -n"],
    "export": ["export paper walks --walks 5"],
    "status": ["status results/paper/latest"],
    "figures": ["figures results/paper/latest fig16 fig17", "figures --paper --tier smoke -j 2"],
    "report": ["report results/paper/latest --walks 3"],
    "gate": ["gate results/paper/latest", "gate results/paper/latest --gates paper_claims"],
    "baseline": ["baseline update results/paper/latest --reason 'what changed and why'", "baseline history"],
    "history": ["history results --suite paper"],
    "compare": ["compare before/paper/latest results/paper/latest"],
    "ls": ["ls suites", "ls phones"],
    "validate": ["validate paper", "validate mine.yaml"],
    "doctor": ["doctor"],
    "beep": ["beep beeps.wav --seconds 60"],
    "calibrate": ["calibrate wall.flac --phone galaxy-s8-plus --wall 1.025 -o my_phone.yaml"],
    "simulate": [
        "simulate supermarket --category wall --phone galaxy-s8-plus -o walk.flac",
        "simulate yard.yaml -o yard.wav",
    ],
    "detect": ["detect walk.flac --phone galaxy-s8-plus --pitch 30 --detector TrackingDetector --plot walk.png"],
    "scene": ["scene check supermarket", "scene preview supermarket -o street.html"],
}
"""For the end of each command's help."""

MODULES = {"beep": "own_phone", "calibrate": "own_phone"}
"""Of commands that share one."""

USAGE = 2
CRASH = 70
"""EX_SOFTWARE of sysexits.h: never 1, which says that a gate is red."""
LONGEST_MESSAGE = 200
INTERRUPTED, UNREAD, TERMINATED = 130, 141, 143
"""As shells have it: 128 and the number of the signal, SIGINT, SIGPIPE or SIGTERM."""


class LazyGroup(click.Group):
    """A group whose commands live in modules of their own, imported on demand."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command. That nobody reads its output ends it without a word; click would say 1, a red gate."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            for stream in (sys.stdout, sys.stderr):
                mute(stream)
            sys.exit(UNREAD)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """All names, in the order of use."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return one command."""
        if cmd_name not in COMMANDS:
            return None
        module = MODULES.get(cmd_name, cmd_name)
        command = getattr(importlib.import_module(f"benchmarks.commands.{module}"), cmd_name)
        command.epilog = "\n".join(["\b", "Examples:", *(f"  obstaclewatch {each}" for each in EXAMPLES[cmd_name])])
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The list of commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="obstaclewatch")
def cli() -> None:
    """Test bench for phone sonar: scenes, echoes, detectors, scores.

    Exit codes: 0 good; 1 a gate is red or an extreme silently wrong; 2 usage or input; 3 failed or missing cells;
    4 nothing measured; 70 a defect of this program; 130 interrupted, 143 terminated, both resumable; 141 nobody reads
    what is printed, as after `| head`: a run goes on all the same.
    """


def main() -> None:
    """Entry point: what is wrong with the input becomes one line on stderr and exit code 2."""
    for stream in (sys.stdout, sys.stderr):  # a locale without a path's letters must not end the command
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        with interruptible():
            cli(standalone_mode=False)
    except click.exceptions.Abort as error:
        _end_workers()
        ended, code = (
            ("terminated", TERMINATED) if isinstance(error.__cause__, Terminated) else ("interrupted", INTERRUPTED)
        )
        tell(f"{ended}; the same command goes on where it stopped", sys.stderr)
        sys.exit(code)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        sys.exit(USAGE)
    except click.ClickException as error:
        _complain(error.format_message(), getattr(error, "ctx", None))
        sys.exit(error.exit_code)
    except (ValueError, OSError) as error:  # OSError: a file that is missing, a folder that cannot be written
        _complain(str(error) or type(error).__name__)
        sys.exit(USAGE)
    except Exception as error:
        _complain(f"a defect of this program: {_first_words(error)}; {_kept_trace(error)}")
        sys.exit(CRASH)


def _end_workers() -> None:
    """Worker processes would finish their cells and keep standard output open, on which a pipe waits."""
    if "joblib" in sys.modules:
        from benchmarks.runs.executors.local import end_workers

        end_workers()


def _first_words(error: Exception) -> str:
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return text if len(text) <= LONGEST_MESSAGE else f"{text[:LONGEST_MESSAGE]}..."


def _kept_trace(error: Exception) -> str:
    """Where the trace lies; where no file can be written, its last place."""
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="obstaclewatch-", suffix=".txt", delete=False, encoding="utf-8", errors="backslashreplace"
        ) as file:
            file.write("".join(traceback.format_exception(error)))
    except OSError:
        last = traceback.extract_tb(error.__traceback__)[-1]
        return f"no file could be written for the trace, which ends at {last.filename}:{last.lineno}"
    return f"its trace is in {file.name}"


def _complain(message: str, context: click.Context | None = None) -> None:
    """One line on stderr, after the command that is meant where it is known."""
    path = "obstaclewatch" if context is None else context.command_path
    tell(f"{path}: {' '.join(message.split())}", sys.stderr)


if __name__ == "__main__":
    main()
