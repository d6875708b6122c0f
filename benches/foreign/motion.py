"""References of a recording: positions and velocities of all joints every millisecond."""
import math

import numpy as np

PERIOD = 1e-3
RISE = 0.2  # [s] to the speed of a step of the staircase


def staircase(low, high, draw, top=0.5, levels=6, longest=2.5):
    """One joint after the other moves to and fro at constant speeds, up to `top` [rad/s], while the others hold a pose."""
    middle = 0.5 * (low + high)
    pieces = [hold(middle, 1.0)]
    for k in range(len(low)):
        for speed in np.geomspace(0.015, top, levels):
            start = middle.copy()
            duration = min(longest, 0.8 * (high[k] - low[k]) / speed)
            start[k] -= 0.5 * speed * duration
            pieces.append(move(pieces[-1][0][-1], start, max(0.5, 4 * abs(start - pieces[-1][0][-1]).max())))
            for sign in (1, -1):
                pieces.append(hold(pieces[-1][0][-1], draw.uniform(0.2, 0.5)))
                pieces.append(ramp(pieces[-1][0][-1], k, sign * speed, duration))
    return join(pieces)


def ramp(pose, joint, speed, duration):
    q, v = hold(pose, duration + RISE)
    t = PERIOD * np.arange(len(q))
    v[:, joint] = speed * np.minimum(1, np.minimum(t, duration + RISE - t) / RISE)
    q[:, joint] += PERIOD * np.cumsum(v[:, joint])
    return q, v


def sines(low, high, draw, duration, top):
    """Three sines a joint within the box, at most `top` [rad/s] fast."""
    t = np.arange(0, duration, PERIOD)
    rise = np.minimum(1, np.minimum(t, duration - t) / 2)
    rise = rise * rise * (3 - 2 * rise)
    q = np.empty((len(t), len(low)))
    for k in range(len(low)):
        wave = sum(draw.uniform(0.4, 1) * np.sin(2 * math.pi * draw.uniform(0.06, 0.4) * t + draw.uniform(0, 6.3)) for _ in range(3))
        wave /= max(abs(wave).max(), 0.5 * (high[k] - low[k]) * abs(np.gradient(wave, PERIOD)).max() / top)
        q[:, k] = 0.5 * (low[k] + high[k]) + 0.5 * (high[k] - low[k]) * wave * rise
    return q, np.gradient(q, PERIOD, axis=0)


def poses(low, high, draw, duration, top):
    """Point to point between random poses, with rests of 0.2 to 1.5 s."""
    pieces = [hold(0.5 * (low + high), 1.0)]
    while sum(len(q) for q, _ in pieces) * PERIOD < duration:
        here, there = pieces[-1][0][-1], draw.uniform(low, high)
        pieces.append(move(here, there, 1.875 * abs(there - here).max() / (top * draw.uniform(0.4, 1))))
        pieces.append(hold(there, draw.uniform(0.2, 1.5)))
    return join(pieces)


def hold(pose, duration):
    q = np.tile(pose, (max(1, round(duration / PERIOD)), 1))
    return q, np.zeros_like(q)


def move(here, there, duration):
    """Polynomial of fifth degree, at rest at both ends."""
    s = np.linspace(0, 1, max(2, round(duration / PERIOD)))[:, None]
    way = there - here
    return here + way * s**3 * (10 - 15 * s + 6 * s**2), way * 30 * s**2 * (1 - s) ** 2 / duration


def join(pieces):
    return tuple(np.concatenate(part) for part in zip(*pieces))
