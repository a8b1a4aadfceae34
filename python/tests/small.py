"""Recordings that a diagnosis is soon done with."""

import numpy as np

import pitchid


def small(path, seed):
    """A recording of 20 s that a diagnosis is soon done with."""
    generator = np.random.default_rng(seed)
    t = np.arange(1000) * 0.02
    u = 0.02 * np.sign(np.sin(0.9 * t * (1 + 0.2 * np.sin(t))))
    q = np.zeros_like(t)
    for k in range(len(t) - 1):
        q[k + 1] = q[k] + 0.02 * (100 * u[k] - 2 * q[k]) + 0.01 * generator.normal()
    columns = {"t_s": t, "u_rad": u, "q_rad_s": q + 0.005 * generator.normal(size=t.size)}
    pitchid.Recording.from_arrays(columns, splits=[10.0]).to_csv(path)
