#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the service's throughput: submissions per second, empty jobs per second with full leases, and the response
time of /healthz while streams are open and submissions in flight. Prints numbers without judging them.

  fault_injection/load.py MULTUM_DRILL [--jobs 2000] [--streams 64] [--in-flight 2000]
"""
import argparse
import multiprocessing
import os
import selectors
import socket
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from service_harness import Service, percentile  # noqa: E402

BODY = b'{"type":"drill","parameters":{"seconds":0}}'


def request_bytes(port):
    return (b"POST /v1/jobs HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nContent-Length: %d\r\n\r\n%s" % (port, len(BODY), BODY))


def flood(port, count, connections):
    """Sends `count` submissions over several connections at once. Returns the elapsed seconds."""
    wanted = request_bytes(port)
    selector = selectors.DefaultSelector()
    left = count
    open_count = 0
    for _ in range(min(connections, count)):
        one = socket.create_connection(("127.0.0.1", port))
        one.setblocking(False)
        selector.register(one, selectors.EVENT_READ, [b""])
        open_count += 1
    begun = time.monotonic()
    for key in list(selector.get_map().values()):
        key.fileobj.sendall(wanted)
        left -= 1
    answered = 0
    while answered < count:
        for key, _ in selector.select(30):
            data = key.fileobj.recv(65536)
            assert data, "a connection was closed"
            key.data[0] += data
            head_end = key.data[0].find(b"\r\n\r\n")
            if head_end < 0:
                continue
            head = key.data[0][:head_end]
            length = int(head.lower().split(b"content-length: ")[1].split(b"\r\n")[0])
            if len(key.data[0]) < head_end + 4 + length:
                continue
            assert b" 201 " in head.split(b"\r\n")[0], head
            key.data[0] = key.data[0][head_end + 4 + length:]
            answered += 1
            if left > 0:
                left -= 1
                key.fileobj.sendall(wanted)
            else:
                selector.unregister(key.fileobj)
                key.fileobj.close()
    return time.monotonic() - begun


def watch_health(port, result, stop):
    """Runs in its own process, because otherwise it would wait for the Python code that sends the submissions."""
    seconds_of = []
    one = socket.create_connection(("127.0.0.1", port))
    while not stop.is_set():
        begun = time.monotonic()
        one.sendall(b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        data = b""
        while not data.endswith(b"ok\n"):
            more = one.recv(4096)
            assert more, "closed"
            data += more
        seconds_of.append(time.monotonic() - begun)
        time.sleep(0.002)
    result.put(seconds_of)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("multum")
    parser.add_argument("--jobs", type=int, default=2000)
    parser.add_argument("--streams", type=int, default=64)
    parser.add_argument("--in-flight", type=int, default=2000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        service = Service(options.multum, folder).start()
        streams = []
        for _ in range(options.streams):
            one = socket.create_connection(("127.0.0.1", service.port))
            one.sendall(b"GET /v1/events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
            streams.append(one)
        received = [0] * len(streams)

        def drain():
            selector = selectors.DefaultSelector()
            for number, one in enumerate(streams):
                selector.register(one, selectors.EVENT_READ, number)
            while True:
                for key, _ in selector.select(1):
                    try:
                        received[key.data] += len(key.fileobj.recv(1 << 20))
                    except OSError:
                        return

        threading.Thread(target=drain, daemon=True).start()

        status, _ = service.ask("POST", "/v1/queues/default/pause")
        assert status == 200
        seconds = flood(service.port, options.jobs, 16)
        print(f"{options.jobs} submissions, 16 at once: {options.jobs / seconds:.0f} a second")
        begun = time.monotonic()
        service.ask("POST", "/v1/queues/default/resume")
        while service.counts()["succeeded"] < options.jobs:
            time.sleep(0.02)
        seconds = time.monotonic() - begun
        print(f"{options.jobs} empty jobs through whole leases: {options.jobs / seconds:.0f} a second")

        stop = multiprocessing.Event()
        result = multiprocessing.Queue()
        health = multiprocessing.Process(target=watch_health, args=(service.port, result, stop))
        health.start()
        count = 10 * options.in_flight
        seconds = flood(service.port, count, options.in_flight)
        stop.set()
        times = result.get()
        health.join()
        print(f"{count} submissions, {options.in_flight} in flight, {options.streams} streams of "
              f"events: {count / seconds:.0f} a second; /healthz "
              f"{1000 * percentile(times, 0.5):.1f} ms median, {1000 * percentile(times, 0.95):.1f} ms at 95 %, "
              f"{1000 * max(times):.1f} ms at most, {len(times)} asked")
        service.wait_until_idle()
        assert min(received) > 0, received
        assert service.stop() == 0


main()
