# SPDX-License-Identifier: Apache-2.0
"""Writes tests/data/stiff_muscles.json: least muscle effort under an object stiffness, by an interior-point method that
shares nothing with the solver. The problems are drawn from seeds by the generator of bench/cases/stiff_problems.h, which
is written here once more; only what was found of them is in the file. Needs numpy alone, and takes some minutes:
    python3 tests/solvers/stiff_muscles_reference.py tests/data/stiff_muscles.json"""

import json
import sys

import numpy as np

LENGTH_M = 0.025  # Rotations are measured on this arm.
SCALE = np.diag([1.0, 1.0, 1.0, 1 / LENGTH_M, 1 / LENGTH_M, 1 / LENGTH_M])


class Random:
    """Mersenne twister of 64 bits, as std::mt19937_64, and the distributions of bench/cases/random.h."""

    def __init__(self, seed):
        self.words = [seed]
        for i in range(1, 312):
            last = self.words[-1]
            self.words.append((6364136223846793005 * (last ^ (last >> 62)) + i) & 0xFFFFFFFFFFFFFFFF)
        self.at = 312

    def twist(self):
        w = self.words
        for i in range(312):
            x = (w[i] & 0xFFFFFFFF80000000) | (w[(i + 1) % 312] & 0x7FFFFFFF)
            w[i] = w[(i + 156) % 312] ^ (x >> 1) ^ (0xB5026F5AA96619E9 if x & 1 else 0)
        self.at = 0

    def next(self):
        if self.at == 312:
            self.twist()
        x = self.words[self.at]
        self.at += 1
        x ^= (x >> 29) & 0x5555555555555555
        x ^= (x << 17) & 0x71D67FFFEDA60000
        x ^= (x << 37) & 0xFFF7EEE000000000
        return x ^ (x >> 43)

    def real(self, low, high):
        return low + (high - low) * ((self.next() >> 11) * 2.0**-53)

    def chance(self, part):
        return self.real(0.0, 1.0) < part


def skew(p):
    return np.array([[0.0, -p[2], p[1]], [p[2], 0.0, -p[0]], [-p[1], p[0], 0.0]])


def symmetric(random, n, size):
    S = np.zeros((n, n))
    for i in range(n):
        for c in range(i + 1):
            S[i, c] = S[c, i] = random.real(-size, size)
    return S


class Problem:
    pass


def add_finger(random, p, k, n):
    """A fingertip's springs against the object, and the joints behind it."""
    side = -1.0 if k == 0 else 1.0
    spread = 0.02 * (k - 0.5 * p.fingers) if k > 0 else 0.0
    point = np.array([0.022 * side, spread + random.real(-3e-3, 3e-3), random.real(-3e-3, 3e-3)])
    normal = np.array([-side, random.real(-0.2, 0.2), random.real(-0.2, 0.2)])
    normal = normal / np.sqrt(normal @ normal)
    stiff = random.real(2000.0, 5000.0)
    nn = np.outer(normal, normal)
    spring = np.zeros((6, 6))
    spring[:3, :3] = stiff * (nn + 0.67 * (np.eye(3) - nn))
    spring[3:, 3:] = 1e-5 * stiff * (nn + 0.5 * (np.eye(3) - nn))
    J = np.zeros((6, n))
    for c in range(n):
        arm = np.array([side * random.real(0.0, 0.02), random.real(-0.01, 0.01), -0.09 * (n - c) / n])
        axis = np.array([1.0 if c == 0 else 0.1, 0.1 if c == 0 else 1.0, random.real(-0.2, 0.2)])
        axis = axis / np.sqrt(axis @ axis)
        J[:3, c] = np.cross(axis, arm)
        J[3:, c] = axis
    grasp = np.eye(6)
    grasp[3:, :3] = skew(point)
    rows = slice(k * n, (k + 1) * n)
    p.A += grasp @ spring @ grasp.T
    p.B[:, rows] = grasp @ spring @ J
    p.D[rows, rows] = J.T @ spring @ J + symmetric(random, n, 0.01) - 0.02 * np.eye(n)


def add_muscle(random, p, j, n):
    own = j % p.fingers
    turn = j // p.fingers
    p.gain[j] = 23.4 / random.real(0.04, 0.08)
    p.tendon[j] = random.real(2e4, 2e5)
    p.limit[j] = random.real(60.0, 250.0)
    for part in range(2):
        if part == 1 and not random.chance(0.08):
            break
        k = (own + part) % p.fingers
        for c in range(n):
            arm = random.real(3e-3, 12e-3)
            is_crossed = turn < 2 or random.chance(0.8)
            negative = random.chance(0.5)
            sign = (1.0 if turn == 0 else -1.0) if turn < 2 and c > 0 else (-1.0 if negative else 1.0)
            p.H[k * n + c, j] = sign * arm if is_crossed else 0.0
        p.G[k][j] = symmetric(random, n, 3e-3)


