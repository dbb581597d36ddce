"""Responses, envelopes, echograms and the walker's body (Figures 3 to 6, 8 and 9)."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.figures.plots import Guide, Image, Line, Panel, PlotFigure
from benchmarks.runs.results import RunData
from simulator.phone.presets import MEASURED_RESPONSES


def signals_of(run: RunData, name: str) -> list[dict[str, Any]]:
    """The stored signals of a name, in the order of the plan."""
    return [r["result"]["signal"] for r in run.ok if r["cell"]["kind"] == "signal" and r["cell"]["category"] == name]


def responses(run: RunData) -> PlotFigure:
    """Figure 3: speaker to microphone, for every phone."""
    cells = [r for r in run.ok if r["cell"]["kind"] == "signal" and r["cell"]["category"] == "response"]
    panels: list[Panel] = []
    said = []
    for record in cells:
        signal, phone = record["result"]["signal"], record["cell"]["phone"]
        frequency = np.array(signal["frequency_hz"]) / 1e3
        known = phone in MEASURED_RESPONSES
        lines = tuple(
            Line(f"mic{k}, measured" if known else "both, assumed", str(k - 1) if known else "ink", frequency,
                 np.array(signal[f"mic{k}_db"]), ("line" if k == 1 else "dashed") if known else "dashed")
            for k in ((1, 2) if known else (1,))
        )  # fmt: skip
        basis = "measured" if known else "assumed"
        said.append(f"{phone} ({basis}) at 23 kHz: {np.interp(23.0, frequency, lines[0].y):.0f} dB at mic1")
        guides = (Guide("x", 18.0, ""), Guide("x", 23.0, ""))
        panels.append(
            Panel(
                f"{phone}, {basis}",
                "frequency (kHz)",
                "" if panels else "level, dB re mean over 18-22 kHz",
                lines,
                guides,
                y_range=(-55.0, 10.0),
                width_in=2.6,
            )
        )
    return PlotFigure(
        "fig3",
        "Fig. 3 · Frequency response, speaker to microphone",
        tuple(panels),
        f"{'; '.join(said)}. The paper's phones decay quickly after 22 to 23 kHz." if said else "No data.",
        "Lines up: 18 and 23 kHz. Sources and assumptions: simulator/phone/presets.py.",
    )


def one_envelope(run: RunData) -> PlotFigure:
    """Figure 4: the envelope before one obstacle."""
    return _envelope_figure(run, 0, "fig4", "Fig. 4 · Envelope of microphone 1 before one obstacle, standing")


def several_envelopes(run: RunData) -> PlotFigure:
    """Figure 6: the envelope before several obstacles."""
    return _envelope_figure(run, 1, "fig6", "Fig. 6 · Envelope of microphone 1 before several obstacles, standing")


def walking_envelopes(run: RunData) -> PlotFigure:
    """Figure 5: envelopes one after another while walking up to obstacles."""
    panels: list[Panel] = []
    for signal in signals_of(run, "approach")[:2]:
        time, range_m = np.array(signal["time_s"]), np.array(signal["range_m"])
        step = 4
        values = np.array(signal["level_db"], dtype=float).T
        kept = range_m <= 6.0
        count = int(kept.sum()) // step * step
        coarse = values[kept][:count].reshape(-1, step, len(time)).max(axis=1)
        edges = np.append(range_m[kept][:count:step], range_m[kept][count - 1])
        period = time[1] - time[0]
        image = Image(np.append(time, time[-1] + period), edges, coarse, "level (dB re direct sound)", -75.0, -25.0)
        dots = [(t, r) for t, row in zip(time, signal["candidate_m"], strict=True) for r in row if r <= 6.0]
        true = np.array(signal["true_m"])
        lines = (
            Line("true distance", "on image too", time + 0.5 * period, true, "dashed"),
            Line(
                "candidates of the paper's detector",
                "on image",
                np.array([t for t, _ in dots]) + 0.5 * period,
                np.array([r for _, r in dots]),
                "points",
            ),
        )
        panels.append(
            Panel(signal["category"], "time (s)", "" if panels else "range (m)", lines, image=image, y_range=(0.3, 6.0))
        )
    ahead = 100 * signals_of(run, "approach")[0]["read_ahead_m"] if panels else 0.0
    return PlotFigure(
        "fig5",
        "Fig. 5 · Envelopes over time, walking up to an obstacle at 1.2 m/s",
        tuple(panels),
        f"The obstacle's echo comes nearer while ground and body stay; the range-Doppler bias is {-ahead:.0f} cm."
        if panels
        else "No data.",
        "Envelope of microphone 1, beep after beep; the highest of four samples is shown.",
    )


def body_at_obstacle(run: RunData) -> PlotFigure:
    """Figure 8: at microphone 2 the obstacle's echo (D2) is followed by the one over the body (D3)."""
    return _body_figure(run, "fig8", "Fig. 8 · The obstacle's echo at mic2, with and without the body", True)


