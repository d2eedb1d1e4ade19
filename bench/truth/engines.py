# SPDX-License-Identifier: Apache-2.0
"""The programs that worlds are given to, and what comes back: a Run, whose rows no engine has judged."""

import json
import os
import subprocess
from pathlib import Path

import numpy

FOLDER = Path(__file__).resolve().parent
PEERS = {name: peer for name, peer in json.loads((FOLDER / "peers.json").read_text()).items() if name != "about"}


class Run:
    """What became of a world: a row a step, after it. Lengths in m, times in s."""

    def __init__(self, world, rows):
        self.world = world
        self.at, self.attitude = rows[:, 0:3], rows[:, 3:7]
        self.kinetic, self.stored, self.contacts, self.us = rows[:, 7], rows[:, 8], rows[:, 9], rows[:, 10]
        self.travel = rows[:, 11:]
        self.time = world["step"] * numpy.arange(1, len(rows) + 1)
        self.whole = len(rows) == round(world["duration"] / world["step"]) and bool(numpy.isfinite(rows[-1, :7]).all())

    def along(self):
        """How far the object has gone along the world's load [m]."""
        return (self.at - numpy.asarray(self.world["at"], float)) @ numpy.asarray(self.world["along"], float)


class Engine:
    """A program that answers worlds."""

    def __init__(self, name, command, folder):
        self.name, self.peer, self.version, self.build = name, PEERS[name], "", None
        self._command, self._folder = command, Path(folder)
        self._folder.mkdir(parents=True, exist_ok=True)
        self._log = open(self._folder / f"{name}.log", "wb")  # What engines say beside their answers.
        self._start()

    def _start(self):
        self._process = subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log,
                                         env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "TRUTH_FOLDER": str(self._folder)})

    def run(self, world):
        """Runs a world; an engine that refuses it raises RuntimeError."""
        if self.peer.get("fresh"):
            self._end()
            self._start()
        self._process.stdin.write((json.dumps(world) + "\n").encode())
        self._process.stdin.flush()
        head = self._process.stdout.readline()
        if not head:
            raise RuntimeError(f"{self.name} ended")
        head = json.loads(head)
        if "error" in head:
            raise RuntimeError(f"{self.name}: {head['error']}")
        self.version, self.build = head["engine"], head.get("build")
        size = 8 * head["rows"] * head["columns"]
        return Run(world, numpy.frombuffer(self._process.stdout.read(size)).reshape(head["rows"], head["columns"]))

    def _end(self):
        self._process.stdin.close()
        self._process.wait()

    def close(self):
        self._end()
        self._log.close()


def commands(build):
    """{engine: its command} of those that were built in this folder, and of node's where their packages are."""
    build, found = Path(build), {}
    for name, peer in PEERS.items():
        program = build / "bench" / peer["program"]
        if peer["program"].endswith(".mjs"):
            modules = build / "truth" / "node_modules"
            if (modules / peer["package"]).exists():
                found[name] = ["node", str(FOLDER / "peers" / peer["program"]), str(modules)]
        elif program.exists():
            found[name] = [str(program)]
    return found
