#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every command of the program under faults, and holds what comes of it against what it does without.

faults.py THENAR LIBRARY [--seconds S] [--seed N] [--out FOLDER]

Faults: calls that fail (LIBRARY, of inject.cpp), limits on memory, stack, files and their size; SIGINT, SIGTERM, SIGKILL
and SIGSTOP at random times, and while figures are drawn; standard streams that are closed; recordings into pipes that
nobody reads, or no longer; inputs edited, cut or removed in the middle; the same command twice at once. What must hold:

    no crash and no hang        it ends by itself, with an exit code that is documented; killed only if it was killed
    nothing wrong with 0        if it ends as without a fault, its results are those, times aside
    said                        if it ends otherwise, stderr has a word of it
    nothing destroyed           its inputs are what they were
    nothing cut                 a figure is whole or not there, and so is a recording of a run that was not killed
    nothing lost                a sweep that did not finish is finished by the same command, to the same rows

Exit code 1, and a line for each finding with the seed that repeats it, if one of them does not."""

import argparse
import collections
import json
import math
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCUMENTED = {0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13}
CALLS = {"open": ("EMFILE", "EACCES"), "read": ("EIO",), "write": ("ENOSPC", "EIO"), "sync": ("EIO",),
         "rename": ("EIO",), "malloc": ("ENOMEM",)}
INTERNAL = 1  # What only a defect ends with.
TIMEOUT_S = 60.0
TIMES = re.compile(r"_us$|_s$|real_time|compute|machine|host|rate|started|version|core|threads|stages|time")


class Command:
    """A command line in a folder that has scene.yaml, hand.yaml and what `needs` made, and what it leaves."""

    def __init__(self, name, *words, results=(), repeats=False, ended_after_s=None):
        self.name, self.words, self.results, self.repeats = name, words, results, repeats
        self.ended_after_s = ended_after_s  # By SIGINT: it goes on until then.


COMMANDS = [
    Command("run", "run", "scene.yaml", "--quiet", "--out", "out", "--record", "run.mcap",
            results=("out/summary.json", "out/signals.csv")),
    Command("lockstep", "run", "scene.yaml", "--quiet", "--lockstep", "--out", "out", results=("out/signals.csv",)),
    Command("realtime", "run", "scene.yaml", "--quiet", "--realtime", "--no-realtime", "--out", "out",
            "--trace", "trace.json"),
    Command("dump", "run", "scene.yaml", "--quiet", "--dump-problems", "dumped", results=("dumped",)),
    Command("sweep", "sweep", "scene.yaml", "--out", "out", "--vary", "contact.friction=0.4:0.8:4",
            results=("out/rows.csv",), repeats=True),
    Command("solve", "solve", "problems/contact-0.fcp", "problems/grasp-0.json"),
    Command("check", "check", "scene.yaml", "--format", "json"),
    Command("import", "hand", "import", "gripper.xml", "--tips", "thumb=thumb_2:@24/1/-3mm,fore=fore_cap,little=little_tip",
            "--out", "made.yaml", results=("made.yaml",)),
    Command("doctor", "doctor"),
    Command("demo", "demo", "scene.yaml", "--port", "0", "--record", "run.mcap", ended_after_s=1.0),
    Command("export csv", "export", "ready.mcap", "--csv", "table.csv", results=("table.csv",)),
    Command("export html", "export", "ready.mcap", "--html", "page.html", results=("page.html",)),
]


def without_times(value):
    """Of a summary, what the scene alone decides."""
    if isinstance(value, dict):
        return {key: without_times(part) for key, part in value.items() if not TIMES.search(key)}
    return [without_times(part) for part in value] if isinstance(value, list) else value


def contents(path):
    """A result as it can be compared."""
    if path.is_dir():
        return {file.name: contents(file) for file in sorted(path.iterdir())}
    if not path.exists():
        return None
    if path.suffix == ".json":
        try:
            return without_times(json.loads(path.read_text()))
        except ValueError:
            return "cut"
    return path.read_bytes()


class Finding(Exception):
    pass


class Trial:
    def __init__(self, options, clean, seed):
        self.options, self.clean, self.random = options, clean, random.Random(seed)
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="thenar-faults-"))
        shutil.copytree(options.inputs, self.folder, dirs_exist_ok=True)
        self.stopped = self.edited = self.silent = False

    def start(self, command, environment=None, limits=None, closed=()):
        def limit():
            for what, value in (limits or {}).items():
                resource.setrlimit(what, (value, value))
            for stream in closed:
                os.close(stream)
        process = subprocess.Popen([self.options.thenar, *command.words], cwd=self.folder, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
                                   preexec_fn=limit if limits or closed else None,
                                   env={**os.environ, **(environment or {})}, start_new_session=True)
        process.ended_after_s = command.ended_after_s
        return process

    def wait(self, process):
        try:
            if process.ended_after_s is not None:
                try:
                    process.wait(process.ended_after_s)
                except subprocess.TimeoutExpired:
                    process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=TIMEOUT_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            raise Finding(f"still running after {TIMEOUT_S:g} s")
        return process.returncode, said.decode(errors="replace")

    def inputs(self):
        return {file.name: file.read_bytes() for file in self.folder.iterdir() if file.suffix in (".yaml", ".mcap")
                and file.name != "run.mcap"}

    # Faults: each starts the command and returns its processes.

    def failing_call(self, command):
        call = self.random.choice(list(CALLS))
        error = self.random.choice(CALLS[call])
        most = 4000 if call == "malloc" else 60
        fault = f"{call}:{error}:{int(math.exp(self.random.uniform(0.0, math.log(most))))}"
        if self.random.random() < 0.5:
            fault += ":once"
        self.what = fault
        return [self.start(command, {"FAULT": fault, "FAULT_IN": "thenar", "LD_PRELOAD": self.options.library})]

    def limited(self, command):
        name, what, low, high = self.random.choice([
            ("memory", resource.RLIMIT_AS, 30e6, 3e9), ("stack", resource.RLIMIT_STACK, 64e3, 8e6),
            ("open files", resource.RLIMIT_NOFILE, 4, 64), ("file size", resource.RLIMIT_FSIZE, 1, 3e5)])
        value = int(math.exp(self.random.uniform(math.log(low), math.log(high))))
        self.what = f"{name} limited to {value}"
        return [self.start(command, limits={what: value})]

    def signalled(self, command):
        which = self.random.choice([signal.SIGINT, signal.SIGTERM, signal.SIGKILL, signal.SIGSTOP])
        after_s = self.random.uniform(0.0, 1.2) * self.clean[command.name]["seconds"]
        self.what = f"{which.name} after {after_s:.3f} s"
        process = self.start(command)
        self.stopped = which != signal.SIGSTOP

        def send():
            time.sleep(after_s)
            if process.poll() is None:
                process.send_signal(which)
                if which == signal.SIGSTOP:
                    time.sleep(0.3)
                    process.send_signal(signal.SIGCONT)
        threading.Thread(target=send, daemon=True).start()
        return [process]

    def closed_streams(self, command):
        closed = [stream for stream in (0, 1, 2) if self.random.random() < 0.6] or [2]
        self.what = f"without the streams {closed}"
        self.silent = 2 in closed
        return [self.start(command, closed=closed)]

    def signalled_drawing(self, command):
        """A signal as soon as the numbers are there: figures follow."""
        which = self.random.choice([signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
        after_s = self.random.uniform(0.0, 0.5)
        self.what = f"{which.name} {after_s:.3f} s after signals.csv"
        self.stopped = True
        process = self.start(command)

        def send():
            while not (self.folder / "out" / "signals.csv").exists() and process.poll() is None:
                time.sleep(0.005)
            time.sleep(after_s)
            if process.poll() is None:
                process.send_signal(which)
        threading.Thread(target=send, daemon=True).start()
        return [process]

    def pipe_recording(self, command):
        """A recording into a pipe: without a reader, with one that goes, or with one that stops reading."""
        if "run.mcap" not in command.words:
            return self.signalled(command)
        os.mkfifo(self.folder / "run.mcap")
        how = self.random.choice(["no reader", "reader goes", "reader stops"])
        self.what = f"recording into a pipe: {how}"
        self.stopped = True
        reader = None
        if how != "no reader":
            reader = os.open(self.folder / "run.mcap", os.O_RDONLY | os.O_NONBLOCK)
        process = self.start(command)
        after_s = self.random.uniform(0.0, 1.0) * self.clean[command.name]["seconds"]

        def leave():
            time.sleep(after_s)
            if how == "reader goes":
                os.close(reader)
            elif how == "reader stops":
                time.sleep(2.0)  # What it writes by then waits for a reader.
                if process.poll() is None:
                    process.send_signal(signal.SIGTERM)
        threading.Thread(target=leave, daemon=True).start()
        return [process]

    def edited_input(self, command):
        name = self.random.choice([word for word in ("scene.yaml", "hand.yaml", "ready.mcap", "gripper_thumb.xml")
                                   if (self.folder / word).exists()])
        how = self.random.choice(["cut", "removed", "replaced", "away"])
        after_s = self.random.uniform(0.0, 1.0) * self.clean[command.name]["seconds"]
        self.what = f"{name} {how} after {after_s:.3f} s"
        self.edited = True
        path = self.folder / name
        process = self.start(command)

        def edit():
            time.sleep(after_s)
            data = path.read_bytes()
            if how == "cut":
                path.write_bytes(data[:self.random.randrange(len(data))])
            elif how == "replaced":
                path.write_bytes(data.replace(b"friction: 0.", b"friction: 0.9"))
            else:
                path.unlink()
                time.sleep(0.1)
                if how == "away":
                    path.write_bytes(data)
        thread = threading.Thread(target=edit, daemon=True)
        thread.start()
        process.wait_for = thread
        return [process]

    def twice(self, command):
        self.what = "twice at once"
        return [self.start(command), self.start(command)]

    def judge(self, command, code, said):
        clean = self.clean[command.name]
        if code < 0 and not (self.stopped and -code in (signal.SIGKILL, signal.SIGINT, signal.SIGTERM)):
            raise Finding(f"ended by {signal.Signals(-code).name}: {said[-300:]}")
        if code > 0 and code not in DOCUMENTED | {130, 143}:
            raise Finding(f"exit code {code} is not documented")
        if code == INTERNAL and "memory" not in self.what and "malloc" not in self.what:
            raise Finding(f"internal error: {said[-300:]}")
        if code > 0 and code != clean["code"] and not said.strip() and not self.silent:
            raise Finding(f"exit code {code} without a word")
        for figure in (self.folder / "out").glob("*.svg"):
            if not figure.read_text(errors="replace").rstrip().endswith("</svg>"):
                raise Finding(f"{figure.name} is cut")
        if code == clean["code"] and not self.edited and not self.stopped:
            for result in command.results:
                if contents(self.folder / result) != clean["results"][result]:
                    raise Finding(f"exit code {code}, and {result} is not as without a fault")

    def run(self, command):
        kind = self.random.choice([self.failing_call, self.failing_call, self.failing_call, self.limited,
                                   self.edited_input, self.twice, self.signalled, self.signalled_drawing,
                                   self.closed_streams, self.pipe_recording])
        self.kind, self.what = kind.__name__.replace("_", " "), ""
        before = self.inputs()
        processes = kind(command)
        ended = [self.wait(process) for process in processes]
        for process in processes:
            if hasattr(process, "wait_for"):
                process.wait_for.join()
        for code, said in ended:
            self.judge(command, code, said)
        after = self.inputs()
        if not self.edited and any(after.get(name) != data for name, data in before.items()):
            raise Finding("an input is not what it was")
        if command.repeats and not self.edited:
            code, said = self.wait(self.start(command))
            if code != self.clean[command.name]["code"]:
                raise Finding(f"the same command again ends with {code}: {said[-300:]}")
            for result in command.results:
                if contents(self.folder / result) != self.clean[command.name]["results"][result]:
                    raise Finding(f"the same command again leaves another {result}")
        return [code for code, _ in ended]


def make_inputs(options, folder):
    """Scene and hands, problems, and a recording."""
    scene = (ROOT / "configs" / "minimal.yaml").read_text()
    (folder / "scene.yaml").write_text(re.sub(r"duration: [^,}\n]+", "duration: 0.3 s", scene))
    shutil.copy(ROOT / "configs" / "hand.yaml", folder)
    for hand in (ROOT / "tests" / "data" / "hands").glob("gripper*.xml"):
        shutil.copy(hand, folder)
    for words in (("run", "scene.yaml", "--quiet", "--record", "ready.mcap"),
                  ("run", "scene.yaml", "--quiet", "--dump-problems", "problems")):
        subprocess.run([options.thenar, *words], cwd=folder, check=True)


def clean_runs(options):
    clean = {}
    page = pathlib.Path(options.thenar).parents[1] / "share" / "thenar" / "page.html"
    for command in list(COMMANDS):
        if "--html" in command.words and not page.exists():
            print("faults: without the page, which needs npm, nothing is exported to HTML")
            COMMANDS.remove(command)
            continue
        trial = Trial(options, clean, 0)
        start = time.monotonic()
        code, said = trial.wait(trial.start(command))
        seconds = time.monotonic() - start
        results = {result: contents(trial.folder / result) for result in command.results}
        if any(result is None for result in results.values()):
            sys.exit(f"faults: {command.name} leaves no {', '.join(r for r in results if results[r] is None)}: {said}")
        clean[command.name] = {"code": code, "seconds": seconds, "results": results}
        shutil.rmtree(trial.folder)
    return clean


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("thenar")
    parser.add_argument("library")
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=None, help="repeats one trial, and keeps its folder")
    parser.add_argument("--out", type=pathlib.Path, help="folder for faults.json")
    options = parser.parse_args()
    options.thenar, options.library = os.path.abspath(options.thenar), os.path.abspath(options.library)
    with tempfile.TemporaryDirectory(prefix="thenar-faults-inputs-") as inputs:
        options.inputs = pathlib.Path(inputs)
        make_inputs(options, options.inputs)
        clean = clean_runs(options)
        first = options.seed if options.seed is not None else random.SystemRandom().randrange(1, 2**31)
        end = time.monotonic() + options.seconds
        trials, codes, findings = collections.Counter(), collections.Counter(), []
        seed = first
        print(f"faults: seeds from {first} on")
        while True:
            trial = Trial(options, clean, seed)
            command = trial.random.choice(COMMANDS)
            try:
                codes.update(trial.run(command))
            except Finding as finding:
                findings.append(f"seed {seed}: {command.name}, {trial.what}: {finding}")
                print(findings[-1], flush=True)
            trials[trial.kind] += 1
            if options.seed is not None:
                print(f"faults: {command.name}, {trial.what}; folder {trial.folder}")
                break
            shutil.rmtree(trial.folder, ignore_errors=True)
            seed += 1
            if time.monotonic() > end:
                break
    print(f"faults: {sum(trials.values())} trials, {len(findings)} findings; "
          + ", ".join(f"{count} {kind}" for kind, count in trials.most_common()) + "; exit codes "
          + ", ".join(f"{code}: {count}" for code, count in sorted(codes.items())))
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        (options.out / "faults.json").write_text(json.dumps(
            {"first_seed": first, "seconds": options.seconds, "trials": trials, "exit_codes": codes, "findings": findings}, indent=2))
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
