"""Nothing that can be read ends in a traceback, a hang, or a message that says nothing.

300 inputs a format by default; `OBSTACLEWATCH_FUZZ=10000` asks for more, from other streams with
`OBSTACLEWATCH_FUZZ_SEED=7`, and `-rP` shows the counts. A case that once failed is kept in `corpus/<format>/` and tried
first.
"""

from __future__ import annotations

import os
import re
import time
import warnings
from collections import Counter
from pathlib import Path

import click
import numpy as np
import pytest

from tests.fuzz.formats import FORMATS, Format

COUNT = int(os.environ.get("OBSTACLEWATCH_FUZZ", "300"))
SEED = int(os.environ.get("OBSTACLEWATCH_FUZZ_SEED", "0"))
CORPUS = Path(__file__).parent / "corpus"
SLOWEST_S = 5.0
TOLD = (ValueError, OSError, click.ClickException, click.exceptions.Abort)
"""What `benchmarks.cli.main` says in one line with exit code 2."""
ACCEPTED, REFUSED = "accepted", "refused"
CLEAR = (ACCEPTED, REFUSED)
UNCLEAR = re.compile(
    "zero-size|has no attribute|not subscriptable|unsupported operand|NoneType|object is not|broadcast|unhashable|"
    "positional"
)
QUOTED = re.compile("that trimesh reads|must be YAML")
"""After these words a message is what the reader of the format said."""


@pytest.mark.parametrize("name", FORMATS)
def test_every_input_ends_clearly(name: str, tmp_path: Path) -> None:
    kept = sorted((CORPUS / name).glob("*"))
    tried = ((path.name, _ending(FORMATS[name], path.read_bytes(), tmp_path)) for path in kept)
    bad = [f"corpus {file}: {said}" for file, said in tried if said not in CLEAR]
    key, endings = sorted(FORMATS).index(name), Counter[str]()
    for k in range(COUNT):
        data = FORMATS[name].make(np.random.default_rng([SEED, key, k]))
        said = _ending(FORMATS[name], data, tmp_path)
        endings[said if said in CLEAR else "unclear"] += 1
        if said not in CLEAR:
            _keep(name, k, data)
            bad.append(f"seed {SEED}, {k}: {said}")
    print(f"{name}: {COUNT} inputs, {dict(endings)}")
    assert bad == []


@pytest.mark.parametrize("name", FORMATS)
def test_what_the_inputs_are_made_from_is_accepted(name: str, tmp_path: Path) -> None:
    """Cause: scenes were made from one whose walk was refused, so that nothing behind its walk was ever tried."""
    endings = [_ending(FORMATS[name], data, tmp_path) for data in FORMATS[name].good()]
    assert set(endings) == {ACCEPTED}


def _ending(form: Format, data: bytes, folder: Path) -> str:
    """How an input ends: one of `CLEAR`, or what is wrong with it."""
    begin, ending = time.process_time(), ACCEPTED
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            form.read(data, folder)
    except TOLD as error:
        ending = REFUSED
        text = error.format_message() if isinstance(error, click.ClickException) else str(error)
        if not text.strip() or UNCLEAR.search(QUOTED.split(text)[0]):
            return f"unclear: {type(error).__name__}: {text[:200]!r}"
    except Exception as error:  # what the command line would call its own defect
        return f"{type(error).__name__}: {str(error)[:200]}"
    spent = time.process_time() - begin
    return f"{spent:.1f} s" if spent > SLOWEST_S else ending


def _keep(name: str, number: int, data: bytes) -> None:
    """Store an input that failed where `OBSTACLEWATCH_FUZZ_KEEP` says, to be looked at and put into the corpus."""
    folder = os.environ.get("OBSTACLEWATCH_FUZZ_KEEP")
    if folder:
        path = Path(folder) / name
        path.mkdir(parents=True, exist_ok=True)
        (path / f"{SEED}-{number}").write_bytes(data)