def draw(seed, fingers, n, muscles, tendons, squeeze):
    random = Random(seed)
    p = Problem()
    p.fingers, p.n = fingers, n
    joints = fingers * n
    p.A, p.B, p.D = np.zeros((6, 6)), np.zeros((6, joints)), np.zeros((joints, joints))
    for k in range(fingers):
        add_finger(random, p, k, n)
    p.A[3:, 3:] += symmetric(random, 3, 0.02) - 0.06 * np.eye(3)
    p.H = np.zeros((joints, muscles))
    p.G = [[np.zeros((n, n)) for _ in range(muscles)] for _ in range(fingers)]
    p.gain, p.tendon, p.limit = np.zeros(muscles), np.zeros(muscles), np.zeros(muscles)
    for j in range(muscles):
        add_muscle(random, p, j, n)
    if not tendons:
        p.tendon[:] = np.inf
    f = np.zeros(muscles)
    for j in range(muscles):
        f[j] = random.real(0.0, 1.0)
        f[j] = 0.1 * p.limit[j] * f[j] * f[j]
    p.tau = p.H @ f
    off = symmetric(random, 6, 10.0)
    p.wanted = np.linalg.inv(SCALE) @ (100.0 * np.eye(6) + off) @ np.linalg.inv(SCALE)
    p.kappa = 0.005
    p.has_squeeze = squeeze
    p.low, p.high, p.weight = 0.0, 5.0, 20.0
    p.tau_1, p.A_1, p.B_1, p.D_1 = np.zeros(joints), np.zeros((6, 6)), np.zeros((6, joints)), np.zeros((joints, joints))
    if squeeze:
        for j in range(muscles):
            f[j] = random.real(0.0, 1.0)
        p.tau_1 = p.H @ f
        p.A_1[3:, 3:] = symmetric(random, 3, 0.01) - 0.01 * np.eye(3)
        p.A_1[:3, :3] = 200.0 * np.eye(3)
        for k in range(fingers):
            rows = slice(k * n, (k + 1) * n)
            p.D_1[rows, rows] = symmetric(random, n, 0.004)
            for i in range(6):
                for c in range(n):
                    p.B_1[i, k * n + c] = random.real(-0.5, 0.5)
    return p


class Blocks:
    """All limits as matrices that must be positive, concave in x = (f, s, t): diagonal ones and two of stiffness."""

    def __init__(self, p, K_des, elastic, K_1):
        self.p, self.K_des, self.elastic, self.K_1 = p, K_des, elastic, K_1
        m, joints = p.H.shape
        m = p.H.shape[1]
        self.m, self.joints = m, p.H.shape[0]
        self.stiff = np.zeros((m, self.joints, self.joints))
        self.turns = np.zeros((m, self.joints, self.joints))
        for k in range(p.fingers):
            r = slice(k * p.n, (k + 1) * p.n)
            for j in range(m):
                a = p.H[r, j]
                self.stiff[j, r, r] = np.outer(a, a)
                self.turns[j, r, r] = p.G[k][j]

    def posture(self, x):
        p = self.p
        f, s = x[: self.m], x[self.m]
        give = 1.0 / p.gain + f / p.tendon
        k, dk, ddk = f / give, 1.0 / p.gain / give**2, -2.0 / p.gain / p.tendon / give**3
        P = p.D + s * p.D_1 + np.tensordot(k, self.stiff, 1) - np.tensordot(f, self.turns, 1)
        dP = dk[:, None, None] * self.stiff - self.turns
        return P, dP, ddk

    def matrices(self, x):
        """(value, first derivatives, diagonal second ones) of each block."""
        p, m, n = self.p, self.m, self.joints
        s, t = x[m], x[m + 1]
        P, dP, ddk = self.posture(x)
        dP_all = np.concatenate([dP, p.D_1[None], np.zeros((1, n, n))])
        ddP = np.concatenate([ddk[:, None, None] * self.stiff, np.zeros((2, n, n))])
        big, dbig, ddbig = np.zeros((6 + n, 6 + n)), np.zeros((m + 2, 6 + n, 6 + n)), np.zeros((m + 2, 6 + n, 6 + n))
        big[:6, :6] = SCALE @ (p.A + s * p.A_1 - self.K_des + t * self.K_1) @ SCALE
        big[:6, 6:] = SCALE @ (p.B + s * p.B_1)
        big[6:, :6] = big[:6, 6:].T
        big[6:, 6:] = P
        dbig[:, 6:, 6:] = dP_all
        dbig[m, :6, :6] = SCALE @ p.A_1 @ SCALE
        dbig[m, :6, 6:] = SCALE @ p.B_1
        dbig[m, 6:, :6] = dbig[m, :6, 6:].T
        dbig[m + 1, :6, :6] = SCALE @ self.K_1 @ SCALE
        ddbig[:, 6:, 6:] = ddP
        posture = P - p.kappa * np.eye(n)
        if self.elastic:
            dP_all[m + 1] = 1e-3 * np.eye(n)
            dbig[m + 1, 6:, 6:] += 1e-3 * np.eye(n)
            posture = posture + 1e-3 * t * np.eye(n)
            big[6:, 6:] += 1e-3 * t * np.eye(n)
        return [(big, dbig, ddbig), (posture, dP_all, ddP)]

    def slacks(self, x):
        """Bounds: (values, rows)."""
        p, m = self.p, self.m
        eye = np.eye(m + 2)
        values, rows = [], []
        give = 1.0 * eye[m + 1] if self.elastic else np.zeros(m + 2)
        t = x[m + 1] if self.elastic else 0.0
        for j in range(m):
            values += [x[j] + t, p.limit[j] - x[j] + t]
            rows += [eye[j] + give, -eye[j] + give]
        if p.has_squeeze:
            values += [x[m] - p.low + t, p.high - x[m] + t]
            rows += [eye[m] + give, -eye[m] + give]
        return np.array(values), np.array(rows)