def body_at_phone(run: RunData) -> PlotFigure:
    """Figure 9: the direct sound at microphone 2 and the body's echo after it."""
    return _body_figure(run, "fig9", "Fig. 9 · The direct sound at mic2, with and without the body", False)


def _envelope_figure(run: RunData, which: int, name: str, title: str) -> PlotFigure:
    found, words = signals_of(run, "envelope")[which : which + 1], "level (dB re the highest peak)"
    panels, said = [], "No data."
    for signal in found:
        axis, level = np.array(signal["range_m"]), np.array(signal["level_db"])
        candidates = np.array(signal["candidate_m"], dtype=float)
        heights = np.interp(candidates, axis, level)
        lines = (
            Line("envelope", "0", axis, level),
            Line("threshold (OS-CFAR)", "1", axis, np.array(signal["threshold_db"]), "dashed"),
            Line("the paper's threshold, 3 x average", "3", axis[[0, -1]], np.full(2, signal["average_db"]), "dotted"),
            Line("candidates", "ink", candidates, heights, "ring"),
        )
        truths = zip(signal["things"], signal["true_m"], strict=True)
        guides = tuple(Guide("x", r, name) for name, r in truths)
        panels.append(
            Panel("", "range (m)", words, lines, guides, x_range=(0.3, 7.0), width_in=6.0, y_range=(-50.0, 3.0))
        )
        near = [float(np.abs(candidates - r).min()) if len(candidates) else np.inf for r in signal["true_m"]]
        hits = sum(miss < 0.1 for miss in near)
        said = f"{hits} of {len(near)} objects have a candidate within 10 cm, among {len(candidates)} candidates."
    return PlotFigure(
        name,
        title,
        tuple(panels),
        said,
        "One beep. Thin lines up: true ranges of the objects' nearest points. Peaks without one are the ground, "
        "its corners with objects, and the walker's body.",
    )


def _peaks(signal: dict[str, Any]) -> str:
    """Which of D2 and D3 is the higher peak, and what the paper says of it."""
    axis, level = np.array(signal["path_m"]), np.array(signal["with_db"])
    ends = signal["obstacle_m"], signal["obstacle_m"] + signal["detour_m"]
    near, far = (float(level[np.abs(axis - end) < 0.1].max()) for end in ends)
    held = "This contradicts the paper" if near > far else "This agrees with the paper"
    return (
        f"D2 peaks at {near:.0f} dB, D3 at {far:.0f} dB. {held}, which sees no clear peak at D2 and the body's D3 "
        "above it (section 3.5)."
    )


def _body_figure(run: RunData, name: str, title: str, far: bool) -> PlotFigure:
    panels, said = [], "No data."
    for signal in signals_of(run, "body")[:1]:
        axis = np.array(signal["path_m"])
        curves = (
            Line("with the walker's body", "0", axis, np.array(signal["with_db"])),
            Line("without", "1", axis, np.array(signal["without_db"]), "dashed"),
        )
        obstacle, detour = signal["obstacle_m"], signal["detour_m"]
        if far:
            guides: tuple[Guide, ...] = (
                Guide("x", obstacle, "D2: the wall"),
                Guide("x", obstacle + detour, "D3: over the body"),
            )
            ends = (obstacle - 0.6, obstacle + detour + 0.6)
            said = f"The body's detour is {100 * detour:.0f} cm of path, {detour / 0.125:.1f} pulse widths. " + _peaks(
                signal
            )
        else:
            marks = ("case_m", "through the case"), ("direct_m", "through the air"), ("body_m", "the body")
            guides = tuple(Guide("x", signal[key], words) for key, words in marks if key in signal)
            ends = (-0.1, 1.6)
            said = (
                f"The body's echo follows the direct sound in the air by {100 * detour:.0f} cm of path; sound through "
                "the case comes first, and both together peak in between."
            )
        inside = (axis >= ends[0]) & (axis <= ends[1])
        top = max(float(line.y[inside].max()) for line in curves)
        panels.append(
            Panel(
                "",
                "path (m)",
                "level (dB re direct sound)",
                curves,
                guides,
                x_range=ends,
                y_range=(top - 60.0, top + 4.0),
                width_in=5.6,
            )
        )
    return PlotFigure(
        name,
        title,
        tuple(panels),
        said,
        "A standing phone, a wall straight ahead; path from the speaker to microphone 2.",
    )
