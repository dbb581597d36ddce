"""The sinusoid that two series share: least squares at every frequency of a grid, with weights that outliers lose.

Of a fit only its normal equations are formed; residuals are those of the likeliest frequency alone.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.signal.echoes import TINY
from obstaclewatch.support.arrays import Complexes, Floats
from obstaclewatch.support.compiled import compiled, inlined

ROUNDS = 3
"""Of the fit, whose weights fall where something else crosses."""
LEAST_LEFT = 0.02
"""Share of the variance below which a better fit no longer counts for a frequency."""


@inlined
def common_sinusoid(
    time_s: Floats, values: Floats, rates_rad_s: Floats, log_prior: Floats
) -> tuple[float, Complexes, Floats]:
    """The likeliest frequency of sinusoids in two series, their phasors, and the shares that they explain.

    Args:
        time_s: (K,).
        values: (2, K) in units of the residual at which a weight has halved; their means are fitted too.
        rates_rad_s: (F,) angular frequencies that are tried, evenly spaced.
        log_prior: (F,) of these.
    """
    cosine, sine = waves(time_s, rates_rad_s)
    best, phasor, share = _robust_fit(cosine, sine, values, log_prior)
    return rates_rad_s[best], phasor, share


@inlined
def waves(time_s: Floats, rates_rad_s: Floats) -> tuple[Floats, Floats]:
    """(K, F) cosines and sines at evenly spaced rates, each rotated on from the one before."""
    cosine, sine = np.empty((2, len(time_s), len(rates_rad_s)))
    for beep in range(len(time_s)):
        step = (rates_rad_s[1] - rates_rad_s[0]) * time_s[beep]
        rotation = complex(np.cos(step), np.sin(step))
        wave = complex(np.cos(rates_rad_s[0] * time_s[beep]), np.sin(rates_rad_s[0] * time_s[beep]))
        for which in range(len(rates_rad_s)):
            cosine[beep, which], sine[beep, which] = wave.real, wave.imag
            wave *= rotation
    return cosine, sine


@inlined
def _robust_fit(cosine: Floats, sine: Floats, values: Floats, log_prior: Floats) -> tuple[int, Complexes, Floats]:
    """The best of F frequencies, (2,) phasors, and (2,) shares explained, from (K, F) cosines and sines."""
    best, phasor, share = 0, np.empty(2, dtype=np.complex128), np.empty(2)
    weight = np.ones(values.shape)
    for _ in range(ROUNDS):
        first, of_first = weighted_fits(cosine, sine, values[0], weight[0])
        second, of_second = weighted_fits(cosine, sine, values[1], weight[1])
        best = _likeliest(of_first, of_second, len(cosine), log_prior)
        share[0], share[1] = of_first[best], of_second[best]
        for row, fit in enumerate((first, second)):
            phasor[row] = complex(fit[0, best], -fit[1, best])
            for beep in range(len(cosine)):
                wave = fit[0, best] * cosine[beep, best] + fit[1, best] * sine[beep, best]
                weight[row, beep] = 1.0 / (1.0 + (values[row, beep] - wave - fit[2, best]) ** 2)
    return best, phasor, share


@inlined
def _likeliest(first: Floats, second: Floats, count: int, log_prior: Floats) -> int:
    """Which frequency is likeliest, from the (F,) shares of two series of so many values that it explains.

    What is left of a series is white and of unknown variance: log likelihood -count / 2 log(left).
    """
    best, most = 0, -np.inf
    for which in range(len(first)):
        left = max(1.0 - first[which], LEAST_LEFT) * max(1.0 - second[which], LEAST_LEFT)
        log = log_prior[which] - 0.5 * count * np.log(left)
        if log > most:
            best, most = which, log
    return best


@compiled
def weighted_fits(cosine: Floats, sine: Floats, values: Floats, weight: Floats) -> tuple[Floats, Floats]:
    """(3, F) coefficients of cosine, sine and 1 that fit (K,) values best, and (F,) the shares that they explain.

    The normal equations of values about their weighted mean, by elimination.
    """
    total, mean, scatter = _moments(values, weight)
    c, s, cc, cs, cv, sv = _products(cosine, sine, values - mean, weight)
    fit, share = np.empty((3, len(c))), np.empty(len(c))
    for which in range(len(c)):
        ss = total - cc[which] - s[which] * s[which] / total
        of_both = cs[which] - c[which] * s[which] / total
        own = cc[which] - c[which] * c[which] / total
        of_sine = (sv[which] - of_both * cv[which] / own) / (ss - of_both * of_both / own)
        of_cosine = (cv[which] - of_both * of_sine) / own
        fit[0, which], fit[1, which] = of_cosine, of_sine
        fit[2, which] = mean - (c[which] * of_cosine + s[which] * of_sine) / total
        share[which] = (of_cosine * cv[which] + of_sine * sv[which]) / scatter
    return fit, share


@inlined
def _moments(values: Floats, weight: Floats) -> tuple[float, float, float]:
    """Sum of the weights, weighted mean of (K,) values, and weighted sum of their squared departures from it."""
    total = moment = scatter = 0.0
    for beep in range(len(values)):
        total += weight[beep]
        moment += weight[beep] * values[beep]
    for beep in range(len(values)):
        scatter += weight[beep] * (values[beep] - moment / total) ** 2
    return total, moment / total, max(scatter, TINY)


@inlined
def _products(cosine: Floats, sine: Floats, values: Floats, weight: Floats) -> Floats:
    """(6, F) weighted sums over beeps: cosine, sine, cosine squared, cosine times sine, and both times the values."""
    products = np.zeros((6, cosine.shape[1]))
    for beep in range(len(cosine)):
        own, heavy = weight[beep], weight[beep] * values[beep]
        for which in range(cosine.shape[1]):  # two sums a loop, so that it is vectorised over frequencies
            products[0, which] += own * cosine[beep, which]
            products[1, which] += own * sine[beep, which]
        for which in range(cosine.shape[1]):
            products[2, which] += own * cosine[beep, which] * cosine[beep, which]
            products[3, which] += own * cosine[beep, which] * sine[beep, which]
        for which in range(cosine.shape[1]):
            products[4, which] += heavy * cosine[beep, which]
            products[5, which] += heavy * sine[beep, which]
    return products