def barrier(blocks, x):
    values, rows = blocks.slacks(x)
    if values.min() <= 0:
        return None
    value, grad, hess = -np.log(values).sum(), -(rows / values[:, None]).sum(0), (rows / values[:, None] ** 2).T @ rows
    for S, dS, ddS in blocks.matrices(x):
        try:
            L = np.linalg.cholesky(S)
        except np.linalg.LinAlgError:
            return None
        inv = np.linalg.inv(S)
        value -= 2.0 * np.log(np.diag(L)).sum()
        T = inv @ dS  # (variables, n, n)
        grad -= np.trace(T, axis1=1, axis2=2)
        hess += np.einsum("iab,jba->ij", T, T) - np.diag(np.einsum("ab,iba->i", inv, ddS))
    return value, grad, hess


def barrier_value(blocks, x):
    values, _ = blocks.slacks(x)
    if values.min() <= 0:
        return None
    value = -np.log(values).sum()
    for S, _, _ in blocks.matrices(x):
        try:
            value -= 2.0 * np.log(np.diag(np.linalg.cholesky(S))).sum()
        except np.linalg.LinAlgError:
            return None
    return value


def minimise(blocks, x, Q, c, free, end, stop=None):
    """min 1/2 x'Qx + c'x on x + free y, inside all limits, from a point inside."""
    weight = 1.0 / max(1e-300, abs(0.5 * x @ Q @ x + c @ x) + 1e-3)
    nu = 2 * blocks.m + 2 + 6 + 2 * blocks.joints
    while True:
        for _ in range(60):
            value, grad, hess = barrier(blocks, x)
            g = free.T @ (grad + weight * (Q @ x + c))
            h = free.T @ (hess + weight * Q) @ free
            d = np.sqrt(np.diag(h))
            y = -np.linalg.solve(h / np.outer(d, d), g / d) / d
            decrement = -g @ y
            step, dx = 1.0, free @ y
            now = value + weight * (0.5 * x @ Q @ x + c @ x)
            while step > 1e-12:
                trial = x + step * dx
                v = barrier_value(blocks, trial)
                if v is not None and v + weight * (0.5 * trial @ Q @ trial + c @ trial) <= now - 0.1 * step * decrement + 1e-12 * abs(now):
                    break
                step *= 0.5
            else:
                break
            x = trial
            if stop is not None and stop(x):
                return x
            if decrement < 1e-9:
                break
        if nu / weight < end * max(1e-12, abs(0.5 * x @ Q @ x + c @ x)):
            return x
        weight *= 4.0


def null_space(p):
    """x = x0 + free y keeps H f = tau + s tau_1; the last column moves t."""
    m = p.H.shape[1]
    E = np.hstack([p.H, -p.tau_1[:, None], np.zeros((p.H.shape[0], 1))])
    if not p.has_squeeze:
        row = np.zeros(m + 2)
        row[m] = 1.0
        E = np.vstack([E, row])
    tau = np.concatenate([p.tau, np.zeros(E.shape[0] - p.tau.size)])
    U, S, Vt = np.linalg.svd(E)
    rank = int((S > 1e-10 * S[0]).sum())
    return np.linalg.lstsq(E, tau, rcond=1e-10)[0], Vt[rank:].T


