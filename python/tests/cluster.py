"""A scheduler and workers, each a process of its own, over TCP on this machine."""

import os
import signal
import socket
import subprocess
import sys
import time

import distributed


class Cluster:
    """Started as people start it: ``dask scheduler`` and ``dask worker``."""

    def __init__(self, folder, workers=2):
        self.folder, self.workers = folder, []
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.scheduler = self._start("scheduler", "--port", str(self.port), "--no-dashboard")
        self.start_workers(workers)

    def _start(self, what, *arguments):
        with open(self.folder / f"{what}-{time.monotonic_ns()}.log", "wb") as log:
            command = [sys.executable, "-m", "dask", what, "--host", "127.0.0.1", *arguments]
            return subprocess.Popen(command, cwd=self.folder, stdout=log, stderr=log)

    def start_workers(self, count):
        local = ["--local-directory", str(self.folder / "workers"), "--no-dashboard"]
        self.workers += [self._start("worker", self.address, "--nthreads", "1", *local) for _ in range(count)]

    def client(self, workers=2):
        client = distributed.Client(self.address, timeout="60s", set_as_default=False)
        client.wait_for_workers(workers, timeout=120)
        return client

    def kill_scheduler(self):
        self.scheduler.kill()
        self.scheduler.wait()

    def close(self):
        for process in [*self.workers, self.scheduler]:
            process.terminate()
        for process in [*self.workers, self.scheduler]:
            try:
                process.wait(timeout=3)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def kill_a_worker(client, generator):
    """Kills a worker's process without a word; its nanny starts another."""
    pids = []
    while not pids:
        # one that was killed before may not be back
        pids = list(client.run(os.getpid, on_error="ignore").values())
        time.sleep(0.05)
    pid = pids[generator.integers(len(pids))]
    os.kill(pid, signal.SIGKILL)
    return pid
