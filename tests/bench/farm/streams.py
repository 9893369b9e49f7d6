#!/usr/bin/env python3
"""Events to many streams on two fronts: tests/bench/farm/streams.py BIN [--jobs 20000] [--streams 50]

BIN is the folder of qrayd and of qray_claims (cmake -DQRAY_BENCH=ON). Starts a PostgreSQL of its own
and two fronts, opens the streams of GET /v1/events on them in turns, and lets qray_claims take so
many jobs to their ends, each of which makes events. Says how many events each stream had in a second
and how late the last one was, and fails unless all streams had the same ids in the same order.
"""
import argparse
import pathlib
import socket
import subprocess
import sys
import tempfile
import threading
import time

from shared import PROGRAMS, Database, free_port


class Stream(threading.Thread):
    """Reads events of a front for as long as it says anything."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.ids, self.last, self.bytes = [], 0, 0
        self.socket = socket.create_connection(('127.0.0.1', port))
        self.socket.sendall(b'GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n')
        self.start()

    def run(self):
        rest = b''
        while data := self.socket.recv(1 << 16):
            self.bytes += len(data)
            lines = (rest + data).split(b'\n')
            rest = lines.pop()
            new = [int(line[3:]) for line in lines if line.startswith(b'id:')]
            if new:
                self.ids += new
                self.last = time.monotonic()


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('bin', type=pathlib.Path)
    parser.add_argument('--jobs', type=int, default=20000)
    parser.add_argument('--streams', type=int, default=50)
    args = parser.parse_args()
    database = Database()
    fronts, ports = [], [free_port(), free_port()]
    with tempfile.TemporaryDirectory(prefix='qray-streams-') as data:
        try:
            subprocess.run([PROGRAMS / 'createdb', '-h', '127.0.0.1', '-p', str(database.port), '-U',
                            'qray', 'farm'], check=True)
            url = f'postgresql://qray@127.0.0.1:{database.port}/farm'
            for port in ports:
                fronts.append(subprocess.Popen(
                    [args.bin / 'qrayd', '--port', str(port), '--jobs-at-once', '0', '--data', data,
                     '--max-streams', str(args.streams), '--store', url],
                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
                while True:
                    try:
                        socket.create_connection(('127.0.0.1', port)).close()
                        break
                    except OSError:
                        time.sleep(.1)
            streams = [Stream(ports[i % 2]) for i in range(args.streams)]
            time.sleep(1)
            begin = time.monotonic()
            subprocess.run([args.bin / 'qray_claims', url, '--jobs', str(args.jobs)], check=True)
            end = time.monotonic()
            while time.monotonic() - max(s.last for s in streams) < 3:
                time.sleep(.2)
            counts = {len(s.ids) for s in streams}
            print(f'{args.streams} streams, {end - begin:.0f} s of jobs: {min(counts)} to '
                  f'{max(counts)} events each, {sum(s.bytes for s in streams) / 1e6:.0f} MB in all; '
                  f'the last event was {max(s.last for s in streams) - end:.2f} s after the last '
                  f'job at the slowest stream')
            if any(s.ids != streams[0].ids for s in streams):
                sys.exit('the streams differ')
            if streams[0].ids != sorted(set(streams[0].ids)):
                sys.exit('ids are not in order')
        finally:
            for front in fronts:
                front.terminate()
            for front in fronts:
                front.wait()
            database.end()


if __name__ == '__main__':
    main()