def inside(p, K_des):
    """A point with slack, or None; with the least t of the elastic limits."""
    m = p.H.shape[1]
    x, free = null_space(p)
    if not np.allclose(p.H @ x[:m] - x[m] * p.tau_1, p.tau, atol=1e-9):
        return None
    blocks = Blocks(p, K_des, True, np.linalg.inv(SCALE) @ np.linalg.inv(SCALE))
    x[m + 1] = 1.0
    while barrier_value(blocks, x) is None:
        x[m + 1] *= 2.0
    c = np.zeros(m + 2)
    c[m + 1] = 1.0
    x = minimise(blocks, x, np.zeros((m + 2, m + 2)), c, free, 1e-7, lambda x: x[m + 1] < -1e-3)
    return x if x[m + 1] < 0 else None


def most(p):
    """The largest theta with K_o >= theta K_wanted that any forces give."""
    m = p.H.shape[1]
    _, free = null_space(p)
    x = inside(p, -1e4 * p.wanted)
    if x is None:
        return None
    x[m + 1] = -1e4
    c = np.zeros(m + 2)
    c[m + 1] = -1.0
    # K_o - t K_wanted.
    blocks = Blocks(p, np.zeros((6, 6)), False, -p.wanted)
    return minimise(blocks, x, np.zeros((m + 2, m + 2)), c, free, 1e-9)[m + 1]


def least_effort(p, theta):
    m = p.H.shape[1]
    x = inside(p, theta * p.wanted)
    if x is None:
        return None
    _, free = null_space(p)
    free = free - np.outer(np.eye(m + 2)[m + 1], free[m + 1])
    U, S, _ = np.linalg.svd(free, full_matrices=False)
    free = U[:, S > 1e-9]
    x[m + 1] = 0.0
    Q = np.eye(m + 2)
    Q[m, m] = p.weight if p.has_squeeze else 0.0
    Q[m + 1, m + 1] = 0.0
    return minimise(Blocks(p, theta * p.wanted, False, np.zeros((6, 6))), x, Q, np.zeros(m + 2), free, 1e-11)


SHAPES = [(3, 4, 23), (3, 4, 23), (2, 4, 16), (3, 4, 23), (2, 3, 10), (5, 4, 39), (3, 5, 30), (4, 4, 30), (3, 3, 20),
          (2, 5, 20)]
# (part of the largest theta, tendons, squeeze)
KINDS = [(0.5, False, False), (0.9, False, False), (0.999, False, False), (1.05, False, False), (0.7, True, False),
         (0.6, False, True), (1.3, True, False), (0.95, True, False), (-1.0, False, False), (0.8, True, True)]


def main(path, count=200):
    found = []
    for i in range(count):
        fingers, n, muscles = SHAPES[(i // 10) % 10]
        part, tendons, squeeze = KINDS[i % 10]
        seed = 1000 + i
        while True:  # Until a hand that can do it at all, and that the method takes.
            p = draw(seed, fingers, n, muscles, tendons, squeeze)
            try:
                theta_most = most(p)
                if theta_most is not None and 0.1 < theta_most < 100.0:
                    theta = float("%.12g" % (part * theta_most if part > 0 else -1e3))
                    x = least_effort(p, theta)
                    if (x is None) == (part > 1):
                        break
                    print("passed over", seed, theta, flush=True)
            except np.linalg.LinAlgError:
                pass
            seed += 1000
        row = {"seed": seed, "fingers": fingers, "joints": n, "muscles": muscles, "tendons": tendons,
               "squeeze": squeeze, "theta": theta, "theta_most": float("%.9g" % theta_most),
               "status": "infeasible" if x is None else "optimal"}
        assert (x is None) == (part > 1), row
        if x is not None:
            m = muscles
            row["effort"] = float("%.12g" % (0.5 * x[:m] @ x[:m] + (0.5 * p.weight * x[m] ** 2 if squeeze else 0.0)))
            row["f"] = [float("%.9g" % v) for v in x[:m]]
            if squeeze:
                row["s"] = float("%.9g" % x[m])
        found.append(row)
        print(i, seed, row["status"], theta_most, row.get("effort"), flush=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write("[\n" + ",\n".join(json.dumps(row) for row in found) + "\n]\n")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 200)
