"""Headless Chromium for tests of pages: without a network, with WebGL drawn by the processor."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from numpy.typing import NDArray

QUIET = (
    "--headless --no-sandbox --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --hide-scrollbars --use-angle=swiftshader "
    "--enable-unsafe-swiftshader --virtual-time-budget=2000"
)


def browser() -> str:
    """Path of the browser; skips the test if there is none."""
    found = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if found is None:
        pytest.skip("no Chromium on this machine: the page is not opened")
    return found


def screenshot(
    page: Path, folder: Path, size: tuple[int, int] = (600, 400), wait_ms: int | None = None
) -> NDArray[np.float64]:
    """(height, width, 3) pixels of a page, 0 to 1; every host is unreachable while it is open.

    After two seconds of virtual time, or `wait_ms` of real time: a page that unpacks its library needs that.
    """
    picture = folder / "shot.png"
    quiet = QUIET if wait_ms is None else QUIET.replace("--virtual-time-budget=2000", f"--timeout={wait_ms}")
    subprocess.run(
        [browser(), *quiet.split(), "--host-resolver-rules=MAP * ~NOTFOUND", f"--window-size={size[0]},{size[1]}",
         f"--user-data-dir={folder / 'profile'}", f"--screenshot={picture}", page.as_uri()],
        check=True, capture_output=True, timeout=120,
    )  # fmt: skip
    return np.asarray(matplotlib.image.imread(picture)[..., :3], dtype=np.float64)


def on_a_phone(page: Path, folder: Path, width: int) -> tuple[int, int]:
    """How wide a page is in a frame of so many pixels, and its tallest cell of a table; a window has 500 at least."""
    measure = (
        "const page = this.contentDocument, cells = [...page.querySelectorAll('td')].map(cell => cell.clientHeight); "
        "document.title = `wide ${page.documentElement.scrollWidth} tall ${Math.max(0, ...cells)}`"
    )
    frame = folder / "phone.html"
    frame.write_text(f'<iframe width="{width}" height="800" src="{page.as_uri()}" onload="{measure}"></iframe>')
    done = subprocess.run(
        [browser(), *QUIET.split(), "--disable-web-security", "--allow-file-access-from-files",
         f"--user-data-dir={folder / 'profile'}", "--dump-dom", frame.as_uri()],
        check=True, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    ((wide, tall),) = re.findall(r"<title>wide (\d+) tall (\d+)</title>", done.stdout)
    return int(wide), int(tall)
