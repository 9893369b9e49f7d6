#!/usr/bin/env python3
"""What sharing a picture costs: one worker of N threads against N workers of one thread each.

    tests/bench/farm/shared.py BIN [--seconds 60] [--size 512x512] [--scene ajar-door]
        [--method adaptive none] [--workers 2] [--rounds 3] [--latency MS]

BIN is the folder of qrayd. Starts a PostgreSQL of its own, as a user without rights, and lets both
farms render the same job in turns. Prints the paths a second of each, their ratio (the efficiency of
sharing: errors fall with the number of paths, whoever traces them), and what went over the network.
--latency puts a proxy before the database that holds back each packet by half of so many ms, so that
each way there and back takes that much longer.

    tests/bench/farm/shared.py --model RATE [--size 512x512] [--seconds 60] [--latency MS]

prints what a model expects of 2 to 64 workers, each of RATE paths a second: see model().
"""
import argparse
import json
import os
import pathlib
import pwd
import re
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request

PROGRAMS = pathlib.Path('/usr/lib/postgresql/15/bin')
ROOT = pathlib.Path(__file__).resolve().parents[3]


def free_port():
    with socket.socket() as s:
        s.bind(('127.0.0.1', 0))
        return s.getsockname()[1]


class Database:
    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix='qray-shared-'))
        self.user = {}
        if os.getuid() == 0:  # PostgreSQL refuses to be root
            nobody = pwd.getpwnam('nobody')
            os.chown(self.folder, nobody.pw_uid, nobody.pw_gid)
            self.user = {'user': nobody.pw_uid, 'group': nobody.pw_gid, 'extra_groups': []}
        quiet = {'stdout': subprocess.DEVNULL, 'cwd': self.folder, **self.user}
        subprocess.run([PROGRAMS / 'initdb', '-D', self.folder / 'db', '-U', 'qray', '-A', 'trust',
                        '-E', 'UTF8', '--locale=C'], check=True, **quiet)
        self.port = free_port()
        self.process = subprocess.Popen(
            [PROGRAMS / 'postgres', '-D', self.folder / 'db', '-k', self.folder, '-c',
             f'port={self.port}', '-c', 'listen_addresses=127.0.0.1', '-c', 'max_connections=200'],
            stderr=subprocess.DEVNULL, **quiet)
        while subprocess.run([PROGRAMS / 'pg_isready', '-q', '-h', '127.0.0.1', '-p',
                              str(self.port)]).returncode:
            time.sleep(.05)

    def end(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


class Proxy:
    """Holds back what passes, and counts it. A turn of direction is half a way there and back."""

    def __init__(self, port, delay):
        self.target, self.delay = port, delay
        self.bytes = [0, 0]
        self.turns = 0
        self.listener = socket.create_server(('127.0.0.1', 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            client, _ = self.listener.accept()
            try:
                server = socket.create_connection(('127.0.0.1', self.target))
            except OSError:  # the database has ended
                client.close()
                continue
            last = [None]
            for way, (a, b) in enumerate(((client, server), (server, client))):
                for s in (a, b):
                    s.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                threading.Thread(target=self.pump, args=(a, b, way, last), daemon=True).start()

    def pump(self, a, b, way, last):
        queue, there = [], threading.Condition()

        def send():
            while True:
                with there:
                    while not queue:
                        there.wait()
                    due, data = queue.pop(0)
                time.sleep(max(0, due - time.monotonic()))
                try:
                    if not data:
                        return b.shutdown(socket.SHUT_WR)
                    b.sendall(data)
                except OSError:
                    return None

        threading.Thread(target=send, daemon=True).start()
        while True:
            try:
                data = a.recv(1 << 18)
            except OSError:
                data = b''
            self.bytes[way] += len(data)
            if data and last[0] != way:
                last[0] = way
                self.turns += 1
            with there:
                queue.append((time.monotonic() + self.delay / 2, data))
                there.notify()
            if not data:
                return


class Farm:
    running = set()

    def __init__(self, binary, database, workers, threads, latency):
        self.data = pathlib.Path(tempfile.mkdtemp(prefix='qray-shared-data-'))
        self.name = f'farm{time.monotonic_ns()}'
        subprocess.run([PROGRAMS / 'createdb', '-h', '127.0.0.1', '-p', str(database.port), '-U',
                        'qray', self.name], check=True)
        self.proxy = Proxy(database.port, latency / 1000)
        self.port = free_port()
        common = ['--data', self.data, '--store',
                  f'postgresql://qray@127.0.0.1:{self.proxy.port}/{self.name}']
        self.log = open(self.data / 'log', 'w')
        Farm.running.add(self)
        self.processes = []
        for i in range(workers + 1):
            what = (['worker', '--threads', str(threads), '--jobs-at-once', '1'] if i else
                    ['--port', str(self.port), '--jobs-at-once', '0'])
            self.processes.append(subprocess.Popen(
                [binary / 'qrayd', what[0], *what[1:], *common] if i else
                [binary / 'qrayd', *what, *common],
                stdout=subprocess.DEVNULL, stderr=self.log))
            time.sleep(.3)
        for _ in range(200):
            try:
                if len(self.get('/v1/workers')['workers']) == workers + 1:
                    break
            except OSError:
                pass
            time.sleep(.1)

    def get(self, path, body=None):
        request = urllib.request.Request(
            f'http://127.0.0.1:{self.port}{path}', headers={'Content-Type': 'application/json'},
            data=json.dumps(body).encode() if body else None)
        with urllib.request.urlopen(request, timeout=30) as answer:
            text = answer.read().decode()
            return text if path.endswith('/log') else json.loads(text)

    def render(self, job):
        job = self.get('/v1/jobs', job)
        before = list(self.proxy.bytes), self.proxy.turns
        while job['state'] not in ('succeeded', 'failed', 'canceled'):
            time.sleep(.2)
            job = self.get(f"/v1/jobs/{job['id']}")
        if job['state'] != 'succeeded':
            sys.exit(f"the job has {job['state']}: {job['error']}")
        job['sent'] = sum(self.proxy.bytes) - sum(before[0])
        job['turns'] = self.proxy.turns - before[1]
        job['log'] = self.get(f"/v1/jobs/{job['id']}/log").splitlines()
        return job

    def end(self):
        Farm.running = Farm.running - {self}
        for process in self.processes:
            process.send_signal(signal.SIGTERM)
        for process in self.processes:
            process.wait()
        shutil.rmtree(self.data, ignore_errors=True)


def model(rate, pixels, seconds, round_trip, bandwidth, workers, learned_bytes, guide_bytes):
    """The paths of a job of so many seconds over those of as many workers that lose nothing.

    A pass of p samples a pixel takes pixels * p / rate seconds of one worker. Alone, where that is
    under 0.25 s. Shared, it takes that over the number of workers, or as long as its results take
    through the job's worker's network if that is longer, and then what all wait for: half a unit
    at its end; six ways there and back (a result handed in, collected, the next pass begun, seen,
    its table fetched, a unit taken); and the next pass sent to each worker.
    """
    sample_bytes, noise_bytes = 60, 4  # a pixel, of a result, and of a pass that begins
    tile = 64 * 64 / pixels
    done = spent = 0
    while spent < seconds:
        p = min(64, max(1, (1 << (max(1, int(done)).bit_length() - 1)) // 2))
        alone = pixels * p / rate
        if alone < .25:
            spent += alone
        else:
            unit = max(min(alone / 16, .25), tile * alone)
            results = (pixels * sample_bytes + learned_bytes) * (workers - 1) / workers
            begun = (pixels * noise_bytes + guide_bytes) * (workers - 1)
            spent += (max(alone / workers, results * 8 / bandwidth) + unit / 2 + 6 * round_trip +
                      begun * 8 / bandwidth)
        done += p
    return done * pixels / spent / (rate * workers)


def print_model(options, pixels):
    print('workers  1 Gbit/s  10 Gbit/s')
    for workers in (2, 4, 16, 64):
        of = [model(options.model, pixels, options.seconds, options.latency / 1000, bandwidth,
                    workers, learned_bytes=2e6, guide_bytes=1e6) for bandwidth in (1e9, 1e10)]
        print(f'{workers:7d}  {of[0]:8.2f}  {of[1]:9.2f}')


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('binaries', type=pathlib.Path, metavar='BIN', nargs='?')
    parser.add_argument('--model', type=float, metavar='RATE')
    parser.add_argument('--seconds', type=float, default=60)
    parser.add_argument('--size', default='512x512')
    parser.add_argument('--scene', default='ajar-door')
    parser.add_argument('--method', nargs='+', default=['adaptive', 'none'])
    parser.add_argument('--workers', type=int, default=2)
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--latency', type=float, default=0, metavar='MS')
    options = parser.parse_args()
    width, height = map(int, options.size.split('x'))
    if options.model:
        return print_model(options, width * height)
    database = Database()
    try:
        for method in options.method:
            ratios = []
            for turn in range(options.rounds):
                rates = {}
                kinds = [('whole', 1, options.workers), ('shared', options.workers, 1)]
                for kind, workers, threads in kinds if turn % 2 == 0 else kinds[::-1]:
                    farm = Farm(options.binaries, database, workers, threads, options.latency)
                    job = farm.render({
                        'scene': options.scene, 'method': method, 'seconds': options.seconds,
                        'width': width, 'height': height, 'table': 'none', 'seed': 1 + turn,
                        **({'workers': 'auto'} if kind == 'shared' else {})})
                    farm.end()
                    stats = job['stats']
                    rates[kind] = stats['paths'] / stats['seconds']
                    print(f"{method} {kind}: {rates[kind] / 1e6:.3f} M paths/s, "
                          f"{stats['samples']} samples a pixel in whole passes, "
                          f"{len(stats['passes'])} passes; {job['sent'] / 1e6:.1f} MB, "
                          f"{job['turns'] // 2} ways there and back", flush=True)
                    for line in job['log']:
                        if re.search('passes were shared', line):
                            print('  ' + line)
                ratios.append(rates['shared'] / rates['whole'])
            print(f"{method}: shared over whole {statistics.median(ratios):.3f} "
                  f"({', '.join(f'{r:.3f}' for r in ratios)})", flush=True)
    finally:
        for farm in Farm.running:
            farm.end()
        database.end()


if __name__ == '__main__':
    main()
